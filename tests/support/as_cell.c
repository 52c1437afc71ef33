/* SPDX-License-Identifier: Apache-2.0 */
#include "as_cell.h"

#include "check.h"
#include "rays.h"

#include <stdlib.h>
#include <string.h>

typedef struct answers {
    cw_hit *expected, *hits;
    uint8_t *occluded;
} answers;

static void compare(const cw_field *field, const cw_kernel *kernel, const cw_ray *rays, size_t n, answers *a) {
    const cw_run run = {.kernel = kernel, .leaf = CW_LEAF_WATERTIGHT};
    const char *name = cw_kernel_describe(kernel).name;
    check_status(cw_closest(field, &run, rays, n, a->hits), CW_OK);
    check_status(cw_occluded(field, &run, rays, n, a->occluded), CW_OK);
    for (size_t k = 0; k < n; k++) {
        const bool same = hit_same(&a->hits[k], &a->expected[k]), any = a->occluded[k] == (a->expected[k].i >= 0);
        if (same && any) continue;
        ray_print(&rays[k]);
        hit_print("cell", &a->expected[k]);
        hit_print(name, &a->hits[k]);
        check(false, "%s: ray %zu of %zu differs from cell, any hit says %d", name, k, n, a->occluded[k]);
    }
}

void as_cell_check(cw_field *field, const cw_ray *rays, size_t n, as_cell_counts *counts) {
    answers a = {malloc(n * sizeof *a.expected), malloc(n * sizeof *a.hits), malloc(n)};
    assert_true(a.expected != NULL && a.hits != NULL && a.occluded != NULL);
    const cw_run plain = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    check_status(cw_closest(field, &plain, rays, n, a.expected), CW_OK);
    for (size_t k = 0; k < n; k++) counts->hits += a.expected[k].i >= 0;
    counts->rays += n;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(kernel);
        if (strncmp(info.name, "pyramid", 7) != 0 || !info.available) continue;
        check_status(cw_field_build(field, &(cw_run){.kernel = kernel}), CW_OK);
        compare(field, kernel, rays, n, &a);
        counts->kernels++;
    }
    free(a.expected);
    free(a.hits);
    free(a.occluded);
}
