/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk horizon`: the horizon's angle all round, or how much of the sky is seen; of all samples, or of places. */

#include "command.h"
#include "inputs.h"
#include "output.h"
#include "place.h"
#include "product.h"
#include "sun_day.h"
#include "suns.h"
#include "table.h"

#include <math.h>

static const char name[] = "horizon";

typedef struct horizon_command {
    product product;
    cw_horizon desc;
    unsigned directions;
    bool sky, tilted, open, below, distance;
    bool sum;                          /* one band, not one of each direction */
    option_again at;                   /* texts of places, or */
    const char *file;                  /* a table of them; NULL: none */
    io_place places[OPTION_AGAIN_MAX]; /* of at */
    /* Of places. */
    io_points all;
    sight_bounds *bounds;
    bool in_circles; /* the circle around each place is read in turn */
    io_output to;
} horizon_command;

static bool fill(product *p, const product_block *b, void *cells, io_error *error) {
    const horizon_command *c = p->context;
    const terrain *t = &p->ground.terrain;
    cw_horizon h = c->desc;
    h.flags = c->tilted ? CW_HORIZON_TILTED : c->below ? CW_HORIZON_BELOW : 0;
    return product_good(c->sky || c->tilted ? cw_sky_view(t, &b->run, &h, b->area, cells)
                        : c->open || c->below
                            ? cw_openness(t, &b->run, &h, b->area, cells)
                            : cw_horizon_angles(t, &b->run, &h, (uint32_t)b->band, b->area, c->distance ? NULL : cells,
                                                c->distance ? cells : NULL),
                        error);
}

/* ---- horizons of places ------------------------------------------------------------------------------------------ */

static bool write_row(horizon_command *c, size_t k, const place_horizon *h, double from_true, io_error *error) {
    char true_azimuth[40] = "";
    if (isfinite(from_true)) snprintf(true_azimuth, sizeof true_azimuth, "%.6g", from_true);
    if (!io_output_print(&c->to, error, "%zu,%.6g,%s,", k + 1, h->azimuth, true_azimuth)) return false;
    if (!(isnan(h->angle)
              ? io_output_print(&c->to, error, ",,,")
              : io_output_print(&c->to, error, "%.6f,%.3f,%.10g,%.10g", h->angle, h->distance, h->at[0], h->at[1])))
        return false;
    return (!c->all.has_names || io_table_write_cell(&c->to, c->all.list[k].name, error)) &&
           io_output_write(&c->to, "\n", 1, error);
}

static bool read_around(horizon_command *c, const io_place *p, double metres, io_error *error) {
    ground *g = &c->product.ground;
    cw_sight_bounds_destroy(c->bounds);
    c->bounds = NULL;
    return ground_read_around(g, p->x, p->y, metres, error) &&
           (cw_sight_bounds_create(&g->terrain, &c->bounds) == CW_OK || io_fail(error, "out of memory"));
}

/* The eye at a place, around which so many metres are read unless all is in memory. */
static bool find_eye(horizon_command *c, size_t number, double metres, double eye[3], io_error *error) {
    const io_place *p = &c->all.list[number];
    char text[IO_PLACE_ROOM];
    double level;
    if (c->in_circles && !read_around(c, p, metres, error)) return false;
    if (!ground_find_place(&c->product.ground.terrain, p, eye, &level, error)) return false;
    return !isnan(level) ||
           io_fail(error, "%s: is not on the terrain, where the horizon is found", io_place_text(p, text));
}

static bool write_place(horizon_command *c, size_t number, io_error *error) {
    const ground *g = &c->product.ground;
    const cw_horizon *d = &c->desc;
    const terrain *t = &g->terrain;
    double eye[3], xy[2];
    sight s;
    sun_place north;
    io_error unknown;
    if (!find_eye(c, number, d->max_distance, eye, error)) return false;
    cw_sight_init(&s, t, c->bounds, eye, d->curvature);
    terrain_to_map(t, eye[0], eye[1], xy);
    if (!sun_place_of(t, &g->about.georef, xy, g->path, NULL, &north, &unknown)) north.turned = NAN;
    for (size_t k = 0; k < d->count; k++) {
        const place_horizon h =
            cw_place_horizon(&s, fmod(d->start + 360.0 * (double)k / (double)d->count, 360), d->max_distance);
        if (!write_row(c, number, &h, fmod(h.azimuth - north.turned + 360, 360), error)) return false;
    }
    return true;
}

/* A place that is none is found before anything is printed. */
static bool write_all(horizon_command *c, io_error *error) {
    bool good = true;
    double eye[3];
    for (size_t k = 0; k < c->all.count && good; k++) good = find_eye(c, k, DBL_MIN, eye, error);
    good = good && io_output_print(&c->to, error, "place,azimuth,true_azimuth,angle,distance,x,y%s\n",
                                   c->all.has_names ? ",name" : "");
    for (size_t k = 0; k < c->all.count && good; k++) {
        product_tell(&c->product, (double)k / (double)c->all.count);
        good = write_place(c, k, error);
    }
    return good;
}

/* The horizons of all places, to the output or standard output. */
static bool write_places(horizon_command *c, io_error *error) {
    const observers_from from = {.places = c->places, .place_count = c->at.count, .file = c->file};
    if (c->file && !io_inputs_note_path(c->file)) return io_fail(error, "out of memory");
    if (!observers_find(&c->all, &from, &c->product.ground, error)) return false;
    const double distance = c->desc.max_distance;
    const bool one = c->all.count == 1; /* then its circle is all */
    c->in_circles = distance > 0 && !one && !ground_is_small(&c->product.ground);
    const char *output = c->product.output;
    const bool good = (c->in_circles || read_around(c, c->all.list, one ? distance : 0, error)) &&
                      io_output_open(&c->to, output ? output : "-", error) && write_all(c, error) &&
                      io_output_commit(&c->to, error);
    io_output_discard(&c->to);
    progress_end();
    if (good)
        command_wrote(name, c->product.quiet, output, c->product.start, "horizons of %zu place%s", c->all.count,
                      c->all.count == 1 ? "" : "s");
    cw_sight_bounds_destroy(c->bounds);
    io_points_free(&c->all);
    return good;
}

/* ---- the command line -------------------------------------------------------------------------------------------- */

static bool is_of_places(const horizon_command *c) { return c->at.count > 0 || c->file != NULL; }

static bool begin(product *p, io_error *error) {
    horizon_command *c = p->context;
    if (is_of_places(c)) return write_places(c, error);
    static double azimuths[3600];
    if (!product_good(cw_horizon_azimuths(&p->ground.terrain, &c->desc, azimuths), error)) return false;
    product_describe(p, IO_CELL_FLOAT32, c->sum ? 1 : c->directions,
                     c->tilted
                         ? "sky-view factor: share of an evenly bright sky's light that reaches the leaning ground"
                     : c->sky      ? "sky-view factor: share of an evenly bright sky's light that reaches level ground"
                     : c->open     ? "openness: the mean angle between the zenith and the horizon"
                     : c->sum      ? "negative openness: the mean angle between the nadir and the lowest point"
                     : c->distance ? "distance to the horizon in metres, one band a direction"
                                   : "angle of the horizon over the level, one band a direction");
    product_note(p, "DIRECTIONS=%u", c->directions);
    product_note(p, "FIRST_AZIMUTH=%.9g", c->desc.start);
    product_note(p, "ANGLES=degrees; azimuth from the map's north over east");
    if (c->desc.max_distance > 0) product_note(p, "MAX_DISTANCE=%.9g", c->desc.max_distance);
    product_note(p, "CURVATURE=%.9g", c->desc.curvature);
    /* Bands are called by their direction, as GRASS numbers none of them alike. */
    for (unsigned k = 0; k < c->directions && !c->sum; k++)
        if (!product_name_band(p, k, error, "azimuth %.6g", azimuths[k])) return false;
    if (!c->sky && !c->tilted) p->raster.unit = c->distance ? "metre" : "degree";
    /* Without a distance far mountains count, as far as the raster's highest samples let them. */
    p->matters = (ground_matters){.distance = c->desc.max_distance,
                                  .horizons = !c->below,
                                  .above_level = c->sky || c->tilted,
                                  .curvature = c->desc.curvature};
    if (c->below) p->more = 8; /* the samples upside down and their bounds */
    p->passes = c->distance ? 30 : 1;
    return true;
}

static bool check(void *context, size_t *bands) {
    horizon_command *c = context;
    const bool at = is_of_places(c);
    c->sum = c->sky || c->tilted || c->open || c->below;
    for (size_t k = 0; k < c->at.count; k++)
        if (!product_parse_place(name, c->at.values[k], 0, &c->places[k])) return false;
    if (c->sky + c->tilted + c->open + c->below > 1)
        return command_refuse(name, "of --svf, --svf-tilted, --openness and --openness-negative one can be written");
    if (c->below && c->desc.curvature != 0)
        return command_refuse(name, "--openness-negative is that of a flat earth, and goes without --curvature");
    if (c->distance && (c->sum || at))
        return command_refuse(name, "--distance goes with none of --svf, --openness, --at and --places");
    if (c->at.count > 0 && c->file) return command_refuse(name, "--at and --places do not go together");
    if (at && (c->sum || c->product.window))
        return command_refuse(
            name, "--at and --places print horizons of places, and go with none of --svf, --openness and --window");
    c->desc.count = c->directions;
    *bands = at ? 0 : c->sum ? 1 : c->directions;
    return true;
}

static int run(int argc, char **argv) {
    static horizon_command c; /* large */
    c.product = (product){.context = &c, .check = check, .begin = begin, .fill = fill};
    c.directions = 32;
    const option_spec options[] = {
        option_count("directions", "N", &c.directions, 1, 3600, "number of directions, evenly spaced (default: 32)"),
        option_number("start", "AZ", &c.desc.start,
                      "azimuth of the first direction in degrees, from the map's north over east (default: 0)"),
        option_flag("svf", &c.sky,
                    "write the sky-view factor instead: the share, 0 to 1, of an evenly bright sky's light that "
                    "reaches level ground (float32)"),
        option_flag("svf-tilted", &c.tilted, "the same for the ground as it leans, which is also hidden behind itself"),
        option_flag(
            "openness", &c.open,
            "write openness instead, in degrees: the mean of the angles between the zenith and the horizon in all "
            "directions in which there is terrain, 90 on a plane, more on ridges; usually with --max-distance"),
        option_flag("openness-negative", &c.below,
                    "the same between the nadir and the lowest point in each direction: more in valleys"),
        option_flag("distance", &c.distance,
                    "write the distance instead, in metres: how far away the horizon is in each direction; takes some "
                    "10 to 100 times as long as the angles"),
        option_several(
            "at", "X,Y[,H]", &c.at,
            "print the horizon at a place of the map, H metres above ground (default: 0) or X,Y,=Z, as CSV: degrees "
            "(azimuths of the map and from true north), metres, coordinates of the map; may be given up to 256 times"),
        option_text("places", "FILE", &c.file,
                    "the same for the places of a table (.csv) with the columns x, y and, if there, height and name, "
                    "or of points in any file that GDAL reads; -o names the table to write"),
        option_metres("max-distance", &c.desc.max_distance,
                      "terrain farther away than D metres does not count (default: no limit)"),
        product_flat_earth_row(&c.desc.curvature),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (-o FILE | --at X,Y | --places FILE) [OPTIONS]",
        .what = "Computes the horizon of every sample of a terrain and writes a raster with one band a direction: the "
                "elevation angle in degrees of the highest point there, negative below the sample's level (float32). "
                "--svf writes the sky-view factor instead, --openness the openness (Yokoyama, Shirasawa and Pike "
                "2002), --distance how far away that point is (the nearest of several), and --at and --places print "
                "the horizons of places.\n\n"
                "NaN means no data: at holes, and where no terrain lies in that direction within --max-distance. The "
                "sky-view factor counts the sky there as free. Angles are exact to 0.001 degrees for the surface of "
                "two triangles between each four samples, if it is less steep than 30; where the map's scale differs "
                "from row to row, to 0.003 (1 + twice its steepest rise over distance). On a map in degrees, "
                "directions are off in proportion to the distance: by up to 0.03 degrees at 5 km and latitude 50.\n\n"
                "To save time (papers/tradeoff.md of the sources): for --svf, 16 directions take half of the time of "
                "32, and 99 % of the factors are off by at most 0.0021. --coarser costs too much error here.\n",
        .examples = "  cellwalk horizon dem.tif --directions 32 -o horizon.tif\n"
                    "  cellwalk horizon dem.tif --directions 64 --svf -o sky.tif\n"
                    "  cellwalk horizon dem.tif --directions 8 --cog -o horizon.tif\n"
                    "  cellwalk horizon dem.tif --openness --max-distance 500 -o open.tif\n"
                    "  cellwalk horizon dem.tif --openness-negative -o deep.png --quiet\n"
                    "  cellwalk horizon dem.tif --directions 8 --distance -o metres.tif\n"
                    "  cellwalk horizon dem.tif --at 600250,5199800 --directions 360 \\\n"
                    "      --max-distance 50000 > horizon.csv\n",
        OPTIONS_OF(options),
    };
    return product_run(&c.product, &usage, argc, argv);
}

const command command_horizon = {"horizon", "compute horizon angles or the sky-view factor of each sample", run};
