/* SPDX-License-Identifier: Apache-2.0 */
/* The work that callgrind counts: it counts inside guard_trace alone and writes a part of its profile whenever that
 * function returns. The lines printed here name the parts in the same order. Without arguments the work is the
 * guard's: every kernel that this machine can run, with each of its leaf tests, on all classes of rays over a small
 * and a larger field. With a kernel, a field and a number of rays it is that kernel on all classes. A hash of all
 * answers, which shows that builds give the same ones, then goes to standard error. */
#include "cellwalk_expert.h"
#include "reference.h"
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The guard's fields; the larger one is not for brute force, which tests all of its two million triangles for each
 * ray, nor for the 3D grid, which takes long to build. */
static const char *const small_field = "65", *const large_field = "1025";
/* Fewer rays for slow work: brute force, and the flat walk on the larger field. */
enum { MOST_RAYS = 1 << 16, GUARD_RAYS = 1024, BRUTE_RAYS = 16, FLAT_RAYS = 256 };

static cw_ray rays[WORKLOAD_CLASS_COUNT][MOST_RAYS];
static cw_hit hits[MOST_RAYS];
static uint8_t occluded[MOST_RAYS];

typedef struct work {
    const char *name; /* of the field */
    cw_field *field;
    cw_run query;
    const cw_ray *rays;
    size_t counts[WORKLOAD_CLASS_COUNT], count;
    bool any;
    uint64_t hash;
} work;

/* callgrind finds this function by its name, so it must not be inlined. */
__attribute__((noinline)) cw_status guard_trace(const work *w);
cw_status guard_trace(const work *w) {
    return w->any ? cw_occluded(w->field, &w->query, w->rays, w->count, occluded)
                  : cw_closest(w->field, &w->query, w->rays, w->count, hits);
}

/* FNV-1a. A hit is 24 bytes without gaps, and all bytes of a miss are set. */
static void hash_answers(work *w) {
    const unsigned char *byte = w->any ? occluded : (const unsigned char *)hits;
    for (size_t left = w->count * (w->any ? 1 : sizeof *hits); left > 0; left--)
        w->hash = (w->hash ^ *byte++) * 0x100000001b3u;
}

/* most: of rays a class. */
static bool run(work *w, cw_leaf leaf, size_t most) {
    const cw_kernel_info info = cw_kernel_describe(w->query.expert.kernel);
    w->query.expert.leaf = leaf;
    if (cw_closest(w->field, &w->query, NULL, 0, NULL) == CW_ERROR_KERNEL) return true;
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
        w->rays = rays[c];
        w->count = w->counts[c];
        if (w->count > most) w->count = most;
        w->any = workload_class_is_any((workload_class)c);
        if (guard_trace(w) != CW_OK) return false;
        hash_answers(w);
        printf("run,%s,%s,%s,%s,%zu\n", info.name, cw_leaf_name(leaf), w->name, workload_class_name((workload_class)c),
               w->count);
    }
    return true;
}

static bool run_guard(work *w, bool small) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        w->query.expert.kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(w->query.expert.kernel);
        if (!info.available && small) printf("absent,%s,%s\n", info.name, cw_isa_name(info.isa));
        const bool brute = strcmp(info.name, "brute") == 0, dear = brute || strncmp(info.name, "grid3d", 6) == 0;
        if (!info.available || (!small && dear)) continue;
        if (cw_field_build(w->field, &(cw_run){.expert.kernel = w->query.expert.kernel}) != CW_OK) return false;
        const size_t most = brute ? BRUTE_RAYS : small || strncmp(info.name, "pyramid", 7) == 0 ? SIZE_MAX : FLAT_RAYS;
        for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++)
            if (!run(w, (cw_leaf)leaf, most)) return false;
    }
    return true;
}

static bool run_kernel(work *w, const char *kernel) {
    w->query.expert.kernel = cw_kernel_find(kernel);
    if (cw_field_build(w->field, &(cw_run){.expert.kernel = w->query.expert.kernel}) != CW_OK ||
        !run(w, cw_kernel_describe(w->query.expert.kernel).default_leaf, SIZE_MAX))
        return false;
    fprintf(stderr, "%016" PRIx64 "\n", w->hash);
    return true;
}

/* Runs a kernel, or the guard's where it is NULL, on rays over the field. */
static bool run_field(const char *field, size_t most, const char *kernel) {
    work w = {.name = field, .hash = 0xcbf29ce484222325u};
    workload_field samples;
    bool good =
        workload_field_make(field, &samples) && workload_field_open(&samples, CW_BORROW, false, &w.field) == CW_OK;
    for (int c = 0; good && c < WORKLOAD_CLASS_COUNT; c++) {
        w.counts[c] = workload_rays_make(w.field, (workload_class)c, 1, most, rays[c]);
        good = w.counts[c] > 0;
    }
    good = good && (kernel ? run_kernel(&w, kernel) : run_guard(&w, field == small_field));
    cw_field_destroy(w.field);
    workload_field_free(&samples);
    return good;
}

int main(int argc, char **argv) {
    cw_reference_add();
    const size_t most = argc == 4 ? strtoul(argv[3], NULL, 10) : GUARD_RAYS;
    if ((argc != 1 && argc != 4) || most == 0 || most > MOST_RAYS) {
        fprintf(stderr, "Usage: cellwalk-counted-work [KERNEL FIELD RAYS]\nAt most %d rays.\n", MOST_RAYS);
        return 2;
    }
    const bool good = argc == 4 ? run_field(argv[2], most, argv[1])
                                : run_field(small_field, most, NULL) && run_field(large_field, most, NULL);
    if (!good) fputs("the work that is counted does not run\n", stderr);
    return good && fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
