/* SPDX-License-Identifier: Apache-2.0 */
#include "field_file.h"

#include "cancel.h"
#include "progress.h"
#include "scene.h"

#include <string.h>
#include <strings.h>

/* Building is told on the terminal, and ends at Ctrl-C. */
static bool tell(void *context, double done) {
    progress_update(context, done);
    return !atomic_load(cancel_flag());
}

/* Holes that are infinite instead of NaN need a copy in which they are NaN. */
static cw_status create(field_file *file, const cw_run *how) {
    const io_raster *r = &file->raster;
    cw_field_desc desc = {0};
    desc.samples = r->z;
    desc.nx = r->nx;
    desc.ny = r->ny;
    desc.storage = CW_BORROW;
    memcpy(desc.map, r->map, sizeof desc.map);
    memcpy(file->map, r->map, sizeof file->map);
    cw_status status = cw_field_create(&desc, how, &file->field);
    if (status != CW_ERROR_SAMPLE) return status;
    desc.storage = CW_COPY;
    return cw_field_create(&desc, how, &file->field);
}

static bool build(field_file *file, const char *path, const cw_run *how, io_error *error) {
    *(progress *)how->watch_context = progress_start("building");
    const cw_status status = create(file, how);
    if (status == CW_OK) return true;
    if (status == CW_ERROR_CANCELLED) return io_fail(error, "interrupted");
    return io_fail(error, "%s: %zu x %zu samples: %s", path, file->raster.nx, file->raster.ny, cw_last_error());
}

static bool open_raster(field_file *file, const char *path, const io_raster_options *options, const cw_run *how,
                        io_error *error) {
    return io_raster_read(path, options, &file->raster, error) && build(file, path, how, error);
}

static bool open_pbrt(field_file *file, const char *path, const cw_run *how, io_error *error) {
    for (int k = 0; k < 3; k++) file->map[k][k] = 1;
    file->field = scene_load_heightfield(path, how, error);
    return file->field != NULL;
}

/* The full field is dropped as soon as the coarser one is there. */
static bool make_coarser(field_file *file, const char *path, const coarser_options *coarser, const cw_run *how,
                         io_error *error) {
    *(progress *)how->watch_context = progress_start("making it coarser");
    if (!coarser_make(coarser, path, how, how->watch_context, &file->field, &file->raster, error)) return false;
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 2; a++) file->map[k][a] *= (double)coarser->factor;
    return true;
}

bool field_file_open(field_file *file, const char *path, const io_raster_options *options,
                     const coarser_options *coarser, const cw_run *query, io_error *error) {
    *file = (field_file){0};
    const bool less = coarser && coarser->factor > 1;
    const char *ending = strrchr(path, '.');
    const bool pbrt = ending && strcasecmp(ending, ".pbrt") == 0;
    progress line = progress_start("building");
    cw_run how = *query;
    how.watch = tell;
    how.watch_context = &line;
    cw_run full = how; /* of which a coarser field needs the samples alone */
    if (less) full.expert.kernel = cw_kernel_find("cell");
    bool good = pbrt ? open_pbrt(file, path, &full, error) : open_raster(file, path, options, &full, error);
    if (good && less) good = make_coarser(file, path, coarser, &how, error);
    if (good) file->kernel = cw_run_kernel(file->field, query);
    progress_end(&line);
    if (!good) field_file_close(file);
    return good;
}

bool field_file_build(field_file *file, const char *path, const cw_run *query, io_error *error) {
    progress line = progress_start("building");
    cw_run how = *query;
    how.watch = tell;
    how.watch_context = &line;
    const bool good = build(file, path, &how, error);
    if (good) file->kernel = cw_run_kernel(file->field, query);
    progress_end(&line);
    return good;
}

void field_file_close(field_file *file) {
    cw_field_destroy(file->field);
    io_raster_free(&file->raster);
    *file = (field_file){0};
}
