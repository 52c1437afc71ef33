/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels, twice 4 lanes wide, for SSE4.2. */

#include "vec_half.h"

#include "vec_sse42.h"

#include "vec_twice.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(pyramid4x2_mt)
CW_DECLARE_KERNEL(pyramid4x2_wt)

void cw_closest_pyramid4x2_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                              cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_closest_pyramid4x2_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                              cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_WATERTIGHT, NULL);
}
void cw_any_pyramid4x2_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                          uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_any_pyramid4x2_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                          uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_WATERTIGHT, NULL);
}
