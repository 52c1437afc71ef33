/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/choices.h"

#include "workload/fields.h"

#include <string.h>

bool choices_kernels(option_list *kernels, io_error *error) {
    const char *names[OPTION_LIST_MAX];
    size_t count = 0;
    for (; count < cw_kernel_count() && count < OPTION_LIST_MAX; count++)
        names[count] = cw_kernel_describe(cw_kernel_at(count)).name;
    return options_check_names(kernels, "--kernel", names, count, 0, error);
}

bool choices_fields(option_list *fields, size_t by_default, io_error *error) {
    const char *names[OPTION_LIST_MAX];
    size_t count = 0;
    for (; count < workload_field_count() && count < OPTION_LIST_MAX; count++)
        names[count] = workload_field_name(count);
    return options_check_names(fields, "--field", names, count, by_default < count ? by_default : count, error);
}

bool choices_isa(const char *name, cw_isa *isa, io_error *error) {
    const cw_isa best = cw_isa_best();
    *isa = best;
    if (name == NULL) return true;
    for (int k = CW_ISA_SCALAR; k <= CW_ISA_AVX512; k++) {
        if (strcmp(name, cw_isa_name((cw_isa)k)) != 0) continue;
        *isa = (cw_isa)k;
        return *isa <= best || io_fail(error, "--isa %s: this machine, or CELLWALK_ISA, allows no more than %s", name,
                                       cw_isa_name(best));
    }
    return io_fail(error, "--isa %s: must be scalar, sse4.2, avx2 or avx512", name);
}
