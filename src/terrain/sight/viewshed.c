/* SPDX-License-Identifier: Apache-2.0 */
#include "viewshed.h"

#include "sweep.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

struct viewshed {
    const terrain *terrain;
    viewshed_desc desc;
    sight sight;
    double target; /* height in the samples' numbers */
    double metres[2];
    double most; /* cells along the longer axis to the greatest distance */
};

/* Samples are within it too, and the products of exact decisions stay far below overflow. */
static const double most_height = 0x1p120;

cw_status viewshed_create(const terrain *t, const sight_bounds *bounds, const viewshed_desc *d, viewshed **out) {
    *out = NULL;
    const double ground = terrain_height(t, d->place[0], d->place[1]);
    const double eye = (d->absolute ? d->height : ground + d->height) / t->map[2][2];
    if (!terrain_is_in_reach(d->place[0], d->place[1]) || !(fabs(eye) <= most_height)) return CW_ERROR_ARGUMENT;
    if (!(d->curvature >= 0 && d->curvature <= 1e9 && d->max_distance >= 0)) return CW_ERROR_ARGUMENT;
    if (!(fabs(d->target_height / t->map[2][2]) <= most_height)) return CW_ERROR_ARGUMENT;
    viewshed *v = malloc(sizeof *v);
    if (v == NULL) return CW_ERROR_MEMORY;
    *v = (viewshed){.terrain = t, .desc = *d, .target = d->target_height / t->map[2][2]};
    sight_init(&v->sight, t, bounds, (double[3]){d->place[0], d->place[1], eye}, d->curvature);
    terrain_metres(t, d->place[0], d->place[1], v->metres);
    /* A metre is at most so many cells long. */
    double cells = 0;
    for (int k = 0; k < 2; k++)
        cells = fmax(cells, fabs(t->back[k][0]) / v->metres[0] + fabs(t->back[k][1]) / v->metres[1]);
    v->most = d->max_distance > 0 ? d->max_distance * cells + 1 : INFINITY;
    *out = v;
    return CW_OK;
}

void viewshed_destroy(viewshed *v) { free(v); }

const sight *viewshed_sight(const viewshed *v) { return &v->sight; }

static bool is_near(const viewshed *v, double i, double j) {
    if (v->desc.max_distance == 0) return true;
    const double x = i - v->sight.eye[0], y = j - v->sight.eye[1];
    const double(*m)[4] = (const double(*)[4])v->terrain->map;
    const double east = (m[0][0] * x + m[0][1] * y) * v->metres[0], north = (m[1][0] * x + m[1][1] * y) * v->metres[1];
    return east * east + north * north <= v->desc.max_distance * v->desc.max_distance;
}

typedef struct job {
    const viewshed *v;
    uint16_t *seen;
    float *heights;
    terrain_progress *progress;
    void *context;
    atomic_flag telling; /* one thread at a time */
    atomic_uint parts;   /* that are done */
    atomic_bool failed, stopped;
} job;

static void count_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    job *q = context;
    const viewshed *v = q->v;
    if (!is_near(v, (double)i, (double)j)) return;
    const bool sure = way->unsure.close == 0 && !way->unsure.eye;
    const size_t k = j * v->terrain->nx + i;
    if (sure || sight_sees(&v->sight, (double)i, (double)j, (double)v->terrain->z[k], v->target, way->unsure))
        q->seen[k]++;
}

static void measure_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    job *q = context;
    const viewshed *v = q->v;
    if (!is_near(v, (double)i, (double)j)) return;
    const size_t k = j * v->terrain->nx + i;
    const double z = (double)v->terrain->z[k];
    const double need = way->known
                            ? sight_need_known(&v->sight, (double)i, (double)j, z, way->rise, way->error, way->unsure)
                            : sight_need(&v->sight, (double)i, (double)j, z, way->low);
    q->heights[k] = (float)(need * v->terrain->map[2][2]);
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
    sweep_visit *visit = q->seen ? count_sample : measure_sample;
    const double target = q->seen ? q->v->target : INFINITY;
    for (size_t k = begin; k < end; k++) {
        if (!sweep_part(&q->v->sight, (unsigned)k, q->v->most, target, visit, tell, q)) atomic_store(&q->failed, true);
        atomic_fetch_add(&q->parts, 1);
    }
}

static cw_status run(job *q, const cw_run *query, bool *done) {
    atomic_flag_clear(&q->telling);
    cw_pool_run(query ? query->pool : NULL, SWEEP_PARTS, 1, sweep_parts, q);
    *done = !atomic_load(&q->failed) && !atomic_load(&q->stopped);
    return atomic_load(&q->failed) ? CW_ERROR_MEMORY : CW_OK;
}

/* The observer's own sample, if the eye is right over it, is in no part. */
static bool own_sample(const viewshed *v, size_t *k) {
    const double x = v->sight.eye[0], y = v->sight.eye[1];
    const terrain *t = v->terrain;
    if (x != floor(x) || y != floor(y) || !(x >= 0 && y >= 0 && x < (double)t->nx && y < (double)t->ny)) return false;
    *k = (size_t)y * t->nx + (size_t)x;
    return isfinite(t->z[*k]);
}

cw_status viewshed_count(const viewshed *v, const cw_run *query, uint16_t *seen, terrain_progress *progress,
                         void *context, bool *done) {
    job q = {.v = v, .seen = seen, .progress = progress, .context = context};
    size_t own;
    const cw_status status = run(&q, query, done);
    if (*done && own_sample(v, &own)) seen[own]++;
    return status;
}

cw_status viewshed_heights(const viewshed *v, const cw_run *query, float *heights, terrain_progress *progress,
                           void *context, bool *done) {
    job q = {.v = v, .heights = heights, .progress = progress, .context = context};
    size_t own;
    for (size_t k = 0; k < v->terrain->nx * v->terrain->ny; k++) heights[k] = NAN;
    const cw_status status = run(&q, query, done);
    if (*done && own_sample(v, &own)) heights[own] = 0;
    return status;
}
