/* SPDX-License-Identifier: Apache-2.0 */
#include "outcome.h"

#include "extremes.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Quantiles of a million values are known to a thousandth of their rank. */
enum { KEPT_MOST = 1 << 20 };

bool outcome_begin(outcome *o, size_t values, io_error *error) {
    *o = (outcome){.low = INFINITY, .high = -INFINITY, .step = values / KEPT_MOST + 1};
    o->room = values / o->step + 1;
    o->kept = malloc(o->room * sizeof *o->kept);
    return o->kept != NULL || io_fail(error, "out of memory");
}

void outcome_end(outcome *o) {
    free(o->kept);
    o->kept = NULL;
}

static bool is_hole(const io_raster_product *p, const void *cells, size_t k) {
    if (p->cell == IO_CELL_FLOAT32) return isnan(((const float *)cells)[k]);
    return (p->cell == IO_CELL_UINT8 ? ((const uint8_t *)cells)[k] : ((const uint16_t *)cells)[k]) == (int)p->nodata;
}

static float number(const io_raster_product *p, const void *cells, size_t k) {
    if (p->cell == IO_CELL_FLOAT32) return ((const float *)cells)[k];
    return p->cell == IO_CELL_UINT8 ? ((const uint8_t *)cells)[k] : ((const uint16_t *)cells)[k];
}

void outcome_take(outcome *o, const io_raster_product *p, const void *cells, size_t n) {
    float low = INFINITY, high = -INFINITY;
    size_t holes = 0, above = 0;
    for (size_t k = 0; k < n; k++) {
        const bool hole = is_hole(p, cells, k);
        holes += hole;
        above += !hole & (number(p, cells, k) > 0);
    }
    if (p->cell == IO_CELL_FLOAT32) extremes_of(cells, n, &low, &high);
    for (size_t k = (o->step - o->samples % o->step) % o->step; k < n; k += o->step)
        if (!is_hole(p, cells, k) && o->count < o->room) o->kept[o->count++] = number(p, cells, k);
    o->samples += n;
    o->holes += holes;
    o->above += above;
    o->low = low < o->low ? low : o->low;
    o->high = high > o->high ? high : o->high;
}

/* After the last value. NaN without any. */
static double outcome_quantile(const outcome *o, double share) {
    if (o->count == 0) return NAN;
    float *v = o->kept;
    const size_t n = (size_t)(share * (double)(o->count - 1) + 0.5);
    /* The part in which number n of the order is shrinks to that: Hoare's selection. */
    for (size_t low = 0, high = o->count - 1; low < high;) {
        const float middle = v[low + (high - low) / 2];
        size_t i = low, j = high;
        for (;; i++, j--) {
            while (v[i] < middle) i++;
            while (v[j] > middle) j--;
            if (i >= j) break;
            const float swap = v[i];
            v[i] = v[j];
            v[j] = swap;
        }
        if (n <= j)
            high = j;
        else
            low = j + 1;
    }
    return (double)v[n];
}

void outcome_text(const outcome *o, const io_raster_product *p, const char *counted, char *text, size_t size) {
    const size_t data = o->samples - o->holes;
    const char *unit = !p->unit                         ? ""
                       : strcmp(p->unit, "degree") == 0 ? "degrees"
                       : strcmp(p->unit, "metre") == 0  ? "m"
                                                        : p->unit;
    if (data == 0)
        snprintf(text, size, "no data in %zu samples", o->samples);
    else if (p->cell == IO_CELL_UINT8 || p->cell == IO_CELL_UINT16)
        snprintf(text, size, "%.3g %% of %zu samples %s", 100 * (double)o->above / (double)data, data, counted);
    else
        snprintf(text, size, "%.3g to %.3g%s%s, median %.3g, of %zu samples", (double)o->low, (double)o->high,
                 *unit ? " " : "", unit, outcome_quantile(o, 0.5), data);
}

/* The ramp cividis (Nuñez, Anderton and Renslow 2018), which people with and without colour blindness see alike. */
enum { STEPS = 8 };
static const unsigned char ramp[STEPS + 1][3] = {{0, 34, 78},     {26, 56, 111},   {67, 78, 108},
                                                 {97, 101, 111},  {125, 124, 120}, {155, 148, 118},
                                                 {188, 174, 108}, {222, 201, 88},  {254, 232, 56}};
/* The share of the ramp's colour; the rest is relief. */
static const double tint = 0.6;

bool picture_begin(picture *p, const char *path, size_t nx, size_t ny, io_error *error) {
    *p = (picture){.nx = nx, .ny = ny};
    if (nx > PICTURE_PIXELS_MOST / ny)
        return io_fail(error, "%s: %zu x %zu samples are too many for a picture; write .tif", path, nx, ny);
    p->values = malloc(3 * nx * ny * sizeof *p->values);
    if (p->values == NULL) return io_fail(error, "out of memory");
    p->toward = p->values + nx * ny;
    p->lean = p->toward + nx * ny;
    return true;
}

void picture_end(picture *p) {
    free(p->values);
    *p = (picture){0};
}

bool picture_take(picture *p, const io_raster_product *product, size_t row, size_t rows, const void *cells,
                  const terrain *t, size_t i, size_t j, size_t step, io_error *error) {
    for (size_t k = 0; k < rows * p->nx; k++)
        p->values[row * p->nx + k] = is_hole(product, cells, k) ? NAN : number(product, cells, k);
    float *slope = malloc(2 * t->nx * sizeof *slope);
    if (slope == NULL) return io_fail(error, "out of memory");
    for (size_t y = 0; y < rows; y++) {
        cw_terrain_slopes(t, NULL, NAN, (cw_rectangle){0, j + y * step, t->nx, 1}, slope, slope + t->nx);
        for (size_t x = 0; x < p->nx; x++) {
            const float east = slope[i + x * step], north = slope[t->nx + i + x * step];
            p->toward[(row + y) * p->nx + x] = 0.70710678f * (north - east); /* northwest */
            p->lean[(row + y) * p->nx + x] = east * east + north * north;
        }
    }
    free(slope);
    return true;
}

/* Flat land is drawn as if it were steeper, so that its relief shows. */
static double exaggeration(const picture *p) {
    double sum = 0;
    size_t count = 0;
    for (size_t k = 0; k < p->nx * p->ny; k++)
        if (isfinite(p->lean[k])) {
            sum += (double)p->lean[k];
            count++;
        }
    const double steepness = count ? sqrt(sum / (double)count) : 0;
    return steepness > 0 ? fmin(fmax(0.6 / steepness, 1), 30) : 1;
}

/* Light on the ground from the northwest at 45 degrees, 0 to 1; NaN where there is no ground. */
static double shade(const picture *p, size_t k, double times) {
    const double light = 0.70710678 * (1 - times * (double)p->toward[k]);
    return fmax(light, 0) / sqrt(1 + times * times * (double)p->lean[k]);
}

static void colour_of(double value, double low, double high, double light, unsigned char rgb[3]) {
    const double share = high > low ? fmin(fmax((value - low) / (high - low), 0), 1) : value > 0;
    const int step = share < 1 ? (int)(share * STEPS) : STEPS - 1;
    const double part = share * STEPS - step;
    for (int c = 0; c < 3; c++) {
        const double own = ramp[step][c] + part * (ramp[step + 1][c] - ramp[step][c]);
        rgb[c] = (unsigned char)(isnan(value) ? 255 * (0.3 + 0.6 * light) : tint * own + (1 - tint) * 255 * light);
    }
}

/* Discs with a white rim, in the vermilion of Okabe and Ito's palette, over a row of pixels. */
static void mark(const picture *p, const double *marks, size_t count, size_t y, unsigned char *row) {
    static const unsigned char colours[2][3] = {{213, 94, 0}, {255, 255, 255}};
    const double radius = fmax(3, (double)(p->nx < p->ny ? p->nx : p->ny) / 80), inner = radius - fmax(1, radius / 4);
    for (size_t k = 0; k < count; k++) {
        const double down = (double)y - marks[2 * k + 1], half = sqrt(fmax(radius * radius - down * down, 0));
        if (!(fabs(down) <= radius)) continue;
        const double from = fmax(ceil(marks[2 * k] - half), 0),
                     until = fmin(floor(marks[2 * k] + half), (double)p->nx - 1);
        for (double x = from; x <= until; x++)
            memcpy(row + 3 * (size_t)x, colours[hypot(x - marks[2 * k], down) > inner], 3);
    }
}

bool picture_write(const picture *p, const char *path, const io_raster_product *product, const outcome *of,
                   const double *marks, size_t mark_count, io_error *error) {
    const double low = outcome_quantile(of, 0.02), high = outcome_quantile(of, 0.98), times = exaggeration(p);
    unsigned char *rgb = malloc(3 * p->nx * p->ny);
    if (rgb == NULL) return io_fail(error, "out of memory");
    for (size_t k = 0; k < p->nx * p->ny; k++) {
        const double light = shade(p, k, times);
        if (isnan(light))
            memset(rgb + 3 * k, 240, 3);
        else
            colour_of((double)p->values[k], low, high, light, rgb + 3 * k);
    }
    for (size_t y = 0; y < p->ny; y++) mark(p, marks, mark_count, y, rgb + 3 * p->nx * y);
    io_raster_writer to;
    const bool good = io_raster_create(&to, path, product, error) && io_raster_write(&to, rgb, p->ny, error) &&
                      io_raster_commit(&to, error);
    io_raster_discard(&to);
    free(rgb);
    return good;
}
