/* SPDX-License-Identifier: Apache-2.0 */
/* What is counted of each variant of the kernels: all classes of rays over one field, with one kernel. The same rays as
 * those of cellwalk-bench micro with as many a class. Prints what was run, as the guard's workload does, and on standard
 * error a hash of all answers, by which variants are known to give the same. */
#include "ray_classes.h"
#include "workload_fields.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct work {
    const cw_field *field;
    cw_query query;
    cw_ray *rays;
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

/* FNV-1a. */
static void add_to_hash(uint64_t *hash, const void *of, size_t size) {
    for (const unsigned char *byte = of; size > 0; size--) *hash = (*hash ^ *byte++) * 0x100000001b3u;
}

static void hash_answers(uint64_t *hash, const work *w) {
    for (size_t k = 0; k < w->count; k++) {
        if (w->any) {
            add_to_hash(hash, &w->occluded[k], 1);
            continue;
        }
        const cw_hit *h = &w->hits[k];
        const int32_t place[3] = {h->i, h->j, (int32_t)h->triangle};
        add_to_hash(hash, &h->t, sizeof h->t);
        if (h->i < 0) continue;
        add_to_hash(hash, &h->u, sizeof h->u);
        add_to_hash(hash, &h->v, sizeof h->v);
        add_to_hash(hash, place, sizeof place);
    }
}

static bool run(work *w, cw_field *field, const char *kernel, size_t most) {
    uint64_t hash = 0xcbf29ce484222325u;
    w->field = field;
    w->query = (cw_query){.kernel = cw_kernel_find(kernel)};
    if (cw_field_build(field, w->query.kernel) != CW_OK) return false;
    const cw_leaf leaf = cw_kernel_describe(w->query.kernel).default_leaf;
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
        w->any = workload_class_is_any((workload_class)c);
        w->count = workload_rays_make(field, (workload_class)c, 1, most, w->rays);
        if (w->count == 0 || guard_trace(w) != CW_OK) return false;
        hash_answers(&hash, w);
        printf("run,%s,%s,%s,%zu\n", kernel, cw_leaf_name(leaf), workload_class_name((workload_class)c), w->count);
    }
    fprintf(stderr, "%016" PRIx64 "\n", hash);
    return true;
}

int main(int argc, char **argv) {
    const size_t most = argc == 4 ? strtoul(argv[3], NULL, 10) : 0;
    if (most == 0) {
        fputs("Usage: cellwalk-ablation-work KERNEL FIELD RAYS\n", stderr);
        return 2;
    }
    workload_field samples;
    cw_field *field = NULL;
    work w = {.rays = malloc(most * sizeof *w.rays),
              .hits = malloc(most * sizeof *w.hits),
              .occluded = malloc(most * sizeof *w.occluded)};
    const bool made = workload_field_make(argv[2], &samples);
    bool good = made && w.rays && w.hits && w.occluded;
    if (good) {
        cw_field_desc desc = cw_field_desc_default();
        desc.samples = samples.z;
        desc.nx = samples.nx;
        desc.ny = samples.ny;
        desc.storage = CW_BORROW;
        good = cw_field_create(&desc, &field) == CW_OK && run(&w, field, argv[1], most);
    }
    cw_field_destroy(field);
    if (made) workload_field_free(&samples);
    free(w.rays);
    free(w.hits);
    free(w.occluded);
    if (!good) fputs("the workload does not run\n", stderr);
    return good && fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
