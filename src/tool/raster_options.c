/* SPDX-License-Identifier: Apache-2.0 */
#include "raster_options.h"

#include "cancel.h"
#include "command.h"
#include "gdal_host.h"
#include "number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

void raster_options_rows(raster_options *r, option_spec rows[RASTER_OPTION_COUNT]) {
    *r = (raster_options){.cellsize = NAN, .zscale = NAN};
    coarser_rows(&r->coarser, rows + 5);
    rows[0] =
        option_count("band", "N", &r->band, 1, 1 << 20, "number of the file's band to read, from 1 on (default: 1)");
    rows[1] =
        option_several("nodata", "V", &r->nodata,
                       "samples of value V are holes, beside those that the file marks; may be given up to 256 times");
    rows[2] = option_number("zscale", "S", &r->zscale,
                            "one unit of height is S units of the map, or S metres on a map in degrees (0.3048: feet)");
    rows[3] = option_number("cellsize", "S", &r->cellsize,
                            "samples are S metres apart, for files that do not say: the first row is the northernmost, "
                            "the last begins at 0, 0");
    rows[4] = option_flag("allow-network", &r->network, "let GDAL fetch what a file names on the network");
}

static void warn(void *context, const char *text) {
    raster_options *r = context;
    progress_end(&r->line);
    command_warn(r->name, "%s", text);
}

static bool tell(void *context, double share) {
    raster_options *r = context;
    if (atomic_load(cancel_flag())) {
        progress_end(&r->line);
        return false;
    }
    progress_update(&r->line, share);
    return true;
}

bool raster_options_resolve(raster_options *r, const char *name, io_raster_options *options) {
    const struct {
        const char *name;
        double value;
    } positive[] = {{"zscale", r->zscale}, {"cellsize", r->cellsize}};
    for (size_t k = 0; k < sizeof positive / sizeof positive[0]; k++)
        if (positive[k].value <= 0) {
            command_fail(name, "--%s takes a number above 0, not %g", positive[k].name, positive[k].value);
            return false;
        }
    for (size_t k = 0; k < r->nodata.count; k++) {
        char *end;
        r->nodata_values[k] = number_read(r->nodata.values[k], &end);
        if (end != r->nodata.values[k] && *end == '\0' && isfinite(r->nodata_values[k])) continue;
        command_fail(name, "--nodata takes a number, not '%s'", r->nodata.values[k]);
        return false;
    }
    if (r->network) gdal_allow_network();
    r->name = r->coarser.name = name;
    r->line = progress_start("reading");
    *options = (io_raster_options){
        .band = r->band,
        .nodata = r->nodata_values,
        .nodata_count = r->nodata.count,
        .cellsize = isnan(r->cellsize) ? 0 : r->cellsize,
        .zscale = isnan(r->zscale) ? 0 : r->zscale,
        .warn = warn,
        .progress = tell,
        .context = r,
    };
    return true;
}
