/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels for tolerant queries, 8 lanes wide, for AVX2. */

/* A tolerant hit lies where its ray enters a slab, so that is computed with the same bits at every width. */
#define CELLWALK_UNFUSED
#include "vec_avx2.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_NEAR(pyramid8)

void cw_closest_near_pyramid8(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits,
                              const cw_tolerance *tolerance) {
    pyramid_closest(field, rays, n, CW_COHERENCE_AUTO, hits, CW_LEAF_WATERTIGHT, tolerance);
}
void cw_any_near_pyramid8(const cw_field *field, const cw_ray *rays, size_t n, uint8_t *occluded,
                          const cw_tolerance *tolerance) {
    pyramid_any(field, rays, n, CW_COHERENCE_AUTO, occluded, CW_LEAF_WATERTIGHT, tolerance);
}
