/* SPDX-License-Identifier: Apache-2.0 */
/* The reference without a walk: every ray against every triangle of the field, by Möller and Trumbore's test (1997),
 * without the gate. Invariant: it returns the nearest hit of that test. Tests compare the other kernels with it on
 * small fields, up to the rounding of the test. It is no reference for exactness: tests use an oracle in exact
 * arithmetic for that. */

#include "field.h"
#include "moller_trumbore.h"
#include "paths.h"
#include "ray.h"
#include "refine.h"

/* The nearest hit; among equally near ones the first in row order. */
static bool trace(const cw_field *f, const cw_ray *given, bool any, cw_hit *best) {
    bool found = false;
    ray_start ray;
    if (!ray_init(&ray, f, given)) return false;
    for (size_t j = 0; j + 1 < f->ny; j++) {
        for (size_t i = 0; i + 1 < f->nx; i++) {
            const float *h = f->z + j * f->stride + i;
            const mt_range range = mt_between(ray.tmin, ray.tmax);
            cw_hit hit;
            if (!mt_cell(ray.org, ray.dir, &range, i, j, h[0], h[1], h[f->stride], h[f->stride + 1], &hit)) continue;
            if (found && !(hit.t < best->t)) continue;
            *best = hit;
            found = true;
            ray.tmax = hit.t;
            if (any) return true;
        }
    }
    if (found) *best = refine_place(f, &ray, best);
    return found;
}

static void trace_all(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    cw_hit unused;
    for (size_t k = 0; k < n && hits == NULL; k++) occluded[k] = trace(f, &rays[k], true, &unused);
    for (size_t k = 0; k < n && hits != NULL; k++)
        if (!trace(f, &rays[k], false, &hits[k])) hits[k] = miss();
}

const cw_kernel_code cw_brute = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_all}};
