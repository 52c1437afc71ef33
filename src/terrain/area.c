/* SPDX-License-Identifier: Apache-2.0 */
#include "area.h"

#include <stdlib.h>
#include <string.h>

enum { SAMPLES_AT_ONCE = 1 << 20 };

cw_status cw_check_number(const char *name, double value, double least, double most) {
    if (value >= least && value <= most) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "%s: %g; it is from %g to %g", name, value, least, most);
}

cw_status cw_check_zeros(const uint64_t reserved[8], uint32_t zero, const char *what) {
    uint64_t all = zero;
    for (int k = 0; k < 8; k++) all |= reserved[k];
    if (all == 0) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "%s: a reserved member is not 0; library %s has no use for it", what, CW_VERSION);
}

cw_status cw_area_begin(const terrain *t, const void *desc, const char *name, const cw_run *run, cw_area *area,
                        cw_run *how) {
    if (t == NULL || desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", t ? name : "terrain");
    const cw_status status = cw_run_begin(run, how);
    if (status != CW_OK) return status;
    cw_rectangle *at = &area->at;
    if (at->i == 0 && at->j == 0 && at->nx == 0 && at->ny == 0) *at = (cw_rectangle){0, 0, t->nx, t->ny};
    if (at->i > t->nx || at->nx > t->nx - at->i || at->j > t->ny || at->ny > t->ny - at->j)
        return cw_fail(CW_ERROR_ARGUMENT, "area: %zu x %zu samples from (%zu, %zu) on; the terrain has %zu x %zu",
                       at->nx, at->ny, at->i, at->j, t->nx, t->ny);
    return CW_OK;
}

cw_status cw_area_stride(cw_area *area) {
    if (area->stride == 0) area->stride = area->at.nx;
    if (area->stride >= area->at.nx) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu; a row of the area has %zu", area->stride, area->at.nx);
}

cw_status cw_area_make(cw_area area, const cw_run *how, size_t bytes, cw_area_fill *fill, void *context, void *out,
                       const char *name) {
    const cw_rectangle all = area.at;
    cw_status status = cw_area_stride(&area);
    if (status != CW_OK || all.nx == 0 || all.ny == 0) return status;
    if (out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", name);
    const size_t most = all.nx < SAMPLES_AT_ONCE ? SAMPLES_AT_ONCE / all.nx : 1, row = all.nx * bytes;
    char *room = area.stride > all.nx ? malloc((most < all.ny ? most : all.ny) * row) : NULL;
    if (area.stride > all.nx && room == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    for (size_t y = 0, rows; y < all.ny && status == CW_OK; y += rows) {
        rows = most < all.ny - y ? most : all.ny - y;
        run_part part = {how, (double)y / (double)all.ny, (double)(y + rows) / (double)all.ny};
        const cw_run run = cw_run_part_of(&part);
        char *to = (char *)out + y * area.stride * bytes;
        status = fill(context, &run, (cw_rectangle){all.i, all.j + y, all.nx, rows}, room ? room : to);
        for (size_t k = 0; k < rows && room && status == CW_OK; k++)
            memcpy(to + k * area.stride * bytes, room + k * row, row);
    }
    free(room);
    return status;
}
