/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include "check.h"

#include <string.h>

/* Each kernel that is available takes part, all but the references by the strict rules, and "cell", with which others are compared, by two
 * leaf tests: forget one and tests prove less than they say. */
static void check_paths(const path *paths, size_t n) {
    size_t strict = 0, own_rules = 0, cell = 0;
    for (size_t p = 0; p < n; p++) {
        const bool again = p > 0 && paths[p].query.expert.kernel == paths[p - 1].query.expert.kernel;
        own_rules += !again && (strcmp(paths[p].name, "brute") == 0 || strcmp(paths[p].name, "grid3d") == 0);
        strict += !again && paths[p].strict;
        cell += strcmp(paths[p].name, "cell") == 0;
    }
    size_t available = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) available += cw_kernel_describe(cw_kernel_at(k)).available;
    check(own_rules == 2 && strict == available - 2 && strict >= 2 && cell == 2,
          "%zu kernels: %zu strict ones, cell with %zu leaf tests", available, strict, cell);
}

size_t paths_find(path paths[PATHS_MAX]) {
    size_t n = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++)
        for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_kernel *kernel = cw_kernel_at(k);
            const cw_kernel_info info = cw_kernel_describe(kernel);
            const bool strict = info.default_leaf == CW_LEAF_WATERTIGHT;
            if (cw_run_check(NULL, &(cw_run){.expert.kernel = kernel, .expert.leaf = (cw_leaf)leaf}) != CW_OK) continue;
            check(n < PATHS_MAX, "too many kernels");
            paths[n++] = (path){.query = {.expert.kernel = kernel, .expert.leaf = (cw_leaf)leaf},
                                .name = info.name,
                                .leaf = (cw_leaf)leaf,
                                .strict = strict};
        }
    check_paths(paths, n);
    return n;
}
