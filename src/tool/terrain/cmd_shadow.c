/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk shadow`: sun and shadow on every sample of a terrain. */

#include "command.h"
#include "product.h"
#include "suns.h"

#include <math.h>

static const char name[] = "shadow";

typedef struct shadow_command {
    product product;
    const char *sun, *time; /* one of them is NULL */
    double seconds;         /* of time, as cw_sun_at takes it */
    double disc;            /* 0: the sun is a point */
    bool usual_disc, hillshade;
    cw_light light;
    bool share; /* floats */
} shadow_command;

static bool fill(product *p, const product_block *b, void *cells, io_error *error) {
    const shadow_command *c = p->context;
    const terrain *t = &p->ground.terrain;
    return product_good(c->share ? cw_sunlight(t, &b->run, &c->light, b->area, cells)
                                 : cw_shadow(t, &b->run, &c->light, b->area, cells),
                        error);
}

static bool find_sun(shadow_command *c, io_error *error) {
    const ground *g = &c->product.ground;
    sun_place place;
    if (c->sun) return true;
    if (!sun_place_of(&g->whole, &g->about.georef, NULL, g->path, "give --sun", &place, error)) return false;
    const sun_position at = cw_sun_at_place(c->seconds, &place);
    c->light.azimuth = at.azimuth;
    c->light.altitude = at.altitude;
    if (c->usual_disc) c->light.radius = at.radius;
    progress_end();
    fputs("sun at ", stdout);
    print_text(stdout, c->time);
    printf(" over %.4f, %.4f: azimuth %.3f (%.3f on the map), altitude %.3f degrees\n", place.longitude, place.latitude,
           fmod(at.azimuth - place.turned + 360, 360), at.azimuth, at.altitude);
    return true;
}

static bool begin(product *p, io_error *error) {
    shadow_command *c = p->context;
    cw_light *sun = &c->light;
    sun->hillshade = c->hillshade;
    sun->radius = c->usual_disc ? SUN_RADIUS : 0;
    if (!find_sun(c, error)) return false;
    if (c->disc > 0) sun->radius = c->disc;
    if (sun->altitude <= 0) command_warn(name, "the sun is at %.3f degrees, not above the horizon", sun->altitude);
    c->share = sun->radius > 0 || sun->hillshade;
    product_describe(p, c->share ? IO_CELL_FLOAT32 : IO_CELL_UINT8, 1,
                     !c->share         ? "1 where the sun is seen, 0 in the shadow"
                     : !sun->hillshade ? "share of the sun's disc that is seen"
                     : sun->radius > 0
                         ? "light on the ground: that cosine times the share of the sun's disc that is seen"
                         : "light on the ground: cosine of the angle between sun and normal, 0 in the shadow");
    product_note(p, "SUN_AZIMUTH=%.9g", sun->azimuth);
    product_note(p, "SUN_ALTITUDE=%.9g", sun->altitude);
    product_note(p, "SUN_DISC_RADIUS=%.9g", sun->radius);
    if (c->time) product_note(p, "TIME=%s", c->time);
    product_note(p, "ANGLES=degrees; azimuth from the map's north over east");
    product_note(p, "CURVATURE=%.9g", sun->curvature);
    p->matters = (ground_matters){.suns = sun, .sun_count = 1};
    p->passes = sun->radius > 0 ? 16 : 1;
    p->counted = "in the sun";
    return true;
}

static bool check(void *context, size_t *bands) {
    shadow_command *c = context;
    double sun[2] = {0, 0};
    (void)bands;
    if (c->usual_disc && c->disc > 0) return command_refuse(name, "either --sun-disc or --disc");
    if (!product_parse_sun(name, c->sun, c->time, sun, &c->seconds)) return false;
    c->light.azimuth = sun[0];
    c->light.altitude = sun[1];
    return true;
}

static int run(int argc, char **argv) {
    static shadow_command c; /* large */
    c.product = (product){.context = &c, .check = check, .begin = begin, .fill = fill};
    const option_spec options[] = {
        option_text("sun", "AZ,ALT", &c.sun, "azimuth from the map's north over east, and altitude, in degrees"),
        option_text("time", "TIME", &c.time,
                    "date and time with a zone (2024-06-21T12:00:00Z, or +02:00 for Z), at which the sun stands over "
                    "the terrain's middle, to 0.01 degrees from 1950 to 2050; the file needs a coordinate system"),
        option_flag(
            "hillshade", &c.hillshade,
            "light on the ground: the cosine of the angle between the sun and the ground's normal, 0 in shadow"),
        option_flag("sun-disc", &c.usual_disc,
                    "write the share of the sun's disc that is seen, so that shadows have soft edges"),
        option_range("disc", "R", &c.disc, DBL_MIN, 10, "degrees above 0, up to 10",
                     "the same for a disc of radius R, in degrees"),
        product_flat_earth_row(&c.light.curvature),
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
                    "  cellwalk shadow dem.tif --sun 225,12 -o shadow.png\n"
                    "  cellwalk shadow dem.tif --sun 315,45 --hillshade -o relief.tif\n",
        OPTIONS_OF(options),
    };
    return product_run(&c.product, &usage, argc, argv);
}

const command command_shadow = {"shadow", "compute sunlight and shadow on each sample of a terrain", run};
