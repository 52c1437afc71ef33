/* SPDX-License-Identifier: Apache-2.0 */
/* Counts of the counting kernels where they can be told beforehand, and bounds that hold where they cannot. */
#include "micro/counters.h"
#include "micro/micro.h"

#include "check.h"

#include <stdlib.h>
#include <string.h>

enum { CELLS_X = 32, CELLS_Y = 8, LANES_MAX = 16 };

/* Flat at 0 but for one sample in a corner, so that a ray at height 0.5 has to be walked and meets nothing. */
static cw_field *spike(void) {
    static float z[(CELLS_Y + 1) * (CELLS_X + 1)];
    z[0] = 1;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = CELLS_X + 1;
    desc.ny = CELLS_Y + 1;
    cw_field *field = NULL;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    return field;
}

static void trace(const cw_field *field, const cw_kernel *kernel, const cw_ray *rays, size_t n,
                  counter counts[COUNTERS_MAX]) {
    const cw_run query = {.kernel = kernel};
    cw_hit hits[LANES_MAX];
    counters_reset();
    check_status(cw_closest(field, &query, rays, n, hits), CW_OK);
    counters_read(counts);
}

/* The counter of that name in an array of all; it must be one of them. */
static const counter *find(const counter *all, const char *name) {
    size_t k = 0;
    while (strcmp(counters_name(k), name) != 0) k++;
    return &all[k];
}

static void expect(const counter *counts, const char *kernel, const char *name, uint64_t events, uint64_t lanes) {
    const counter *c = find(counts, name);
    check(c->events == events && c->lanes == lanes, "%s: %s counts %d events with %d lanes, not %d with %d", kernel,
          name, (int)c->events, (int)c->lanes, (int)events, (int)lanes);
}

static void these_kernels_count(void **state) {
    (void)state;
    check(counters_here(), "linked without the counting objects");
}

static void cell_walks_take_a_step_a_cell(void **state) {
    (void)state;
    cw_field *field = spike();
    static const char *const kernels[] = {"cell", "packet4", "packet8", "packet16"};
    for (size_t k = 0; k < sizeof kernels / sizeof kernels[0]; k++) {
        const cw_kernel *kernel = cw_kernel_find(kernels[k]);
        if (!cw_kernel_describe(kernel).available) continue;
        const size_t width = cw_kernel_describe(kernel).width;
        cw_ray across[LANES_MAX], down[LANES_MAX];
        for (size_t n = 0; n < LANES_MAX; n++) {
            across[n] = (cw_ray){.org = {-1, 4.5f, 0.5f}, .dir = {1, 0, 0}, .tmax = 100};
            down[n] = (cw_ray){.org = {7.5f, 4.25f, 2}, .dir = {0, 0, -1}, .tmax = 100};
        }
        counter counts[COUNTERS_MAX];
        trace(field, kernel, across, width, counts);
        expect(counts, kernels[k], "flat", CELLS_X, CELLS_X * width);
        expect(counts, kernels[k], "leaf", 0, 0);
        trace(field, kernel, down, width, counts);
        expect(counts, kernels[k], "flat", 1, width);
        expect(counts, kernels[k], "leaf", 1, width);
        expect(counts, kernels[k], "node", 0, 0);
    }
    cw_field_destroy(field);
}

static void grids_test_each_triangle_of_a_voxel(void **state) {
    (void)state;
    static const float z[4] = {0, 0, 0, 0}; /* one cell: two triangles, both listed in every voxel that the ray meets */
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = 2;
    cw_field *field = NULL;
    const cw_kernel *kernel = cw_kernel_find("grid3d");
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_field_build(field, &(cw_run){.kernel = kernel}), CW_OK);
    const cw_ray down = {.org = {0.5f, 0.5f, 2}, .dir = {0, 0, -1}, .tmax = 100};
    counter counts[COUNTERS_MAX];
    trace(field, kernel, &down, 1, counts);
    expect(counts, "grid3d", "voxel", 1, 1);
    expect(counts, "grid3d", "triangle", 2, 2);
    cw_field_destroy(field);
}

/* A box of 8 × 8 × 8 cells has 15 voxels an axis: 3 · cbrt(128) / 8 a cell. */
static void grids_step_from_voxel_to_voxel(void **state) {
    (void)state;
    enum { SIDE = 9 };
    static float z[SIDE * SIDE];
    z[SIDE * SIDE - 1] = 8;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = SIDE;
    cw_field *field = NULL;
    const cw_kernel *kernel = cw_kernel_find("grid3d");
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_field_build(field, &(cw_run){.kernel = kernel}), CW_OK);
    static const cw_ray rays[] = {
        {{-1, 0.3f, 4}, 0, {1, 0, 0}, 99},    /* over low ground: a row of voxels with nothing in them */
        {{2.6f, 3.3f, 9}, 0, {0, 0, -1}, 99}, /* down a column of them to the ground */
        {{-1, 0.3f, 9}, 0, {1, 0, 0}, 99},    /* over everything */
    };
    static const uint64_t voxels[] = {15, 15, 0};
    for (size_t k = 0; k < 3; k++) {
        counter counts[COUNTERS_MAX];
        trace(field, kernel, &rays[k], 1, counts);
        expect(counts, "grid3d", "voxel", voxels[k], voxels[k]);
        check((find(counts, "triangle")->events > 0) == (k == 1), "ray %zu: %d triangles", k,
              (int)find(counts, "triangle")->events);
    }
    cw_field_destroy(field);
}

/* Whatever the walk, no more lanes are busy than there are, each hit had a leaf test, and no ray is refilled twice. */
static void lanes_are_within_bounds(void **state) {
    (void)state;
    enum { RAYS = 4096 };
    workload_field samples;
    assert_true(workload_field_make("65", &samples));
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples.z;
    desc.nx = samples.nx;
    desc.ny = samples.ny;
    cw_field *field = NULL;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    cw_ray *rays = malloc(RAYS * sizeof *rays);
    cw_hit *hits = malloc(RAYS * sizeof *hits);
    assert_true(rays && hits);
    bool streamed = false, shared = false;
    for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
        const size_t n = workload_rays_make(field, (workload_class)c, 1, RAYS, rays);
        for (size_t k = 0; k < cw_kernel_count(); k++) {
            const cw_kernel *kernel = cw_kernel_at(k);
            const cw_kernel_info info = cw_kernel_describe(kernel);
            if (!info.available || strncmp(info.name, "pyramid", 7) != 0) continue;
            const cw_run query = {.kernel = kernel};
            counter all[COUNTERS_MAX];
            counters_reset();
            check_status(cw_closest(field, &query, rays, n, hits), CW_OK);
            counters_read(all);
            static const char *const walks[] = {"flat", "stream", "node", "round", "reload", "leaf"};
            for (size_t w = 0; w < sizeof walks / sizeof walks[0]; w++) {
                const counter *one = find(all, walks[w]);
                check(one->lanes <= one->events * info.width, "%s, %s: %d lanes in %d events", info.name, walks[w],
                      (int)one->lanes, (int)one->events);
            }
            size_t found = 0;
            for (size_t r = 0; r < n; r++) found += hits[r].i >= 0;
            check(find(all, "leaf")->lanes >= found, "%s: %zu hits from %d leaf tests", info.name, found,
                  (int)find(all, "leaf")->lanes);
            const counter *refill = find(all, "refill"), *groups = find(all, "shared");
            const counter *apart = find(all, "apart");
            check(groups->lanes <= n && apart->lanes <= groups->lanes &&
                      refill->events + groups->lanes <= n + apart->lanes,
                  "%s: %zu rays, but %d refills, %d that share and %d of them no more", info.name, n,
                  (int)refill->events, (int)groups->lanes, (int)apart->lanes);
            check(find(all, "stream")->events == find(all, "node")->events + find(all, "round")->events,
                  "%s: a turn of the lane walk that neither steps nor tests", info.name);
            streamed = streamed || refill->events > 0;
            shared = shared || groups->events > 0;
        }
    }
    check(streamed && shared, "no ray %s", streamed ? "shares a walk" : "walks in a lane");
    free(hits);
    free(rays);
    cw_field_destroy(field);
    workload_field_free(&samples);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(these_kernels_count),
        cmocka_unit_test(cell_walks_take_a_step_a_cell),
        cmocka_unit_test(grids_test_each_triangle_of_a_voxel),
        cmocka_unit_test(grids_step_from_voxel_to_voxel),
        cmocka_unit_test(lanes_are_within_bounds),
    };
    return cmocka_run_group_tests_name("bench_counters", tests, NULL, NULL);
}
