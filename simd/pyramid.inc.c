/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels: which walk a ray takes. Groups of 16 rays are made ready W at a time; rays that climb out of the
 * terrain are cut short (climb.inc.h); a few steps of the flat walk finish what is near (lanes.inc.h); what is left of a
 * group shares its walk if it is coherent (shared.inc.h), else it is queued for the lane walk (stream.inc.h). Which way a
 * ray takes never changes its hit. A stub includes a vocabulary and then this body. */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "lanes.inc.h"

#include "pyramid.h"

#include "climb.inc.h"
#include "wide.inc.h"

/* W rays as arrays, from which one is broadcast. */
typedef struct ray_store {
    float x_org[W], x_dir[W], x_center[W], x_inverse[W];
    float y_org[W], y_dir[W], y_center[W], y_inverse[W];
    float oz[W], dz[W], tmin[W], tmax[W], begin[W], end[W], from[W], until[W];
    unsigned up_x, up_y;
} ray_store;

static inline void store_rays(ray_store *s, const vray *r) {
    vf_store(s->x_org, r->x.org);
    vf_store(s->x_dir, r->x.dir);
    vf_store(s->x_center, r->x.center);
    vf_store(s->x_inverse, r->x.inverse);
    vf_store(s->y_org, r->y.org);
    vf_store(s->y_dir, r->y.dir);
    vf_store(s->y_center, r->y.center);
    vf_store(s->y_inverse, r->y.inverse);
    vf_store(s->oz, r->oz);
    vf_store(s->dz, r->dz);
    vf_store(s->tmin, r->tmin);
    vf_store(s->tmax, r->tmax);
    vf_store(s->begin, r->begin);
    vf_store(s->end, r->end);
    vf_store(s->from, r->from);
    vf_store(s->until, r->until);
    s->up_x = vm_bits(r->x.up);
    s->up_y = vm_bits(r->y.up);
}

static inline void pick_ray(wide_ray *w, const ray_store *s, size_t k) {
    const bool up_x = s->up_x >> k & 1, up_y = s->up_y >> k & 1;
    w->r.x.org = vf_set(s->x_org[k]);
    w->r.x.dir = vf_set(s->x_dir[k]);
    w->r.x.center = vf_set(s->x_center[k]);
    w->r.x.inverse = vf_set(s->x_inverse[k]);
    w->r.x.up = vm_set(up_x);
    w->r.y.org = vf_set(s->y_org[k]);
    w->r.y.dir = vf_set(s->y_dir[k]);
    w->r.y.center = vf_set(s->y_center[k]);
    w->r.y.inverse = vf_set(s->y_inverse[k]);
    w->r.y.up = vm_set(up_y);
    w->r.oz = vf_set(s->oz[k]);
    w->r.dz = vf_set(s->dz[k]);
    w->r.tmin = vf_set(s->tmin[k]);
    w->r.tmax = vf_set(s->tmax[k]);
    w->r.begin = vf_set(s->begin[k]);
    w->r.end = vf_set(s->end[k]);
    w->r.from = vf_set(s->from[k]);
    w->r.until = vf_set(s->until[k]);
    w->step_x = up_x ? 1.0f : -1.0f;
    w->step_y = up_y ? 1.0f : -1.0f;
    w->first_x = up_x ? 0 : 4;
    w->first_y = up_y ? 0 : 4;
    w->order = vorder_make(up_x, up_y);
}

#include "shared.inc.h"

#include "stream.inc.h"

/* Steps of the flat walk, all lanes together, that a packet takes before its rays go on one by one: by then rays that
 * start at the surface and climb have left it, mostly, and the lanes are still nearly full. */
enum { FLAT_STEPS = 6 };

/* Fewer rays than this do not pay for making a fat ray of them. */
enum { SHARE_AT_LEAST = 4 };

/* The first n rays of a group, of which the first is ray number base of its batch. Returns the rays that hit, with their
 * hits written unless any; rays that are to go on alone are put into the queue, and counted in *waiting. */
CW_INLINE unsigned pyramid_group(const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any, cw_hit *hits,
                                 queued *queue, size_t *waiting, uint32_t base) {
    lanes part[PARTS];
    ray_store store[PARTS];
    unsigned found = 0, rest = 0, near = 0; /* near: bits of parts that have walked from cell to cell */
    for (size_t p = 0; p < PARTS; p++) {
        cw_ray tail[W];
        lanes *l = &part[p];
        const size_t begin = p * W, count = n <= begin ? 0 : n - begin < W ? n - begin : W;
        const cw_ray *from = rays + begin;
        if (count < W) { /* lanes beyond the array get a ray of the group to read */
            for (size_t k = 0; k < W; k++) tail[k] = rays[k < count ? begin + k : 0];
            from = tail;
        }
        l->alive = vm_and(vm_first(count), make_rays(&l->r, f, from));
        lanes_clear(l);
        if (!vm_any(l->alive)) continue;
        const vmask short_way = climb(&l->r, f->pyramid, l->alive);
        l->alive = vm_and(l->alive, vf_le(l->r.from, l->r.until));
        if (vm_any(vm_and(l->alive, short_way))) {
            near |= ((1u << W) - 1) << begin;
            lanes_start(l, f);
            for (int k = 0; k < FLAT_STEPS && vm_any(l->alive); k++) lanes_step(l, f, leaf, any);
            l->r.from = vf_max(l->r.from, vf_max(l->c.x_in, l->c.y_in));
        }
        rest |= vm_bits(l->alive) << begin;
        if (vm_any(l->alive)) store_rays(&store[p], &l->r);
    }
    fat_ray a;
    if (__builtin_popcount(rest) >= SHARE_AT_LEAST && coherent(part, rest, f) && fat_init(&a, part, rest)) {
        unsigned alone = 0;
        shared_walk(&a, part, store, rest, f, leaf, any, hits, &alone);
        found |= alone;
    } else {
        for (; rest != 0; rest &= rest - 1) {
            const unsigned k = (unsigned)__builtin_ctz(rest);
            enqueue(&queue[(*waiting)++], &store[k / W], k % W, base + k, near >> k & 1);
        }
    }
    for (size_t p = 0; p < PARTS; p++)
        found |= (any ? vm_bits(part[p].found) : lanes_hits(&part[p], f, hits + p * W)) << (p * W);
    return found;
}

/* Rays whose leftovers are collected for one run of the lane walk. */
enum { BATCH = 16 * CHILDREN };

CW_INLINE void pyramid_closest(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, cw_leaf leaf) {
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH;
        queued queue[BATCH];
        size_t waiting = 0;
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            cw_hit h[CHILDREN];
            const unsigned found =
                pyramid_group(f, rays + k, count, leaf, false, h, queue, &waiting, (uint32_t)(k - b));
            for (size_t m = 0; m < count; m++)
                hits[k + m] = found >> m & 1 ? h[m] : (cw_hit){.t = INFINITY, .i = -1, .j = -1};
        }
        stream_walk(f, queue, waiting, leaf, false, hits + b, NULL);
    }
}

CW_INLINE void pyramid_any(const cw_field *f, const cw_ray *rays, size_t n, uint8_t *occluded, cw_leaf leaf) {
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH;
        queued queue[BATCH];
        size_t waiting = 0;
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            const unsigned found =
                pyramid_group(f, rays + k, count, leaf, true, NULL, queue, &waiting, (uint32_t)(k - b));
            for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        }
        stream_walk(f, queue, waiting, leaf, true, NULL, occluded + b);
    }
}
