/* SPDX-License-Identifier: Apache-2.0 */
#include "field_file.h"

#include <string.h>

static bool create(field_file *file, const char *path, io_error *error) {
    const io_raster *r = &file->raster;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = r->z;
    desc.nx = r->nx;
    desc.ny = r->ny;
    memcpy(desc.map, r->map, sizeof desc.map);
    desc.storage = CW_BORROW;
    cw_status status = cw_field_create(&desc, &file->field);
    file->mapped = status == CW_OK && r->mapped_bytes > 0;
    if (status == CW_ERROR_HOLE) {
        desc.storage = CW_COPY; /* infinite samples: the copy has NaN in their place */
        status = cw_field_create(&desc, &file->field);
    }
    if (status == CW_OK) return true;
    return io_fail(error, "%s: %zu x %zu samples: %s", path, r->nx, r->ny, cw_status_message(status));
}

bool field_file_open(field_file *file, const char *path, io_error *error) {
    *file = (field_file){0};
    if (!io_raster_read(path, &file->raster, error)) return false;
    if (create(file, path, error)) return true;
    field_file_close(file);
    return false;
}

void field_file_close(field_file *file) {
    cw_field_destroy(file->field);
    io_raster_free(&file->raster);
    *file = (field_file){0};
}
