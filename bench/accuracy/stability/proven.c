/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/stability/proven.h"

static bool passes(oracle *o, const aimed_ray *a) {
    const oracle_triangle over = {a->over.i, a->over.j, a->over.triangle}, *t = a->over.i < 0 ? NULL : &over;
    return oracle_ray(o, &a->ray) && oracle_clear(o, a->from, a->side, t) && oracle_clear(o, a->to, -a->side, t);
}

proven_ray proven_ray_make(aim kind, const aimed_field *f, oracle *o, random_state *r) {
    enum { TRIES = 8 }; /* rounding may spoil one; many of those that graze cannot be proved */
    proven_ray p = {.passes = false};
    for (int tries = 0; tries < (kind == AIM_GRAZING ? 1 : TRIES) && !p.passes; tries++) {
        const aimed_ray a = aimed_ray_make(kind, f, r);
        p = (proven_ray){a.ray, passes(o, &a)};
    }
    return p;
}
