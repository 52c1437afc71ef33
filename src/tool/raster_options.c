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
    rows[0] = (option_spec){.name = "band",
                            .value = "N",
                            .help = "number of the file's band to read, from 1 on (default: 1)",
                            .kind = OPTION_COUNT,
                            .to = &r->band,
                            .low = 1,
                            .high = 1 << 20};
    rows[1] = (option_spec){
        .name = "nodata",
        .value = "V",
        .help = "samples of value V are holes, beside those that the\nfile marks; may be given up to 256 times",
        .kind = OPTION_AGAIN,
        .to = &r->nodata};
    rows[2] =
        (option_spec){.name = "zscale",
                      .value = "S",
                      .help = "one unit of height is S units of the map, or S metres on\na map in degrees (0.3048: "
                              "feet)",
                      .kind = OPTION_NUMBER,
                      .to = &r->zscale};
    rows[3] = (option_spec){.name = "cellsize",
                            .value = "S",
                            .help = "samples are S metres apart, for files that do not say:\nthe first row is the "
                                    "northernmost, the last begins at\n0, 0",
                            .kind = OPTION_NUMBER,
                            .to = &r->cellsize};
    rows[4] = (option_spec){.name = "allow-network",
                            .help = "let GDAL fetch what a file names on the network",
                            .kind = OPTION_FLAG,
                            .to = &r->network};
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
