/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk viewshed`: the samples seen from one place or several. */

#include "viewshed.h"

#include "command.h"
#include "pieces.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "viewshed";

enum { OBSERVERS_MOST = OPTION_AGAIN_MAX };

typedef struct viewshed_command {
    ground_options ground;
    option_again from;
    ground_place places[OBSERVERS_MOST];
    double target, max_distance, curvature; /* curvature is NaN if it was not given */
    int extent;
    bool needed, needed_absolute;
} viewshed_command;

typedef struct job {
    ground *ground;
    const viewshed_command *command;
    sight_bounds *bounds;
    uint16_t *seen;
    float *heights;
    size_t observer;
} job;

static bool tell(void *context, double share) {
    job *j = context;
    return ground_tell(j->ground, ((double)j->observer + share) / (double)j->command->from.count);
}

static double curvature_of(const job *j) {
    const double given = j->command->curvature;
    return !isnan(given) ? given : ground_georef(j->ground)->placed ? 6.0 / 7 : 0;
}

enum { EXTENT_NEAR, EXTENT_FULL };

static const char *extent_names(size_t number) {
    static const char *const names[] = {"near", "full"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

/* The samples that one observer's answers in the window come from. */
static cw_rectangle samples_of(const job *j, const double at[2]) {
    const viewshed_command *c = j->command;
    const ground *g = j->ground;
    const cw_rectangle all = pieces_all(g);
    if (c->max_distance > 0) return reach_around(&g->whole, at, c->max_distance);
    /* Needed heights are rounded, and how depends on more than the lines. */
    const bool whole = g->window.nx == all.nx && g->window.ny == all.ny;
    return whole || c->needed ? all : reach_between(&g->whole, at, g->window);
}

/* Reads the part that all observers need, and sets the window to the part that they can see. */
static bool read_samples(job *j, io_error *error) {
    const viewshed_command *c = j->command;
    ground *g = j->ground;
    cw_rectangle near = {0}, piece = {0};
    for (size_t k = 0; k < c->from.count; k++) {
        double at[2];
        if (!terrain_find_place(&g->whole, c->places[k].x, c->places[k].y, at))
            return io_fail(error, "%s: is too far away from the terrain", c->places[k].text);
        near = reach_both(near, reach_within(&g->whole, at, c->max_distance));
    }
    if (c->max_distance > 0 && c->extent == EXTENT_NEAR && g->options->window == NULL) {
        if (near.nx == 0)
            return io_fail(error,
                           "no sample is within %g m of any observer; --extent full writes a raster all the same",
                           c->max_distance);
        pieces_set_window(g, near);
    }
    for (size_t k = 0; k < c->from.count; k++) {
        double at[2];
        terrain_find_place(&g->whole, c->places[k].x, c->places[k].y, at);
        piece = reach_both(piece, samples_of(j, at));
    }
    return pieces_read(g, reach_grow(&g->whole, reach_both(piece, g->window), 0), false, error);
}

static bool look_from(job *j, const ground_place *place, io_error *error) {
    const viewshed_command *c = j->command;
    const terrain *t = &j->ground->terrain;
    double eye[3];
    if (!ground_find_place(t, place, eye, NULL, error)) return false;
    const viewshed_desc d = {
        .place = {eye[0], eye[1]},
        .height = eye[2] * terrain_metres_of_height(t),
        .absolute = true,
        .target_height = c->target,
        .max_distance = c->max_distance,
        .curvature = curvature_of(j),
    };
    viewshed *v;
    bool done = false;
    cw_status status = viewshed_create(t, j->bounds, &d, &v);
    if (status == CW_OK)
        status = c->needed ? viewshed_heights(v, &j->ground->query, j->heights, tell, j, &done)
                           : viewshed_count(v, &j->ground->query, j->seen, tell, j, &done);
    viewshed_destroy(v);
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    return done || io_fail(error, "interrupted");
}

static bool fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error) {
    const job *j = context;
    const terrain *t = &j->ground->terrain;
    const size_t first = row * t->nx, n = rows * t->nx;
    const float *z = t->z + first;
    (void)band;
    (void)error;
    if (j->command->needed) {
        const double metres = terrain_metres_of_height(t);
        float *to = memcpy(cells, j->heights + first, n * sizeof *to);
        for (size_t k = 0; k < n && j->command->needed_absolute; k++) to[k] = (float)(to[k] + z[k] * metres);
    } else if (j->command->from.count <= 254) {
        uint8_t *to = cells;
        for (size_t k = 0; k < n; k++) to[k] = isfinite(z[k]) ? (uint8_t)j->seen[first + k] : 255;
    } else {
        uint16_t *to = cells;
        for (size_t k = 0; k < n; k++) to[k] = isfinite(z[k]) ? j->seen[first + k] : 65535;
    }
    return true;
}

static bool make_view(job *j, io_error *error) {
    const viewshed_command *c = j->command;
    if (!read_samples(j, error)) return false;
    const size_t n = j->ground->terrain.nx * j->ground->terrain.ny;
    if (sight_bounds_create(&j->ground->terrain, &j->bounds) != CW_OK) return io_fail(error, "out of memory");
    if (c->needed)
        j->heights = malloc(n * sizeof *j->heights);
    else
        j->seen = calloc(n, sizeof *j->seen);
    if (j->heights == NULL && j->seen == NULL) return io_fail(error, "out of memory");
    for (j->observer = 0; j->observer < c->from.count; j->observer++)
        if (!look_from(j, &c->places[j->observer], error)) return false;
    static const char *const seen = "1 where the target is seen, 0 where it is not",
                             *const count = "number of observers that see the target",
                             *const needed = "height above ground that is needed to be seen",
                             *const absolute = "height that is needed to be seen, absolute";
    ground_notes notes = {0};
    io_raster_product product = ground_product(j->ground,
                                               c->needed              ? IO_CELL_FLOAT32
                                               : c->from.count <= 254 ? IO_CELL_UINT8
                                                                      : IO_CELL_UINT16,
                                               1,
                                               c->needed_absolute  ? &absolute
                                               : c->needed         ? &needed
                                               : c->from.count > 1 ? &count
                                                                   : &seen,
                                               &notes);
    product.white = c->needed ? 100 : (double)c->from.count;
    if (c->needed) product.unit = "m";
    for (size_t k = 0; k < c->from.count; k++) {
        const ground_place *p = &c->places[k];
        ground_note(&notes, "OBSERVER_%zu=%.17g,%.17g,%s%.17g", k + 1, p->x, p->y, p->absolute ? "=" : "", p->z);
    }
    ground_note(&notes, "HEIGHTS=metres; an observer's third number is above ground, or absolute behind =");
    if (!c->needed) ground_note(&notes, "TARGET_HEIGHT=%.9g", c->target);
    if (c->max_distance > 0) ground_note(&notes, "MAX_DISTANCE=%.9g", c->max_distance);
    ground_note(&notes, "CURVATURE=%.9g", curvature_of(j));
    const bool good = ground_write(j->ground, &product, 1, fill, j, error);
    ground_notes_free(&notes);
    return good;
}

static bool make(ground *g, const viewshed_command *c, io_error *error) {
    job j = {.ground = g, .command = c};
    const bool good = make_view(&j, error);
    sight_bounds_destroy(j.bounds);
    free(j.seen);
    free(j.heights);
    return good;
}

static bool wrong(viewshed_command *c) {
    if (c->from.count == 0) return command_fail(name, "--from X,Y is missing: the observer's place"), true;
    for (size_t k = 0; k < c->from.count; k++)
        if (!ground_parse_place(name, c->from.values[k], 2, &c->places[k])) return true;
    c->needed |= c->needed_absolute;
    if (c->needed && c->from.count > 1)
        return command_fail(name, "the height that is needed to be seen is that of one observer, not of %zu",
                            c->from.count),
               true;
    if (c->max_distance < 0) return command_fail(name, "--max-distance takes metres, not %g", c->max_distance), true;
    if (c->curvature < 0) return command_fail(name, "--curvature takes a number from 0 on, not %g", c->curvature), true;
    return false;
}

static int run(int argc, char **argv) {
    static viewshed_command c; /* large */
    c.curvature = NAN;
    enum { OWN = 7, ALL = OWN + PIECES_OPTION_COUNT + GROUND_OPTION_COUNT };
    option_spec options[ALL] = {
        {.name = "from",
         .value = "X,Y[,H]",
         .help = "the observer's place on the map, with the eye H metres\nabove ground (default: 2), or X,Y,=Z; may be "
                 "given\n"
                 "up to 256 times",
         .kind = OPTION_AGAIN,
         .to = &c.from},
        {.name = "target-height",
         .value = "T",
         .help = "height of the target above ground, in metres\n(default: 0, the ground)",
         .kind = OPTION_NUMBER,
         .to = &c.target},
        {.name = "max-distance",
         .value = "D",
         .help = "samples farther away than D metres are not seen, nor\nread and written (default: no limit)",
         .kind = OPTION_NUMBER,
         .to = &c.max_distance},
        {.name = "extent",
         .value = "NAME",
         .help = "with --max-distance: write only samples within it (near,\nthe default), or the full raster",
         .kind = OPTION_NAME,
         .to = &c.extent,
         .names = extent_names},
        {.name = "curvature",
         .value = "K",
         .help = "the earth's curvature as a factor: 0 for a flat earth,\n1 without air, 0.857 = 6/7 with usual "
                 "refraction\n"
                 "(default: 6/7, or 0 if the file has no map)",
         .kind = OPTION_NUMBER,
         .to = &c.curvature},
        {.name = "needed",
         .help = "write the height above ground, in metres, from which on\na target is seen; 0 where the ground itself "
                 "is (float32;\n"
                 "NaN: no data or too far)",
         .to = &c.needed},
        {.name = "needed-absolute", .help = "the same as an absolute height in metres", .to = &c.needed_absolute},
    };
    pieces_rows(&c.ground, options + OWN);
    ground_rows(&c.ground, name, options + OWN + PIECES_OPTION_COUNT);
    static const char *const operands[] = {"DEM"};
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM --from X,Y[,H] -o FILE [OPTIONS]",
        .what = "Computes which samples of a terrain are seen from a place and writes a raster: 1\n"
                "where the straight line from the eye to the sample, or to a target on it, passes\n"
                "above the surface, 0 elsewhere (uint8; 255: no data). With several observers it\n"
                "writes how many of them see the sample (uint16 from 255 observers on; 65535: no\n"
                "data). --needed writes heights instead.\n"
                "\n"
                "The surface is two triangles between each four samples, lowered by the earth's\n"
                "curvature; every sample's line is decided exactly, and one that touches the\n"
                "surface is blocked.\n"
                "\n" GROUND_PLACE_HELP "\n",
        .examples = "  cellwalk viewshed dem.tif --from 600250,5199800 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,30 --target-height 1.5 \\\n"
                    "      --max-distance 20000 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800 --needed -o needed.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,=1250 -o seen.tif\n",
        .options = options,
        .option_count = ALL,
        .operands = operands,
        .operand_least = 1,
        .operand_most = 1,
    };
    const char *path;
    const int status = options_parse(&usage, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    if (wrong(&c)) return EXIT_USAGE;
    ground g;
    io_error error = {""};
    const int opened = ground_open(&g, &c.ground, path, 1, GROUND_PIECES);
    return opened == EXIT_SUCCESS ? ground_close(&g, make(&g, &c, &error), &error) : opened;
}

const command command_viewshed = {"viewshed", "compute which samples are seen from one place or several", run};
