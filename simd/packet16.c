/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels, 16 rays wide, for AVX-512. */

#include "vec_avx512.h"

#include "packet.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(packet16_mt)
CW_DECLARE_KERNEL(packet16_wt)

void cw_closest_packet16_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    (void)query;
    packet_closest(field, rays, n, hits, CW_LEAF_MOLLER_TRUMBORE);
}
void cw_closest_packet16_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    (void)query;
    packet_closest(field, rays, n, hits, CW_LEAF_WATERTIGHT);
}
void cw_any_packet16_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    (void)query;
    packet_any(field, rays, n, occluded, CW_LEAF_MOLLER_TRUMBORE);
}
void cw_any_packet16_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    (void)query;
    packet_any(field, rays, n, occluded, CW_LEAF_WATERTIGHT);
}
