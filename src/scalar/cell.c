/* SPDX-License-Identifier: Apache-2.0 */
/* The kernel cell: rays one after another. */

#include "cell_walk.h"
#include "kernels.h"

static inline void trace_cells(const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, cw_hit *hits,
                               uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        if (hits == NULL)
            occluded[k] = cell_walk(f, &rays[k], leaf, true, NULL);
        else if (!cell_walk(f, &rays[k], leaf, false, &hits[k]))
            hits[k] = miss();
    }
}
static void trace_mt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_MOLLER_TRUMBORE, hits, occluded);
}
static void trace_wt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_WATERTIGHT, hits, occluded);
}

const cw_kernel_code cw_cell = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_mt, [CW_LEAF_WATERTIGHT] = trace_wt}};
