/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include "check.h"

#include <string.h>

/* Each kernel that is available takes part, all but the references by the strict rules, and "cell", with which others are compared, by two
 * leaf tests: forget one and tests prove less than they say. */
size_t paths_find(path paths[PATHS_MAX]) {
    size_t n = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(kernel);
        const bool strict = info.default_leaf == CW_LEAF_WATERTIGHT;
        const bool own_rules = strcmp(info.name, "brute") == 0 || strcmp(info.name, "grid3d") == 0;
        const size_t before = n, least = strcmp(info.name, "cell") == 0 ? 2 : info.available;
        for (cw_leaf leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_run query = {.expert.kernel = kernel, .expert.leaf = leaf};
            if (cw_run_check(NULL, &query) != CW_OK) continue;
            check(n < PATHS_MAX, "too many kernels");
            paths[n++] = (path){query, info.name, leaf, strict};
        }
        check(n - before >= least && strict != own_rules, "%s takes part %zu times", info.name, n - before);
    }
    return n;
}
