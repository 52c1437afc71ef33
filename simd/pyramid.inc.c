/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid walk over an array of rays. Rays are made ready W at a time, in groups of 16; a stub includes a vocabulary and
 * then this body. */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "pyramid.h"

#include "wide.inc.h"

/* 16 rays made ready, ray k in lane k % W of part k / W. */
typedef struct group {
    vray part[PARTS];
    unsigned alive;
} group;

static inline void make_group(group *g, const cw_field *f, const cw_ray *rays, size_t n) {
    cw_ray tail[W];
    g->alive = 0;
    for (size_t k = 0; k < PARTS; k++) {
        const size_t begin = k * W, lanes = n <= begin ? 0 : n - begin < W ? n - begin : W;
        const cw_ray *from = rays + begin;
        if (lanes < W) { /* lanes beyond the array get a ray of the group to read */
            for (size_t l = 0; l < W; l++) tail[l] = rays[l < lanes ? begin + l : 0];
            from = tail;
        }
        g->alive |= vm_bits(vm_and(vm_first(lanes), make_rays(&g->part[k], f, from))) << begin;
    }
}

static inline vfloat broadcast(const vfloat *from, size_t lane) {
    float all[W];
    vf_store(all, *from);
    return vf_set(all[lane]);
}

static inline vaxis broadcast_axis(const vaxis *a, size_t lane) {
    return (vaxis){
        .org = broadcast(&a->org, lane),
        .dir = broadcast(&a->dir, lane),
        .center = broadcast(&a->center, lane),
        .inverse = broadcast(&a->inverse, lane),
        .up = vm_set(vm_bits(a->up) >> lane & 1),
    };
}

static inline void pick_ray(wide_ray *w, const group *g, size_t k) {
    const vray *from = &g->part[k / W];
    const size_t lane = k % W;
    w->r.x = broadcast_axis(&from->x, lane);
    w->r.y = broadcast_axis(&from->y, lane);
    w->r.oz = broadcast(&from->oz, lane);
    w->r.dz = broadcast(&from->dz, lane);
    w->r.tmin = broadcast(&from->tmin, lane);
    w->r.tmax = broadcast(&from->tmax, lane);
    w->r.begin = broadcast(&from->begin, lane);
    w->r.end = broadcast(&from->end, lane);
    w->up_x = vm_any(w->r.x.up);
    w->up_y = vm_any(w->r.y.up);
    w->step_x = w->up_x ? 1.0f : -1.0f;
    w->step_y = w->up_y ? 1.0f : -1.0f;
    w->order = vorder_make(w->up_x, w->up_y);
}

static inline void pyramid_closest(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, cw_leaf leaf) {
    for (size_t k = 0; k < n; k += CHILDREN) {
        const size_t count = n - k < CHILDREN ? n - k : CHILDREN;
        group g;
        make_group(&g, f, rays + k, count);
        for (size_t l = 0; l < count; l++) {
            wide_ray w;
            if (g.alive >> l & 1) {
                pick_ray(&w, &g, l);
                if (wide_walk(&w, f, leaf, false, &hits[k + l])) continue;
            }
            hits[k + l] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
        }
    }
}

static inline void pyramid_any(const cw_field *f, const cw_ray *rays, size_t n, uint8_t *occluded, cw_leaf leaf) {
    for (size_t k = 0; k < n; k += CHILDREN) {
        const size_t count = n - k < CHILDREN ? n - k : CHILDREN;
        group g;
        make_group(&g, f, rays + k, count);
        for (size_t l = 0; l < count; l++) {
            wide_ray w;
            occluded[k + l] = 0;
            if (!(g.alive >> l & 1)) continue;
            pick_ray(&w, &g, l);
            cw_hit unused;
            occluded[k + l] = wide_walk(&w, f, leaf, true, &unused);
        }
    }
}
