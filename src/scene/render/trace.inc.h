/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_TRACE_INC_H
#define CELLWALK_SCENE_TRACE_INC_H

#include "lanes.h"
#include "wave.h"

#include <string.h>

/* A wave's rays against the scene's shapes: moved to a field and asked of it where they pass through its box, and
 * met with cylinders in closed form. */

/* WAVE_LANES rays in a shape's space. Loops over them have a known length, and their callers are compiled into one
 * body, so that all this stays in registers. */
typedef struct moved {
    float org[3][WAVE_LANES], dir[3][WAVE_LANES], tmin[WAVE_LANES], tmax[WAVE_LANES];
} moved;

/* Where rays come from: all from one point; from this very shape; or from somewhere else. */
typedef enum origin { FROM_CAMERA, FROM_HERE, FROM_ELSEWHERE } origin;

static origin origin_of(size_t home, size_t shape) {
    return home == PLAN_CAMERA ? FROM_CAMERA : home == plan_home(shape) ? FROM_HERE : FROM_ELSEWHERE;
}

/* The rays of a wave from first on. */
LANE_INLINE void move_rays(const plan_map *map, origin from, const float *restrict t, const wave_rays *restrict r,
                           size_t first, moved *restrict out) {
    const float *dx = &r->dir[0][first], *dy = &r->dir[1][first], *dz = &r->dir[2][first];
    const float *ox = &r->org[0][first], *oy = &r->org[1][first], *oz = &r->org[2][first];
    const float *tmin = &r->tmin[first];
    for (int c = 0; c < 3; c++) {
        const float a = map->m[c][0], b = map->m[c][1], d = map->m[c][2], e = map->m[c][3], row[4] = {a, b, d, e};
        for (int k = 0; k < WAVE_LANES; k++)
            out->dir[c][k] = from == FROM_HERE ? r->dir[c][first + (size_t)k] : lane_turn(row, dx[k], dy[k], dz[k]);
        for (int k = 0; k < WAVE_LANES; k++)
            out->org[c][k] = from == FROM_CAMERA ? e
                             : from == FROM_HERE ? r->org[c][first + (size_t)k]
                                                 : lane_move(row, ox[k], oy[k], oz[k]);
    }
    for (int k = 0; k < WAVE_LANES; k++) {
        out->tmin[k] = from == FROM_CAMERA ? 0 : tmin[k];
        out->tmax[k] = t[first + (size_t)k];
    }
}

/* Segments to a light, where t is 1. */
LANE_INLINE void move_shadows(const plan_map *map, origin from, const float light[3], const wave_shadows *restrict s,
                              size_t first, moved *restrict out) {
    const float *ox = &s->org[0][first], *oy = &s->org[1][first], *oz = &s->org[2][first], *tmin = &s->tmin[first];
    for (int c = 0; c < 3; c++) {
        const float a = map->m[c][0], b = map->m[c][1], d = map->m[c][2], e = map->m[c][3], row[4] = {a, b, d, e};
        const float to = light[c];
        for (int k = 0; k < WAVE_LANES; k++) {
            const float org = from == FROM_HERE ? s->org[c][first + (size_t)k] : lane_move(row, ox[k], oy[k], oz[k]);
            out->org[c][k] = org;
            out->dir[c][k] = to - org;
        }
    }
    for (int k = 0; k < WAVE_LANES; k++) {
        out->tmin[k] = tmin[k];
        out->tmax[k] = 1;
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

/* Whether each ray passes through a shape's box between tmin and tmax, 1 or 0. Each t has three roundings, so it is
 * off by less than 2^-22 of itself, and its sign is right: with that much room no ray is left out that passes. */
LANE_INLINE void pass_box(const plan_shape *shape, const moved *restrict m, uint8_t *restrict passes) {
    const float room = 1 + 0x1p-21f;
    float low[3], high[3];
    memcpy(low, shape->low, sizeof low);
    memcpy(high, shape->high, sizeof high);
    int32_t within[WAVE_LANES]; /* as wide as floats: bytes would make all of the loop's vectors short */
    for (int k = 0; k < WAVE_LANES; k++) {
        float enter = m->tmin[k], leave = m->tmax[k];
        const float ix = 1 / m->dir[0][k], iy = 1 / m->dir[1][k], iz = 1 / m->dir[2][k];
        enter = later_entry(enter, low[0], high[0], m->org[0][k], ix);
        enter = later_entry(enter, low[1], high[1], m->org[1][k], iy);
        enter = later_entry(enter, low[2], high[2], m->org[2][k], iz);
        leave = earlier_exit(leave, low[0], high[0], m->org[0][k], ix);
        leave = earlier_exit(leave, low[1], high[1], m->org[1][k], iy);
        leave = earlier_exit(leave, low[2], high[2], m->org[2][k], iz);
        within[k] = enter <= leave * room;
    }
    for (int k = 0; k < WAVE_LANES; k++) passes[k] = (uint8_t)within[k];
}

/* How many of WAVE_LANES pass. */
LANE_INLINE size_t count_passes(const uint8_t *passes) {
    uint64_t half[2];
    memcpy(half, passes, sizeof half);
    return (size_t)((half[0] + half[1]) * 0x0101010101010101u >> 56);
}

/* The rays one after the other: eight arrays woven into one in three steps, for which there are vector instructions. */
LANE_INLINE void line_up(const moved *m, cw_ray *out) {
    float pair[4][2 * WAVE_LANES], quad[2][4 * WAVE_LANES], ray[8 * WAVE_LANES];
    lane_weave(m->org[0], m->dir[0], WAVE_LANES, pair[0]);
    lane_weave(m->org[2], m->dir[2], WAVE_LANES, pair[1]);
    lane_weave(m->org[1], m->dir[1], WAVE_LANES, pair[2]);
    lane_weave(m->tmin, m->tmax, WAVE_LANES, pair[3]);
    lane_weave(pair[0], pair[1], 2 * WAVE_LANES, quad[0]);
    lane_weave(pair[2], pair[3], 2 * WAVE_LANES, quad[1]);
    lane_weave(quad[0], quad[1], 4 * WAVE_LANES, ray);
    memcpy(out, ray, sizeof ray);
}

/* Appends the rays from first on to the query of a field, and returns the number of rays in it. */
LANE_INLINE size_t ask_all(wave *w, size_t asked, const moved *m, size_t first, size_t rays) {
    line_up(m, &w->asked[asked]);
    uint32_t *of = &w->asked_of[asked];
    for (size_t k = 0; k < WAVE_LANES; k++) of[k] = (uint32_t)(first + k);
    return asked + (rays < WAVE_LANES ? rays : WAVE_LANES);
}

/* Appends those of them that pass. Mostly all pass or none. */
LANE_INLINE size_t ask(wave *w, size_t asked, const moved *m, uint8_t *passes, size_t first, size_t rays) {
    for (size_t k = rays; k < WAVE_LANES; k++) passes[k] = 0; /* the next segment's */
    const size_t passing = count_passes(passes);
    if (passing == 0) return asked;
    ask_all(w, asked, m, first, rays);
    if (passing == WAVE_LANES) return asked + WAVE_LANES;
    cw_ray *to = &w->asked[asked];
    uint32_t *of = &w->asked_of[asked];
    size_t kept = 0;
    for (size_t k = 0; k < WAVE_LANES; k++) {
        to[kept] = to[k];
        of[kept] = of[k];
        kept += passes[k];
    }
    return asked + kept;
}

/* ---- closest hits ------------------------------------------------------------------------------------------------ */

LANE_INLINE size_t ask_closest(wave *w, const wave_rays *r, const wave_segment *g, size_t f, size_t asked,
                               origin from) {
    const plan *p = w->plan;
    const plan_map map = plan_map_to(p, f, g->home);
    for (size_t first = g->begin; first < g->end; first += WAVE_LANES) {
        moved m;
        move_rays(&map, from, w->t, r, first, &m);
        if (p->general) {
            asked = ask_all(w, asked, &m, first, g->end - first);
            continue;
        }
        uint8_t passes[WAVE_LANES];
        pass_box(&p->shapes[f], &m, passes);
        asked = ask(w, asked, &m, passes, first, g->end - first);
    }
    return asked;
}

/* The rays of one segment. The constants pick the code that is compiled. */
static size_t ask_segment(wave *w, const wave_rays *r, const wave_segment *g, size_t f, size_t asked) {
    const origin from = origin_of(g->home, f);
    return from == FROM_CAMERA ? ask_closest(w, r, g, f, asked, FROM_CAMERA)
           : from == FROM_HERE ? ask_closest(w, r, g, f, asked, FROM_HERE)
                               : ask_closest(w, r, g, f, asked, FROM_ELSEWHERE);
}

static void closest_on_field(wave *w, const wave_rays *r, size_t f) {
    size_t asked = 0;
    for (size_t s = 0; s < r->segment_count; s++) asked = ask_segment(w, r, &r->segments[s], f, asked);
    if (asked == 0) return;
    cw_hit *answers = w->answers[f];
    w->tracer->closest(w->tracer->context, f, w->asked, asked, answers);
    w->stats.field_queries += asked;
    for (size_t k = 0; k < asked; k++) {
        const size_t of = w->asked_of[k];
        const float found = answers[k].t;
        if (!(found < w->t[of])) continue;
        w->t[of] = found;
        w->shape[of] = (int32_t)f;
        w->hit[of] = (uint32_t)k;
    }
}

/* Where a ray meets the side of a cylinder of radius 1 between z = -1 and z = 1, in its space; infinity if nowhere
 * between tmin and tmax. (o + t d)² - 1 in x and y is a t² + 2 half t + c, and its discriminant is a minus the
 * square of the cross product of o and d, a form in which nothing cancels that matters. */
LANE_INLINE float cylinder_t(float ox, float oy, float oz, float dx, float dy, float dz, float tmin, float tmax) {
    const float a = dx * dx + dy * dy, half = ox * dx + oy * dy, c = ox * ox + oy * oy - 1;
    const float across = ox * dy - oy * dx, square = a - across * across;
    const float root = sqrtf(square > 0 ? square : 0);
    /* The sum that does not cancel; one solution is q / a, the other c / q. */
    const float q = half < 0 ? root - half : -root - half;
    const float far = (half < 0 ? q : c) / (half < 0 ? a : q);
    /* From inside, the nearer one lies behind. */
    const int inside = (c < 0) & (tmin >= 0);
    const float near = (half < 0 ? c : q) / (half < 0 ? q : a);
    const int near_holds = (inside == 0) & (near >= tmin) & (near <= tmax) & (fabsf(oz + near * dz) <= 1);
    const int far_holds = (far >= tmin) & (far <= tmax) & (fabsf(oz + far * dz) <= 1);
    const float t = near_holds ? near : far_holds ? far : INFINITY;
    return ((a > 0) & (square >= 0)) ? t : INFINITY;
}

LANE_INLINE void meet_cylinder(wave *w, const wave_rays *r, const wave_segment *g, size_t shape, origin from) {
    const plan_map map = plan_map_to(w->plan, shape, g->home);
    for (size_t first = g->begin; first < g->end; first += WAVE_LANES) {
        moved m;
        float found[WAVE_LANES];
        move_rays(&map, from, w->t, r, first, &m);
        for (int k = 0; k < WAVE_LANES; k++)
            found[k] = cylinder_t(m.org[0][k], m.org[1][k], m.org[2][k], m.dir[0][k], m.dir[1][k], m.dir[2][k],
                                  m.tmin[k], m.tmax[k]);
        for (size_t k = g->end - first; k < WAVE_LANES; k++) found[k] = INFINITY; /* the next segment's */
        float *t = &w->t[first];
        int32_t *which = &w->shape[first];
        for (int k = 0; k < WAVE_LANES; k++) {
            which[k] = found[k] < m.tmax[k] ? (int32_t)shape : which[k];
            t[k] = found[k] < m.tmax[k] ? found[k] : m.tmax[k];
        }
    }
}

static void closest_on_cylinder(wave *w, const wave_rays *r, size_t shape) {
    for (size_t s = 0; s < r->segment_count; s++) {
        const wave_segment *g = &r->segments[s];
        if (g->home == PLAN_CAMERA)
            meet_cylinder(w, r, g, shape, FROM_CAMERA);
        else
            meet_cylinder(w, r, g, shape, FROM_ELSEWHERE);
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
}

/* ---- hidden lights ----------------------------------------------------------------------------------------------- */

/* Ways to a light stay in the order of their pixels. Sorted by the cells where they begin they are traced in 0.76 to
 * 0.98 of the time, by direction in 0.99 to 1.17, shuffled in 2.5: the best sort would save up to 5 ns a ray, less
 * than it takes. */

LANE_INLINE size_t ask_any(wave *w, const wave_shadows *s, const wave_segment *g, const float *light, size_t f,
                           size_t asked, origin from) {
    const plan *p = w->plan;
    const plan_map map = plan_map_to(p, f, g->home);
    for (size_t first = g->begin; first < g->end; first += WAVE_LANES) {
        moved m;
        move_shadows(&map, from, light, s, first, &m);
        const size_t rays = g->end - first;
        /* Paths that begin on the field begin in its box. */
        const bool all = from == FROM_HERE || p->general;
        if (all && f == 0) {
            asked = ask_all(w, asked, &m, first, rays);
            continue;
        }
        uint8_t passes[WAVE_LANES];
        if (all)
            memset(passes, 1, sizeof passes);
        else
            pass_box(&p->shapes[f], &m, passes);
        const uint8_t *hidden = &w->hidden[first];
        for (int k = 0; f > 0 && k < WAVE_LANES; k++) passes[k] &= hidden[k] ^ 1;
        asked = ask(w, asked, &m, passes, first, rays);
    }
    return asked;
}

static void hide_by_field(wave *w, const wave_shadows *s, size_t light, size_t f) {
    float place[3];
    plan_light(w->plan, f, light, place);
    size_t asked = 0;
    for (size_t k = 0; k < s->segment_count; k++) {
        const wave_segment *g = &s->segments[k];
        if (origin_of(g->home, f) == FROM_HERE)
            asked = ask_any(w, s, g, place, f, asked, FROM_HERE);
        else
            asked = ask_any(w, s, g, place, f, asked, FROM_ELSEWHERE);
    }
    if (asked == 0) return;
    w->tracer->any(w->tracer->context, f, w->asked, asked, w->yes);
    w->stats.field_queries += asked;
    for (size_t k = 0; k < asked; k++) w->hidden[w->asked_of[k]] |= w->yes[k] != 0;
}

/* Segments with both ends inside of a cylinder stay there. */
static void hide_by_cylinder(wave *w, const wave_shadows *s, size_t light, size_t shape) {
    const plan *p = w->plan;
    for (size_t k = 0; k < s->segment_count; k++) {
        const wave_segment *g = &s->segments[k];
        if (!plan_blocks(p, light, g->home, shape)) continue;
        const plan_map map = plan_map_to(p, shape, g->home);
        float end[3];
        plan_light(p, shape, light, end);
        const int32_t light_inside = end[0] * end[0] + end[1] * end[1] < 1;
        for (size_t first = g->begin; first < g->end; first += WAVE_LANES) {
            moved m;
            int32_t hides[WAVE_LANES];
            move_shadows(&map, FROM_ELSEWHERE, end, s, first, &m);
            for (int q = 0; q < WAVE_LANES; q++) {
                const float x = m.org[0][q] + m.tmin[q] * m.dir[0][q], y = m.org[1][q] + m.tmin[q] * m.dir[1][q];
                const float t = cylinder_t(m.org[0][q], m.org[1][q], m.org[2][q], m.dir[0][q], m.dir[1][q], m.dir[2][q],
                                           m.tmin[q], 1);
                const int32_t stays = light_inside & (x * x + y * y < 1);
                hides[q] = (t < INFINITY) & (stays == 0);
            }
            for (size_t q = g->end - first; q < WAVE_LANES; q++) hides[q] = 0; /* the next segment's */
            uint8_t *hidden = &w->hidden[first];
            for (int q = 0; q < WAVE_LANES; q++) hidden[q] |= (uint8_t)hides[q];
        }
    }
}

/* Traces shadow rays to a light and adds the light that is not blocked. */
static void trace_shadows(wave *w, size_t light) {
    wave_shadows *s = &w->shadows[light];
    const plan *p = w->plan;
    if (s->count == 0) return;
    memset(w->hidden, 0, wave_lanes(s->count));
    for (size_t f = 0; f < p->field_count; f++) hide_by_field(w, s, light, f);
    for (size_t c = p->field_count; c < p->shape_count; c++) hide_by_cylinder(w, s, light, c);
    for (size_t k = 0; k < s->count; k++)
        for (int c = 0; c < 3 && w->hidden[k] == 0; c++) w->sum[c][s->pixel[k]] += (double)s->light[c][k];
    w->stats.shadow_rays += s->count;
}

#endif
