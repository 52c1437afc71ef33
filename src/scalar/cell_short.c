/* SPDX-License-Identifier: Apache-2.0 */
/* Short rays, one at a time. Not in cell.c: with four more calls of the walk there GCC does not inline all of it, and cell gets slower
 * (the test guard). */

#include "cell_walk.h"
#include "kernels.h"
#include "short_way.h"

bool cw_short1(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        const float speed = short_speed(&rays[k]);
        if (!short_in_box(f, &rays[k], speed) && !short_over_slab(f, &rays[k], speed)) return false;
        size_t turns = SHORT_TURNS;
        if (hits == NULL)
            occluded[k] = cell_walk(f, &rays[k], CW_LEAF_WATERTIGHT, true, &turns, NULL);
        else if (!cell_walk(f, &rays[k], CW_LEAF_WATERTIGHT, false, &turns, &hits[k]))
            hits[k] = miss();
        if (turns == 0) return false;
    }
    return true;
}
