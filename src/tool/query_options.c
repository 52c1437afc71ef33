/* SPDX-License-Identifier: Apache-2.0 */
#include "query_options.h"

#include "command.h"
#include "words.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_MAX = 64 };

void query_options_rows(query_options *q, option_spec rows[QUERY_OPTION_COUNT]) {
    rows[QUERY_KERNEL] =
        option_word("kernel", "NAME", &q->kernel, option_kernel_names,
                    "the kernel that finds hits; `cellwalk info` explains them (default: the best for this CPU)");
    rows[QUERY_LEAF] = option_word("leaf", "NAME", &q->leaf, option_leaf_names,
                                   "the test of a ray against a cell (default: as `cellwalk info` shows)");
    rows[QUERY_ISA] = option_word("isa", "NAME", &q->isa, option_isa_names,
                                  "the highest instruction set to use, up to that of the variable CELLWALK_ISA");
    rows[QUERY_THREADS] =
        option_count("threads", "N", &q->threads, 0, 4096, "number of threads; 0: one for each CPU (default)");
}

static bool apply_isa(const query_options *q, const char *name) {
    cw_isa isa;
    if (!option_isa_environment(name)) return false;
    return q->isa == NULL || (option_isa_find(name, "--isa", q->isa, &isa) && option_isa_limit(name, isa));
}

static bool find_kernel(const char *name, const char *word, const cw_kernel **kernel) {
    *kernel = cw_kernel_find(word);
    if (!cw_kernel_exists(*kernel)) {
        const char *names[NAMES_MAX];
        size_t count = 0;
        for (; count < NAMES_MAX && count < cw_kernel_count(); count++)
            names[count] = cw_kernel_describe(cw_kernel_at(count)).name;
        return words_unknown(name, "--kernel", word, names, count);
    }
    const cw_kernel_info info = cw_kernel_describe(*kernel);
    if (info.available) return true;
    command_fail(name, "--kernel %s needs %s; this machine, or the limit set by --isa or CELLWALK_ISA, has %s", word,
                 cw_isa_name(info.isa), cw_isa_name(cw_isa_best()));
    return false;
}

static bool find_leaf(const char *name, const char *word, cw_leaf *leaf) {
    const char *names[CW_LEAF_COUNT];
    for (int k = 0; k < CW_LEAF_COUNT; k++) {
        names[k] = cw_leaf_name((cw_leaf)k);
        if (strcmp(word, names[k]) != 0) continue;
        *leaf = (cw_leaf)k;
        return true;
    }
    return words_unknown(name, "--leaf", word, names, CW_LEAF_COUNT);
}

static bool goes_together(const char *name, const cw_run *query) {
    if (cw_run_check(NULL, query) == CW_OK) return true;
    command_fail(name, "%s", cw_last_error());
    return false;
}

bool query_options_resolve(const query_options *q, const char *name, cw_run *query) {
    *query = (cw_run){0};
    if (!apply_isa(q, name)) return false;
    if (q->kernel && !find_kernel(name, q->kernel, &query->expert.kernel)) return false;
    if (q->leaf && !find_leaf(name, q->leaf, &query->expert.leaf)) return false;
    return goes_together(name, query);
}
