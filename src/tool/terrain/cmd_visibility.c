/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk visibility`: how much of the ground each place sees. */

#include "visibility.h"

#include "command.h"
#include "product.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "visibility";

typedef struct visibility_command {
    ground_options ground;
    visibility_desc desc;
    unsigned directions, every;
    double curvature; /* NaN if it was not given */
    bool longest, share;
} visibility_command;

typedef struct job {
    ground *ground;
    const visibility_command *command;
    visibility_desc desc;
    size_t nx, ny;      /* eyes */
    size_t from, until; /* rows of the product that are known */
    float *band[2];
} job;

static bool enter(void *context, io_error *error) {
    job *j = context;
    (void)error;
    j->from = j->until = 0;
    return true;
}

static bool around(void *context, cw_rectangle part, cw_rectangle *piece, io_error *error) {
    const job *j = context;
    (void)error;
    const double reach = j->desc.max_distance;
    *piece = reach > 0 ? reach_beside(&j->ground->whole, part, reach) : pieces_all(j->ground);
    return true;
}

/* All rows that the piece is good for, at once: the land is turned toward each direction once. */
static bool find(job *j, size_t row, io_error *error) {
    ground *g = j->ground;
    const visibility_command *c = j->command;
    const size_t every = j->desc.every, first = row * every;
    const cw_rectangle at = {g->window.i - g->terrain.column, g->window.j + first - g->terrain.row, g->window.nx,
                             g->until - first};
    const size_t rows = (at.ny + every - 1) / every;
    for (int b = 0; b < (c->longest ? 2 : 1); b++) {
        free(j->band[b]);
        j->band[b] = malloc(rows * j->nx * sizeof(float));
        if (j->band[b] == NULL) return io_fail(error, "out of memory");
    }
    visibility_answers to = {.area = j->band[0]};
    if (c->longest) to = (visibility_answers){.farthest = j->band[0], .azimuth = j->band[1]};
    if (c->share) to = (visibility_answers){.share = j->band[0]};
    bool done;
    g->part = (double)rows / (double)j->ny / (c->longest ? 2 : 1); /* of all these rows, not of a block */
    const cw_status status = visibility_find(&g->terrain, &j->desc, &g->query, at, &to, ground_tell_block, g, &done);
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    j->from = row;
    j->until = row + rows;
    return done || io_fail(error, "interrupted");
}

static bool fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error) {
    job *j = context;
    if ((row < j->from || row >= j->until) && !find(j, row, error)) return false;
    memcpy(cells, j->band[band] + (row - j->from) * j->nx, rows * j->nx * sizeof(float));
    return true;
}

/* White in a picture: the most that can be in sight. */
static double most_of(const job *j) {
    const terrain *t = &j->ground->whole;
    const double reach = j->desc.max_distance;
    double metres[2], side[2];
    terrain_metres(t, 0.5 * (double)t->nx, 0.5 * (double)t->ny, metres);
    for (int a = 0; a < 2; a++)
        side[a] = hypot(t->map[0][a] * metres[0], t->map[1][a] * metres[1]) * (double)(a ? t->ny : t->nx);
    if (j->command->share) return 1;
    if (j->command->longest) return reach > 0 ? reach : hypot(side[0], side[1]);
    const double all = side[0] * side[1], circle = 3.141592653589793 * reach * reach;
    return 1e-6 * (reach > 0 ? fmin(all, circle) : all);
}

static bool make(void *context, ground *g, io_error *error) {
    const visibility_command *c = context;
    job j = {.ground = g, .command = c, .desc = c->desc};
    j.desc.directions = c->directions;
    j.desc.every = c->every;
    j.desc.curvature = ground_curvature(g, c->curvature);
    static const char *const area = "square kilometres of ground in sight",
                             *const share = "share of the ground within the distance that is in sight",
                             *const longest = "metres to the farthest ground in sight";
    static const char *const names[] = {"metres to the farthest ground in sight", "azimuth of that place"};
    ground_notes notes = {0};
    io_raster_product product = ground_product(g, IO_CELL_FLOAT32, c->longest ? 2 : 1,
                                               c->longest ? &longest
                                               : c->share ? &share
                                                          : &area,
                                               &notes);
    double map[3][4];
    memcpy(map, g->map, sizeof map);
    for (int k = 0; k < 2; k++)
        for (int a = 0; a < 2; a++) map[k][a] *= (double)c->every;
    product.map = (const double(*)[4])map;
    product.nx = j.nx = (g->window.nx + c->every - 1) / c->every;
    product.ny = j.ny = (g->window.ny + c->every - 1) / c->every;
    product.white = most_of(&j);
    if (c->longest) product.band_names = names;
    ground_note(&notes, "DIRECTIONS=%u", c->directions);
    ground_note(&notes, "EVERY=%u", c->every);
    ground_note(&notes, "OBSERVER_HEIGHT=%.9g", j.desc.eye_height);
    ground_note(&notes, "TARGET_HEIGHT=%.9g", j.desc.target_height);
    ground_note(&notes, "MAX_DISTANCE=%.9g", j.desc.max_distance);
    ground_note(&notes, "CURVATURE=%.9g", j.desc.curvature);
    /* The turned land and its bounds; sums in double, and answers. */
    const pieces_maker maker = {fill, around, enter, .more = 5 + 8 + (c->share || c->longest ? 8 : 4),
                                .every = c->every};
    const bool good = pieces_write(g, &product, 1, &maker, &j, error);
    ground_notes_free(&notes);
    for (int b = 0; b < 2; b++) free(j.band[b]);
    return good;
}

static bool check(void *context, size_t *bands) {
    visibility_command *c = context;
    const visibility_desc *d = &c->desc;
    *bands = c->longest ? 2 : 1;
    if (c->longest && c->share)
        command_fail(name, "of --longest and --share one can be written");
    else if (!(d->eye_height >= 0))
        command_fail(name, "--observer-height takes metres from 0 on, not %g", d->eye_height);
    else if (!(d->target_height >= 0))
        command_fail(name, "--target-height takes metres from 0 on, not %g", d->target_height);
    else if (!(d->max_distance >= 0))
        command_fail(name, "--max-distance takes metres, not %g", d->max_distance);
    else if (c->curvature < 0)
        command_fail(name, "--curvature takes a number from 0 on, not %g", c->curvature);
    else
        return true;
    return false;
}

static int run(int argc, char **argv) {
    visibility_command c = {.desc = {.eye_height = 2}, .directions = 128, .every = 1, .curvature = NAN};
    const option_spec options[] = {
        option_flag(
            "longest", &c.longest,
            "write how far one sees instead: metres to the farthest ground in sight, and its azimuth in a second band"),
        option_flag(
            "share", &c.share,
            "write a share instead, 0 to 1: of all ground within --max-distance and the raster, what is in sight"),
        option_count("directions", "N", &c.directions, 1, VISIBILITY_DIRECTIONS_MOST,
                     "number of directions, evenly spaced from north on (default: 128)"),
        option_number("observer-height", "H", &c.desc.eye_height,
                      "height of the eyes above the ground in metres (default: 2)"),
        option_number("target-height", "T", &c.desc.target_height,
                      "what must be seen is T metres above the ground (default: 0, the ground itself)"),
        option_number("max-distance", "D", &c.desc.max_distance,
                      "what is farther away than D metres does not count (default: no limit)"),
        option_number("curvature", "K", &c.curvature,
                      "the earth's curvature as a factor: 0 for a flat earth, 1 without air, 0.857 = 6/7 with usual "
                      "refraction (default: 6/7, or 0 if the file has no map)"),
        option_count("every", "K", &c.every, 1, 1 << 20,
                     "eyes at every K-th column and row, on the land in full: a raster of cells K times as wide, in 1 "
                     "/ K^2 of the time"),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM -o FILE [OPTIONS]",
        .what = "Computes how much every sample of a terrain sees, and writes a raster: the square kilometres of "
                "ground in sight of an eye above the sample (float32; NaN: no data).\n\n"
                "Along each direction, the parts of the surface in sight are exact: the surface is two triangles "
                "between each four samples, and a part ends where the line of sight meets it. A line that touches the "
                "surface is blocked. Between directions nothing is looked at; papers/terrain.md has the error this "
                "makes. Ground counts by its area on the map, whether steep or level. Holes are not seen and hide "
                "nothing, and the view ends where the raster does.\n\n"
                "How exposed a place is, which is from how much of the ground one sees it, follows by exchanging the "
                "two heights: --observer-height 0 --target-height 2 counts the places at which an eye 2 m above ground "
                "sees the sample.\n\n"
                "Without --max-distance all of the raster matters to each eye, and --memory must have room for it, at "
                "about 30 bytes a sample. --window limits the eyes, not the ground that they see. `cellwalk viewshed` "
                "shows what one place sees.\n",
        .examples = "  cellwalk visibility dem.tif -o km2.tif\n"
                    "  cellwalk visibility dem.tif --longest -o far.tif\n"
                    "  cellwalk visibility dem.tif --share --max-distance 5000 -o share.tif\n"
                    "  cellwalk visibility dem.tif --observer-height 0 --target-height 30 -o mast.tif\n"
                    "  cellwalk visibility dem.tif --every 8 --directions 64 -o overview.tif\n",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    return product_run(&(product_command){&c.ground, &c, check, make}, &usage, argc, argv);
}

const command command_visibility = {"visibility", "compute how much of the ground each sample sees", run};
