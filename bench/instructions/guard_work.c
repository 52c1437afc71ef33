/* SPDX-License-Identifier: Apache-2.0 */
/* The guard's fixed workload: every kernel that this machine can run, with every leaf test it has, on some classes of
 * rays over one field. It runs under callgrind, which counts inside guard_trace alone and writes down the count whenever
 * that function returns; the lines printed here say, in the same order, what was counted. */
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 2048, BRUTE_RAYS = 16 }; /* brute force tests all 131072 triangles for each ray */

static const workload_class classes[] = {WORKLOAD_PRIMARY, WORKLOAD_SHADOW, WORKLOAD_BOUNCE, WORKLOAD_RANDOM};
enum { CLASS_COUNT = sizeof classes / sizeof classes[0] };

typedef struct work {
    const cw_field *field;
    cw_query query;
    const cw_ray *rays;
    size_t count;
    bool any;
    cw_hit *hits;
    uint8_t *occluded;
} work;

/* callgrind finds this function by its name, so it must stay a function of its own. */
__attribute__((noinline)) cw_status guard_trace(const work *w);
cw_status guard_trace(const work *w) {
    return w->any ? cw_any(w->field, &w->query, w->rays, w->count, w->occluded)
                  : cw_closest(w->field, &w->query, w->rays, w->count, w->hits);
}

static bool run_kernel(cw_field *field, const cw_kernel *kernel, cw_ray *const rays[CLASS_COUNT],
                       const size_t counts[CLASS_COUNT], cw_hit *hits, uint8_t *occluded) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    if (!info.available) {
        printf("absent,%s,%s\n", info.name, cw_isa_name(info.isa));
        return true;
    }
    if (cw_field_build(field, kernel) != CW_OK) return false;
    const size_t most = strcmp(info.name, "brute") == 0 ? BRUTE_RAYS : RAYS;
    for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++) {
        work w = {.field = field, .query = {.kernel = kernel, .leaf = (cw_leaf)leaf}, .hits = hits};
        w.occluded = occluded;
        if (cw_closest(field, &w.query, NULL, 0, NULL) == CW_ERROR_UNSUPPORTED) continue;
        for (size_t c = 0; c < CLASS_COUNT; c++) {
            w.rays = rays[c];
            w.count = counts[c] < most ? counts[c] : most;
            w.any = workload_class_is_any(classes[c]);
            if (guard_trace(&w) != CW_OK) return false;
            printf("run,%s,%s,%s,%zu\n", info.name, cw_leaf_name((cw_leaf)leaf), workload_class_name(classes[c]),
                   w.count);
        }
    }
    return true;
}

int main(void) {
    static cw_ray storage[CLASS_COUNT][RAYS];
    static cw_hit hits[RAYS];
    static uint8_t occluded[RAYS];
    cw_ray *rays[CLASS_COUNT];
    size_t counts[CLASS_COUNT];
    workload_field samples;
    cw_field *field = NULL;
    bool good = workload_field_make("257", &samples);
    if (good) {
        cw_field_desc desc = cw_field_desc_default();
        desc.samples = samples.z;
        desc.nx = samples.nx;
        desc.ny = samples.ny;
        desc.storage = CW_BORROW;
        good = cw_field_create(&desc, &field) == CW_OK;
    }
    for (size_t c = 0; good && c < CLASS_COUNT; c++) {
        rays[c] = storage[c];
        counts[c] = workload_rays_make(field, classes[c], 1, RAYS, rays[c]);
        good = counts[c] > 0;
    }
    for (size_t k = 0; good && k < cw_kernel_count(); k++)
        good = run_kernel(field, cw_kernel_at(k), rays, counts, hits, occluded);
    cw_field_destroy(field);
    workload_field_free(&samples);
    if (!good) fputs("the guard's workload does not run\n", stderr);
    return good && fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
