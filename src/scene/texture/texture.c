/* SPDX-License-Identifier: Apache-2.0 */
#include "texture.h"

#include "large.h"

#include "half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint16_t *texel(const texture *t, const texture_level *l, int32_t x, int32_t y) {
    return t->texels + 4 * ((size_t)l->first + (size_t)y * (size_t)l->stride + (size_t)(x + 1));
}

/* The stretch of a row of n texels that texel k of a row of half as many covers: texels first … last, the outer two by
 * a part of their width where n is odd. */
static void covered(int32_t n, int32_t halved, int32_t k, int32_t *first, int32_t *last, float *first_part,
                    float *last_part) {
    const double low = (double)k * (double)n / (double)halved, high = (double)(k + 1) * (double)n / (double)halved;
    *first = (int32_t)low;
    *last = (int32_t)ceil(high) - 1;
    if (*last >= n) *last = n - 1;
    *first_part = (float)((double)(*first + 1) - low);
    *last_part = (float)(high - (double)*last);
}

/* The mean of four texels: the usual case of even sides. */
static void halve_row(const texture *t, const texture_level *from, const texture_level *to, int32_t y) {
    const uint16_t *restrict above = texel(t, from, 0, 2 * y), *restrict below = texel(t, from, 0, 2 * y + 1);
    uint16_t *restrict out = texel(t, to, 0, y);
    for (int32_t x = 0; x < to->width; x++)
        for (int c = 0; c < 4; c++) {
            const float left = half_number(above[8 * x + c]), right = half_number(above[8 * x + 4 + c]);
            const float low_left = half_number(below[8 * x + c]), low_right = half_number(below[8 * x + 4 + c]);
            out[4 * x + c] = half_from_float(((left + right) + (low_left + low_right)) * 0.25f);
        }
}

/* The mean of the texels under each one of the smaller level. */
static void shrink_row(const texture *t, const texture_level *from, const texture_level *to, int32_t y) {
    for (int32_t x = 0; x < to->width; x++) {
        int32_t x0, x1, y0, y1;
        float left, right, top, bottom, sum[4] = {0, 0, 0, 0}, total = 0;
        covered(from->width, to->width, x, &x0, &x1, &left, &right);
        covered(from->height, to->height, y, &y0, &y1, &top, &bottom);
        for (int32_t j = y0; j <= y1; j++)
            for (int32_t i = x0; i <= x1; i++) {
                const float wx = x0 == x1 ? 1 : i == x0 ? left : i == x1 ? right : 1;
                const float wy = y0 == y1 ? 1 : j == y0 ? top : j == y1 ? bottom : 1;
                const uint16_t *in = texel(t, from, i, j);
                for (int c = 0; c < 4; c++) sum[c] += wx * wy * half_number(in[c]);
                total += wx * wy;
            }
        uint16_t *out = texel(t, to, x, y);
        for (int c = 0; c < 4; c++) out[c] = half_from_float(sum[c] / total);
    }
}

/* The texel more on each side. */
static void repeat_row(const texture *t, const texture_level *l, int32_t y) {
    memcpy(texel(t, l, -1, y), texel(t, l, l->width - 1, y), 4 * sizeof(uint16_t));
    memcpy(texel(t, l, l->width, y), texel(t, l, 0, y), 4 * sizeof(uint16_t));
}

/* False if there are too many texels for their numbers. A level has at most half the texels of the level before and one
 * more, for the outer two of a row: below the finest there are at most as many as in it and 62, with room for 64. */
static bool lay_out(texture *t, size_t width, size_t height, size_t *texels) {
    *texels = 0;
    for (t->count = 1;; t->count++) {
        const size_t stride = width + 2;
        if (width > INT32_MAX / 4 || stride * height > INT32_MAX / 4 - *texels) return false;
        t->levels[t->count - 1] = (texture_level){(int32_t)width, (int32_t)height, (int32_t)stride, (int32_t)*texels};
        *texels += stride * height;
        if (width == 1 && height == 1) return true;
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
    }
}

static void build_levels(texture *t) {
    for (int k = 1; k < t->count; k++) {
        const texture_level *from = &t->levels[k - 1], *to = &t->levels[k];
        for (int32_t y = 0; y < to->height; y++) {
            if (from->width % 2 == 0 && from->height % 2 == 0)
                halve_row(t, from, to, y);
            else
                shrink_row(t, from, to, y);
            repeat_row(t, to, y);
        }
    }
}

bool texture_fill(texture *t, io_image *image) {
    size_t texels = 0;
    if (!lay_out(t, image->width, image->height, &texels)) return false;
    t->texels = image->halves; /* it has room for all levels and stands where the finest one does */
    image->halves = NULL;
    for (int32_t y = 0; y < t->levels[0].height; y++) repeat_row(t, &t->levels[0], y);
    build_levels(t);
    return true;
}

void texture_free(texture *t) {
    if (t == NULL) return;
    large_release(t->texels);
    free(t);
}
