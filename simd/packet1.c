/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels, one ray wide: the oracle of the lanes. */

#include "vec_scalar.h"

#include "packet.inc.c"

#include "kernels.h"

CW_DECLARE_KERNEL(packet1_mt)
CW_DECLARE_KERNEL(packet1_wt)

void cw_closest_packet1_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    (void)query;
    packet_closest(field, rays, n, hits, CW_LEAF_MOLLER_TRUMBORE);
}
void cw_closest_packet1_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits) {
    (void)query;
    packet_closest(field, rays, n, hits, CW_LEAF_WATERTIGHT);
}
void cw_any_packet1_mt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    (void)query;
    packet_any(field, rays, n, occluded, CW_LEAF_MOLLER_TRUMBORE);
}
void cw_any_packet1_wt(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded) {
    (void)query;
    packet_any(field, rays, n, occluded, CW_LEAF_WATERTIGHT);
}
