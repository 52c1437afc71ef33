/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk shadow`: sun and shadow on every sample of a terrain. */

#include "shadow.h"

#include "command.h"
#include "product.h"
#include "sun_place.h"

#include <math.h>
#include <stdlib.h>

static const char name[] = "shadow";

typedef struct shadow_command {
    ground_options ground;
    const char *sun, *time;   /* one of them is NULL */
    double azimuth, altitude; /* of sun, degrees */
    double seconds;           /* of time, as sun_at takes it */
    double disc;              /* NaN: the sun is a point */
    double curvature;
    bool hillshade, usual_disc;
} shadow_command;

typedef struct job {
    const shadow_command *command;
    ground *ground;
    sunlight_desc sun;
    sunlight *light;
    bool share;            /* floats */
    reach_blocks blocks;   /* of all from which shadows can fall on the window, once they are needed */
    reach_sunward sunward; /* from the window */
} job;

static bool enter(void *context, io_error *error) {
    job *j = context;
    sunlight_destroy(j->light);
    const cw_status status = sunlight_create(&j->ground->terrain, &j->sun, &j->light);
    return status == CW_OK || io_fail(error, "%s", cw_status_message(status));
}

static bool is_sunward(void *context, cw_rectangle block) {
    const job *j = context;
    return reach_passes(&j->sunward, j->ground->window, block);
}

static bool around(void *context, cw_rectangle part, cw_rectangle *piece, io_error *error) {
    job *j = context;
    const terrain *whole = &j->ground->whole;
    if (j->blocks.whole == NULL) {
        j->sunward = reach_toward(whole, &j->sun, j->ground->window);
        if (reach_blocks_create(whole, &j->blocks) != CW_OK) return io_fail(error, "out of memory");
        if (!pieces_survey(j->ground, &j->blocks, is_sunward, j, error)) return false;
    }
    const reach_sunward sunward = reach_toward(whole, &j->sun, part);
    *piece = reach_of_shadows(&j->blocks, &sunward, part);
    return true;
}

static bool fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error) {
    job *j = context;
    (void)band;
    const cw_status status = j->share ? sunlight_share(j->light, &j->ground->query, row, rows, cells)
                                      : sunlight_lit(j->light, &j->ground->query, row, rows, cells);
    return status == CW_OK || io_fail(error, "%s", cw_status_message(status));
}

static bool find_sun(const shadow_command *c, const ground *g, sunlight_desc *sun, io_error *error) {
    sun_place place;
    sun->azimuth = c->azimuth;
    sun->altitude = c->altitude;
    if (c->sun) return true;
    if (!sun_place_find(&g->whole, ground_georef(g), g->path, "give --sun", &place, error)) return false;
    const sun_position p = sun_place_at(&place, c->seconds);
    sun->azimuth = p.azimuth;
    sun->altitude = p.altitude;
    if (c->usual_disc) sun->radius = p.radius;
    fputs("sun at ", stdout);
    print_text(stdout, c->time);
    printf(" over %.4f, %.4f: azimuth %.3f (%.3f on the map), altitude %.3f degrees\n", place.longitude, place.latitude,
           fmod(p.azimuth - place.turned + 360, 360), p.azimuth, p.altitude);
    return true;
}

static bool make_light(job *j, io_error *error) {
    const shadow_command *c = j->command;
    sunlight_desc sun = {
        .hillshade = c->hillshade, .curvature = c->curvature, .radius = c->usual_disc ? SUN_RADIUS : 0};
    if (!find_sun(c, j->ground, &sun, error)) return false;
    if (!isnan(c->disc)) sun.radius = c->disc;
    if (sun.altitude <= 0) command_warn("shadow", "the sun is at %.3f degrees, below the horizon", sun.altitude);
    j->sun = sun;
    j->share = sun.radius > 0 || sun.hillshade;
    static const char *const lit = "1 where the sun is seen, 0 in the shadow",
                             *const share = "share of the sun's disc that is seen",
                             *const shade =
                                 "light on the ground: cosine of the angle between sun and normal, 0 in the shadow",
                             *const soft =
                                 "light on the ground: that cosine times the share of the sun's disc that is seen";
    ground_notes notes = {0};
    const io_raster_product product = ground_product(j->ground, j->share ? IO_CELL_FLOAT32 : IO_CELL_UINT8, 1,
                                                     !j->share        ? &lit
                                                     : !sun.hillshade ? &share
                                                     : sun.radius > 0 ? &soft
                                                                      : &shade,
                                                     &notes);
    ground_note(&notes, "SUN_AZIMUTH=%.9g", sun.azimuth);
    ground_note(&notes, "SUN_ALTITUDE=%.9g", sun.altitude);
    ground_note(&notes, "SUN_DISC_RADIUS=%.9g", sun.radius);
    if (c->time) ground_note(&notes, "TIME=%s", c->time);
    ground_note(&notes, "ANGLES=degrees; azimuth from the map's north over east");
    ground_note(&notes, "CURVATURE=%.9g", c->curvature);
    static const pieces_maker maker = {.fill = fill, .around = around, .enter = enter};
    j->ground->counted = "in the sun";
    const bool good = pieces_write(j->ground, &product, sun.radius > 0 ? 16 : 1, &maker, j, error);
    ground_notes_free(&notes);
    return good;
}

static bool make(void *context, ground *g, io_error *error) {
    job j = {.command = context, .ground = g};
    const bool good = make_light(&j, error);
    sunlight_destroy(j.light);
    reach_blocks_destroy(&j.blocks);
    return good;
}

static bool check(void *context, size_t *bands) {
    shadow_command *c = context;
    (void)bands;
    double numbers[2] = {0, 0};
    if (c->sun && c->time == NULL && !ground_parse_sun(name, c->sun, numbers)) return false;
    if ((c->sun == NULL) == (c->time == NULL))
        command_fail(name, "give the sun's place by either --sun or --time");
    else if (c->time && !sun_parse_time(c->time, &c->seconds))
        command_fail(name, "--time takes a time with its zone, as 2024-06-21T12:00:00Z or +02:00, not '%s'", c->time);
    else if (!isnan(c->disc) && !(c->disc > 0 && c->disc <= 10))
        command_fail(name, "--disc takes degrees above 0, up to 10, not %g", c->disc);
    else if (c->curvature < 0)
        command_fail(name, "--curvature takes a number from 0 on, not %g", c->curvature);
    else {
        c->azimuth = numbers[0];
        c->altitude = numbers[1];
        return true;
    }
    return false;
}

static int run(int argc, char **argv) {
    shadow_command c = {.disc = NAN};
    const option_spec options[] = {
        option_text("sun", "AZ,ALT", &c.sun, "azimuth from the map's north over east, and altitude, in degrees"),
        option_text("time", "TIME", &c.time,
                    "date and time with a zone (2024-06-21T12:00:00Z, or +02:00 for Z), at which the sun stands over "
                    "the terrain's middle; the file must name a coordinate system"),
        option_flag(
            "hillshade", &c.hillshade,
            "light on the ground: the cosine of the angle between the sun and the ground's normal, 0 in shadow"),
        option_flag("sun-disc", &c.usual_disc,
                    "write the share of the sun's disc that is seen, so that shadows have soft edges"),
        option_number("disc", "R", &c.disc, "the same for a disc of radius R, in degrees"),
        ground_flat_earth_row(&c.curvature),
    };
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (--sun AZ,ALT | --time TIME) -o FILE [OPTIONS]",
        .what = "Computes sunlight on every sample of a terrain and writes a raster: 1 where the sun is seen, 0 where "
                "the terrain hides it (uint8; 255: no data). --hillshade, --sun-disc and --disc write the share of its "
                "light, 0 to 1 (float32; NaN: no data).\n\n"
                "The surface is two triangles between each four samples; rays start on the samples themselves and need "
                "no lift. On a map in degrees, directions are off in proportion to the distance: by up to 0.03 degrees "
                "at 5 km and latitude 50.\n",
        .examples = "  cellwalk shadow dem.tif --sun 225,30 -o shadow.tif\n"
                    "  cellwalk shadow dem.tif --time 2024-12-21T13:00:00Z --sun-disc -o light.tif\n"
                    "  cellwalk shadow dem.tif --sun 315,45 --hillshade -o relief.png\n",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    return product_run(&(product_command){&c.ground, &c, check, make}, &usage, argc, argv);
}

const command command_shadow = {"shadow", "compute sunlight and shadow on each sample of a terrain", run};
