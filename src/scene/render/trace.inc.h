/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_TRACE_INC_H
#define CELLWALK_SCENE_TRACE_INC_H

#include "lanes.h"
#include "wave.h"

#include <string.h>

/* A wave's rays against the scene's shapes: moved to a field and asked of it where they pass through its box, and met with
 * cylinders in closed form. */

/* Rays of a strip on their way to a shape. */
typedef struct moved {
    size_t n;           /* whole lanes */
    size_t first, rays; /* of so many rays from that one on */
    float org[3][WAVE_STRIP], dir[3][WAVE_STRIP];
    const float *tmin, *tmax;
    int32_t passes[WAVE_STRIP]; /* through the field's box; 0 behind the last ray */
} moved;

static const float zeros[WAVE_STRIP] = {0};

/* Where all segments to a light end. */
#define FOUR_ONES 1, 1, 1, 1
#define ONES      FOUR_ONES, FOUR_ONES, FOUR_ONES, FOUR_ONES
static const float ones[WAVE_STRIP] = {ONES, ONES, ONES, ONES, ONES, ONES, ONES, ONES};

static void begin_moved(moved *m, size_t first, size_t end) {
    m->first = first;
    m->rays = wave_strip_of(first, end);
    m->n = wave_lanes(m->rays);
}

/* The rays of a wave from first to before end, or as many of them as a strip holds. */
static void move_rays(const plan_map *map, const wave *w, const wave_rays *r, size_t home, size_t first, size_t end,
                      moved *out) {
    begin_moved(out, first, end);
    const size_t n = out->n;
    float m[3][4];
    memcpy(m, map->m, sizeof m);
    const float *dx = &r->dir[0][first], *dy = &r->dir[1][first], *dz = &r->dir[2][first];
    const float *ox = &r->org[0][first], *oy = &r->org[1][first], *oz = &r->org[2][first];
    out->tmin = home == PLAN_CAMERA ? zeros : &r->tmin[first];
    out->tmax = &w->t[first];
    for (size_t k = 0; k < n; k++)
        for (int c = 0; c < 3; c++) out->dir[c][k] = lane_turn(m[c], dx[k], dy[k], dz[k]);
    if (home == PLAN_CAMERA) {
        for (int c = 0; c < 3; c++)
            for (size_t k = 0; k < n; k++) out->org[c][k] = m[c][3];
    } else {
        for (size_t k = 0; k < n; k++)
            for (int c = 0; c < 3; c++) out->org[c][k] = lane_move(m[c], ox[k], oy[k], oz[k]);
    }
}

/* Segments to a light. */
static void move_shadows(const plan_map *map, const wave_shadows *s, const float light[3], size_t first, size_t end,
                         moved *out) {
    begin_moved(out, first, end);
    const size_t n = out->n;
    float m[3][4];
    memcpy(m, map->m, sizeof m);
    const float to[3] = {light[0], light[1], light[2]};
    const float *ox = &s->org[0][first], *oy = &s->org[1][first], *oz = &s->org[2][first];
    out->tmin = &s->tmin[first];
    out->tmax = ones;
    for (size_t k = 0; k < n; k++)
        for (int c = 0; c < 3; c++) {
            const float org = lane_move(m[c], ox[k], oy[k], oz[k]);
            out->org[c][k] = org;
            out->dir[c][k] = to[c] - org;
        }
}

/* Where the line enters and leaves the stretch from low to high of one axis. The comparisons are such that a NaN, of a
 * line that runs along the border, leaves all open. */
LANE_INLINE float later_entry(float enter, float low, float high, float org, float inverse) {
    const float t = ((inverse >= 0 ? low : high) - org) * inverse;
    return t > enter ? t : enter;
}
LANE_INLINE float earlier_exit(float leave, float low, float high, float org, float inverse) {
    const float t = ((inverse >= 0 ? high : low) - org) * inverse;
    return t < leave ? t : leave;
}

/* Decides which rays pass through the box between tmin and tmax. Each t has three roundings, so it is off by less than
 * 2^-22 of itself, and its sign is right: with that much room no ray is left out that passes. */
static void pass_box(const plan_shape *shape, moved *m) {
    const float room = 1 + 0x1p-21f;
    const float low[3] = {shape->low[0], shape->low[1], shape->low[2]};
    const float high[3] = {shape->high[0], shape->high[1], shape->high[2]};
    const float *tmin = m->tmin, *tmax = m->tmax;
    for (size_t k = 0; k < m->n; k++) {
        float enter = tmin[k], leave = tmax[k];
        const float ix = 1 / m->dir[0][k], iy = 1 / m->dir[1][k], iz = 1 / m->dir[2][k];
        enter = later_entry(enter, low[0], high[0], m->org[0][k], ix);
        enter = later_entry(enter, low[1], high[1], m->org[1][k], iy);
        enter = later_entry(enter, low[2], high[2], m->org[2][k], iz);
        leave = earlier_exit(leave, low[0], high[0], m->org[0][k], ix);
        leave = earlier_exit(leave, low[1], high[1], m->org[1][k], iy);
        leave = earlier_exit(leave, low[2], high[2], m->org[2][k], iz);
        m->passes[k] = enter <= leave * room;
    }
    for (size_t k = m->rays; k < m->n; k++) m->passes[k] = 0;
}

static void all_pass(moved *m) {
    for (size_t k = 0; k < m->n; k++) m->passes[k] = k < m->rays;
}

LANE_INLINE void weave(const float *a, const float *b, size_t n, float *out) {
    for (size_t k = 0; k < n; k++) {
        out[2 * k] = a[k];
        out[2 * k + 1] = b[k];
    }
}

/* WAVE_LANES rays from k on, one after the other: eight arrays woven into one in three steps, for which there are vector
 * instructions. */
static void ask_lanes(const moved *m, size_t k, cw_ray *out) {
    float pair[4][2 * WAVE_LANES], quad[2][4 * WAVE_LANES], ray[8 * WAVE_LANES];
    weave(&m->org[0][k], &m->dir[0][k], WAVE_LANES, pair[0]);
    weave(&m->org[2][k], &m->dir[2][k], WAVE_LANES, pair[1]);
    weave(&m->org[1][k], &m->dir[1][k], WAVE_LANES, pair[2]);
    weave(&m->tmin[k], &m->tmax[k], WAVE_LANES, pair[3]);
    weave(pair[0], pair[1], 2 * WAVE_LANES, quad[0]);
    weave(pair[2], pair[3], 2 * WAVE_LANES, quad[1]);
    weave(quad[0], quad[1], 4 * WAVE_LANES, ray);
    memcpy(out, ray, sizeof ray);
}

/* Of a group of WAVE_LANES flags that are 0 or 1, how many are 1: mostly all or none. */
LANE_INLINE int32_t lanes_set(const int32_t *flags) {
    int32_t sum = 0;
    for (int k = 0; k < WAVE_LANES; k++) sum += flags[k];
    return sum;
}

/* Appends the rays that pass to what the field is asked. Returns how many are asked now. */
static size_t ask(wave *w, size_t asked, const moved *m) {
    for (size_t k = 0; k < m->n; k += WAVE_LANES) {
        const int32_t passing = lanes_set(&m->passes[k]);
        if (passing == 0) continue;
        if (passing == WAVE_LANES) {
            ask_lanes(m, k, &w->asked[asked]);
            for (size_t q = 0; q < WAVE_LANES; q++) w->asked_of[asked + q] = (uint32_t)(m->first + k + q);
            asked += WAVE_LANES;
            continue;
        }
        for (size_t q = k; q < k + WAVE_LANES; q++) {
            if (!m->passes[q]) continue;
            w->asked[asked] = (cw_ray){.org = {m->org[0][q], m->org[1][q], m->org[2][q]},
                                       .tmin = m->tmin[q],
                                       .dir = {m->dir[0][q], m->dir[1][q], m->dir[2][q]},
                                       .tmax = m->tmax[q]};
            w->asked_of[asked++] = (uint32_t)(m->first + q);
        }
    }
    return asked;
}

/* ---- closest hits ------------------------------------------------------------------------------------------------- */

static void closest_on_field(wave *w, const wave_rays *r, size_t f) {
    const plan *p = w->plan;
    size_t asked = 0;
    for (size_t s = 0; s < r->segment_count; s++) {
        const wave_segment *g = &r->segments[s];
        const plan_map *map = plan_map_to(p, f, g->home);
        for (size_t first = g->begin; first < g->end; first += WAVE_STRIP) {
            moved m;
            move_rays(map, w, r, g->home, first, g->end, &m);
            if (p->general)
                all_pass(&m);
            else
                pass_box(&p->shapes[f], &m);
            asked = ask(w, asked, &m);
        }
    }
    if (asked == 0) return;
    wave_lap(w, WAVE_RAYS);
    w->tracer->closest(w->tracer->context, f, w->asked, asked, w->answers);
    wave_lap(w, WAVE_TRACE);
    w->stats.field_queries += asked;
    for (size_t k = 0; k < asked; k++) {
        const size_t of = w->asked_of[k];
        if (!(w->answers[k].t < w->t[of])) continue;
        w->t[of] = w->answers[k].t;
        w->shape[of] = (int32_t)f;
        w->hits[of] = w->answers[k];
    }
}

/* Where a ray meets the side of a cylinder of radius 1 between z = -1 and z = 1, in its space; infinity if nowhere between
 * tmin and tmax. (o + t d)² - 1 in x and y is a t² + 2 half t + c, and its discriminant is a minus the square of the cross
 * product of o and d, a form in which nothing cancels that matters. */
LANE_INLINE float cylinder_t(float ox, float oy, float oz, float dx, float dy, float dz, float tmin, float tmax) {
    const float a = dx * dx + dy * dy, half = ox * dx + oy * dy, c = ox * ox + oy * oy - 1;
    const float across = ox * dy - oy * dx, square = a - across * across;
    const float root = sqrtf(square > 0 ? square : 0);
    /* The sum that does not cancel; one solution is q / a, the other c / q. */
    const float q = half < 0 ? root - half : -root - half;
    const float one = q / a, other = c / q;
    const float near = half < 0 ? other : one, far = half < 0 ? one : other;
    /* From inside, the nearer one lies behind. */
    const int inside = (c < 0) & (tmin >= 0);
    const int near_holds = (inside == 0) & (near >= tmin) & (near <= tmax) & (fabsf(oz + near * dz) <= 1);
    const int far_holds = (far >= tmin) & (far <= tmax) & (fabsf(oz + far * dz) <= 1);
    const float t = near_holds ? near : far_holds ? far : INFINITY;
    return ((a > 0) & (square >= 0)) ? t : INFINITY;
}

static void closest_on_cylinder(wave *w, const wave_rays *r, size_t shape) {
    for (size_t s = 0; s < r->segment_count; s++) {
        const wave_segment *g = &r->segments[s];
        const plan_map *map = plan_map_to(w->plan, shape, g->home);
        for (size_t first = g->begin; first < g->end; first += WAVE_STRIP) {
            moved m;
            move_rays(map, w, r, g->home, first, g->end, &m);
            float found[WAVE_STRIP];
            for (size_t k = 0; k < m.n; k++)
                found[k] = cylinder_t(m.org[0][k], m.org[1][k], m.org[2][k], m.dir[0][k], m.dir[1][k], m.dir[2][k],
                                      m.tmin[k], m.tmax[k]);
            float *t = &w->t[first];
            int32_t *which = &w->shape[first];
            for (size_t k = 0; k < m.rays; k++) {
                which[k] = found[k] < t[k] ? (int32_t)shape : which[k];
                t[k] = found[k] < t[k] ? found[k] : t[k];
            }
        }
    }
}

/* Finds where each path ends. */
static void trace_paths(wave *w, const wave_rays *r) {
    for (size_t k = 0; k < r->count; k++) {
        w->t[k] = INFINITY;
        w->shape[k] = WAVE_MISS;
    }
    for (size_t f = 0; f < w->plan->field_count; f++) closest_on_field(w, r, f);
    for (size_t c = w->plan->field_count; c < w->plan->shape_count; c++) closest_on_cylinder(w, r, c);
    wave_lap(w, WAVE_RAYS);
}

/* ---- hidden lights ------------------------------------------------------------------------------------------------ */

static void hide_by_field(wave *w, const wave_shadows *s, size_t light, size_t f) {
    const plan *p = w->plan;
    size_t asked = 0;
    for (size_t k = 0; k < s->segment_count; k++) {
        const wave_segment *g = &s->segments[k];
        for (size_t first = g->begin; first < g->end; first += WAVE_STRIP) {
            moved m;
            move_shadows(plan_map_to(p, f, g->home), s, p->shapes[f].lights[light], first, g->end, &m);
            /* What begins on the field begins in its box. */
            if (p->general || g->home == plan_home(f))
                all_pass(&m);
            else
                pass_box(&p->shapes[f], &m);
            for (size_t q = 0; f > 0 && q < m.rays; q++) m.passes[q] &= w->hidden[first + q] == 0;
            asked = ask(w, asked, &m);
        }
    }
    if (asked == 0) return;
    wave_lap(w, WAVE_RAYS);
    w->tracer->any(w->tracer->context, f, w->asked, asked, w->yes);
    wave_lap(w, WAVE_TRACE);
    w->stats.field_queries += asked;
    for (size_t k = 0; k < asked; k++) w->hidden[w->asked_of[k]] |= w->yes[k];
}

/* Segments with both ends inside of a cylinder stay there. */
static void hide_by_cylinder(wave *w, const wave_shadows *s, size_t light, size_t shape) {
    const plan *p = w->plan;
    const size_t cylinders = p->shape_count - p->field_count;
    for (size_t k = 0; k < s->segment_count; k++) {
        const wave_segment *g = &s->segments[k];
        if (!p->blocks[(light * p->shape_count + g->home - 1) * cylinders + shape - p->field_count]) continue;
        const float *end = p->shapes[shape].lights[light];
        const bool light_inside = end[0] * end[0] + end[1] * end[1] < 1;
        for (size_t first = g->begin; first < g->end; first += WAVE_STRIP) {
            moved m;
            move_shadows(plan_map_to(p, shape, g->home), s, end, first, g->end, &m);
            int32_t *hidden = &w->hidden[first];
            for (size_t q = 0; q < m.rays; q++) {
                const float x = m.org[0][q] + m.tmin[q] * m.dir[0][q], y = m.org[1][q] + m.tmin[q] * m.dir[1][q];
                const float t = cylinder_t(m.org[0][q], m.org[1][q], m.org[2][q], m.dir[0][q], m.dir[1][q], m.dir[2][q],
                                           m.tmin[q], 1);
                const int32_t stays = light_inside & (x * x + y * y < 1);
                hidden[q] |= (t < INFINITY) & (stays == 0);
            }
        }
    }
}

/* Traces the ways to a light and adds what gets through. */
static void trace_shadows(wave *w, size_t light) {
    wave_shadows *s = &w->shadows[light];
    const plan *p = w->plan;
    if (s->count == 0) return;
    memset(w->hidden, 0, s->count * sizeof w->hidden[0]);
    for (size_t f = 0; f < p->field_count; f++) hide_by_field(w, s, light, f);
    for (size_t c = p->field_count; c < p->shape_count; c++) hide_by_cylinder(w, s, light, c);
    wave_lap(w, WAVE_RAYS);
    for (size_t k = 0; k < s->count; k++) {
        if (w->hidden[k]) continue;
        double *sum = w->sum[s->pixel[k]];
        for (int c = 0; c < 3; c++) sum[c] += (double)s->light[c][k];
    }
    wave_lap(w, WAVE_FILM);
    w->stats.shadow_rays += s->count;
}

#endif
