/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk viewshed`: the samples seen from one place or many. */

#include "command.h"
#include "product.h"
#include "viewshed_make.h"

#include <math.h>
#include <stdlib.h>

static const char name[] = "viewshed";

typedef struct viewshed_command {
    ground_options ground;
    viewshed_request request;
    int extent;
    bool weights, angle, needed;
} viewshed_command;

enum { EXTENT_NEAR, EXTENT_FULL };

static const char *extent_names(size_t number) {
    static const char *const names[] = {"near", "full"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

static bool check(void *context, size_t *bands) {
    viewshed_command *c = context;
    (void)bands; /* known when the observers are read */
    viewshed_request *r = &c->request;
    const bool needed = c->needed || r->absolute;
    if (!observer_options_check(&r->observers, name) || !target_options_read(&r->target, name)) return false;
    r->kind = needed ? VIEW_NEEDED : c->angle ? VIEW_ANGLE : c->weights ? VIEW_WEIGHT : VIEW_SEEN;
    r->full = c->extent == EXTENT_FULL;
    if (needed + c->angle + c->weights > 1)
        command_fail(name, "of --weights, --angle and --needed one can be written");
    else if (c->weights && !r->observers.file)
        command_fail(name, "--weights goes with --observers FILE, whose weights it adds up");
    else if (c->weights && r->bands)
        command_fail(name, "--weights adds up observers, and --bands keeps them apart");
    else if (needed && r->target.vertical)
        command_fail(name, "--vertical is about targets of a given height, and --needed looks for that height");
    else if (r->observers.from.count > 1 && r->observers.every == 0 && !r->bands && (needed || c->angle))
        command_fail(name, "%s is that of one observer, not of %zu; --bands writes a band for each",
                     needed ? "the height that is needed to be seen" : "the angle", r->observers.from.count);
    else if (r->table && (r->kind != VIEW_SEEN || r->bands))
        command_fail(name,
                     "--table is about what is seen, and goes with none of --angle, --bands, --needed and --weights");
    else if (r->curvature < 0)
        command_fail(name, "--curvature takes a number from 0 on, not %g", r->curvature);
    else
        return true;
    return false;
}

static bool make(void *context, ground *g, io_error *error) {
    const viewshed_command *c = context;
    return viewshed_make(g, &c->request, error);
}

static int run(int argc, char **argv) {
    static viewshed_command c; /* large */
    viewshed_request *r = &c.request;
    r->curvature = NAN;
    enum { PLACES = OBSERVER_OPTION_COUNT + TARGET_OPTION_COUNT };
    option_spec options[] = {
        [PLACES] = option_number("curvature", "K", &r->curvature,
                                 "the earth's curvature as a factor: 0 for a flat earth, 1 without air, 0.857 = 6/7 "
                                 "with usual refraction (default: 6/7, or 0 if the file has no map)"),
        option_flag("weights", &c.weights,
                    "write the sum of the weights of the observers that see the sample (float32; NaN: no data)"),
        option_flag("angle", &c.angle,
                    "write the angle of the target above the eye's horizontal, in degrees (float32; NaN: not seen)"),
        option_flag("needed", &c.needed,
                    "write the height above ground, in metres, from which on a target is seen; 0 where the ground "
                    "itself is (float32; NaN: no data or too far)"),
        option_flag("needed-absolute", &r->absolute, "the same as an absolute height in metres"),
        option_flag("bands", &r->bands,
                    "write a band for each observer instead of counts; also with --angle and --needed"),
        option_text("table", "FILE", &r->table,
                    "also write a table (CSV) with a line for each observer: how many samples it sees, these times a "
                    "cell's area in square kilometres, and the farthest one"),
        option_choice("extent", "NAME", &c.extent, extent_names,
                      "with --max-distance: write only samples within it (near, the default), or the full raster"),
    };
    observer_rows(&r->observers, options);
    target_rows(&r->target, options + OBSERVER_OPTION_COUNT);
    const options_usage usage = {
        .name = name,
        .synopsis = "DEM (--from X,Y | --observers FILE) -o FILE [OPTIONS]",
        .what =
            "Computes which samples of a terrain are seen from a place and writes a raster: 1 where the straight line "
            "from the eye to the sample, or to a target on it, passes above the surface, 0 elsewhere (uint8; 255: no "
            "data). With several observers it writes how many of them see the sample (uint16 from 255 observers on; "
            "65535: no data; float32 from 65535 on; NaN: no data).\n\n"
            "Who looks: --from, --observers and --every. At which targets: --target-height, --min-distance, "
            "--max-distance, --azimuth and --vertical, each with its ends; a target outside these limits counts as not "
            "seen. What is written instead of counts: --weights, --angle or --needed, and with --bands a band for each "
            "observer.\n\n"
            "The surface is two triangles between each four samples, lowered by the earth's curvature; every sample's "
            "line is decided exactly, and one that touches the surface is blocked.\n\n" GROUND_PLACE_HELP "\n",
        .examples = "  cellwalk viewshed dem.tif --from 600250,5199800 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,30 --target-height 1.5 \\\n"
                    "      --max-distance 20000 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800 --needed -o needed.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,=1250 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800 --azimuth 350,80 --angle \\\n"
                    "      -o angle.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --weights -o served.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --table seen.csv -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --observers road.gpkg --every 50 -o seen.tif\n",
        .options = options,
        .option_count = sizeof options / sizeof *options,
    };
    return product_run(&(product_command){&c.ground, &c, check, make}, &usage, argc, argv);
}

const command command_viewshed = {"viewshed", "compute which samples are seen from one place or many", run};
