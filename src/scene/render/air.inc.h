/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_AIR_INC_H
#define CELLWALK_SCENE_AIR_INC_H

#include "lanes.h"
#include "wave.h"

/* Sky, haze and level water. A scene without them runs none of this. */

/* ---- sky --------------------------------------------------------------------------------------------------------- */

/* The share of the difference to white that is added toward the sun. */
LANE_INLINE float glow_of(float toward) {
    const float near = toward > 0 ? toward : 0, second = near * near, fourth = second * second,
                eighth = fourth * fourth;
    const float far = eighth * eighth, disc = far * far * far * far;
    return 0.15f * eighth + 0.5f * disc * disc;
}

/* The sky's colour: rise is the sine of the angle over the horizon, toward the cosine of that to the sun. Below the
 * horizon the plain is seen through so much air as lies before it. */
LANE_INLINE void vault_colour(const sky *s, float rise, float toward, float colour[3]) {
    static const float warm[3] = {1, 0.95f, 0.85f};
    const float low = rise > 0 ? 1 - rise : 1, share = 1 - low * low * low, glow = glow_of(toward);
    const float left = rise < 0 ? lane_halved(s->plain_haze * s->eye_height / -rise) : 0;
    for (int c = 0; c < 3; c++) {
        const float clear = s->horizon[c] + share * (s->above[c] - s->horizon[c]);
        const float bright = clear + glow * (clear < warm[c] ? warm[c] - clear : 0);
        colour[c] = bright + left * (s->plain[c] - bright);
    }
}

LANE_INLINE void sky_colour(const sky *s, float rise, float toward, float colour[3]) {
    if (s->vault) {
        vault_colour(s, rise, toward, colour);
        return;
    }
    const float share = rise > 0 ? rise : 0;
    for (int c = 0; c < 3; c++) colour[c] = s->horizon[c] + share * (s->above[c] - s->horizon[c]);
}

/* For rays that met nothing: of the camera, or mirrored by water. up and sun are in their space. */
static void add_sky(wave *w, const wave_rays *r, const float up[3], const float sun[3]) {
    const sky s = *w->plan->scene->sky;
    const bool mirrored = r != &w->rays[0] || r->segments[0].home != PLAN_CAMERA;
    for (size_t k = 0; k < r->count; k++) {
        if (w->shape[k] != WAVE_MISS) continue;
        const float x = r->dir[0][k], y = r->dir[1][k], z = r->dir[2][k];
        float colour[3];
        sky_colour(&s, lane_dot(x, y, z, up[0], up[1], up[2]), lane_dot(x, y, z, sun[0], sun[1], sun[2]), colour);
        for (int c = 0; c < 3; c++)
            w->sum[c][r->pixel[k]] += (double)(mirrored ? r->share[c][k] * colour[c] : colour[c]);
    }
}

/* ---- haze -------------------------------------------------------------------------------------------------------- */

/* Takes haze's share of the light of a strip's first n paths, and adds that of the air before them. */
static void add_haze(wave *w, const wave_rays *r, size_t home, size_t n) {
    wave_strip *s = &w->strip;
    const float haze = w->plan->scene->haze;
    const float *horizon = w->plan->scene->sky->horizon;
    float left[WAVE_STRIP];
    for (size_t k = 0; k < wave_whole(s->n); k++) left[k] = lane_halved(haze * s->t[k]);
    for (int c = 0; c < 3; c++) {
        for (size_t k = 0; k < wave_whole(s->n); k++) s->colour[c][k] *= left[k];
        for (size_t k = 0; k < n; k++) {
            const size_t path = s->path[k];
            const float share = home == PLAN_CAMERA ? 1 : r->share[c][path];
            w->sum[c][r->pixel[path]] += (double)(share * (1 - left[k]) * horizon[c]);
        }
    }
}

/* ---- water ------------------------------------------------------------------------------------------------------- */

/* Camera rays that come to the water's plane over the field, before they meet the ground, end there. */
static void meet_water(wave *w) {
    const plan *p = w->plan;
    const plan_shape *field = &p->shapes[0];
    const wave_rays *r = &w->rays[0];
    const plan_map map = plan_map_to(p, 0, PLAN_CAMERA);
    const float down = p->scene->water->level - map.m[2][3];
    if (!(down < 0)) return; /* the eye is not above the water */
    for (size_t k = 0; k < r->count; k++) {
        const float x = r->dir[0][k], y = r->dir[1][k], z = r->dir[2][k], t = down / lane_turn(map.m[2], x, y, z);
        if (!(t > 0 && t < w->t[k])) continue;
        const float i = map.m[0][3] + t * lane_turn(map.m[0], x, y, z);
        const float j = map.m[1][3] + t * lane_turn(map.m[1], x, y, z);
        if (!(i >= 0 && j >= 0 && i <= field->high[0] && j <= field->high[1])) continue;
        w->t[k] = t;
        w->shape[k] = WAVE_WATER;
    }
}

/* The share of light that water reflects, by the cosine of the light's angle to its normal (Schlick 1994). */
LANE_INLINE float mirrored_share(float cosine) {
    const float rest = 1 - cosine, second = rest * rest;
    return 0.02f + 0.98f * (second * second * rest);
}

/* How the mirrored ray's neighbours differ: their points are in the water's plane, their directions mirrored. */
static void spread_from_water(const plan_shape *field, const float dir[3], float t, float depth, wave_spread *spread,
                              size_t to) {
    for (int a = 0; a < 2; a++) {
        float e[3];
        for (int c = 0; c < 3; c++) e[c] = depth * field->step[a][c];
        const float further = t * e[2] / dir[2];
        for (int c = 0; c < 3; c++) {
            spread->org[a][c][to] = c < 2 ? t * e[c] - further * dir[c] : 0;
            spread->dir[a][c][to] = c < 2 ? e[c] : -e[c];
        }
    }
}

/* Light from the water, and mirrored rays, which join the next wave. */
static void shade_water(wave *w, wave_rays *next) {
    const plan *p = w->plan;
    const scene *s = p->scene;
    const wave_rays *r = &w->rays[0];
    const plan_map map = plan_map_to(p, 0, PLAN_CAMERA);
    const size_t begin = next->count;
    for (size_t k = 0; k < r->count; k++) {
        if (w->shape[k] != WAVE_WATER) continue;
        const size_t to = next->count++;
        float dir[3];
        for (int c = 0; c < 3; c++) dir[c] = lane_turn(map.m[c], r->dir[0][k], r->dir[1][k], r->dir[2][k]);
        const float t = w->t[k], cosine = -lane_dot(dir[0], dir[1], dir[2], p->up[0], p->up[1], p->up[2]);
        const float mirrored = mirrored_share(cosine < 1 ? cosine : 1),
                    left = s->haze > 0 ? lane_halved(s->haze * t) : 1;
        for (int c = 0; c < 3; c++) {
            next->org[c][to] = c < 2 ? map.m[c][3] + t * dir[c] : s->water->level;
            next->dir[c][to] = c < 2 ? dir[c] : -dir[c];
            next->share[c][to] = left * mirrored;
            w->sum[c][r->pixel[k]] +=
                (double)(left * (1 - mirrored) * s->water->colour[c] + (1 - left) * s->sky->horizon[c]);
        }
        next->tmin[to] = 0;
        next->pixel[to] = r->pixel[k];
        if (p->spreads) spread_from_water(&p->shapes[0], dir, t, r->dir[2][k], next->spread, to);
    }
    if (next->count == begin) return;
    next->segments[next->segment_count++] = (wave_segment){plan_home(0), begin, next->count};
    w->stats.mirror_rays += next->count - begin;
}

#endif
