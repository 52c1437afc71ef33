/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels, 8 lanes wide, for AVX2. */

#include "vec_avx2.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(pyramid8_mt)
CW_DECLARE_KERNEL(pyramid8_wt)

void cw_closest_pyramid8_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_closest_pyramid8_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_WATERTIGHT, NULL);
}
void cw_any_pyramid8_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_any_pyramid8_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_WATERTIGHT, NULL);
}
