/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk visibility`: how much of the ground each place sees. */

#include "command.h"
#include "product.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "visibility";

typedef struct visibility_command {
    product product;
    cw_visibility_desc desc;
    unsigned directions, every;
    bool longest, share;
    size_t from, until; /* rows of the product that are known */
    float *band[2];
} visibility_command;

/* All rows that the piece is good for, at once, so that no other piece's are known: the land is turned toward each
 * direction once. */
static bool find(product *p, const product_block *b, io_error *error) {
    visibility_command *c = p->context;
    cw_rectangle at = b->area.at;
    at.ny = p->until - b->row * c->every;
    const size_t rows = (at.ny + c->every - 1) / c->every;
    for (int k = 0; k < (c->longest ? 2 : 1); k++) {
        free(c->band[k]);
        c->band[k] = malloc(rows * p->raster.nx * sizeof(float));
        if (c->band[k] == NULL) return io_fail(error, "out of memory");
    }
    cw_visibility_answers to = {.area = c->band[0]};
    if (c->longest) to = (cw_visibility_answers){.farthest = c->band[0], .azimuth = c->band[1]};
    if (c->share) to = (cw_visibility_answers){.share = c->band[0]};
    p->part = (double)rows / (double)p->raster.ny / (double)p->raster.bands; /* of all these rows, not of a block */
    c->from = b->row;
    c->until = b->row + rows;
    return product_good(cw_visibility(&p->ground.terrain, &b->run, &c->desc, (cw_area){at, 0}, &to), error);
}

static bool fill(product *p, const product_block *b, void *cells, io_error *error) {
    visibility_command *c = p->context;
    const size_t nx = p->raster.nx;
    if ((b->row < c->from || b->row >= c->until) && !find(p, b, error)) return false;
    memcpy(cells, c->band[b->band] + (b->row - c->from) * nx, b->rows * nx * sizeof(float));
    return true;
}

/* Turned land has margins beside the samples that are so many columns apart (src/terrain/visible/visible_land.c). */
static double turned_bytes(const visibility_command *c) {
    enum { MARGINS = 80 };
    const terrain *t = &c->product.ground.whole;
    const double least = fmin((double)t->nx, (double)t->ny), most = fmax((double)t->nx, (double)t->ny);
    return 5.5 * (1 + MARGINS * fmin(c->every, most) / least);
}

static bool begin(product *p, io_error *error) {
    visibility_command *c = p->context;
    cw_visibility_desc *d = &c->desc;
    ground *g = &p->ground;
    static const char *const names[] = {"metres to the farthest ground in sight",
                                        "azimuth of that place from the map's north"};
    (void)error;
    d->directions = c->directions;
    d->every = c->every;
    d->curvature = ground_curvature(g, d->curvature);
    product_describe(p, IO_CELL_FLOAT32, c->longest ? 2 : 1,
                     c->longest ? names[0]
                     : c->share ? "share of the ground within the distance that is in sight"
                                : "square kilometres of ground in sight");
    for (int k = 0; k < 2; k++)
        for (int a = 0; a < 2; a++) g->map[k][a] *= (double)c->every;
    p->raster.nx = (g->window.nx + c->every - 1) / c->every;
    p->raster.ny = (g->window.ny + c->every - 1) / c->every;
    p->raster.unit = c->share || c->longest ? NULL : "km2";
    if (c->longest) p->raster.band_names = names;
    product_note(p, "DIRECTIONS=%u", c->directions);
    product_note(p, "EVERY=%u", c->every);
    product_note(p, "OBSERVER_HEIGHT=%.9g", d->height);
    product_note(p, "TARGET_HEIGHT=%.9g", d->target);
    if (d->max_distance > 0) product_note(p, "MAX_DISTANCE=%.9g", d->max_distance);
    product_note(p, "CURVATURE=%.9g", d->curvature);
    p->matters.distance = d->max_distance;
    p->more = turned_bytes(c) + 8 +
              (c->share || c->longest ? 8 : 4); /* the turned land and its bounds; sums in double, and answers */
    p->every = c->every;
    return true;
}

static void end(void *context) {
    visibility_command *c = context;
    for (int b = 0; b < 2; b++) free(c->band[b]);
}

static bool check(void *context, size_t *bands) {
    visibility_command *c = context;
    *bands = c->longest ? 2 : 1;
    return !(c->longest && c->share) || command_refuse(name, "of --longest and --share one can be written");
}

static int run(int argc, char **argv) {
    static visibility_command c = {.desc = {.height = 2}, .directions = 128, .every = 1}; /* large */
    c.product = (product){.context = &c, .check = check, .begin = begin, .fill = fill, .end = end};
    const option_spec options[] = {
        option_flag("longest", &c.longest,
                    "write how far one sees instead: metres to the farthest ground in sight, and in a second band its "
                    "azimuth from the map's north"),
        option_flag(
            "share", &c.share,
            "write a share instead, 0 to 1: of all ground within --max-distance and the raster, what is in sight"),
        option_count("directions", "N", &c.directions, 1, 3600,
                     "number of directions, evenly spaced from the map's north on (default: 128)"),
        option_range("observer-height", "H", &c.desc.height, 0, DBL_MAX, "metres from 0 on",
                     "height of the eyes above the ground in metres (default: 2)"),
        option_range("target-height", "T", &c.desc.target, 0, DBL_MAX, "metres from 0 on",
                     "what must be seen is T metres above the ground (default: 0, the ground itself)"),
        option_metres("max-distance", &c.desc.max_distance,
                      "what is farther away than D metres does not count (default: no limit)"),
        product_round_earth_row(&c.desc.curvature),
        option_count("every", "K", &c.every, 1, 1 << 20,
                     "eyes at every K-th column and row, on the land in full: a raster of cells K times as wide. K = 4 "
                     "is 8 times as fast, 16 some 20 times; more is no faster, and needs more memory from 1/64 of the "
                     "columns on"),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM -o FILE [OPTIONS]",
        .what = "Computes how much every sample of a terrain sees, and writes a raster: the square kilometres of "
                "ground in sight of an eye above the sample (float32; NaN: no data).\n\n"
                "Along each direction, the parts of the surface in sight are exact: the surface is two triangles "
                "between each four samples, and a part ends where the line of sight meets it. A line that touches the "
                "surface is blocked. Between directions nothing is looked at; papers/terrain.md of the sources has the "
                "error this makes. Ground counts by its area on the map, whether steep or level. Holes are not seen "
                "and hide nothing, and the view ends where the raster does.\n\n"
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
        OPTIONS_OF(options),
    };
    return product_run(&c.product, &usage, argc, argv);
}

const command command_visibility = {"visibility", "compute how much of the ground each sample sees", run};
