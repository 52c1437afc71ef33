/* SPDX-License-Identifier: Apache-2.0 */
/* A pyramid of halved images (Williams 1983), filtered by a Gaussian over the ellipse that a pixel covers (Greene and
 * Heckbert 1986). Long ellipses read a level fine enough for their short axis; those longer than eight short axes are
 * fattened, which bounds the cost. */

#include "texture.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { LEVELS_MAX = 32, WEIGHTS = 128 };
static const double longest_ellipse = 8;

typedef struct level {
    size_t width, height;
    float *rgb;
} level;

struct texture {
    level levels[LEVELS_MAX];
    int count;
    float weight[WEIGHTS]; /* of a texel at squared distance k / WEIGHTS, the ellipse's edge being at 1 */
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
    /* A Gaussian of variance 1/4, lowered to reach 0 at the edge. */
    for (int k = 0; k < WEIGHTS; k++) t->weight[k] = expf(-2 * (float)k / (WEIGHTS - 1)) - expf(-2);
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

static const float *texel(const level *l, int64_t x, int64_t y) {
    return l->rgb + (wrap(y, l->height) * l->width + wrap(x, l->width)) * 3;
}

static void bilinear(const level *l, const double uv[2], float colour[3]) {
    const double x = uv[0] * (double)l->width - 0.5, y = uv[1] * (double)l->height - 0.5;
    const int64_t i = (int64_t)floor(x), j = (int64_t)floor(y);
    const float fx = (float)(x - (double)i), fy = (float)(y - (double)j);
    const float *t00 = texel(l, i, j), *t10 = texel(l, i + 1, j);
    const float *t01 = texel(l, i, j + 1), *t11 = texel(l, i + 1, j + 1);
    for (int c = 0; c < 3; c++)
        colour[c] = (1 - fy) * ((1 - fx) * t00[c] + fx * t10[c]) + fy * ((1 - fx) * t01[c] + fx * t11[c]);
}

/* Adds share times the mean over the ellipse whose axes are long_axis and short_axis (any two conjugate radii), widened
 * by a texel so that it holds some. */
static void add_ellipse(const texture *t, int number, float share, const double uv[2], const double long_axis[2],
                        const double short_axis[2], float colour[3]) {
    if (share == 0) return;
    const level *l = &t->levels[number];
    const double w = (double)l->width, h = (double)l->height;
    const double x = uv[0] * w - 0.5, y = uv[1] * h - 0.5;
    const double ax = long_axis[0] * w, ay = long_axis[1] * h, bx = short_axis[0] * w, by = short_axis[1] * h;

    /* Inside: q(dx, dy) = a dx² + b dx dy + c dy² < 1. */
    double a = ay * ay + by * by + 1, b = -2 * (ax * ay + bx * by), c = ax * ax + bx * bx + 1;
    const double f = a * c - b * b / 4;
    a /= f;
    b /= f;
    c /= f;
    const double determinant = 4 * a * c - b * b;
    const double half_width = 2 * sqrt(c / determinant), half_height = 2 * sqrt(a / determinant);
    const int64_t x0 = (int64_t)ceil(x - half_width), x1 = (int64_t)floor(x + half_width);
    const int64_t y0 = (int64_t)ceil(y - half_height), y1 = (int64_t)floor(y + half_height);

    float sum[3] = {0, 0, 0}, total = 0;
    for (int64_t j = y0; j <= y1; j++) {
        const double dy = (double)j - y;
        for (int64_t i = x0; i <= x1; i++) {
            const double dx = (double)i - x, q = a * dx * dx + b * dx * dy + c * dy * dy;
            if (!(q < 1)) continue;
            const float weight = t->weight[(int)(q * WEIGHTS)];
            const float *value = texel(l, i, j);
            for (int k = 0; k < 3; k++) sum[k] += weight * value[k];
            total += weight;
        }
    }
    if (total > 0)
        for (int k = 0; k < 3; k++) colour[k] += share * sum[k] / total;
}

static double length(const double v[2]) { return sqrt(v[0] * v[0] + v[1] * v[1]); }

void texture_lookup(const texture *t, const double uv[2], const double along_x[2], const double along_y[2],
                    float colour[3]) {
    const bool x_longer = length(along_x) > length(along_y);
    const double *longer = x_longer ? along_x : along_y, *shorter = x_longer ? along_y : along_x;
    double minor = length(shorter), fatter = 1;
    const double major = length(longer);
    if (minor * longest_ellipse < major && minor > 0) fatter = major / (minor * longest_ellipse);
    minor *= fatter;
    if (!(minor > 0) || !isfinite(major)) {
        bilinear(&t->levels[0], uv, colour);
        return;
    }
    /* The level whose texels are as wide as the short axis. */
    const size_t side = t->levels[0].width > t->levels[0].height ? t->levels[0].width : t->levels[0].height;
    double number = log2(minor * (double)side);
    number = number < 0 ? 0 : number;
    colour[0] = colour[1] = colour[2] = 0;
    if (number >= t->count - 1) {
        for (int c = 0; c < 3; c++) colour[c] = t->levels[t->count - 1].rgb[c];
        return;
    }
    const int finer = (int)number;
    const float share = (float)(number - finer);
    const double axis[2] = {shorter[0] * fatter, shorter[1] * fatter};
    add_ellipse(t, finer, 1 - share, uv, longer, axis, colour);
    add_ellipse(t, finer + 1, share, uv, longer, axis, colour);
}
