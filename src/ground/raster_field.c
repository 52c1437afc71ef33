/* SPDX-License-Identifier: Apache-2.0 */
#include "raster_field.h"

#include "cellwalk_terrain.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool tell_building(void *context, double share) {
    const ground_watch *w = context;
    return w->tell == NULL || w->tell(w->context, "building", share);
}

static cw_run watched(const cw_run *query, const ground_watch *watch) {
    cw_run how = *query;
    how.watch = tell_building;
    how.watch_context = (void *)watch;
    return how;
}

/* Holes that are infinite instead of NaN need a copy in which they are NaN. */
static cw_status create(raster_field *f, const cw_run *how) {
    const io_raster *r = &f->raster;
    cw_field_desc desc = {0};
    desc.samples = r->z;
    desc.nx = r->nx;
    desc.ny = r->ny;
    desc.storage = CW_BORROW;
    memcpy(desc.map, r->map, sizeof desc.map);
    cw_status status = cw_field_create(&desc, how, &f->field);
    if (status != CW_ERROR_SAMPLE) return status;
    desc.storage = CW_COPY;
    return cw_field_create(&desc, how, &f->field);
}

bool raster_field_build(raster_field *f, const char *path, const cw_run *query, const ground_watch *watch,
                        io_error *error) {
    const cw_run how = watched(query, watch);
    const cw_status status = create(f, &how);
    if (status == CW_ERROR_CANCELLED) return io_fail(error, "interrupted");
    if (status != CW_OK)
        return io_fail(error, "%s: %zu x %zu samples: %s", path, f->raster.nx, f->raster.ny, cw_last_error());
    return true;
}

/* The coarser field's samples and map, for readers of the raster. */
static bool replace(io_raster *r, const cw_field *coarser, unsigned factor, const char *path, io_error *error) {
    const cw_field_info info = cw_field_describe(coarser);
    io_raster smaller = {.nx = info.nx, .ny = info.ny};
    if (!io_raster_allocate(path, &smaller, error)) return false;
    float *z = smaller.memory;
    for (size_t j = 0; j < info.ny; j++) memcpy(z + j * info.nx, cw_field_row(coarser, j), info.nx * sizeof *z);
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 4; a++) smaller.map[k][a] = r->map[k][a] * (a < 2 ? (double)factor : 1);
    smaller.georef = r->georef;
    r->georef = (io_georef){0};
    io_raster_free(r);
    *r = smaller;
    return true;
}

static void note(const ground_watch *w, const char *path, const cw_field *full, const cw_field *coarser,
                 const cw_difference *d, double unit) {
    const cw_field_info f = cw_field_describe(full), g = cw_field_describe(coarser);
    char holes[160] = "", text[1024];
    if (d->lost + d->made > 0)
        snprintf(holes, sizeof holes, "; of its triangles %llu are lost to holes, and %llu come in place of holes",
                 (unsigned long long)d->lost, (unsigned long long)d->made);
    snprintf(text, sizeof text,
             "%s: %zu x %zu samples for %zu x %zu; the surface lies up to %.6g above and %.6g below the full one, "
             "%.6g in the root mean square%s",
             path, g.nx, g.ny, f.nx, f.ny, d->above * unit, d->below * unit, d->rms * unit, holes);
    w->note(w->context, text);
}

/* Replaces field, samples and map by coarser ones. */
static bool coarsen(raster_field *f, const char *path, const ground_coarser *c, const cw_run *query,
                    const ground_watch *watch, io_error *error) {
    const cw_run how = watched(query, watch);
    cw_field *coarser;
    cw_difference d;
    const cw_status status =
        cw_field_coarser(f->field, &how, c->factor, c->filter, &coarser, watch->note ? &d : NULL, sizeof d);
    if (status == CW_ERROR_CANCELLED) return io_fail(error, "interrupted");
    if (status != CW_OK) return io_fail(error, "%s: %s", path, cw_last_error());
    if (watch->note) note(watch, path, f->field, coarser, &d, fabs(f->raster.map[2][2]));
    cw_field_destroy(f->field);
    f->field = coarser;
    return replace(&f->raster, coarser, c->factor, path, error);
}

bool raster_field_open(raster_field *f, const char *path, const io_raster_options *options,
                       const ground_coarser *coarser, const cw_run *query, const ground_watch *watch, io_error *error) {
    *f = (raster_field){0};
    if (io_raster_read(path, options, &f->raster, error) && raster_field_build(f, path, query, watch, error) &&
        (coarser->factor == 0 || coarsen(f, path, coarser, query, watch, error)))
        return true;
    raster_field_close(f);
    return false;
}

void raster_field_close(raster_field *f) {
    cw_field_destroy(f->field);
    io_raster_free(&f->raster);
    *f = (raster_field){0};
}
