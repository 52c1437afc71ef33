/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk render`: a picture of a scene, or of a terrain. */

#include "clock.h"
#include "command.h"
#include "field_options.h"
#include "image.h"
#include "scene.h"
#include "terrain/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "render";

/* Limit on the sides of a picture: the memory for its pixels can then be addressed. */
enum { SIDE_MOST = 65536 };

typedef struct render_command {
    field_options fields;
    view view; /* of a terrain; size, smoothness and quiet also of a scene */
    const char *output, *size, *crop;
    unsigned samples;
    bool terrain;    /* not a scene */
    scene_crop part; /* from crop */
} render_command;

static void tell(void *context, double share) {
    (void)context;
    progress_show("rendering", share);
}

/* The output file is opened first, so that no work is done in vain. */
static int render(const render_command *c, double begun) {
    const scene_render_options options = {.query = c->fields.query,
                                          .threads = c->fields.threads,
                                          .samples = c->samples,
                                          .width = c->view.width,
                                          .height = c->view.height,
                                          .crop = c->part,
                                          .phong = c->view.smooth,
                                          .progress = c->view.quiet ? NULL : tell};
    io_output out;
    io_image image;
    io_error error;
    scene_render_stats stats;
    if (!io_output_open(&out, c->output, &error)) return command_fail(name, "%s", error.text);
    bool good = scene_render(c->view.scene, &options, &image, &stats, &error);
    progress_end();
    good = good && io_image_put(&out, &image, &error) && io_output_commit(&out, &error);
    io_output_discard(&out); /* nothing after the commit */
    /* Every visible point of the ground traces a shadow ray, of water a mirrored one. */
    if (good && c->terrain && !c->view.quiet && stats.shadow_rays + stats.mirror_rays == 0)
        command_warn(name, "nothing of the terrain is in the picture; --from and --to are places on its map");
    if (good)
        command_wrote(name, c->view.quiet, c->output, begun, "%zu x %zu pixels", (size_t)image.width,
                      (size_t)image.height);
    io_image_free(&image);
    return good ? EXIT_SUCCESS : command_fail(name, "%s", error.text);
}

static int render_file(render_command *c, const char *path) {
    io_error error;
    const double start = clock_seconds();
    const io_warner *w = &c->fields.watch.warn;
    if (!c->terrain) c->view.scene = scene_load(path, c->view.quiet ? NULL : w->call, w->context, &error);
    const bool good = c->terrain ? view_open(&c->view, &c->fields, path, &error) : c->view.scene != NULL;
    const int status = good ? render(c, start) : command_fail(name, "%s", error.text);
    view_close(&c->view);
    return status;
}

/* False, after a message, if a size or a crop is none: whole numbers with a separator between each two. */
static bool read_area(render_command *c) {
    const char *size = c->size ? c->size : "1x1", *crop = c->crop ? c->crop : "0,0,1,1";
    unsigned n[2], m[4];
    char rest;
    if (strspn(size, "0123456789x") != strlen(size) || sscanf(size, "%9ux%9u%c", &n[0], &n[1], &rest) != 2 ||
        n[0] == 0 || n[1] == 0 || n[0] > SIDE_MOST || n[1] > SIDE_MOST)
        return command_refuse(name, "--size %s: not a width and a height from 1 to %d, as in 800x600", size, SIDE_MOST);
    if (strspn(crop, "0123456789,") != strlen(crop) ||
        sscanf(crop, "%9u,%9u,%9u,%9u%c", &m[0], &m[1], &m[2], &m[3], &rest) != 4 || m[0] >= m[2] || m[1] >= m[3] ||
        m[2] > SIDE_MOST || m[3] > SIDE_MOST)
        return command_refuse(name, "--crop %s: not X0,Y0,X1,Y1 with X0 < X1 <= %d and Y0 < Y1 <= %d", crop, SIDE_MOST,
                              SIDE_MOST);
    if (c->size) c->view.width = n[0], c->view.height = n[1];
    if (c->crop) c->part = (scene_crop){m[0], m[1], m[2], m[3]};
    return true;
}

static int run(int argc, char **argv) {
    static render_command c = {.view = {.water = NAN}}; /* large */
    static const char *const of_terrain[] = {"from",   "to",       "sun",       "time", "sky",     "haze",
                                             "water",  "fov",      "curvature", "band", "coarser", "nodata",
                                             "zscale", "cellsize", "filter",    NULL};
    option_spec curvature = product_flat_earth_row(&c.view.curvature);
    curvature.help =
        "the earth's curvature as a factor: 0 for a flat earth (default), 1 without air, 0.857 with usual refraction; "
        "terrain is lowered around the eye that --from places, and shadows are those of the lowered terrain";
    const option_spec options[] = {
        option_output("IMAGE", &c.output, "the picture: .exr (half RGBA, linear) or .png (8 bit, sRGB)"),
        option_count("samples", "N", &c.samples, 1, 65536,
                     "samples a pixel (default: as in the scene; 4 for a terrain)"),
        option_text("size", "WxH", &c.size,
                    "width and height in pixels (default: as in the scene; 1200x800 for a terrain)"),
        option_text("crop", "X0,Y0,X1,Y1", &c.crop,
                    "only the part from pixel (X0, Y0) up to and without (X1, Y1), counted from the upper left corner"),
        option_flag("phong", &c.view.smooth, "smooth height fields by Phong normals"),
        option_flag("quiet", &c.view.quiet, "print neither progress nor warnings nor the line at the end"),
        option_text("from", "X,Y[,H]", &c.view.from,
                    "the eye's place on the map, H metres above ground (default: 2), or X,Y,=Z at an absolute height "
                    "in metres; without --from the eye is south of the terrain and sees all of it"),
        option_text("to", "X,Y[,H]", &c.view.to,
                    "the place in the middle of the picture, in the same form (default of H: 0, the ground; without "
                    "--to: the middle of the raster)"),
        option_text("sun", "AZ,ALT", &c.view.sun,
                    "the sun's azimuth, from the map's north over east, and altitude, in degrees (default: 315,40)"),
        option_text("time", "TIME", &c.view.time,
                    "date and time with a zone (2024-06-21T12:00:00Z, or +02:00 for Z), at which the sun stands over "
                    "the terrain's middle; the file must name a coordinate system"),
        option_range("fov", "DEGREES", &c.view.fov, DBL_MIN, 180 - 0x1p-45, "degrees above 0 and below 180",
                     "field of view over the shorter side, in degrees (default: 40)"),
        option_flag(
            "sky", &c.view.sky,
            "a sky that is brighter toward sun and horizon, and a plain at the terrain's lowest height below it"),
        option_range("haze", "V", &c.view.haze, DBL_MIN, DBL_MAX, "a visibility in metres, above 0",
                     "haze with a visibility of V metres: of contrast at a distance d the share 0.02^(d/V) is left "
                     "(Koschmieder)"),
        option_number(
            "water", "Z", &c.view.water,
            "level water at height Z in metres covers all ground that is lower, and holes; it mirrors sky and land"),
        curvature,
    };
    static const char *const operands[] = {"a scene or a raster"};
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM|SCENE.pbrt -o IMAGE [OPTIONS]",
        .what =
            "Draws a terrain from a place on its map, or renders a scene, and writes the picture. A terrain is drawn "
            "in sunlight and shadow, coloured by height. DEM is any raster that the other subcommands read.\n\n"
            "SCENE.pbrt is in the part of pbrt's scene language that height-field scenes need: shapes heightfield and "
            "cylinder, materials matte and mirror, image textures, point lights, a perspective camera. Anything else "
            "in the file is an error with its line, or a warning if it changes neither geometry nor light. The options "
            "--from, --to, --sun, --time, --fov, --sky, --haze, --water, --curvature and those on how to read a raster "
            "are for terrain only.\n\n" FIELD_TRADE "\n",
        .examples = "  cellwalk render dem.tif -o overview.png\n"
                    "  cellwalk render dem.tif --from 600250,5199800,30 --to 603000,5203000 \\\n"
                    "      --sun 225,30 --size 1600x900 --samples 16 -o view.png\n"
                    "  cellwalk render dem.tif --time 2024-06-21T12:00:00Z --sky --haze 40000 \\\n"
                    "      --water 310 -o lake.png\n"
                    "  cellwalk render landsea-0.pbrt -o landsea-0.png\n"
                    "  cellwalk render landsea-0.pbrt -o smooth.exr --phong --samples 64\n"
                    "  cellwalk render texture.pbrt -o part.png --size 1600x1600 --crop 0,0,400,400\n",
        OPTIONS_OF(options),
        .operands = operands,
        .operand_least = 1,
        .operand_most = 1,
    };
    const char *path = NULL;
    const int status = field_options_parse(&c.fields, &usage, FIELD_KERNELS, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    c.terrain = !io_name_ends(path, ".pbrt");
    if ((!c.terrain && !options_lack(name, of_terrain, "is for rasters, not for scenes")) || !read_area(&c))
        return EXIT_USAGE;
    io_error error;
    if (c.output == NULL) return command_fail(name, "no picture to write to: -o IMAGE is missing"), EXIT_USAGE;
    if (!io_image_can_write(c.output, &error)) return command_fail(name, "%s", error.text);
    return !c.terrain || view_check(&c.view) ? render_file(&c, path) : EXIT_USAGE;
}

const command command_render = {name, "draw a terrain from a place on it, or render a pbrt scene", run};
