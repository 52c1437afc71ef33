/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include "check.h"

#include <string.h>

size_t paths_find(path paths[PATHS_MAX]) {
    size_t n = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++)
        for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_kernel *kernel = cw_kernel_at(k);
            const cw_kernel_info info = cw_kernel_describe(kernel);
            const bool strict = info.default_leaf == CW_LEAF_WATERTIGHT;
            if (!info.available || (leaf == CW_LEAF_WATERTIGHT && !strict)) continue;
            check(n < PATHS_MAX, "too many kernels");
            paths[n++] = (path){.query = {.kernel = kernel, .leaf = (cw_leaf)leaf},
                                .name = info.name,
                                .leaf = (cw_leaf)leaf,
                                .strict = strict,
                                .early = strcmp(info.name, "grid3d-early") == 0};
        }
    return n;
}
