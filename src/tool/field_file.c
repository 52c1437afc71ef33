/* SPDX-License-Identifier: Apache-2.0 */
#include "field_file.h"

#include <string.h>

static cw_status create(field_file *file, bool bare) {
    const io_raster *r = &file->raster;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = r->z;
    desc.nx = r->nx;
    desc.ny = r->ny;
    desc.bare = bare;
    desc.storage = CW_BORROW;
    memcpy(desc.map, r->map, sizeof desc.map);
    memcpy(file->map, r->map, sizeof file->map);
    cw_status status = cw_field_create(&desc, &file->field);
    file->mapped = status == CW_OK && r->mapped_bytes > 0;
    if (status != CW_ERROR_HOLE) return status;
    desc.storage = CW_COPY; /* infinite samples: the copy has NaN in their place */
    return cw_field_create(&desc, &file->field);
}

bool field_file_open(field_file *file, const char *path, const cw_query *query, io_error *error) {
    *file = (field_file){0};
    if (!io_raster_read(path, &file->raster, error)) return false;
    /* A kernel that was named says itself what it needs. */
    cw_status status = create(file, query->kernel != NULL);
    if (status == CW_OK) {
        file->kernel = cw_query_kernel(file->field, query);
        status = cw_field_build(file->field, file->kernel);
    }
    if (status == CW_OK) return true;
    io_fail(error, "%s: %zu x %zu samples: %s", path, file->raster.nx, file->raster.ny, cw_status_message(status));
    field_file_close(file);
    return false;
}

void field_file_close(field_file *file) {
    cw_field_destroy(file->field);
    io_raster_free(&file->raster);
    *file = (field_file){0};
}
