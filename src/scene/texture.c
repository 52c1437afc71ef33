/* SPDX-License-Identifier: Apache-2.0 */
/* A pyramid of halved images (Williams 1983), read at a level as fine as the footprint of a sample is wide, in as many
 * probes along its length as it is longer (McCormack et al. 1999): one where it is nearly round. Footprints longer than
 * eight times their width are widened, which bounds the cost. */

#include "texture.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS_MAX = 32 };

/* A footprint is at most this many times as long as wide. */
static const float probes_most = 8;

/* By so much of its width it may be longer before it takes another probe. */
static const float probes_slack = 0.5f;

typedef struct level {
    size_t width, height;
    float *rgb;
} level;

struct texture {
    level levels[LEVELS_MAX];
    int count;
};

/* The stretch of a row of n texels that texel k of a row of half as many covers: texels first … last, the outer two by
 * a part of their width where n is odd. */
static void covered(size_t n, size_t halved, size_t k, size_t *first, size_t *last, float *first_part,
                    float *last_part) {
    const double low = (double)k * (double)n / (double)halved, high = (double)(k + 1) * (double)n / (double)halved;
    *first = (size_t)low;
    *last = (size_t)ceil(high) - 1;
    if (*last >= n) *last = n - 1;
    *first_part = (float)((double)(*first + 1) - low);
    *last_part = (float)(high - (double)*last);
}

/* The mean of four texels: the usual case of even sides. */
static void halve(const level *from, const level *to) {
    for (size_t y = 0; y < to->height; y++) {
        const float *above = from->rgb + 2 * y * from->width * 3, *below = above + from->width * 3;
        float *out = to->rgb + y * to->width * 3;
        for (size_t x = 0; x < to->width; x++)
            for (size_t c = 0; c < 3; c++)
                out[3 * x + c] =
                    (above[6 * x + c] + above[6 * x + 3 + c] + below[6 * x + c] + below[6 * x + 3 + c]) / 4;
    }
}

/* The mean of the texels under each one of the smaller level. */
static void shrink(const level *from, const level *to) {
    for (size_t y = 0; y < to->height; y++)
        for (size_t x = 0; x < to->width; x++) {
            size_t x0, x1, y0, y1;
            float left, right, top, bottom, sum[3] = {0, 0, 0}, total = 0;
            covered(from->width, to->width, x, &x0, &x1, &left, &right);
            covered(from->height, to->height, y, &y0, &y1, &top, &bottom);
            for (size_t j = y0; j <= y1; j++)
                for (size_t i = x0; i <= x1; i++) {
                    const float wx = x0 == x1 ? 1 : i == x0 ? left : i == x1 ? right : 1;
                    const float wy = y0 == y1 ? 1 : j == y0 ? top : j == y1 ? bottom : 1;
                    const float *texel = from->rgb + (j * from->width + i) * 3;
                    for (int c = 0; c < 3; c++) sum[c] += wx * wy * texel[c];
                    total += wx * wy;
                }
            for (int c = 0; c < 3; c++) to->rgb[(y * to->width + x) * 3 + (size_t)c] = sum[c] / total;
        }
}

texture *texture_create(io_image *image) {
    texture *t = calloc(1, sizeof *t);
    if (t == NULL) return NULL;
    t->levels[0] = (level){image->width, image->height, image->rgb};
    for (t->count = 1;; t->count++) {
        const level *from = &t->levels[t->count - 1];
        if (from->width == 1 && from->height == 1) break;
        level *to = &t->levels[t->count];
        to->width = from->width > 1 ? from->width / 2 : 1;
        to->height = from->height > 1 ? from->height / 2 : 1;
        to->rgb = malloc(to->width * to->height * 3 * sizeof(float));
        if (to->rgb == NULL) {
            t->levels[0].rgb = NULL;
            texture_free(t);
            return NULL;
        }
        if (from->width % 2 == 0 && from->height % 2 == 0)
            halve(from, to);
        else
            shrink(from, to);
    }
    *image = (io_image){0};
    return t;
}

void texture_free(texture *t) {
    if (t == NULL) return;
    for (int k = 0; k < LEVELS_MAX; k++) free(t->levels[k].rgb);
    free(t);
}

/* Repeats the image: the remainder that is not negative. */
static size_t wrap(int64_t k, size_t n) {
    const int64_t size = (int64_t)n;
    if (k >= 0 && k < size) return (size_t)k;
    const int64_t r = k % size;
    return (size_t)(r < 0 ? r + size : r);
}

static int64_t floor_of(float x) {
    const int64_t k = (int64_t)x;
    return k - (x < (float)k);
}

/* Adds weight times the interpolated colour at (u, v). */
static void add_bilinear(const level *l, float u, float v, float weight, float colour[3]) {
    const float x = u * (float)l->width - 0.5f, y = v * (float)l->height - 0.5f;
    const int64_t i = floor_of(x), j = floor_of(y);
    const float right = x - (float)i, down = y - (float)j;
    const float *above = l->rgb + 3 * l->width * wrap(j, l->height);
    const float *below = l->rgb + 3 * l->width * wrap(j + 1, l->height);
    const size_t column[2] = {3 * wrap(i, l->width), 3 * wrap(i + 1, l->width)};
    const float share[2][2] = {{weight * (1 - down) * (1 - right), weight * (1 - down) * right},
                               {weight * down * (1 - right), weight * down * right}};
    for (int c = 0; c < 3; c++)
        colour[c] += share[0][0] * above[column[0] + (size_t)c] + share[0][1] * above[column[1] + (size_t)c] +
                     share[1][0] * below[column[0] + (size_t)c] + share[1][1] * below[column[1] + (size_t)c];
}

/* Adds weight times the mean of count probes along an axis through uv. */
static void add_probes(const level *l, const float uv[2], const float axis[2], int count, float weight,
                       float colour[3]) {
    const float step = 1 / (float)count;
    for (int k = 0; k < count; k++) {
        const float along = ((float)k + 0.5f) * step - 0.5f;
        add_bilinear(l, uv[0] + along * axis[0], uv[1] + along * axis[1], weight * step, colour);
    }
}

/* Square of the length in texels of the image itself. */
static float square_in_texels(const texture *t, const float v[2]) {
    const float x = v[0] * (float)t->levels[0].width, y = v[1] * (float)t->levels[0].height;
    return x * x + y * y;
}

void texture_lookup(const texture *t, const float uv[2], const float along_x[2], const float along_y[2],
                    float colour[3]) {
    const float x = square_in_texels(t, along_x), y = square_in_texels(t, along_y);
    const float major = x > y ? x : y, minor = fmaxf(x > y ? y : x, major / (probes_most * probes_most));
    const float *axis = x > y ? along_x : along_y;
    colour[0] = colour[1] = colour[2] = 0;
    if (!(minor > 1)) {
        /* Magnified, at least along the short axis: probes are a texel apart. */
        const int count = major > 1 ? (int)ceilf(sqrtf(major)) : 1;
        add_probes(&t->levels[0], uv, axis, count, 1, colour);
        return;
    }
    /* The level whose texels are as wide as the short axis. */
    const float number = 0.5f * log2f(minor);
    if (!(number < (float)(t->count - 1))) {
        memcpy(colour, t->levels[t->count - 1].rgb, 3 * sizeof *colour);
        return;
    }
    const int finer = (int)number, count = (int)ceilf(sqrtf(major / minor) - probes_slack);
    const float share = number - (float)finer;
    add_probes(&t->levels[finer], uv, axis, count, 1 - share, colour);
    add_probes(&t->levels[finer + 1], uv, axis, count, share, colour);
}
