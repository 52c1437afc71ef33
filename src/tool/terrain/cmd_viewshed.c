/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk viewshed`: the samples seen from one place or many. */

#include "command.h"
#include "viewshed_make.h"

#include <math.h>

static const char name[] = "viewshed";

static const double eye_height = 2;

static bool check_observers(viewshed_command *c) {
    observers_from *o = &c->from;
    const size_t count = o->place_count = c->from_texts.count;
    if ((count > 0) == (o->file != NULL))
        return command_refuse(name, count > 0 ? "--from and --observers do not go together"
                                              : "--from X,Y is missing, or --observers FILE: the place of an observer");
    if (o->layer && !o->file) return command_refuse(name, "--layer goes with --observers");
    if (o->every > 0 && count == 1)
        return command_refuse(name, "--every D takes two places or more: the corners of a line");
    o->places = c->places;
    o->height = eye_height;
    o->lines = true;
    for (size_t k = 0; k < count; k++)
        if (!product_parse_place(name, c->from_texts.values[k], eye_height, &c->places[k])) return false;
    return true;
}

static bool check_limits(viewshed_command *c) {
    cw_observer *l = &c->look;
    double *a = l->azimuths, *v = l->verticals;
    l->limits = (c->azimuth ? 1u * CW_OBSERVER_AZIMUTHS : 0) + (c->vertical ? 1u * CW_OBSERVER_VERTICALS : 0);
    if (l->farthest > 0 && l->nearest > l->farthest)
        return command_refuse(name, "--min-distance %g is more than --max-distance %g", l->nearest, l->farthest);
    if (c->azimuth && !(ground_numbers(c->azimuth, a, 2, 2) > 0 && fabs(a[0]) <= 360 && fabs(a[1]) <= 360))
        return command_refuse(name, "--azimuth takes two angles from -360 to 360 degrees, as 350,10, not '%s'",
                              c->azimuth);
    if (c->azimuth && a[0] == a[1])
        command_warn(name, "--azimuth %s is a single direction, in which few samples lie; 0,360 is all round",
                     c->azimuth);
    if (c->vertical && !(ground_numbers(c->vertical, v, 2, 2) > 0 && v[0] >= -90 && v[0] <= v[1] && v[1] <= 90))
        return command_refuse(name, "--vertical takes two angles from -90 to 90 degrees, the lower one first, not '%s'",
                              c->vertical);
    return true;
}

static bool check(void *context, size_t *bands) {
    viewshed_command *c = context;
    (void)bands; /* known when the observers are read */
    if (!check_observers(c) || !check_limits(c)) return false;
    c->kind = c->needed ? VIEW_NEEDED : c->angle ? VIEW_ANGLE : c->weights ? VIEW_WEIGHT : VIEW_SEEN;
    if (c->needed + c->angle + c->weights > 1)
        return command_refuse(name, "of --weights, --angle and --needed one can be written");
    if (c->weights && !c->from.file)
        return command_refuse(name, "--weights goes with --observers FILE, whose weights it adds up");
    if (c->weights && c->bands)
        return command_refuse(name, "--weights adds up observers, and --bands keeps them apart");
    if (c->needed && c->vertical)
        return command_refuse(name,
                              "--vertical is about targets of a given height, and --needed looks for that height");
    if (c->needed && options_given("target-height"))
        return command_refuse(name, "--target-height goes without --needed, which looks for that height");
    if (c->from.place_count > 1 && c->from.every == 0 && !c->bands && (c->needed || c->angle))
        return command_refuse(name, "%s is that of one observer, not of %zu; --bands writes a band for each",
                              c->needed ? "the height that is needed to be seen" : "the angle", c->from.place_count);
    if (c->table && (c->kind != VIEW_SEEN || c->bands))
        return command_refuse(
            name, "--table lists what is seen; it cannot be used with --angle, --bands, --needed or --weights");
    if (c->within && !c->table) return command_refuse(name, "--within goes with --table");
    return true;
}

static int run(int argc, char **argv) {
    static viewshed_command c; /* large */
    c.product = (product){.context = &c,
                          .check = check,
                          .begin = viewshed_begin,
                          .fill = viewshed_fill,
                          .finish = viewshed_finish,
                          .end = viewshed_end};
    const option_spec options[] = {
        option_several("from", "X,Y[,H]", &c.from_texts,
                       "the observer's place on the map, with the eye H metres above ground (default: 2), or X,Y,=Z; "
                       "may be given up to 256 times"),
        option_text(
            "observers", "FILE", &c.from.file,
            "any number of observers: a table (.csv) whose first line names the columns x, y and, if there, height, "
            "weight and name; or points of any file that GDAL reads, with such attributes, brought to the terrain's "
            "map"),
        option_text("layer", "NAME", &c.from.layer, "the layer of --observers, for files with several"),
        option_metres("every", &c.from.every,
                      "the places are the corners of a line, and so are those of each line in a file: an observer "
                      "stands at its beginning and every D metres; heights and weights change evenly between corners"),
        option_range("target-height", "T", &c.look.target, 0, DBL_MAX, "metres from 0 on",
                     "height of the target above ground, in metres (default: 0, the ground)"),
        option_metres("max-distance", &c.look.farthest,
                      "samples farther away than D metres are not seen, nor read and written (default: no limit)"),
        option_range("min-distance", "D", &c.look.nearest, 0, DBL_MAX, "metres from 0 on",
                     "samples nearer than D metres are not seen, but block the view (default: 0)"),
        option_text("azimuth", "A,B", &c.azimuth,
                    "only samples in directions from azimuth A clockwise to B, in degrees from the map's north: 350,10 "
                    "are 20 degrees"),
        option_text("vertical", "LO,HI", &c.vertical,
                    "only targets at angles from LO to HI degrees above the eye's horizontal, from -90 to 90; below it "
                    "they are negative"),
        product_round_earth_row(&c.look.curvature),
        option_flag("weights", &c.weights,
                    "write the sum of the weights of the observers that see the sample (float32; NaN: no data)"),
        option_flag("angle", &c.angle,
                    "write the angle of the target above the eye's horizontal, in degrees (float32; NaN: not seen)"),
        option_flag("needed", &c.needed,
                    "write the height above ground, in metres, from which on nothing rises above the line to a "
                    "target (float32; NaN: no data or too far)"),
        option_flag("bands", &c.bands,
                    "write a band for each observer instead of counts; also with --angle and --needed"),
        option_text(
            "table", "FILE", &c.table,
            "also write a table (CSV) with a line for each observer: how many samples it sees, the area of their cells "
            "on the ground in square kilometres, the farthest one, and the name if the file has names. Samples stand "
            "out, so more of them are in sight than of the ground: see 'cellwalk visibility'"),
        option_text("within", "FILE", &c.within,
                    "in the table, count only samples inside the polygons of a file that GDAL reads, brought to the "
                    "terrain's map"),
        option_flag("skip-outside", &c.skip,
                    "leave out observers outside the raster, on no data or under the ground: they are listed and "
                    "counted (default: the first one ends the run)"),
    };
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
            "Which site sees most? For a few sites --table says it, with --within of the ground that matters. For "
            "every site at once look from the other end: the samples of the valley as --observers, of height 0, and "
            "--target-height 10 count at each sample how much of the valley a mast of 10 m sees from there.\n\n"
            "The surface is two triangles between each four samples, lowered by the earth's curvature. Each line is "
            "decided exactly: an edge that it touches blocks it. Holes hide nothing.\n\n" PRODUCT_PLACE_HELP "\n",
        .examples = "  cellwalk viewshed dem.tif --from 600250,5199800 -o seen.png\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,30 --target-height 1.5 \\\n"
                    "      --max-distance 20000 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800 --needed -o needed.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800,=1250 -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --from 600250,5199800 --azimuth 350,80 --angle \\\n"
                    "      -o angle.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --weights -o served.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --table seen.csv -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --table seen.csv \\\n"
                    "      --within towns.gpkg -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --observers towers.csv --skip-outside -o seen.tif\n"
                    "  cellwalk viewshed dem.tif --observers road.gpkg --every 50 -o seen.tif\n",
        OPTIONS_OF(options),
    };
    return product_run(&c.product, &usage, argc, argv);
}

const command command_viewshed = {"viewshed", "compute which samples are seen from one place or many", run};
