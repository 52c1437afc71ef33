/* SPDX-License-Identifier: Apache-2.0 */
#include "query_options.h"

#include "command.h"

void query_options_rows(query_options *q, option_spec rows[QUERY_OPTION_COUNT]) {
    *q = (query_options){-1, -1, -1, 0};
    rows[QUERY_KERNEL] =
        option_choice("kernel", "NAME", &q->kernel, option_kernel_names,
                      "the kernel that finds hits; `cellwalk info` explains them (default: the best for this CPU)");
    rows[QUERY_LEAF] = option_choice("leaf", "NAME", &q->leaf, option_leaf_names,
                                     "the test of a ray against a cell (default: as `cellwalk info` shows)");
    rows[QUERY_ISA] = option_choice("isa", "NAME", &q->isa, option_isa_names,
                                    "the highest instruction set to use, up to that of the variable CELLWALK_ISA");
    rows[QUERY_THREADS] =
        option_count("threads", "N", &q->threads, 0, 4096, "number of threads; 0: one for each CPU (default)");
}

bool query_options_resolve(const query_options *q, const char *name, cw_run *query) {
    *query = (cw_run){0};
    if (!option_isa_environment(name) || (q->isa >= 0 && !option_isa_limit(name, CW_ISA_SCALAR + (cw_isa)q->isa)))
        return false;
    if (q->kernel >= 0) query->expert.kernel = cw_kernel_at((size_t)q->kernel);
    if (q->leaf >= 0) query->expert.leaf = (cw_leaf)q->leaf;
    const cw_kernel_info info = cw_kernel_describe(query->expert.kernel);
    if (q->kernel >= 0 && !info.available)
        return command_refuse(name,
                              "--kernel %s needs %s; this machine, or the limit set by --isa or CELLWALK_ISA, has %s",
                              info.name, cw_isa_name(info.isa), cw_isa_name(cw_isa_best()));
    return cw_run_check(NULL, query) == CW_OK || command_refuse(name, "%s", cw_last_error());
}
