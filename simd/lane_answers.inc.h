/* SPDX-License-Identifier: Apache-2.0 */
/* The finds of the walks of single rays, and their conversion to hits. */

/* The first n lanes, a bit each. */
static inline unsigned first_lanes(size_t n) { return (unsigned)(((uint64_t)1 << n) - 1); }

/* Turns count of the finds into hits, from number first on. */
void CW_CODE(lane_write_)(const lane_answers *a, const cw_field *f, size_t first, size_t count);
#ifndef CELLWALK_PAIRS /* pairs call that of the single vectors */
void CW_CODE(lane_write_)(const lane_answers *a, const cw_field *f, size_t first, size_t count) {
    const cw_ray *rays[W];
    for (size_t k = 0; k < W; k++) rays[k] = &a->rays[a->number[first + (k < count ? k : 0)]];
    const found_hits found = {{vf_load(a->t0 + first), vf_load(a->t1 + first), vf_gt(vf_load(a->b + first), vf_set(0))},
                              vf_load(a->i + first),
                              vf_load(a->j + first),
                              vf_load(a->h00 + first),
                              vf_load(a->corner + first),
                              vf_load(a->h11 + first)};
    vfloat c[8];
    vf_load_each_ray(rays, c);
    vstart s;
    restart_rays(&s, f, c);
    const vhit h = refine_hits(&s, &found);
    scatter_hits(&h, &found, first_lanes(count), a->number + first, a->hits);
}

#endif

/* Turns all finds into hits. Lanes beyond the last find would else be computed from numbers that nothing has set. */
static inline void write_rest(lane_answers *a, const cw_field *f) {
    float *const numbers[FOUND_NUMBERS] = {a->t0, a->t1, a->i, a->j, a->h00, a->corner, a->h11, a->b};
    while (a->found > 0) {
        const size_t count = a->found < (size_t)QUEUE_W ? a->found : (size_t)QUEUE_W;
        for (int k = 0; k < FOUND_NUMBERS; k++)
            for (size_t m = count; m < (size_t)QUEUE_W; m++) numbers[k][m] = 0;
        CW_CODE(lane_write_)(a, f, a->found -= count, count);
    }
}

/* Stores the finds of the leaf test in the lanes of which. */
CW_INLINE void lane_found(lane_answers *a, const cw_field *f, const uint32_t ray[W], vmask which, const vfind *find,
                          const vcell *c) {
    unsigned bits = vm_bits(which);
    if (a->occluded) {
        for (; bits != 0; bits &= bits - 1) a->occluded[ray[__builtin_ctz(bits)]] = 1;
        return;
    }
    const vpick pick = vpick_make(which);
    size_t n = a->found;
    vf_store_picked(a->t0 + n, find->t0, pick);
    vf_store_picked(a->t1 + n, find->t1, pick);
    vf_store_picked(a->i + n, c->i, pick);
    vf_store_picked(a->j + n, c->j, pick);
    vf_store_picked(a->h00 + n, c->h00, pick);
    vf_store_picked(a->corner + n, vf_select(find->b, c->h01, c->h10), pick);
    vf_store_picked(a->h11 + n, c->h11, pick);
    vf_store_picked(a->b + n, vf_select(find->b, vf_set(1), vf_set(0)), pick);
    for (; bits != 0; bits &= bits - 1) a->number[n++] = ray[__builtin_ctz(bits)];
    while (n >= (size_t)QUEUE_W) CW_CODE(lane_write_)(a, f, n -= (size_t)QUEUE_W, (size_t)QUEUE_W);
    a->found = n;
}

/* The same for one ray, of which find holds t0, t1, i, j, h00, corner, h11 and b, in this order. */
static inline void one_found(lane_answers *a, const cw_field *f, uint32_t ray, const float find[FOUND_NUMBERS]) {
    if (a->occluded) {
        a->occluded[ray] = 1;
        return;
    }
    float *const to[FOUND_NUMBERS] = {a->t0, a->t1, a->i, a->j, a->h00, a->corner, a->h11, a->b};
    for (int k = 0; k < FOUND_NUMBERS; k++) to[k][a->found] = find[k];
    a->number[a->found++] = ray;
    if (a->found >= (size_t)QUEUE_W) CW_CODE(lane_write_)(a, f, a->found -= (size_t)QUEUE_W, (size_t)QUEUE_W);
}
