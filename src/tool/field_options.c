/* SPDX-License-Identifier: Apache-2.0 */
#include "field_options.h"

#include "command.h"
#include "gdal_host.h"
#include "number.h"
#include "output.h"

#include <math.h>
#include <string.h>

static const char *filter_names(size_t number) {
    static const char *const names[] = {"mean", "highest", "lowest"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

enum { RASTER = 7, ROWS = RASTER + FIELD_LEAVES };

/* Of queries the last ones. Sets *f to nothing given. */
static size_t add_rows(field_options *f, field_queries queries, option_spec *to) {
    *f = (field_options){.kernel = -1, .leaf = -1, .isa = -1};
    const option_spec rows[ROWS] = {
        option_count("band", "N", &f->band, 1, 1 << 20, "number of the file's band to read, from 1 on (default: 1)"),
        option_several("nodata", "V", &f->nodata,
                       "samples of value V are holes, beside those that the file marks; may be given up to 256 times"),
        option_range("zscale", "S", &f->zscale, DBL_MIN, DBL_MAX, "a number above 0",
                     "one unit of height is S units of the map, or S metres on a map in degrees (0.3048: feet)"),
        option_range("cellsize", "S", &f->cellsize, DBL_MIN, DBL_MAX, "a number above 0",
                     "samples are S metres apart, for files that do not say: the first row is the northernmost, the "
                     "last begins at 0, 0"),
        option_flag("allow-network", &f->network, "let GDAL fetch what a file names on the network"),
        option_count("coarser", "N", &f->coarser.factor, 2, CW_SIDE_MAX,
                     "a terrain of every N-th row and column; prints the largest and the root-mean-square distance of "
                     "its surface from the full one to standard error, in the map's unit of height"),
        option_choice("filter", "NAME", &f->coarser.filter, filter_names,
                      "with --coarser: a height is the weighted mean of the samples around it (default), or such that "
                      "the surface is nowhere below (highest) or nowhere above (lowest) the full one"),
        option_choice("leaf", "NAME", &f->leaf, option_leaf_names,
                      "the test of a ray against a cell (default: as `cellwalk info` shows)"),
        option_choice("kernel", "NAME", &f->kernel, option_kernel_names,
                      "the kernel that finds hits; `cellwalk info` explains them (default: the best for this CPU)"),
        option_choice("isa", "NAME", &f->isa, option_isa_names,
                      "the highest instruction set to use, up to that of the variable CELLWALK_ISA"),
        option_count("threads", "N", &f->threads, 0, 4096, "number of threads; 0: one for each CPU (default)"),
    };
    memcpy(to, rows, RASTER * sizeof *rows);
    memcpy(to + RASTER, rows + ROWS - queries, queries * sizeof *rows);
    return RASTER + (size_t)queries;
}

static void warn(void *context, const char *text) { command_warn(((const field_options *)context)->name, "%s", text); }
static void note(void *context, const char *text) { command_note(((const field_options *)context)->name, "%s", text); }

static bool tell(void *context, const char *step, double share) {
    (void)context;
    if (step) progress_show(step, share);
    return true;
}

static bool tell_reading(void *context, double share) { return tell(context, "reading", share); }

static bool resolve_query(field_options *f) {
    cw_run *query = &f->query;
    if (!option_isa_environment(f->name) || (f->isa >= 0 && !option_isa_limit(f->name, CW_ISA_SCALAR + (cw_isa)f->isa)))
        return false;
    if (f->kernel >= 0) query->expert.kernel = cw_kernel_at((size_t)f->kernel);
    if (f->leaf >= 0) query->expert.leaf = (cw_leaf)f->leaf;
    const cw_kernel_info info = cw_kernel_describe(query->expert.kernel);
    if (f->kernel >= 0 && !info.available)
        return command_refuse(f->name,
                              "--kernel %s needs %s; this machine, or the limit set by --isa or CELLWALK_ISA, has %s",
                              info.name, cw_isa_name(info.isa), cw_isa_name(cw_isa_best()));
    return cw_run_check(NULL, query) == CW_OK || command_refuse(f->name, "--%s", cw_last_error()); /* "leaf: …" */
}

static bool resolve_reading(field_options *f) {
    for (size_t k = 0; k < f->nodata.count; k++) {
        char *end;
        f->nodata_values[k] = number_read(f->nodata.values[k], &end);
        if (end == f->nodata.values[k] || *end != '\0' || !isfinite(f->nodata_values[k]))
            return command_refuse(f->name, "--nodata takes a number, not '%s'", f->nodata.values[k]);
    }
    if (options_given("filter") && f->coarser.factor == 0)
        return command_refuse(f->name, "--filter goes with --coarser N");
    if (f->network) gdal_allow_network();
    f->watch = (ground_watch){tell, {warn, f}, note, f};
    f->reading = (io_raster_options){
        .band = f->band,
        .nodata = f->nodata_values,
        .nodata_count = f->nodata.count,
        .cellsize = f->cellsize,
        .zscale = f->zscale,
        .warn = f->watch.warn,
        .progress = tell_reading,
        .context = f,
    };
    return true;
}

int field_options_parse(field_options *f, const options_usage *usage, field_queries queries, int argc, char **argv,
                        const char **operands) {
    option_spec rows[FIELD_OWN_MOST + ROWS];
    options_usage all = *usage;
    memcpy(rows, usage->options, usage->option_count * sizeof *rows);
    all.options = rows;
    all.option_count += add_rows(f, queries, rows + usage->option_count);
    f->name = usage->name;
    const int status = options_parse(&all, argc, argv, operands);
    if (status == OPTIONS_GO && operands[0] && io_name_ends(operands[0], ".pbrt") && !strstr(usage->synopsis, ".pbrt"))
        return command_fail(f->name, "%s: is a scene, which cellwalk render draws, and no raster", operands[0]);
    return status != OPTIONS_GO || (resolve_query(f) && resolve_reading(f)) ? status : EXIT_USAGE;
}
