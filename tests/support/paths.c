/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include <fnmatch.h>
#include <string.h>

path paths[PATHS_MAX];
size_t path_count;

/* Each kernel that is available takes part, all but the references by the strict rules, and "cell", with which others
 * are compared, by two leaf tests: forget one and tests prove less than they say. */
static int paths_find(void **state) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(kernel);
        const bool strict = info.default_leaf == CW_LEAF_WATERTIGHT;
        const bool own_rules = strcmp(info.name, "brute") == 0 || strcmp(info.name, "grid3d") == 0;
        const size_t before = path_count, least = strcmp(info.name, "cell") == 0 ? 2 : info.available;
        for (cw_leaf leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_run query = {.expert.kernel = kernel, .expert.leaf = leaf};
            if (cw_run_check(NULL, &query) != CW_OK) continue;
            check(path_count < PATHS_MAX, "too many kernels");
            paths[path_count++] = (path){query, info.name, leaf, strict};
        }
        check(path_count - before >= least && strict != own_rules, "%s takes part %zu times", info.name,
              path_count - before);
    }
    return 0;
}

int paths_run(const char *name, struct CMUnitTest *rows, size_t n, int argc, char **argv) {
    size_t chosen = 0;
    for (size_t k = 0; k < n; k++) {
        bool in = argc == 1;
        for (int a = 1; a < argc; a++) in |= fnmatch(argv[a], rows[k].name, 0) == 0;
        if (in) rows[chosen++] = rows[k];
    }
    if (chosen > 0) return _cmocka_run_group_tests(name, rows, chosen, paths_find, NULL);
    print_error("%s: no row has a name like that\n", name);
    return EXIT_FAILURE;
}
