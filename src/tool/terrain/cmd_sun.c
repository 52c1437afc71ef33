/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk sun`: hours of sunlight and its energy, over a day or many, on every sample of a terrain. */

#include "sun.h"

#include "command.h"
#include "insolation.h"
#include "number.h"
#include "sun_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char name[] = "sun";

/* Suns over all days at most: a year in half minutes. */
enum { SUNS_MOST = 1100000 };

typedef struct sun_command {
    product product;
    const char *date, *to, *step, *place;
    unsigned directions;
    bool irradiance;
    sun_table at; /* all that the table shares with the raster stands here */
    double last;  /* midnight of UTC that begins the last day */
    /* The work. */
    sun_list suns; /* weights: of the file's */
    size_t bands;
    cw_light *shadows; /* the lowest sun of each direction */
    insolation *sum;
} sun_command;

enum { DIRECT, DIFFUSE, BANDS };

/* The ground's terrain is another piece, or the whole without samples. */
static bool enter(product *p, io_error *error) {
    sun_command *c = p->context;
    const insolation_desc desc = {.suns = c->suns.suns,
                                  .count = c->suns.count,
                                  .weights = c->suns.weights,
                                  .hours = c->at.desc.step / 3600,
                                  .linke = c->at.desc.linke,
                                  .curvature = c->at.curvature,
                                  .directions = c->directions};
    return product_good(cw_insolation_create(&p->ground.terrain, &desc, &c->sum), error);
}

static bool fill(product *p, const product_block *b, void *cells, io_error *error) {
    const sun_command *c = p->context;
    const terrain *t = &p->ground.terrain;
    const cw_horizon sky = {.count = c->at.desc.sky, .curvature = c->at.curvature, .flags = CW_HORIZON_TILTED};
    const cw_status status = !c->irradiance      ? cw_insolation_hours(c->sum, &b->run, b->area, cells)
                             : b->band == DIRECT ? cw_insolation_direct(c->sum, &b->run, b->area, cells)
                                                 : cw_sky_view(t, &b->run, &sky, b->area, cells);
    const float light = c->irradiance && b->band == DIFFUSE ? (float)cw_insolation_diffuse(c->sum) : 1;
    for (size_t k = 0; k < b->rows * b->area.at.nx && status == CW_OK && light != 1; k++) ((float *)cells)[k] *= light;
    return product_good(status, error);
}

/* The sun in the middle of each step. Days begin at midnight of the place's mean solar time, so that a day's light is
 * one piece. */
static bool find_suns(sun_command *c, const sun_place *place, io_error *error) {
    sun_list *list = &c->suns;
    if (c->at.suns) return sun_list_read(c->at.suns, &c->product.ground.watch, list, error);
    list->count = (size_t)nearbyint((c->last + day - c->at.first) / c->at.desc.step);
    list->suns = malloc(list->count * sizeof *list->suns);
    if (list->suns == NULL) return io_fail(error, "out of memory");
    const double midnight = c->at.first - place->longitude / 360 * day;
    for (size_t k = 0; k < list->count; k++)
        list->suns[k] = cw_sun_at_place(midnight + ((double)k + 0.5) * c->at.desc.step, place);
    return true;
}

/* All that can throw a shadow in the direction of any sun matters, and for diffuse light all that hides sky. */
static bool find_what_matters(product *p, io_error *error) {
    sun_command *c = p->context;
    const size_t count = cw_insolation_directions(c->sum);
    c->shadows = calloc(count + 1, sizeof *c->shadows);
    if (c->shadows == NULL) return io_fail(error, "out of memory");
    c->shadows[0].altitude = 90; /* without any sun there are no shadows */
    for (size_t k = 0; k < count; k++) {
        cw_insolation_direction(c->sum, k, &c->shadows[k].azimuth, &c->shadows[k].altitude);
        c->shadows[k].curvature = c->at.curvature;
    }
    p->matters = (ground_matters){.suns = c->shadows,
                                  .sun_count = count > 0 ? count : 1,
                                  .horizons = c->bands == BANDS,
                                  .above_level = true,
                                  .curvature = c->at.curvature};
    return true;
}

static void note_light(product *p, const sun_command *c) {
    product_note(p, "CLEAR_SKY=ESRA (Rigollier, Bauer, Wald 2000)");
    product_note(p, "LINKE=%.9g", c->at.desc.linke);
    product_note(p, "SKY_DIRECTIONS=%u", c->at.desc.sky);
    product_note(p, "DIFFUSE_LEVEL=%.9g", cw_insolation_diffuse(c->sum));
}

static void describe_list(product *p, const sun_command *c) {
    product_describe(p, IO_CELL_FLOAT32, 1,
                     c->irradiance ? "sum of the suns' weights on the ground as it leans"
                                   : "sum of the weights of suns that are seen");
    product_note(p, "SUNS_FILE=%s", c->at.suns);
    product_note(p, "SUNS=%zu", c->suns.count);
}

static void describe(product *p, const sun_command *c, const sun_place *place) {
    static const char *const bands[BANDS] = {"direct light on the ground", "diffuse light on the ground"};
    product_describe(p, IO_CELL_FLOAT32, c->bands,
                     c->irradiance ? "energy of sunlight on the ground under a cloudless sky"
                                   : "hours of direct sunlight");
    p->raster.unit = c->irradiance ? "Wh/m2" : "h";
    if (c->irradiance) p->raster.band_names = bands;
    product_note(p, "DATE=%s", c->date);
    product_note(p, "TO=%s", c->to ? c->to : c->date);
    product_note(p, "STEP_SECONDS=%.9g", c->at.desc.step);
    product_note(p, "SUN_OVER=%.9g,%.9g", place->longitude, place->latitude);
    if (c->irradiance) note_light(p, c);
}

static bool begin(product *p, io_error *error) {
    sun_command *c = p->context;
    const ground *g = &p->ground;
    sun_place *place = &c->at.desc.place;
    if (c->at.at) return sun_table_write(p, &c->at, error);
    if (!c->at.suns && !sun_table_place(p, &c->at, &g->whole, NULL, error)) return false;
    if (!find_suns(c, place, error) || !product_check_output(p, error) || !enter(p, error) ||
        !find_what_matters(p, error))
        return false;
    if (c->at.suns)
        describe_list(p, c);
    else
        describe(p, c, place);
    product_note(p, "SUN_DIRECTIONS=%zu%s", cw_insolation_directions(c->sum), c->directions ? "" : " (each sun's own)");
    product_note(p, "CURVATURE=%.9g", c->at.curvature);
    return true;
}

static void leave(void *context) {
    sun_command *c = context;
    cw_insolation_destroy(c->sum);
    c->sum = NULL;
}

static void end(void *context) {
    sun_command *c = context;
    free(c->shadows);
    sun_list_free(&c->suns);
}

/* ---- the command line -------------------------------------------------------------------------------------------- */

/* The midnights of UTC that begin the first and the last day of a day, a month or a year: 2024-06-21, 2024-06, 2024. */
static bool read_days(const char *text, double *first, double *last) {
    const size_t length = strlen(text);
    char whole[40];
    snprintf(whole, sizeof whole, "%.10s%sT00:00Z", text, length == 4 ? "-01-01" : length == 7 ? "-01" : "");
    if ((length != 4 && length != 7 && length != 10) || !cw_sun_parse_time(whole, first)) return false;
    for (*last = *first;; *last += day) {
        const time_t next = (time_t)(*last + day);
        const struct tm *date = gmtime(&next);
        snprintf(whole, sizeof whole, "%04d-%02d-%02d", date->tm_year + 1900, date->tm_mon + 1, date->tm_mday);
        if (strncmp(whole, text, length) != 0) return true;
    }
}

/* A number with s, min or h, which divides a day. */
static bool read_step(const char *text, double *seconds) {
    static const struct {
        const char *name;
        double seconds;
    } units[] = {{"s", 1}, {"min", 60}, {"h", 3600}};
    char *end;
    const double number = number_read(text, &end);
    for (size_t k = 0; k < sizeof units / sizeof *units && end != text; k++) {
        if (strcmp(end, units[k].name) != 0) continue;
        *seconds = number * units[k].seconds;
        const double steps = nearbyint(day / *seconds);
        return *seconds >= 1 && *seconds <= day && fabs(steps * *seconds - day) < 1e-6;
    }
    return false;
}

static bool check(void *context, size_t *bands) {
    sun_command *c = context;
    double unused, lon_lat[2] = {0, 0};
    const bool energy_only = c->at.desc.linke > 0 || c->at.desc.sky > 0,
               dated = c->date || c->to || c->step || c->place;
    if (c->step == NULL) c->step = c->at.at ? "1min" : "15min";
    if (c->at.suns && (dated || energy_only))
        return command_refuse(name, "--suns goes with none of --date, --to, --step, --lon-lat, --linke and --sky");
    if (!c->at.suns && c->date == NULL) return command_refuse(name, "--date is missing, or --suns FILE.csv");
    if (c->date && !read_days(c->date, &c->at.first, &c->last))
        return command_refuse(name, "--date takes a day, as 2024-06-21, a month or a year, not '%s'", c->date);
    if (c->to && !read_days(c->to, &unused, &c->last))
        return command_refuse(name, "--to takes a day, as 2024-06-21, a month or a year, not '%s'", c->to);
    if (c->to && c->last < c->at.first) return command_refuse(name, "--to %s is before --date %s", c->to, c->date);
    if (!read_step(c->step, &c->at.desc.step))
        return command_refuse(name, "--step takes a time that divides a day, as 15min, 1h or 30s, not '%s'", c->step);
    if ((c->last + day - c->at.first) / c->at.desc.step > SUNS_MOST)
        return command_refuse(name, "there are more than %d steps from %s to %s; give a longer --step", SUNS_MOST,
                              c->date, c->to ? c->to : c->date);
    if (c->place && (ground_numbers(c->place, lon_lat, 2, 2) == 0 || fabs(lon_lat[0]) > 360 || fabs(lon_lat[1]) > 90))
        return command_refuse(name, "--lon-lat takes longitude and latitude in degrees, as 6.1,49.8, not '%s'",
                              c->place);
    if (c->at.desc.max_distance > 0 && !c->at.at) return command_refuse(name, "--max-distance goes with --at");
    if (c->at.at && (c->irradiance || c->directions > 0 || c->product.window))
        return command_refuse(
            name, "--at prints hours and energy, and goes with none of --irradiance, --directions and --window");
    if (energy_only && !c->irradiance && !c->at.at)
        return command_refuse(name, "--linke and --sky go with --irradiance");
    if (c->at.desc.linke == 0) c->at.desc.linke = CLEAR_SKY_LINKE;
    if (c->at.desc.sky == 0) c->at.desc.sky = 32;
    *bands = c->bands = c->at.at ? 0 : c->irradiance && !c->at.suns ? BANDS : 1;
    c->at.days = (size_t)nearbyint((c->last - c->at.first) / day) + 1;
    c->at.placed = c->place != NULL;
    c->at.desc.place = (sun_place){remainder(lon_lat[0], 360), lon_lat[1], 0};
    return sun_table_check(&c->at, name);
}

static int run(int argc, char **argv) {
    static sun_command c = {.at = {.facing = NAN}}; /* large */
    c.product = (product){
        .context = &c, .check = check, .begin = begin, .enter = enter, .leave = leave, .fill = fill, .end = end};
    const option_spec options[] = {
        option_text("date", "DAY", &c.date, "the day, as 2024-06-21; 2024-06 and 2024 are all their days"),
        option_text("to", "DAY", &c.to, "the last of several days (default: --date)"),
        option_text(
            "step", "TIME", &c.step,
            "time between two places of the sun, as 30s, 15min (default, with --at 1min) or 1h; it divides a day"),
        option_text("suns", "CSV", &c.at.suns,
                    "places of the sun in place of dates, for the Moon, Mars or a weather year: a table whose first "
                    "line names the columns azimuth (from the map's north), altitude and, if there, weight; the result "
                    "is the sum of the weights of suns that are seen, with --irradiance that of their light on the "
                    "ground as it leans, where a weight is the energy on a surface that faces the sun"),
        option_count("directions", "N", &c.directions, 8, 3600,
                     "cast shadows from the nearest of N directions all round, so that many days share their horizons; "
                     "azimuths are then off by up to 180 / N degrees (default: each sun's own)"),
        option_flag("irradiance", &c.irradiance,
                    "energy instead of hours, in watt hours a square metre of the ground as it leans: one band of "
                    "direct light, one of diffuse light"),
        option_range("linke", "TL", &c.at.desc.linke, 1, 10, "a turbidity from 1 to 10",
                     "with --irradiance: Linke's turbidity for an air mass of 2, from 1 to 10 (default: 3)"),
        option_count("sky", "N", &c.at.desc.sky, 1, 3600,
                     "with --irradiance: directions of the sky-view factor for diffuse light (default: 32)"),
        option_text("lon-lat", "LON,LAT", &c.place,
                    "where on earth the terrain is, in degrees, for files that do not say; the map's north is then the "
                    "true one"),
        option_text("at", "X,Y[,H]", &c.at.at,
                    "print a table of the sun at one place of the map, H metres above ground (default: 0) or X,Y,=Z, "
                    "as CSV: a row a day, or for more than 62 days a row a month: when it is first and last seen "
                    "behind the hills (UTC; of a month the mean), hours, and direct and diffuse light in watt hours a "
                    "square metre; free_... are without hills"),
        option_text("tilt", "DEG", &c.at.tilt,
                    "with --at: light on a surface that leans by so much, as a roof (90: a wall), or the word ground: "
                    "as the ground leans there (default: 0, level)"),
        option_number("facing", "AZ", &c.at.facing,
                      "with --tilt: where the surface looks to, in degrees from the map's north (default: 180)"),
        option_metres(
            "max-distance", &c.at.desc.max_distance,
            "with --at: terrain farther away than D metres does not count and is not read (default: no limit)"),
        product_flat_earth_row(&c.at.curvature),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (--date DAY | --suns CSV) (-o FILE | --at X,Y) [OPTIONS]",
        .what = "Computes hours of direct sunlight on every sample of a terrain and writes a raster (float32; NaN: no "
                "data). --irradiance writes the energy of direct and diffuse light under a cloudless sky instead.\n\n"
                "The sun stands in the middle of each step, where it is seen from the terrain's middle, lifted by the "
                "air's refraction. A sample is lit while the sun's middle is above its horizon; shadows are those of "
                "`cellwalk shadow`. Days begin at midnight of the terrain's mean solar time. Hours are right to one "
                "step a day and horizon, and the sun's place to 0.01 degrees from 1950 to 2050.\n\n"
                "Energy is by the model of the European Solar Radiation Atlas (Rigollier, Bauer and Wald 2000, also in "
                "GRASS' r.sun): direct light falls on the ground as it leans, at its height; diffuse light comes from "
                "an evenly bright sky, as much of it as the leaning ground sees. Light that other ground reflects is "
                "left out.\n",
        .examples = "  cellwalk sun dem.tif --date 2024-06-21 -o hours.tif\n"
                    "  cellwalk sun dem.tif --date 2024-06-01 --to 2024-06-30 -o june.tif\n"
                    "  cellwalk sun dem.tif --date 2024-03-20 --irradiance --linke 2.5 -o energy.tif\n"
                    "  cellwalk sun dem.tif --date 2024 --at 600250,5199800,2 > months.csv\n"
                    "  cellwalk sun dem.tif --date 2024-01 --at 600250,5199800,6 --tilt 35\n"
                    "  cellwalk sun dem.tif --suns moon.csv -o share.tif\n",
        OPTIONS_OF(options),
    };
    return product_run(&c.product, &usage, argc, argv);
}

const command command_sun = {"sun", "compute hours or energy of sunlight over days on a terrain", run};
