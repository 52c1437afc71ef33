/* SPDX-License-Identifier: Apache-2.0 */
#include "coarser.h"

#include "cellwalk_terrain.h"
#include "command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char *filter_names(size_t number) {
    static const char *const names[] = {"mean", "highest", "lowest"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

void coarser_rows(coarser_options *c, option_spec rows[COARSER_OPTION_COUNT]) {
    *c = (coarser_options){0};
    rows[0] = option_count("coarser", "N", &c->factor, 2, CW_SIDE_MAX,
                           "a terrain of every N-th row and column; prints the largest and the root-mean-square "
                           "distance of its surface from the full one to standard error, in the map's unit of height");
    rows[1] = option_choice("filter", "NAME", &c->filter, filter_names,
                            "with --coarser: a height is the weighted mean of the samples around it (default), or such "
                            "that the surface is nowhere below (highest) or nowhere above (lowest) the full one");
}

/* The coarser field's samples and map, for readers of the raster. */
static bool replace(io_raster *r, const cw_field *coarser, unsigned factor, const char *path, io_error *error) {
    const cw_field_info info = cw_field_describe(coarser);
    io_raster smaller;
    if (!io_raster_allocate(path, info.nx, info.ny, &smaller, error)) return false;
    for (size_t j = 0; j < info.ny; j++)
        for (size_t i = 0; i < info.nx; i++) smaller.memory[j * info.nx + i] = cw_field_row(coarser, j)[i];
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 4; a++) smaller.map[k][a] = r->map[k][a] * (a < 2 ? (double)factor : 1);
    smaller.georef = r->georef;
    r->georef = (io_georef){0};
    io_raster_free(r);
    *r = smaller;
    return true;
}

static void print(const coarser_options *c, const char *path, const cw_field *full, const cw_field *coarser,
                  const cw_difference *d, double unit) {
    const cw_field_info f = cw_field_describe(full), g = cw_field_describe(coarser);
    char holes[160] = "";
    if (d->lost + d->made > 0)
        snprintf(holes, sizeof holes, "; of its triangles %llu are lost to holes, and %llu come in place of holes",
                 (unsigned long long)d->lost, (unsigned long long)d->made);
    command_note(c->name,
                 "%s: %zu x %zu samples for %zu x %zu; the surface lies up to %.6g above and %.6g below the full one, "
                 "%.6g in the root mean square%s",
                 path, g.nx, g.ny, f.nx, f.ny, d->above * unit, d->below * unit, d->rms * unit, holes);
}

bool coarser_make(const coarser_options *c, const char *path, const cw_run *query, progress *line, cw_field **field,
                  io_raster *raster, io_error *error) {
    cw_field *coarser;
    cw_difference d;
    const cw_status status = cw_field_coarser(*field, query, c->factor, c->filter, &coarser, &d, sizeof d);
    progress_end(line);
    if (status == CW_ERROR_CANCELLED) return io_fail(error, "interrupted");
    if (status != CW_OK) return io_fail(error, "%s: %s", path, cw_last_error());
    const double unit = raster->z ? fabs(raster->map[2][2]) : 1;
    if (c->name) print(c, path, *field, coarser, &d, unit);
    cw_field_destroy(*field);
    *field = coarser;
    return raster->z == NULL || replace(raster, coarser, c->factor, path, error);
}
