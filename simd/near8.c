/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels for tolerant queries, 8 lanes wide, for AVX2. */

/* A tolerant hit lies where its ray enters a slab, so that is computed with the same bits at every width. */
#define CELLWALK_UNFUSED

#include "vec_avx2.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(near_pyramid8)

void cw_closest_near_pyramid8(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                              cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_WATERTIGHT, query);
}
void cw_any_near_pyramid8(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                          uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_WATERTIGHT, query);
}
