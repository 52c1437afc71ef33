/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk horizon`: the horizon's angle in directions all round, or how much of the sky is seen. */

#include "horizon.h"

#include "command.h"
#include "horizon_at.h"
#include "product.h"
#include "trade.h"

#include <math.h>
#include <stdlib.h>

static const char name[] = "horizon";

/* Steps of int16, powers of two: shares up to 1 and angles up to 90 have room, and floats hold each multiple exactly. */
static const double step_of_angle = 0x1p-8, step_of_share = 0x1p-14;

static const char *type_names(size_t number) {
    static const char *const names[] = {"float32", "int16"};
    return number < 2 ? names[number] : NULL;
}
enum { INT16 = 1 };

typedef struct horizon_command {
    ground_options ground;
    unsigned directions;
    double start, curvature, max_distance;
    bool sky, tilted, grid, distance;
    int type; /* 0: float32, 1: int16 */
    horizon_at at;
} horizon_command;

typedef struct job {
    ground *ground;
    horizon *horizon;
    const horizon_command *command;
    bool sky, tilted;
    reach_blocks blocks; /* once they are needed */
    reach_horizons reach;
} job;

static bool enter(void *context, io_error *error) {
    job *j = context;
    const horizon_command *c = j->command;
    const horizon_desc desc = {.start = c->start,
                               .count = c->directions,
                               .max_distance = c->max_distance,
                               .curvature = c->curvature,
                               .grid = c->grid};
    horizon_destroy(j->horizon);
    const cw_status status = horizon_create(&j->ground->terrain, &desc, &j->horizon);
    return status == CW_OK || io_fail(error, "%s", cw_status_message(status));
}

/* Without a distance far mountains count, as far as the raster's highest samples let them. On lines of the grid all do. */
static bool around(void *context, cw_rectangle part, cw_rectangle *piece, io_error *error) {
    job *j = context;
    const horizon_command *c = j->command;
    ground *g = j->ground;
    *piece = c->max_distance > 0 ? reach_beside(&g->whole, part, c->max_distance) : pieces_all(g);
    if (c->max_distance > 0 || c->grid) return true;
    if (j->blocks.whole == NULL) {
        if (reach_blocks_create(&g->whole, &j->blocks) != CW_OK) return io_fail(error, "out of memory");
        if (!pieces_survey(g, &j->blocks, NULL, NULL, error)) return false;
        if (reach_horizons_create(&j->blocks, g->window, c->curvature, c->sky, &j->reach) != CW_OK)
            return io_fail(error, "out of memory");
    }
    *piece = reach_of_horizons(&j->reach, part);
    return true;
}

static bool fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error) {
    job *j = context;
    bool done = true;
    const cw_run *q = &j->ground->query;
    const cw_status status =
        j->tilted ? horizon_sky_view_tilted(j->horizon, q, row, rows, cells, ground_tell_block, j->ground, &done)
        : j->sky  ? horizon_sky_view(j->horizon, q, row, rows, cells, ground_tell_block, j->ground, &done)
        : j->command->distance ? horizon_distances(j->horizon, q, band, row, rows, cells)
                               : horizon_angles(j->horizon, q, band, row, rows, cells);
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    /* Without terrain in a direction horizon.h has the nadir, which must not count as the least or in the mean. */
    float *angles = cells;
    for (size_t k = 0; k < rows * j->ground->terrain.nx && !j->sky && !j->command->distance; k++)
        if (angles[k] == -90) angles[k] = NAN;
    return done || io_fail(error, "interrupted");
}

enum { NAME_MOST = 32 };

/* Bands are called by their direction, as GRASS numbers none of them alike. */
static const char **band_names(const horizon *h, size_t count) {
    const char **names = malloc(count * (sizeof *names + NAME_MOST));
    char *text = names ? (char *)(names + count) : NULL;
    for (size_t k = 0; k < count && names; k++, text += NAME_MOST) {
        snprintf(text, NAME_MOST, "azimuth %.6g", horizon_azimuth(h, k));
        names[k] = text;
    }
    return names;
}

static bool make_bands(job *j, const horizon_command *c, io_error *error) {
    if (c->grid && ground_georef(j->ground)->geographic)
        return io_fail(error, "%s: --grid needs a map in metres, and this one is in degrees", j->ground->path);
    if (c->grid && !horizon_has_grid(terrain_whole(&j->ground->terrain)))
        return io_fail(error,
                       "%s: --grid needs a map whose scale is the same in all rows, and this one's changes by "
                       "more than 1 %%",
                       j->ground->path);
    j->command = c;
    j->sky = c->sky;
    j->tilted = c->tilted;
    if (!enter(j, error)) return false; /* for the bands' names */
    static const char
        *const sky = "sky-view factor: share of an evenly bright sky's light that reaches level ground",
               *const tilted = "sky-view factor: share of an evenly bright sky's light that reaches the leaning ground",
               *const angles = "angle of the horizon over the level, one band a direction",
               *const metres = "distance to the horizon in metres, one band a direction";
    const char **names = c->sky ? NULL : band_names(j->horizon, c->directions);
    if (!c->sky && names == NULL) return io_fail(error, "out of memory");
    ground_notes notes = {0};
    io_raster_product product = ground_product(j->ground, IO_CELL_FLOAT32, c->sky ? 1 : c->directions,
                                               c->tilted     ? &tilted
                                               : c->sky      ? &sky
                                               : c->distance ? &metres
                                                             : &angles,
                                               &notes);
    ground_note(&notes, "DIRECTIONS=%u", c->directions);
    ground_note(&notes, "FIRST_AZIMUTH=%.9g", c->start);
    ground_note(&notes, "ANGLES=degrees; azimuth from the map's north over east");
    ground_note(&notes, "CURVATURE=%.9g", c->curvature);
    if (!c->sky) {
        product.band_names = names;
        product.unit = c->distance ? "metre" : "degree";
        product.white = 90;
    }
    if (c->type == INT16) ground_scale(&product, c->sky ? step_of_share : step_of_angle);
    static const pieces_maker maker = {.fill = fill, .around = around, .enter = enter};
    const bool good = pieces_write(j->ground, &product, c->distance ? 30 : 1, &maker, j, error);
    ground_notes_free(&notes);
    free(names);
    return good;
}

static bool make(void *context, ground *g, io_error *error) {
    const horizon_command *c = context;
    if (horizon_at_asked(&c->at)) return horizon_at_write(g, &c->at, error);
    job j = {.ground = g};
    const bool good = make_bands(&j, c, error);
    horizon_destroy(j.horizon);
    reach_horizons_destroy(&j.reach);
    reach_blocks_destroy(&j.blocks);
    return good;
}

static bool check(void *context, size_t *bands) {
    horizon_command *c = context;
    const bool regular = c->directions == 8 || c->directions == 16 || c->directions == 32;
    const bool tif = c->ground.output && io_raster_is_tif(c->ground.output), sky = c->sky || c->tilted;
    const bool at = horizon_at_asked(&c->at);
    if (!horizon_at_check(&c->at, name)) return false;
    if (c->tilted && (c->sky || c->grid))
        command_fail(name, "--svf-tilted goes with neither --svf nor --grid");
    else if (c->distance && (sky || at))
        command_fail(name, "--distance goes with none of --svf, --svf-tilted, --at and --places");
    else if (c->distance && c->grid)
        command_fail(name, "--grid computes angles and sky-view factors only; give --distance without --grid");
    else if (c->type == INT16 && (c->distance || !tif))
        command_fail(name,
                     c->distance ? "--type int16 has no room for --distance" : "--type int16 goes with -o FILE.tif");
    else if (c->at.at.count > 0 && c->at.file)
        command_fail(name, "--at and --places do not go together");
    else if (at && (sky || c->ground.window))
        command_fail(name, "--at and --places print horizons of places, and go with neither --svf nor --window");
    else if (c->at.json && !at)
        command_fail(name, "--json goes with --at or --places");
    else if (c->curvature < 0)
        command_fail(name, "--curvature takes a number from 0 on, not %g", c->curvature);
    else if (c->max_distance <= 0)
        command_fail(name, "--max-distance takes metres above 0, not %g", c->max_distance);
    else if (c->grid && (at || c->start != 0 || c->max_distance > 0 || !regular))
        command_fail(name,
                     "--grid goes with 8, 16 or 32 --directions, and with none of --at, --start and --max-distance");
    else {
        c->sky = sky;
        if (isnan(c->max_distance)) c->max_distance = 0; /* no limit */
        c->at.output = c->ground.output;
        c->at.directions = c->directions;
        c->at.start = c->start;
        c->at.max_distance = c->max_distance;
        c->at.curvature = c->curvature;
        *bands = at ? 0 : sky ? 1 : c->directions;
        return true;
    }
    return false;
}

static int run(int argc, char **argv) {
    static horizon_command c; /* large */
    c.directions = 32;
    c.max_distance = NAN;
    const option_spec options[] = {
        option_count("directions", "N", &c.directions, 1, 3600, "number of directions, evenly spaced (default: 32)"),
        option_number("start", "AZ", &c.start,
                      "azimuth of the first direction in degrees, from the map's north over east (default: 0)"),
        option_flag("grid", &c.grid,
                    "with --directions 8, 16 or 32: directions from sample to sample, such as (1, 0), (2, 1) and (3, "
                    "2), which are as exact, not evenly spaced, and faster on large terrains"),
        option_flag("svf", &c.sky,
                    "write the sky-view factor instead: the share, 0 to 1, of an evenly bright sky's light that "
                    "reaches level ground (float32)"),
        option_flag("svf-tilted", &c.tilted, "the same for the ground as it leans, which is also hidden behind itself"),
        option_flag("distance", &c.distance,
                    "write the distance instead, in metres: how far away the horizon is in each direction"),
        option_choice("type", "NAME", &c.type, type_names,
                      "cells of a GeoTIFF: float32 (default), or int16 with a scale, half as large: angles are off by "
                      "1/512 degree at most, shares by 1/32768"),
        option_several(
            "at", "X,Y[,H]", &c.at.at,
            "print the horizon at a place of the map, H metres above ground (default: 0) or X,Y,=Z, as CSV: degrees "
            "(azimuths of the map and from true north), metres, coordinates of the map; may be given up to 256 times"),
        option_text("places", "FILE", &c.at.file,
                    "the same for the places of a table (.csv) with the columns x, y and, if there, height, or of "
                    "points in any file that GDAL reads; -o names the table to write"),
        option_flag("json", &c.at.json, "with --at or --places: print one JSON object"),
        option_number("max-distance", "D", &c.max_distance,
                      "terrain farther away than D metres does not count (default: no limit)"),
        ground_flat_earth_row(&c.curvature),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (-o FILE | --at X,Y | --places FILE) [OPTIONS]",
        .what = "Computes the horizon of every sample of a terrain and writes a raster with one band a direction: the "
                "elevation angle in degrees of the highest point there, negative below the sample's level (float32). "
                "--svf writes the sky-view factor instead, --distance how far away that point is (the nearest of "
                "several), and --at and --places print the horizons of places.\n\n"
                "NaN means no data: at holes, and where no terrain lies in that direction within --max-distance. The "
                "sky-view factor counts the sky there as free. Angles are exact to 0.001 degrees (0.003 where the "
                "scale differs from row to row) for the surface of two triangles between each four samples, if "
                "neighbours differ by less than 30 times their distance. On a map in degrees, directions are off in "
                "proportion to the distance: by up to 0.03 degrees at 5 km and latitude 50.\n\n" TRADE_HORIZON,
        .examples = "  cellwalk horizon dem.tif --directions 32 -o horizon.tif\n"
                    "  cellwalk horizon dem.tif --directions 64 --svf -o sky.tif\n"
                    "  cellwalk horizon dem.tif --directions 16 --grid --svf -o sky.tif\n"
                    "  cellwalk horizon dem.tif --directions 8 --type int16 --cog -o horizon.tif\n"
                    "  cellwalk horizon dem.tif --directions 8 --distance -o metres.tif\n"
                    "  cellwalk horizon dem.tif --at 600250,5199800 --directions 360 > horizon.csv\n",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    return product_run(&(product_command){&c.ground, &c, check, make}, &usage, argc, argv);
}

const command command_horizon = {"horizon", "compute horizon angles or the sky-view factor of each sample", run};
