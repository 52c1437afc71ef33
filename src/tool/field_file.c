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
static cw_status create(field_file *file, bool bare, const cw_query *how) {
    const io_raster *r = &file->raster;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = r->z;
    desc.nx = r->nx;
    desc.ny = r->ny;
    desc.bare = bare;
    desc.storage = CW_BORROW;
    desc.pool = how->pool;
    desc.watch = how->watch;
    desc.watch_context = how->watch_context;
    memcpy(desc.map, r->map, sizeof desc.map);
    memcpy(file->map, r->map, sizeof file->map);
    cw_status status = cw_field_create(&desc, &file->field);
    file->mapped = status == CW_OK && r->mapped_bytes > 0;
    if (status != CW_ERROR_HOLE) return status;
    desc.storage = CW_COPY;
    return cw_field_create(&desc, &file->field);
}

static bool open_raster(field_file *file, const char *path, const io_raster_options *options, bool bare,
                        const cw_query *how, io_error *error) {
    if (!io_raster_read(path, options, &file->raster, error)) return false;
    *(progress *)how->watch_context = progress_start("building");
    const cw_status status = create(file, bare, how);
    if (status == CW_OK) return true;
    if (status == CW_ERROR_CANCELLED) return io_fail(error, "interrupted");
    return io_fail(error, "%s: %zu x %zu samples: %s", path, file->raster.nx, file->raster.ny,
                   cw_status_message(status));
}

static bool open_pbrt(field_file *file, const char *path, bool bare, io_error *error) {
    for (int k = 0; k < 3; k++) file->map[k][k] = 1;
    file->field = scene_load_heightfield(path, bare, error);
    return file->field != NULL;
}

bool field_file_open(field_file *file, const char *path, const io_raster_options *options, const cw_query *query,
                     io_error *error) {
    *file = (field_file){0};
    const bool bare = query->kernel != NULL; /* a kernel that was named says itself what it needs */
    const char *ending = strrchr(path, '.');
    const bool pbrt = ending && strcasecmp(ending, ".pbrt") == 0;
    progress line = progress_start("building");
    cw_query how = *query;
    how.watch = tell;
    how.watch_context = &line;
    bool good = pbrt ? open_pbrt(file, path, bare, error) : open_raster(file, path, options, bare, &how, error);
    if (good) {
        file->kernel = cw_query_kernel(file->field, query);
        const cw_status status = cw_field_build_for(file->field, &how);
        good = status == CW_OK ||
               (status == CW_ERROR_CANCELLED ? io_fail(error, "interrupted")
                                             : io_fail(error, "%s: %s", path, cw_status_message(status)));
    }
    progress_end(&line);
    if (!good) field_file_close(file);
    return good;
}

void field_file_close(field_file *file) {
    cw_field_destroy(file->field);
    io_raster_free(&file->raster);
    *file = (field_file){0};
}
