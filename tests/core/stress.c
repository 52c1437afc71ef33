/* SPDX-License-Identifier: Apache-2.0 */
/* The flat walk from cell to cell against all other walks, on the benchmark's classes of rays: other land each round, and
 * each ray has to get the same bits from every kernel with either leaf test, and the same answer from any hit. A round
 * takes RAYS rays a class; CELLWALK_TEST_ROUNDS=170 takes more than 10^7. With CELLWALK_TEST_COUNTS = FILE the counts are
 * kept for papers/robustness.md. */

#include "as_cell.h"
#include "check.h"
#include "paths.h"

#include "workload/fractal_terrain.h"
#include "workload/ray_classes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 61440 / WORKLOAD_TILE * WORKLOAD_TILE };

/* Land of several levels of the pyramid, whose last blocks stick out; one that is long, one small and steep; water. */
static const struct {
    size_t nx, ny;
    float relief, roughness; /* land, or water if relief is 0 */
} shapes[] = {{257, 257, 0.1f, 0}, {1023, 310, 0.1f, 0}, {39, 66, 0.6f, 0}, {500, 500, 0, 0.5f}};
enum { SHAPES = sizeof shapes / sizeof shapes[0] };

typedef struct count {
    uint64_t rays, hits, answers, other; /* answers: by all kernels but cell; other: with other bits */
} count;

static cw_field *make_field(size_t round) {
    const size_t nx = shapes[round % SHAPES].nx, ny = shapes[round % SHAPES].ny;
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    if (shapes[round % SHAPES].relief > 0)
        terrain_fractal(z, nx, ny, (uint32_t)round, shapes[round % SHAPES].relief);
    else
        terrain_sea(z, nx, ny, (uint32_t)round, shapes[round % SHAPES].roughness);
    cw_field_desc d = {0};
    d.samples = z;
    d.nx = nx;
    d.ny = ny;
    cw_field *field;
    check_status(cw_field_create(&d, NULL, &field), CW_OK);
    free(z);
    return field;
}

typedef struct work {
    cw_ray rays[RAYS];
    cw_hit expected[RAYS];
} work;

static void compare_class(work *w, const cw_field *field, const path *paths, size_t path_count, workload_class class,
                          uint32_t seed, count *c) {
    const size_t wanted = test_share(RAYS, RAYS / 64) / WORKLOAD_TILE * WORKLOAD_TILE;
    const size_t n = workload_rays_make(field, class, seed, wanted, w->rays);
    check(n > 0, "no %s rays", workload_class_name(class));
    c->rays += n;
    for (size_t p = 0; p < path_count; p++) {
        if (strcmp(paths[p].name, "cell") != 0) continue;
        check_status(cw_closest(field, &paths[p].query, w->rays, n, w->expected), CW_OK);
        if (paths[p].leaf == CW_LEAF_WATERTIGHT)
            for (size_t k = 0; k < n; k++) c->hits += w->expected[k].i >= 0;
        for (size_t q = 0; q < path_count; q++)
            if (paths[q].strict && q != p && paths[q].leaf == paths[p].leaf) {
                c->other += as_cell_differ(field, &paths[q].query, w->rays, n, w->expected);
                c->answers += n;
            }
    }
}

static bool keep(const count counts[WORKLOAD_CLASS_COUNT]) {
    const char *where = getenv("CELLWALK_TEST_COUNTS");
    if (where == NULL) return true;
    FILE *to = fopen(where, "w");
    if (to == NULL) return false;
    bool good = fputs("{\"kind\": \"run\", \"command\": \"stress\"}\n", to) >= 0;
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++)
        good = fprintf(to,
                       "{\"kind\": \"stress\", \"rays\": \"%s\", \"traced\": %llu, \"hits\": %llu, \"answers\": %llu, "
                       "\"other_bits\": %llu}\n",
                       workload_class_name((workload_class)c), (unsigned long long)counts[c].rays,
                       (unsigned long long)counts[c].hits, (unsigned long long)counts[c].answers,
                       (unsigned long long)counts[c].other) > 0 &&
               good;
    return fclose(to) == 0 && good;
}

static void test_walks_agree(void **state) {
    (void)state;
    path paths[PATHS_MAX];
    const size_t path_count = paths_find(paths);
    count counts[WORKLOAD_CLASS_COUNT] = {{0}};
    work *w = malloc(sizeof *w);
    assert_non_null(w);
    for (size_t round = 0; round < test_rounds(); round++) {
        cw_field *field = make_field(round);
        for (size_t p = 0; p < path_count; p++)
            check_status(cw_field_build(field, &(cw_run){.expert.kernel = paths[p].query.expert.kernel}), CW_OK);
        for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++)
            compare_class(w, field, paths, path_count, (workload_class)c, (uint32_t)round, &counts[c]);
        cw_field_destroy(field);
    }
    free(w);
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
        printf("%-8s %10llu rays, %10llu hits, %12llu answers, %llu with other bits\n",
               workload_class_name((workload_class)c), (unsigned long long)counts[c].rays,
               (unsigned long long)counts[c].hits, (unsigned long long)counts[c].answers,
               (unsigned long long)counts[c].other);
        check(counts[c].other == 0, "%s: walks differ", workload_class_name((workload_class)c));
        check(counts[c].hits > counts[c].rays / 50 && counts[c].answers >= counts[c].rays,
              "%s: too few hits or kernels for the test to mean anything", workload_class_name((workload_class)c));
    }
    check(keep(counts), "%s: %s", getenv("CELLWALK_TEST_COUNTS"), strerror(errno));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_walks_agree)};
    return cmocka_run_group_tests_name("stress", tests, NULL, NULL);
}
