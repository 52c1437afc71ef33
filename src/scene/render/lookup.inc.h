/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_LOOKUP_INC_H
#define CELLWALK_SCENE_LOOKUP_INC_H

#include "lanes.h"
#include "wave.h"

#include <string.h>

/* Colours of an image for a strip of paths. A pyramid of halved images is read at a level as fine as the footprint of a
 * sample is wide, in as many probes along its length as it is longer (McCormack et al. 1999): one where it is nearly
 * round. Footprints longer than eight times their width are widened, which bounds the cost. */

/* A footprint is at most this many times as long as wide, and by so much of its width it may be longer before it takes
 * another probe. */
static const float probes_most = 8, probes_slack = 0.5f;

/* The logarithm to base 2 of a normal number, within 1.2·10^-4. */
LANE_INLINE float lane_log2(float x) {
    union {
        float f;
        uint32_t bits;
    } whole = {x}, part;
    part.bits = (whole.bits & 0x7fffff) | 0x3f800000;
    const float t = part.f - 1, exponent = (float)((int32_t)(whole.bits >> 23) - 127);
    const float bend = (-0.0821298910f * t + 0.239057400f) * t - 0.438725559f;
    return exponent + t * (1 + (t - 1) * bend);
}

/* (GCC turns choices that follow from one another in one loop into branches, hence three.) */
static void find_footprints(const wave_strip *restrict s, const texture *t, wave_footprints *restrict f) {
    const size_t n = wave_whole(s->n);
    const float width = (float)t->levels[0].width, height = (float)t->levels[0].height, last = (float)(t->count - 1);
    const float most = probes_most * probes_most;
    float longer[WAVE_STRIP], shorter[WAVE_STRIP], level[WAVE_STRIP], ratio[WAVE_STRIP];
    for (size_t k = 0; k < n; k++) {
        /* Squares of lengths in texels of the image itself. */
        const float au = s->uv_apart[0][0][k], av = s->uv_apart[0][1][k];
        const float bu = s->uv_apart[1][0][k], bv = s->uv_apart[1][1][k];
        const float ax = au * width, ay = av * height, bx = bu * width, by = bv * height;
        const float a = ax * ax + ay * ay, b = bx * bx + by * by;
        longer[k] = a > b ? a : b;
        shorter[k] = a > b ? b : a;
        f->axis[0][k] = a > b ? au : bu;
        f->axis[1][k] = a > b ? av : bv;
    }
    for (size_t k = 0; k < n; k++) {
        const float least = longer[k] * (1 / most), minor = shorter[k] > least ? shorter[k] : least;
        /* The level whose texels are as wide as the short axis; the image itself is the finest. */
        const float number = 0.5f * lane_log2(minor);
        level[k] = number < last ? number : last;
        const float times = longer[k] / (minor > 1 ? minor : 1);
        ratio[k] = times < most ? times : most;
    }
    for (size_t k = 0; k < n; k++) {
        const float at = (level[k] + fabsf(level[k])) * 0.5f; /* not below 0 */
        const int32_t whole = (int32_t)at, count = lane_ceil(sqrtf(ratio[k]) - probes_slack);
        f->level[k] = whole;
        f->share[k] = at - (float)whole;
        f->count[k] = count > 1 ? count : 1;
    }
}

/* Does each path take one probe, of the image itself and no coarser level? */
static bool are_plain(const wave_strip *s, const wave_footprints *f) {
    int32_t other = 0;
    for (size_t k = 0; k < wave_whole(s->n); k++) other |= f->level[k] | (f->count[k] - 1) | (f->share[k] > 0);
    return other == 0;
}

static void add_probes(const wave_strip *s, const wave_footprints *f, size_t k, int32_t level, float weight,
                       wave_probes *p) {
    const float step = 1 / (float)f->count[k];
    for (int32_t q = 0; q < f->count[k]; q++) {
        const float along = ((float)q + 0.5f) * step - 0.5f;
        p->u[p->n] = s->uv[0][k] + along * f->axis[0][k];
        p->v[p->n] = s->uv[1][k] + along * f->axis[1][k];
        p->weight[p->n] = weight * step;
        p->level[p->n] = level;
        p->of[p->n++] = (int32_t)k;
    }
}

static void list_probes(const wave_strip *s, const wave_footprints *f, wave_probes *p) {
    p->n = 0;
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        add_probes(s, f, k, f->level[k], 1 - f->share[k], p);
        if (f->share[k] > 0) add_probes(s, f, k, f->level[k] + 1, f->share[k], p);
    }
}

/* The fractional part, in [0, 1]; 0 for numbers too large to have one. */
LANE_INLINE float lane_part(float x) {
    union {
        float f;
        uint32_t bits;
    } near = {x};
    near.bits &= 0u - (uint32_t)(fabsf(x) < 0x1p23f);
    return near.f - (float)lane_floor(near.f);
}

/* The texels that a probe reads of a level: rows and columns repeat with the image. (In two steps, without a choice:
 * else GCC makes branches of it.) */
LANE_INLINE void place_probe(wave_probes *p, size_t k, float width, float height) {
    p->right[k] = lane_part(p->u[k]) * width - 0.5f;
    p->down[k] = lane_part(p->v[k]) * height - 0.5f;
}
/* In an image that clamps, a probe lies between the middles of the outer texels, where the far side's have weight 0. */
LANE_INLINE float clamped(float x, float last) {
    const float from = x > 0 ? x : 0;
    return from < last ? from : last;
}
LANE_INLINE void clamp_probe(wave_probes *p, size_t k, float width, float height) {
    p->right[k] = clamped(p->u[k] * width - 0.5f, width - 1);
    p->down[k] = clamped(p->v[k] * height - 0.5f, height - 1);
}
LANE_INLINE void place_texels(wave_probes *p, size_t k, int32_t rows, int32_t stride, int32_t first) {
    const float x = p->right[k], y = p->down[k];
    const int32_t i = lane_floor(x), j = lane_floor(y);
    const int32_t above = j + (rows & -(j < 0)), below = j + 1 - (rows & -(j + 1 >= rows));
    p->right[k] = x - (float)i;
    p->down[k] = y - (float)j;
    p->above[k] = first + above * stride + i + 1;
    p->below[k] = first + below * stride + i + 1;
}

static void place_probes(const texture *t, wave_probes *p) {
    const size_t n = wave_lanes(p->n);
    for (size_t k = p->n; k < n; k++) {
        p->u[k] = p->v[k] = 0;
        p->level[k] = 0;
    }
    float width[TEXTURE_LEVELS], height[TEXTURE_LEVELS];
    int32_t rows[TEXTURE_LEVELS], stride[TEXTURE_LEVELS], first[TEXTURE_LEVELS];
    for (int k = 0; k < t->count; k++) {
        const texture_level *l = &t->levels[k];
        width[k] = (float)l->width;
        height[k] = (float)l->height;
        rows[k] = l->height;
        stride[k] = l->stride;
        first[k] = l->first;
    }
    if (t->clamps)
        for (size_t k = 0; k < n; k++) clamp_probe(p, k, width[p->level[k]], height[p->level[k]]);
    else
        for (size_t k = 0; k < n; k++) place_probe(p, k, width[p->level[k]], height[p->level[k]]);
    for (size_t k = 0; k < n; k++) place_texels(p, k, rows[p->level[k]], stride[p->level[k]], first[p->level[k]]);
}

/* One of the image itself for each path. */
static void place_plain_probes(const wave_strip *s, const texture *t, wave_probes *p) {
    const texture_level l = t->levels[0];
    const float width = (float)l.width, height = (float)l.height;
    memcpy(p->u, s->uv[0], sizeof s->uv[0]);
    memcpy(p->v, s->uv[1], sizeof s->uv[1]);
    if (t->clamps)
        for (size_t k = 0; k < wave_whole(s->n); k++) clamp_probe(p, k, width, height);
    else
        for (size_t k = 0; k < wave_whole(s->n); k++) place_probe(p, k, width, height);
    for (size_t k = 0; k < wave_whole(s->n); k++) place_texels(p, k, l.height, l.stride, l.first);
}

/* A half, given as a signed number, as a float: exactly, as half_number does it. */
LANE_INLINE float lane_half(int32_t half) {
    union {
        uint32_t bits;
        float f;
    } value = {((uint32_t)half << 13) & 0x8fffe000u};
    return value.f * 0x1p112f;
}

/* The interpolated colour at a probe; the fourth is 0. Two texels side by side are eight halves: a vector. */
LANE_INLINE void read_probe(const uint16_t *above, const uint16_t *below, float right, float down, float colour[4]) {
    float pair[8];
    for (int k = 0; k < 8; k++) {
        const float high = lane_half((int16_t)above[k]), low = lane_half((int16_t)below[k]);
        pair[k] = high + down * (low - high);
    }
    for (int c = 0; c < 4; c++) colour[c] = pair[c] + right * (pair[4 + c] - pair[c]);
}

/* The colours at up to WAVE_STRIP probes from first on. */
static void read_probes(const texture *t, const wave_probes *p, size_t first, size_t n, float colour[WAVE_STRIP][4]) {
    for (size_t k = 0; k < n; k++)
        read_probe(t->texels + 4 * (size_t)p->above[first + k], t->texels + 4 * (size_t)p->below[first + k],
                   p->right[first + k], p->down[first + k], colour[k]);
}

/* Sets the strip's colours, which are never below 0. */
static void look_up(wave *w, const texture *t) {
    wave_strip *s = &w->strip;
    wave_footprints *f = &w->footprints;
    wave_probes *p = &w->probes;
    float sum[WAVE_STRIP][4];
    find_footprints(s, t, f);
    if (!w->plan->general && are_plain(s, f)) {
        place_plain_probes(s, t, p);
        read_probes(t, p, 0, s->n, sum);
    } else {
        list_probes(s, f, p);
        place_probes(t, p);
        memset(sum, 0, s->n * sizeof sum[0]);
        for (size_t first = 0; first < p->n; first += WAVE_STRIP) {
            const size_t n = wave_strip_of(first, p->n);
            float colour[WAVE_STRIP][4];
            read_probes(t, p, first, n, colour);
            for (size_t k = 0; k < n; k++)
                for (int c = 0; c < 4; c++) sum[p->of[first + k]][c] += p->weight[first + k] * colour[k][c];
        }
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float red = sum[k][0], green = sum[k][1], blue = sum[k][2];
        s->colour[0][k] = red > 0 ? red : 0;
        s->colour[1][k] = green > 0 ? green : 0;
        s->colour[2][k] = blue > 0 ? blue : 0;
    }
}

#endif
