/* SPDX-License-Identifier: Apache-2.0 */
/* The work that callgrind counts: it counts inside guard_trace alone and writes down a part whenever that function returns. The
 * lines printed here say, in the same order, what was counted. Without arguments it is the guard's: every kernel that this
 * machine can run, with every leaf test it has, on some classes of rays over one field. With a kernel, a field and a number of
 * rays it is that kernel's on all classes; a hash of all answers, by which builds are known to give the same ones, then goes to
 * standard error. */
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GUARD_RAYS = 2048, BRUTE_RAYS = 16 }; /* brute force tests all 131072 triangles for each ray */

typedef struct work {
    cw_field *field;
    cw_query query;
    cw_ray *class_rays[WORKLOAD_CLASS_COUNT], *rays;
    size_t class_counts[WORKLOAD_CLASS_COUNT], count;
    bool wanted[WORKLOAD_CLASS_COUNT], any;
    cw_hit *hits;
    uint8_t *occluded;
    uint64_t hash;
} work;

/* callgrind finds this function by its name, so it must stay a function of its own. */
__attribute__((noinline)) cw_status guard_trace(const work *w);
cw_status guard_trace(const work *w) {
    return w->any ? cw_any(w->field, &w->query, w->rays, w->count, w->occluded)
                  : cw_closest(w->field, &w->query, w->rays, w->count, w->hits);
}

/* FNV-1a. A hit is 24 bytes without gaps, and all of a miss is set as well. */
static void hash_answers(work *w) {
    const unsigned char *byte = w->any ? w->occluded : (const unsigned char *)w->hits;
    for (size_t left = w->count * (w->any ? 1 : sizeof *w->hits); left > 0; left--)
        w->hash = (w->hash ^ *byte++) * 0x100000001b3u;
}

static bool run(work *w, cw_leaf leaf) {
    const cw_kernel_info info = cw_kernel_describe(w->query.kernel);
    w->query.leaf = leaf;
    if (cw_closest(w->field, &w->query, NULL, 0, NULL) == CW_ERROR_UNSUPPORTED) return true;
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
        if (!w->wanted[c]) continue;
        w->rays = w->class_rays[c];
        w->count = w->class_counts[c];
        if (strcmp(info.name, "brute") == 0 && w->count > BRUTE_RAYS) w->count = BRUTE_RAYS;
        w->any = workload_class_is_any((workload_class)c);
        if (guard_trace(w) != CW_OK) return false;
        hash_answers(w);
        printf("run,%s,%s,%s,%zu\n", info.name, cw_leaf_name(leaf), workload_class_name((workload_class)c), w->count);
    }
    return true;
}

static bool run_guard(work *w) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        w->query.kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(w->query.kernel);
        if (!info.available) printf("absent,%s,%s\n", info.name, cw_isa_name(info.isa));
        if (!info.available) continue;
        if (cw_field_build(w->field, w->query.kernel) != CW_OK) return false;
        for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++)
            if (!run(w, (cw_leaf)leaf)) return false;
    }
    return true;
}

static bool run_kernel(work *w, const char *kernel) {
    w->query.kernel = cw_kernel_find(kernel);
    if (cw_field_build(w->field, w->query.kernel) != CW_OK || !run(w, cw_kernel_describe(w->query.kernel).default_leaf))
        return false;
    fprintf(stderr, "%016" PRIx64 "\n", w->hash);
    return true;
}

static bool make_rays(work *w, size_t most) {
    w->hits = malloc(most * sizeof *w->hits);
    w->occluded = malloc(most);
    bool good = w->hits && w->occluded;
    for (int c = 0; good && c < WORKLOAD_CLASS_COUNT; c++) {
        w->class_rays[c] = malloc(most * sizeof *w->rays);
        if (w->class_rays[c])
            w->class_counts[c] = workload_rays_make(w->field, (workload_class)c, 1, most, w->class_rays[c]);
        good = w->class_counts[c] > 0;
    }
    return good;
}

int main(int argc, char **argv) {
    const bool guards = argc == 1;
    const size_t most = guards ? GUARD_RAYS : argc == 4 ? strtoul(argv[3], NULL, 10) : 0;
    if (most == 0) {
        fputs("Usage: cellwalk-counted-work [KERNEL FIELD RAYS]\n", stderr);
        return 2;
    }
    work w = {.hash = 0xcbf29ce484222325u};
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) w.wanted[c] = !guards || (c != WORKLOAD_AO && c != WORKLOAD_GRAZING);
    workload_field samples;
    const bool good = workload_field_make(guards ? "257" : argv[2], &samples) &&
                      workload_field_open(&samples, CW_BORROW, false, &w.field) == CW_OK && make_rays(&w, most) &&
                      (guards ? run_guard(&w) : run_kernel(&w, argv[1]));
    cw_field_destroy(w.field);
    workload_field_free(&samples);
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) free(w.class_rays[c]);
    free(w.hits);
    free(w.occluded);
    if (!good) fputs("the work that is counted does not run\n", stderr);
    return good && fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
