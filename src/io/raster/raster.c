/* SPDX-License-Identifier: Apache-2.0 */
/* Which reader a raster has, and the steps after reading that both share. */

#include "raster.h"

#include "extremes.h"
#include "large.h"
#include "number.h"
#include "output.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Of heights that are not the file's numbers, gdal/read.c has taken it out: the option's values are the file's. */
static void take_nodata_out(const io_raster_options *options, io_raster *raster) {
    for (size_t n = 0; n < options->nodata_count && raster->georef.scale == 0; n++) {
        const float value = (float)options->nodata[n];
        for (size_t k = 0; raster->z != NULL && k < raster->nx * raster->ny; k++)
            if (raster->memory[k] == value) raster->memory[k] = NAN;
    }
    if (options->nodata_count == 0 || raster->georef.has_nodata) return;
    raster->georef.has_nodata = true;
    raster->georef.nodata = options->nodata[0];
}

/* The file's number for a height. */
static double number_of(const io_georef *g, float z) {
    return g->scale != 0 ? (double)(float)(((double)z - g->offset) / g->scale) : (double)z;
}

/* From here on floats are more than 1 apart. */
static const float coarse = 0x1p24f;

void io_raster_smell(const char *path, const io_warner *warn, const io_raster *raster) {
    static const float suspicious[] = {-32768, -32767, -9999, -99999}, beyond = 1e30f;
    enum { COUNT = sizeof suspicious / sizeof suspicious[0] };
    size_t counts[COUNT] = {0}, huge = 0, zeros = 0;
    float example = 0, largest = 0, nearest = INFINITY; /* to 0 */
    for (size_t j = 0; j < raster->ny; j++) {
        const float *z = raster->z + j * raster->nx;
        float low, high;
        extremes_of(z, raster->nx, &low, &high);
        if (fabsf(low) < beyond) largest = fmaxf(largest, fabsf(low));
        if (fabsf(high) < beyond) largest = fmaxf(largest, fabsf(high));
        if (low > 0) nearest = fminf(nearest, low);
        for (size_t i = 0; i < raster->nx && !(low > 0 && high < beyond); i++) {
            const float size = fabsf(z[i]);
            zeros += size == 0;
            nearest = size > 0 && size < nearest ? size : nearest;
            for (int k = 0; k < COUNT; k++) counts[k] += z[i] == suspicious[k];
            if (!(size >= beyond) || isinf(size)) continue;
            example = z[i];
            huge++;
        }
    }
    const locale_t before = number_enter_plain();
    for (int k = 0; k < COUNT; k++)
        if (counts[k] > 0)
            io_warn(warn, "%s: %zu samples are %g, which often stands for no data; --nodata %.9g makes them holes",
                    path, counts[k], (double)suspicious[k], number_of(&raster->georef, suspicious[k]));
    if (huge > 0)
        io_warn(warn,
                "%s: %zu samples are beyond 1e30, as %.9g, which looks like no data; --nodata %.9g makes them holes",
                path, huge, (double)example, number_of(&raster->georef, example));
    const double share = (double)zeros / ((double)raster->nx * (double)raster->ny);
    if (!raster->georef.has_nodata && share >= 0.001 && share <= 0.5 && nearest >= 10)
        io_warn(
            warn,
            "%s: %.3g %% of the samples are exactly 0, and the next ones are %.6g from it, which looks like missing "
            "data; --nodata %.9g makes them holes",
            path, 100 * share, (double)nearest, number_of(&raster->georef, 0));
    if (largest > coarse)
        io_warn(warn, "%s: heights are floats, and those up to %.9g are rounded to multiples of %g", path,
                (double)largest, (double)(nextafterf(largest, INFINITY) - largest));
    uselocale(before);
}

/* A guess that is wrong makes relief 3.28 times too flat, or too steep. */
static void tell_guessed_unit(const char *path, const io_raster_options *options, const io_raster *raster) {
    const io_georef *g = &raster->georef;
    const bool stated = g->height_unit > 0;
    const double metres = stated ? g->height_unit : g->unit;
    char unit[IO_UNIT_NAME];
    if (options->zscale > 0 || !g->placed || g->geographic || metres == 0 || metres == 1) return;
    if (stated && (g->unit > 0 || options->cellsize > 0)) return;
    io_unit_name(metres, unit);
    if (stated)
        io_warn(&options->warn,
                "%s: heights are in %s, and x and y are taken as metres, as no coordinate system says; --zscale 1 if "
                "they are in the unit of heights",
                path, unit);
    else
        io_warn(&options->warn, "%s: heights taken as %s, as x and y; --zscale %.5g if they are metres", path, unit,
                1 / g->unit);
}

static void smell_degrees(const char *path, const io_raster_options *options, const io_raster *raster) {
    const io_georef *g = &raster->georef;
    const double dx = hypot(raster->map[0][0], raster->map[1][0]), x = raster->map[0][3], y = raster->map[1][3];
    if (g->placed && g->crs == NULL && dx > 0 && dx < 0.1 && fabs(x) <= 360 && fabs(y) <= 90)
        io_warn(&options->warn,
                "%s: samples are %g apart around (%g, %g), which looks like degrees, but the file names no coordinate "
                "system; %s",
                path, dx, x, y,
                g->height_unit > 0 ? "x and y are taken as metres" : "heights are taken in the same unit");
}

bool io_raster_allocate(const char *path, io_raster *r, io_error *error) {
    if (r->ny == 0 || r->nx <= SIZE_MAX / sizeof(float) / r->ny)
        r->memory = large_allocate(r->nx * r->ny * sizeof(float));
    r->z = r->memory;
    return r->memory != NULL || io_fail(error, "%s: out of memory for %zu x %zu samples", path, r->nx, r->ny);
}

/* Samples that far apart, the first row in the north, the last row's first sample at the origin. */
static void set_map(const io_raster_options *o, double cellsize, io_raster *raster) {
    const double last = raster->rows > 0 ? (double)(raster->rows - 1) : 0;
    const double map[3][4] = {{cellsize, 0, 0, 0}, {0, -cellsize, 0, cellsize * last}, {0, 0, 1, 0}};
    memcpy(raster->map, map, sizeof map);
    io_raster_shift(raster, o->window.i, o->window.j);
}

static bool finish(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    io_georef *g = &raster->georef;
    take_nodata_out(options, raster);
    if (options->cellsize > 0) {
        if (g->placed)
            return io_fail(error,
                           "%s: the file gives the distance between its samples; --cellsize is for files without one",
                           path);
        set_map(options, options->cellsize, raster);
        g->placed = true;
    } else if (!g->placed && options->north_up) {
        set_map(options, 1, raster);
        io_warn(&options->warn,
                "%s: has no map: cells are read as 1 wide, row 0 as the northernmost, and the last row begins at 0,0;"
                " --cellsize sets their width",
                path);
    }
    if (options->zscale > 0)
        raster->map[2][2] = options->zscale;
    else if (g->height_unit > 0 && g->placed)
        raster->map[2][2] = g->height_unit / (g->geographic || g->unit == 0 ? 1 : g->unit);
    if (raster->z != NULL) io_raster_smell(path, &options->warn, raster);
    tell_guessed_unit(path, options, raster);
    smell_degrees(path, options, raster);
    return true;
}

bool io_raster_read(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    *raster = (io_raster){.map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    const bool good =
        (io_name_ends(path, ".npy") ? io_raster_read_npy : io_raster_read_gdal)(path, options, raster, error) &&
        finish(path, options, raster, error);
    if (!good) io_raster_free(raster);
    return good;
}

void io_raster_free(io_raster *raster) {
    large_release(raster->memory);
    io_georef_free(&raster->georef);
    *raster = (io_raster){0};
}
