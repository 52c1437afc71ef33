/* SPDX-License-Identifier: Apache-2.0 */
#include "raster_options.h"

#include "command.h"
#include "gdal_host.h"
#include "number.h"
#include "progress.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const char *filter_names(size_t number) {
    static const char *const names[] = {"mean", "highest", "lowest"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

void raster_options_rows(raster_options *r, option_spec rows[RASTER_OPTION_COUNT]) {
    *r = (raster_options){0};
    rows[0] =
        option_count("band", "N", &r->band, 1, 1 << 20, "number of the file's band to read, from 1 on (default: 1)");
    rows[1] =
        option_several("nodata", "V", &r->nodata,
                       "samples of value V are holes, beside those that the file marks; may be given up to 256 times");
    rows[2] = option_range("zscale", "S", &r->zscale, DBL_MIN, DBL_MAX, "a number above 0",
                           "one unit of height is S units of the map, or S metres on a map in degrees (0.3048: feet)");
    rows[3] = option_range("cellsize", "S", &r->cellsize, DBL_MIN, DBL_MAX, "a number above 0",
                           "samples are S metres apart, for files that do not say: the first row is the northernmost, "
                           "the last begins at 0, 0");
    rows[4] = option_flag("allow-network", &r->network, "let GDAL fetch what a file names on the network");
    rows[5] = option_count("coarser", "N", &r->coarser.factor, 2, CW_SIDE_MAX,
                           "a terrain of every N-th row and column; prints the largest and the root-mean-square "
                           "distance of its surface from the full one to standard error, in the map's unit of height");
    rows[6] = option_choice("filter", "NAME", &r->coarser.filter, filter_names,
                            "with --coarser: a height is the weighted mean of the samples around it (default), or such "
                            "that the surface is nowhere below (highest) or nowhere above (lowest) the full one");
}

static void warn(void *context, const char *text) { command_warn(((const raster_options *)context)->name, "%s", text); }
static void note(void *context, const char *text) { command_note(((const raster_options *)context)->name, "%s", text); }

static bool tell(void *context, const char *step, double share) {
    (void)context;
    if (step) progress_show(step, share);
    return true;
}

static bool tell_reading(void *context, double share) { return tell(context, "reading", share); }
static bool tell_building(void *context, double share) { return tell(context, "building", share); }

bool raster_options_resolve(raster_options *r, const char *name, io_raster_options *options) {
    for (size_t k = 0; k < r->nodata.count; k++) {
        char *end;
        r->nodata_values[k] = number_read(r->nodata.values[k], &end);
        if (end == r->nodata.values[k] || *end != '\0' || !isfinite(r->nodata_values[k]))
            return command_refuse(name, "--nodata takes a number, not '%s'", r->nodata.values[k]);
    }
    if (r->network) gdal_allow_network();
    r->name = name;
    r->watch = (ground_watch){tell, warn, note, r};
    *options = (io_raster_options){
        .band = r->band,
        .nodata = r->nodata_values,
        .nodata_count = r->nodata.count,
        .cellsize = r->cellsize,
        .zscale = r->zscale,
        .warn = warn,
        .progress = tell_reading,
        .context = r,
    };
    return true;
}

static bool open_pbrt(const raster_options *r, const char *path, const cw_run *query, raster_field *f,
                      io_error *error) {
    cw_run how = *query;
    how.watch = tell_building;
    for (int k = 0; k < 3; k++) f->map[k][k] = 1;
    f->field = scene_load_heightfield(path, &how, error);
    if (f->field == NULL) return false;
    f->kernel = cw_run_kernel(f->field, query);
    return r->coarser.factor == 0 || raster_field_coarsen(f, path, &r->coarser, query, &r->watch, error);
}

bool raster_options_open(const raster_options *r, const char *path, const io_raster_options *options,
                         const cw_run *query, raster_field *field, io_error *error) {
    const char *ending = strrchr(path, '.');
    if (ending == NULL || strcasecmp(ending, ".pbrt") != 0)
        return raster_field_open(field, path, options, &r->coarser, query, &r->watch, error);
    *field = (raster_field){0};
    const bool good = open_pbrt(r, path, query, field, error);
    if (!good) raster_field_close(field);
    return good;
}
