/* SPDX-License-Identifier: Apache-2.0 */
#include "as_cell.h"

#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t as_cell_differ(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, const cw_hit *expected) {
    cw_hit *hits = malloc((n + 1) * sizeof *hits);
    uint8_t *occluded = malloc(n + 1);
    assert_true(hits != NULL && occluded != NULL);
    check_status(cw_closest(field, run, rays, n, hits), CW_OK);
    check_status(cw_occluded(field, run, rays, n, occluded), CW_OK);
    size_t count = 0;
    for (size_t k = 0; k < n; k++) {
        if (hit_same(&hits[k], &expected[k]) && occluded[k] == (expected[k].i >= 0)) continue;
        if (count++ > 0) continue;
        const char *name = cw_kernel_describe(run->expert.kernel).name;
        printf("%s with leaf test %s, ray %zu of %zu:\n", name, cw_leaf_name(run->expert.leaf), k, n);
        ray_print(&rays[k]);
        hit_print("expected", &expected[k]);
        hit_print(name, &hits[k]);
        printf("any hit: %d\n", occluded[k]);
    }
    free(hits);
    free(occluded);
    return count;
}

void as_cell_check(cw_field *field, const cw_ray *rays, size_t n, as_cell_counts *counts) {
    cw_hit *expected = malloc(n * sizeof *expected);
    assert_non_null(expected);
    cw_run run = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = CW_LEAF_WATERTIGHT};
    check_status(cw_closest(field, &run, rays, n, expected), CW_OK);
    for (size_t k = 0; k < n; k++) counts->hits += expected[k].i >= 0;
    counts->rays += n;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (strncmp(info.name, "pyramid", 7) != 0 || !info.available) continue;
        run.expert.kernel = cw_kernel_at(k);
        check_status(cw_field_build(field, &run), CW_OK);
        check(as_cell_differ(field, &run, rays, n, expected) == 0, "%s differs from cell", info.name);
        counts->kernels++;
    }
    free(expected);
}
