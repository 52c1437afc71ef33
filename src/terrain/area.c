/* SPDX-License-Identifier: Apache-2.0 */
#include "area.h"

cw_status cw_check_number(const char *name, double value, double least, double most) {
    if (value >= least && value <= most) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "%s: %g; it is from %g to %g", name, value, least, most);
}

cw_status cw_area_begin(const terrain *t, const void *desc, const char *name, const cw_run *run, size_t every,
                        cw_area *area, cw_run *how) {
    if (t == NULL || desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", t ? name : "terrain");
    const cw_status status = cw_run_begin(run, how);
    if (status != CW_OK) return status;
    cw_rectangle *at = &area->at;
    if (at->i == 0 && at->j == 0 && at->nx == 0 && at->ny == 0) *at = (cw_rectangle){0, 0, t->nx, t->ny};
    if (at->i > t->nx || at->nx > t->nx - at->i || at->j > t->ny || at->ny > t->ny - at->j)
        return cw_fail(CW_ERROR_ARGUMENT, "area: %zu x %zu samples from (%zu, %zu) on; the terrain has %zu x %zu",
                       at->nx, at->ny, at->i, at->j, t->nx, t->ny);
    const size_t answers = at->nx / every + (at->nx % every != 0);
    if (area->stride == 0) area->stride = answers;
    if (area->stride < answers)
        return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu; a row has %zu answers", area->stride, answers);
    if (at->ny == 0 || area->stride <= PTRDIFF_MAX / sizeof(double) / at->ny) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu; no array holds %zu such rows", area->stride, at->ny);
}
