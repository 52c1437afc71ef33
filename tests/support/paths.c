/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include "check.h"

#include <string.h>

/* Each kernel that is available has at least one path, and "cell", with which others are compared, has two. */
static void check_paths(const path *paths, size_t n) {
    size_t kernels = 0, found = 0, cell = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) kernels += cw_kernel_describe(cw_kernel_at(k)).available;
    for (size_t p = 0; p < n; p++) {
        found += p == 0 || paths[p].query.expert.kernel != paths[p - 1].query.expert.kernel;
        cell += strcmp(paths[p].name, "cell") == 0;
    }
    check(found == kernels && cell == 2, "%zu kernels of %zu, cell with %zu leaf tests", found, kernels, cell);
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
