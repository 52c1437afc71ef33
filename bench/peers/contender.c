/* SPDX-License-Identifier: Apache-2.0 */
#include "peers/peer.h"

#include <stdio.h>

static size_t call_of(const contender *c, size_t left) { return c->call > 0 && c->call < left ? c->call : left; }

/* NULL, as most callers pass, unless a kernel, leaf test or pool is set: with NULL one-ray calls get their own walk. */
static const cw_run *run_of(const contender *c) {
    const cw_run *r = &c->query;
    return r->pool || r->expert.kernel || r->expert.leaf != CW_LEAF_DEFAULT ? r : NULL;
}

/* Queries cannot fail here: contender_from_kernel has tried one. */
static void closest(const contender *c, const cw_ray *rays, size_t n, cw_hit *hits) {
    for (size_t k = 0, count; k < n; k += count) {
        count = call_of(c, n - k);
        (void)cw_closest(c->field, run_of(c), rays + k, count, hits + k);
    }
}

static void any(const contender *c, const cw_ray *rays, size_t n, uint8_t *occluded) {
    for (size_t k = 0, count; k < n; k += count) {
        count = call_of(c, n - k);
        (void)cw_occluded(c->field, run_of(c), rays + k, count, occluded + k);
    }
}

cw_status contender_from_kernel(contender *c, cw_field *field, const cw_kernel *kernel, cw_leaf leaf) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    if (leaf == CW_LEAF_DEFAULT) leaf = info.default_leaf;
    *c = (contender){.width = info.width, .threads = 1, .closest = closest, .any = any, .field = field};
    c->query = (cw_run){.expert.kernel = kernel, .expert.leaf = leaf};
    snprintf(c->name, sizeof c->name, "%s/%s", info.name, cw_leaf_name(leaf));
    const cw_status status =
        info.available ? cw_field_build(field, &(cw_run){.expert.kernel = kernel}) : CW_ERROR_KERNEL;
    return status == CW_OK ? cw_closest(field, &c->query, NULL, 0, NULL) : status;
}

void contender_run(void *pass) {
    const contender_pass *p = pass;
    if (p->any)
        p->of->any(p->of, p->rays, p->n, p->out.occluded);
    else
        p->of->closest(p->of, p->rays, p->n, p->out.hits);
}

const peer_kind *const peer_kinds[PEER_KINDS] = {&peer_embree, &peer_bullet};

#if !CELLWALK_EMBREE
const peer_kind peer_embree = {.name = "embree", .package = "libembree-dev", .options = EMBREE_OPTIONS};
#endif
#if !CELLWALK_BULLET
const peer_kind peer_bullet = {.name = "bullet", .package = "libbullet-dev"};
#endif
