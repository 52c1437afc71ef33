/* SPDX-License-Identifier: Apache-2.0 */
#include "viewshed.h"

#include "cellwalk_expert.h"
#include "sweep.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

struct viewshed {
    const terrain *terrain;
    viewshed_desc desc;
    sight sight;
    double target; /* height in the samples' numbers */
    view_limits limits;
    double most; /* cells along the longer axis to the greatest distance */
};

/* Samples are within it too, and the products of exact decisions stay far below overflow. */
static const double most_height = 0x1p120;

cw_status viewshed_create(const terrain *t, const sight_bounds *bounds, const viewshed_desc *d, viewshed **out) {
    *out = NULL;
    const double ground = terrain_height(t, d->place[0], d->place[1]);
    const double eye = (d->absolute ? d->height : ground + d->height) / t->map[2][2];
    if (!terrain_is_in_reach(d->place[0], d->place[1]) || !(fabs(eye) <= most_height)) return CW_ERROR_ARGUMENT;
    if (!(d->curvature >= 0 && d->curvature <= 1e9)) return CW_ERROR_ARGUMENT;
    if (!(fabs(d->target_height / t->map[2][2]) <= most_height)) return CW_ERROR_ARGUMENT;
    viewshed *v = malloc(sizeof *v);
    if (v == NULL) return CW_ERROR_MEMORY;
    *v = (viewshed){.terrain = t, .desc = *d, .target = d->target_height / t->map[2][2]};
    sight_init(&v->sight, t, bounds, (double[3]){d->place[0], d->place[1], eye}, d->curvature);
    if (!view_limits_init(&v->limits, &v->sight, &d->limits)) {
        free(v);
        return CW_ERROR_ARGUMENT;
    }
    /* A metre is at most so many cells long. */
    const double *metres = v->limits.metres;
    double cells = 0;
    for (int k = 0; k < 2; k++) cells = fmax(cells, fabs(t->back[k][0]) / metres[0] + fabs(t->back[k][1]) / metres[1]);
    v->most = d->limits.farthest > 0 ? d->limits.farthest * cells + 1 : INFINITY;
    *out = v;
    return CW_OK;
}

void viewshed_destroy(viewshed *v) { free(v); }

const sight *viewshed_sight(const viewshed *v) { return &v->sight; }

typedef struct job {
    const viewshed *v;
    sweep_visit *visit;
    uint16_t *seen; /* one of these */
    double *sums, weight;
    float *heights, *angles;
    terrain_progress *progress;
    void *context;
    atomic_flag telling; /* one thread at a time */
    atomic_uint parts;   /* that are done */
    atomic_bool failed, stopped;
} job;

/* The target's height over the eye, lowered. */
static double rise_of(const viewshed *v, size_t i, size_t j) { return sight_sample(&v->sight, i, j) + v->target; }

static inline bool is_seen(const viewshed *v, size_t i, size_t j, const sweep_way *way) {
    if (v->limits.any && !view_limits_have(&v->limits, (double)i, (double)j, rise_of(v, i, j))) return false;
    const double z = (double)v->terrain->z[j * v->terrain->nx + i];
    return (way->unsure.close == 0 && !way->unsure.eye) ||
           sight_sees(&v->sight, (double)i, (double)j, z, v->target, way->unsure);
}

static void count_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const job *q = context;
    if (is_seen(q->v, i, j, way)) q->seen[j * q->v->terrain->nx + i]++;
}

static void weigh_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const job *q = context;
    if (is_seen(q->v, i, j, way)) q->sums[j * q->v->terrain->nx + i] += q->weight;
}

static void put_angle(const job *q, size_t i, size_t j) {
    const viewshed *v = q->v;
    q->angles[j * v->terrain->nx + i] = (float)view_limits_angle(&v->limits, (double)i, (double)j, rise_of(v, i, j));
}

static void angle_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const job *q = context;
    if (is_seen(q->v, i, j, way)) put_angle(q, i, j);
}

/* Whether a number that may be off by the error becomes the same float as the exact one, or one within most_apart of it. Small
 * numbers have floats that are closer together than the error. */
static bool is_sure(double x, double error) {
    static const double most_apart = 0x1p-17;
    return (double)(float)(x + error) - (double)(float)(x - error) <= most_apart;
}

static void measure_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const job *q = context;
    const viewshed *v = q->v;
    if (v->limits.any && !view_limits_have(&v->limits, (double)i, (double)j, 0)) return;
    const size_t k = j * v->terrain->nx + i;
    const double z = (double)v->terrain->z[k], metres = v->terrain->map[2][2];
    double need;
    if (!way->known) {
        need = sight_need(&v->sight, (double)i, (double)j, z, way->low);
    } else {
        need = sight_need_known(&v->sight, (double)i, (double)j, z, way->rise, way->error, way->unsure);
        if (!is_sure(need * metres, way->error * metres))
            need = sight_need(&v->sight, (double)i, (double)j, z, way->rise - way->error);
    }
    q->heights[k] = (float)(need * metres);
}

static bool tell(void *context) {
    job *q = context;
    if (q->progress && !atomic_flag_test_and_set(&q->telling)) {
        if (!q->progress(q->context, (double)atomic_load(&q->parts) / SWEEP_PARTS)) atomic_store(&q->stopped, true);
        atomic_flag_clear(&q->telling);
    }
    return !atomic_load_explicit(&q->stopped, memory_order_relaxed);
}

static void sweep_parts(void *context, size_t begin, size_t end) {
    job *q = context;
    const viewshed *v = q->v;
    const double target = q->heights ? INFINITY : v->target;
    for (size_t k = begin; k < end; k++) {
        double directions[2][2];
        sweep_directions((unsigned)k, directions);
        if (view_limits_meet(&v->limits, directions[0], directions[1]) &&
            !sweep_part(&v->sight, (unsigned)k, v->most, target, q->visit, tell, q))
            atomic_store(&q->failed, true);
        atomic_fetch_add(&q->parts, 1);
    }
}

static cw_status run(job *q, const cw_run *query, bool *done) {
    atomic_flag_clear(&q->telling);
    cw_pool_run(query ? query->pool : NULL, SWEEP_PARTS, 1, sweep_parts, q);
    *done = !atomic_load(&q->failed) && !atomic_load(&q->stopped);
    return atomic_load(&q->failed) ? CW_ERROR_MEMORY : CW_OK;
}

/* The observer's own sample, if the eye is right over it and it counts, is in no part. */
static bool own_sample(const viewshed *v, size_t at[2]) {
    const double x = v->sight.eye[0], y = v->sight.eye[1];
    const terrain *t = v->terrain;
    if (x != floor(x) || y != floor(y) || !(x >= 0 && y >= 0 && x < (double)t->nx && y < (double)t->ny)) return false;
    at[0] = (size_t)x;
    at[1] = (size_t)y;
    return isfinite(t->z[at[1] * t->nx + at[0]]);
}

static bool sees_own_sample(const viewshed *v, size_t at[2]) {
    return own_sample(v, at) && view_limits_have(&v->limits, (double)at[0], (double)at[1], rise_of(v, at[0], at[1]));
}

cw_status viewshed_count(const viewshed *v, const cw_run *query, uint16_t *seen, terrain_progress *progress,
                         void *context, bool *done) {
    job q = {.v = v, .visit = count_sample, .seen = seen, .progress = progress, .context = context};
    size_t own[2];
    const cw_status status = run(&q, query, done);
    if (*done && sees_own_sample(v, own)) seen[own[1] * v->terrain->nx + own[0]]++;
    return status;
}

cw_status viewshed_weigh(const viewshed *v, const cw_run *query, double weight, double *sums,
                         terrain_progress *progress, void *context, bool *done) {
    job q = {.v = v, .visit = weigh_sample, .sums = sums, .weight = weight, .progress = progress, .context = context};
    size_t own[2];
    const cw_status status = run(&q, query, done);
    if (*done && sees_own_sample(v, own)) sums[own[1] * v->terrain->nx + own[0]] += weight;
    return status;
}

static void clear(const viewshed *v, float *numbers) {
    for (size_t k = 0; k < v->terrain->nx * v->terrain->ny; k++) numbers[k] = NAN;
}

cw_status viewshed_angles(const viewshed *v, const cw_run *query, float *angles, terrain_progress *progress,
                          void *context, bool *done) {
    job q = {.v = v, .visit = angle_sample, .angles = angles, .progress = progress, .context = context};
    size_t own[2];
    clear(v, angles);
    const cw_status status = run(&q, query, done);
    if (*done && sees_own_sample(v, own)) put_angle(&q, own[0], own[1]);
    return status;
}

cw_status viewshed_heights(const viewshed *v, const cw_run *query, float *heights, terrain_progress *progress,
                           void *context, bool *done) {
    job q = {.v = v, .visit = measure_sample, .heights = heights, .progress = progress, .context = context};
    size_t own[2];
    if (v->desc.limits.has_verticals) return CW_ERROR_ARGUMENT;
    clear(v, heights);
    const cw_status status = run(&q, query, done);
    if (*done && own_sample(v, own) && view_limits_have(&v->limits, (double)own[0], (double)own[1], 0))
        heights[own[1] * v->terrain->nx + own[0]] = 0;
    return status;
}
