/* SPDX-License-Identifier: Apache-2.0 */
#include "peers/contender.h"

#include <stdio.h>

/* Queries cannot fail here: contender_from_kernel has tried one. */
static void closest(const void *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    const kernel_contender *k = self;
    (void)cw_closest(k->field, &k->query, rays, n, hits);
}

static void any(const void *self, const cw_ray *rays, size_t n, uint8_t *occluded) {
    const kernel_contender *k = self;
    (void)cw_any(k->field, &k->query, rays, n, occluded);
}

cw_status contender_from_kernel(contender *c, kernel_contender *k, cw_field *field, const cw_kernel *kernel,
                                cw_leaf leaf) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    if (leaf == CW_LEAF_DEFAULT) leaf = info.default_leaf;
    if (!info.available) return CW_ERROR_UNAVAILABLE;
    *k = (kernel_contender){.field = field, .query = {.kernel = kernel, .leaf = leaf}};
    *c = (contender){.width = info.width, .threads = 1, .self = k, .closest = closest, .any = any};
    snprintf(c->name, sizeof c->name, "%s/%s", info.name, cw_leaf_name(leaf));
    cw_status status = cw_field_build(field, kernel);
    if (status == CW_OK) status = cw_closest(field, &k->query, NULL, 0, NULL);
    return status;
}

void contender_run(void *pass) {
    const contender_pass *p = pass;
    if (p->any)
        p->of->any(p->of->self, p->rays, p->n, p->occluded);
    else
        p->of->closest(p->of->self, p->rays, p->n, p->hits);
}
