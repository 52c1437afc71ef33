/* SPDX-License-Identifier: Apache-2.0 */
/* Visibility from a place: for each sample, whether the straight line from the observer's eye to it, or to something of
 * a given height on it, passes above the surface. A line that touches it on the way is blocked. */
#include "area.h"
#include "fpenv.h"
#include "sweep.h"
#include "view_limits.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

/* What is looked for from the eye of a sight. One sweep over all samples finds those that are seen, another one the
 * heights that are needed. */
typedef struct viewshed {
    const sight *sight;
    double target; /* height in the samples' numbers */
    view_limits limits;
    double most; /* cells along the longer axis to the greatest distance */
    cw_area area;
    cw_view to;
    bool heights; /* of the present sweep */
    atomic_bool failed;
} viewshed;

/* The number of an output, or SIZE_MAX outside the area. */
static inline size_t place_of(const viewshed *q, size_t i, size_t j) {
    const cw_rectangle at = q->area.at;
    return i - at.i < at.nx && j - at.j < at.ny ? (j - at.j) * q->area.stride + (i - at.i) : SIZE_MAX;
}

/* The target's height over the eye, lowered. */
static double rise_of(const viewshed *q, size_t i, size_t j) { return cw_sight_sample(q->sight, i, j) + q->target; }

/* The number of the output of a sample, or SIZE_MAX if that does not count. */
static inline size_t place_of_target(const viewshed *q, size_t i, size_t j) {
    const view_limits *l = &q->limits;
    if (l->any && !cw_view_limits_have(l, (double)i, (double)j, q->heights ? 0 : rise_of(q, i, j))) return SIZE_MAX;
    return place_of(q, i, j);
}

static void put_seen(const viewshed *q, size_t i, size_t j, size_t k) {
    if (q->to.seen) q->to.seen[k]++;
    if (q->to.sum) q->to.sum[k] += q->to.weight;
    if (q->to.angle) q->to.angle[k] = (float)cw_view_limits_angle(&q->limits, (double)i, (double)j, rise_of(q, i, j));
}

static void see_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const viewshed *q = context;
    const sight *s = q->sight;
    const size_t k = place_of_target(q, i, j);
    if (k == SIZE_MAX) return;
    if ((way->unsure.close == 0 && !way->unsure.eye) ||
        cw_sight_sees(s, (double)i, (double)j, (double)terrain_row(s->terrain, j)[i], q->target, way->unsure))
        put_seen(q, i, j, k);
}

static uint64_t see_span(void *context, const sweep_span *s) {
    const viewshed *q = context;
    const size_t end = s->count - 1, first = place_of(q, s->i, s->j),
                 last = place_of(q, s->down ? s->i : s->i + end, s->down ? s->j + end : s->j);
    const bool plain = !q->limits.any && !q->to.sum && !q->to.angle && first != SIZE_MAX && last != SIZE_MAX;
    const size_t step = s->down ? q->area.stride : 1;
    for (uint64_t left = s->which; left != 0; left &= left - 1) {
        const size_t k = (size_t)__builtin_ctzll(left), i = s->down ? s->i : s->i + k, j = s->down ? s->j + k : s->j;
        const size_t at = plain ? first + k * step : place_of_target(q, i, j);
        if (plain)
            q->to.seen[at]++;
        else if (at != SIZE_MAX)
            put_seen(q, i, j, at);
    }
    return 0;
}

/* Whether a number that may be off by the error becomes the same float as the exact one, or one within most_apart of
 * it. Small numbers have floats that are closer together than the error. */
static bool is_sure(double x, double error) {
    static const double most_apart = 0x1p-17;
    return (double)(float)(x + error) - (double)(float)(x - error) <= most_apart;
}

static void measure_sample(void *context, size_t i, size_t j, const sweep_way *way) {
    const viewshed *q = context;
    const sight *s = q->sight;
    const size_t k = place_of_target(q, i, j);
    if (k == SIZE_MAX) return;
    const double z = (double)terrain_row(s->terrain, j)[i], metres = s->terrain->map[2][2];
    double need = NAN, low = way->low;
    if (way->known) {
        need = cw_sight_need_known(s, (double)i, (double)j, z, way->rise, way->error, way->unsure);
        low = fmax(low, way->rise - way->error); /* where the skyline has a step, the error is large */
    }
    if (!is_sure(need * metres, way->error * metres)) need = cw_sight_need(s, (double)i, (double)j, z, low);
    q->to.needed[k] = (float)(need * metres);
}

static uint64_t measure_span(void *context, const sweep_span *s) {
    const viewshed *q = context;
    const sight *from = q->sight;
    const double metres = q->sight->terrain->map[2][2], across = s->down ? 0 : 1, eye = from->eye[2], i = (double)s->i,
                 j = (double)s->j;
    float needs[SWEEP_SPAN_MOST];
    bool open[SWEEP_SPAN_MOST];
    uint64_t left = 0;
    for (int k = 0; s->rise && k < (int)s->count; k++) {
        const double fall = sight_fall(from, i + across * k, j + (1 - across) * k);
        const double z = (double)s->z[k], top = z - eye - fall, rise = s->rise[k];
        const double error = s->error[k] + 0x1p-50 * (fabs(z) + fabs(eye) + fabs(fall)); /* that of top too */
        const double need = ((rise > top ? rise : top) - top) * metres;
        open[k] = !(fabs(rise - top) > error) | !is_sure(need, error * metres);
        needs[k] = (float)need;
    }
    for (size_t k = 0; k < s->count; k++) {
        if (!(s->which >> k & 1)) continue;
        const size_t at = place_of_target(q, s->down ? s->i : s->i + k, s->down ? s->j + k : s->j);
        if (at == SIZE_MAX) continue;
        if (s->rise && open[k])
            left |= (uint64_t)1 << k;
        else
            q->to.needed[at] = s->rise ? needs[k] : 0;
    }
    return left;
}

static void sweep_parts(void *context, size_t begin, size_t end) {
    viewshed *q = context;
    for (size_t k = begin; k < end; k++) {
        double directions[2][2];
        cw_sweep_directions((unsigned)k, directions);
        if (cw_view_limits_meet(&q->limits, directions[0], directions[1]) &&
            !cw_sweep_part(q->sight, (unsigned)k, q->most, q->heights ? INFINITY : q->target,
                           q->heights ? measure_sample : see_sample, q->heights ? measure_span : see_span, q))
            atomic_store(&q->failed, true);
    }
}

/* The observer's own sample, if the eye is right over it and it counts, is in no part. */
static bool own_sample(const sight *s, size_t at[2]) {
    const double x = s->eye[0], y = s->eye[1];
    const terrain *t = s->terrain;
    if (x != floor(x) || y != floor(y) || !(x >= 0 && y >= 0 && x < (double)t->nx && y < (double)t->ny)) return false;
    at[0] = (size_t)x;
    at[1] = (size_t)y;
    return isfinite(terrain_row(t, at[1])[at[0]]);
}

static cw_status sweep(viewshed *q, const cw_run *run, bool heights) {
    const cw_area *a = &q->area;
    float *numbers = heights ? q->to.needed : q->to.angle;
    for (size_t y = 0; y < a->at.ny && numbers; y++)
        for (size_t x = 0; x < a->at.nx; x++) numbers[y * a->stride + x] = NAN;
    q->heights = heights;
    const cw_status status = cw_run_work(run, SWEEP_PARTS, 1, 1, sweep_parts, q);
    if (atomic_load(&q->failed)) return cw_fail_plainly(CW_ERROR_MEMORY);
    if (status != CW_OK) return status;
    size_t own[2];
    const size_t k = own_sample(q->sight, own) ? place_of_target(q, own[0], own[1]) : SIZE_MAX;
    if (k != SIZE_MAX && heights) q->to.needed[k] = 0;
    if (k != SIZE_MAX && !heights) put_seen(q, own[0], own[1], k);
    return CW_OK;
}

cw_status cw_viewshed_from(const sight *s, const cw_observer *from, const cw_run *run, cw_area area,
                           const cw_view *view) {
    const terrain *t = s->terrain;
    cw_run how;
    viewshed q = {.sight = s, .target = from->target / terrain_metres_of_height(t), .most = INFINITY};
    cw_status status = cw_area_begin(t, view, "view", run, 1, &area, &how);
    if (status == CW_OK) status = cw_check_reserved(view->reserved, 8, 0, "cw_view");
    if (status == CW_OK) status = cw_check_number("weight", view->weight, -DBL_MAX, DBL_MAX);
    if (status == CW_OK && view->needed && (from->limits & CW_OBSERVER_VERTICALS) != 0)
        status = cw_fail(CW_ERROR_ARGUMENT, "needed: does not go with CW_OBSERVER_VERTICALS");
    if (status == CW_OK) status = cw_check_number("farthest", from->farthest, 0, INFINITY);
    const double most = from->farthest > 0 ? from->farthest : INFINITY;
    if (status == CW_OK) status = cw_check_number("nearest", from->nearest, 0, most);
    if (status == CW_OK && !cw_view_limits_init(&q.limits, s, from))
        status = cw_fail(CW_ERROR_ARGUMENT,
                         "azimuths, verticals: %g to %g, %g to %g; numbers, and verticals from -90 up to 90",
                         from->azimuths[0], from->azimuths[1], from->verticals[0], from->verticals[1]);
    if (status != CW_OK) return status;
    double cells = 0; /* that a metre is long at most */
    for (int k = 0; k < 2; k++)
        cells = fmax(cells, fabs(t->back[k][0]) / q.limits.metres[0] + fabs(t->back[k][1]) / q.limits.metres[1]);
    if (from->farthest > 0) q.most = from->farthest * cells + 1;
    q.area = area;
    q.to = *view;
    if (view->weight == 0) q.to.weight = 1;
    const bool sees = view->seen || view->sum || view->angle;
    const cw_run one = cw_run_part_of(&(run_part){&how, 0, view->needed ? 0.5 : 1});
    const cw_run other = cw_run_part_of(&(run_part){&how, sees ? 0.5 : 0, 1});
    if (sees) status = sweep(&q, &one, false);
    return status == CW_OK && view->needed ? sweep(&q, &other, true) : status;
}

/* The observer's eye in field coordinates and the samples' numbers. */
static cw_status find_eye(const terrain *t, const cw_observer *from, double eye[3]) {
    if (!cw_terrain_find_place(t, from->x, from->y, eye))
        return cw_fail(CW_ERROR_ARGUMENT, "x, y: (%.10g, %.10g) is too far away from the terrain", from->x, from->y);
    const double level = cw_terrain_level(t, eye[0], eye[1]), metres = terrain_metres_of_height(t);
    const double ground = level * metres, height = from->absolute ? from->height : ground + from->height;
    eye[2] = (from->absolute ? 0 : level) + from->height / metres;
    if (height < ground - TERRAIN_LEAST_DEPTH)
        return cw_fail(CW_ERROR_ARGUMENT,
                       "height: %.10g m is under the ground, which is %.10g m high at (%.10g, %.10g)", height, ground,
                       from->x, from->y);
    if (isnan(eye[2]))
        return cw_fail(CW_ERROR_ARGUMENT, "x, y: no ground to stand on at (%.10g, %.10g), or height is no number: %g",
                       from->x, from->y, from->height);
    const double most = TERRAIN_HEIGHT_MOST * metres;
    cw_status status = cw_check_number("height", height, -most, most);
    if (status == CW_OK) status = cw_check_number("target", from->target, -most, most);
    if (status == CW_OK) status = cw_check_number("curvature", from->curvature, 0, 1e9);
    return status;
}

cw_status cw_viewshed(const cw_terrain *t, const cw_run *run, const cw_observer *from, cw_area area,
                      const cw_view *view) {
    FPENV_HERE;
    const uint32_t flags = CW_OBSERVER_AZIMUTHS | CW_OBSERVER_VERTICALS;
    if (t == NULL || from == NULL || view == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", !t ? "terrain" : !from ? "from" : "view");
    cw_status status = cw_check_reserved(from->reserved, 8, 0, "cw_observer");
    if (status == CW_OK) status = cw_check_number("absolute", from->absolute, 0, 1);
    if (status == CW_OK) status = cw_check_number("limits", from->limits, 0, flags);
    if (status != CW_OK) return status;
    double eye[3];
    sight s;
    door_pass in;
    const sight_bounds *bounds;
    if (!cw_terrain_enter(t, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    status = find_eye(t, from, eye);
    if (status == CW_OK) status = cw_terrain_bounds(t, &bounds);
    if (status == CW_OK) {
        cw_sight_init(&s, t, bounds, eye, from->curvature);
        status = cw_viewshed_from(&s, from, run, area, view);
        cw_terrain_bounds_release(t, bounds);
    }
    cw_field_leave(in);
    return status;
}
