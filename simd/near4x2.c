/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels for tolerant queries, twice 4 lanes wide, for SSE4.2. */

#include "vec_half.h"

#include "vec_sse42.h"

#include "vec_twice.h"

#include "pyramid.inc.c"

#include "kernels.h"

CW_DECLARE_NEAR(pyramid4x2)

void cw_closest_near_pyramid4x2(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits,
                                const cw_tolerance *tolerance) {
    pyramid_closest(field, rays, n, CW_COHERENCE_AUTO, hits, CW_LEAF_WATERTIGHT, tolerance);
}
void cw_any_near_pyramid4x2(const cw_field *field, const cw_ray *rays, size_t n, uint8_t *occluded,
                            const cw_tolerance *tolerance) {
    pyramid_any(field, rays, n, CW_COHERENCE_AUTO, occluded, CW_LEAF_WATERTIGHT, tolerance);
}
