/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels, 16 lanes wide, for AVX-512. */

#include "vec_avx512.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(pyramid16_mt)
CW_DECLARE_KERNEL(pyramid16_wt)

void cw_closest_pyramid16_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_closest_pyramid16_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    pyramid_closest(field, rays, n, query, hits, CW_LEAF_WATERTIGHT, NULL);
}
void cw_any_pyramid16_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                         uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
void cw_any_pyramid16_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query,
                         uint8_t *occluded) {
    pyramid_any(field, rays, n, query, occluded, CW_LEAF_WATERTIGHT, NULL);
}
