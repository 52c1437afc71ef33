/* SPDX-License-Identifier: Apache-2.0 */
#include "kernels.h"

#include "field.h"
#include "run.h"

#include <string.h>

/* For few rays. Of 16 lanes half would be empty, and they take more of the stack. */
#define FEW_4  .if_short = {cw_short4, cw_short4}, .few = &cw_pyramid4
#define FEW_8  .if_short = {cw_short4, cw_short8}, .few = &cw_pyramid8
#define FEW_16 FEW_8

/* From the plainest to the fastest: the last one available is the default. */
/* clang-format off */
static const cw_kernel kernels[] = {
    {"cell", "2D cell walk, one ray at a time", CW_ISA_SCALAR, 1, &cw_cell, .to_field = cw_to_field1},
#define KERNEL(set, lanes) \
    {"packet" #lanes, "2D cell walk, " #lanes " rays at once", CW_ISA_##set, lanes, &cw_packet##lanes, \
     .to_field = cw_to_field##lanes},
    CELLWALK_KERNELS /* KERNEL(set, lanes) for each row of simd/isas.cmake but the scalar one */
#undef KERNEL
    {"pyramid1", "bounds pyramid, one lane", CW_ISA_SCALAR, 1, &cw_pyramid1, cw_to_field1, cw_one1,
     .few = &cw_pyramid1},
#define KERNEL(set, lanes) \
    {"pyramid" #lanes, "bounds pyramid, " #lanes " lanes, single rays in pairs of " #lanes, \
     CW_ISA_##set, 2 * lanes, &cw_pyramid##lanes, cw_to_field##lanes, cw_one##lanes, FEW_##lanes},
    CELLWALK_KERNELS
#undef KERNEL
};
/* clang-format on */
enum { KERNEL_COUNT = sizeof kernels / sizeof kernels[0] };

const cw_kernel cw_kernel_none = {.name = "none", .what = "there is no kernel of that name"};

static const cw_kernel *added;
static size_t added_count;

void cw_kernels_add(const cw_kernel *first, size_t count) {
    added = first;
    added_count = count;
}

size_t cw_kernel_count(void) { return added_count + KERNEL_COUNT; }

const cw_kernel *cw_kernel_at(size_t number) {
    if (number < added_count) return &added[number];
    return number - added_count < KERNEL_COUNT ? &kernels[number - added_count] : NULL;
}

const cw_kernel *cw_kernel_find(const char *name) {
    for (size_t k = 0; name && k < cw_kernel_count(); k++)
        if (strcmp(name, cw_kernel_at(k)->name) == 0) return cw_kernel_at(k);
    return &cw_kernel_none;
}

cw_leaf cw_kernel_default_leaf(const cw_kernel *kernel) {
    return kernel->code->trace[CW_LEAF_WATERTIGHT] ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE;
}

bool cw_kernel_exists(const cw_kernel *kernel) { return kernel != NULL && kernel != &cw_kernel_none; }

void cw_kernel_describe_into(const cw_kernel *kernel, cw_kernel_info *info, size_t size) {
    const cw_kernel *k = kernel ? kernel : &cw_kernel_none;
    cw_kernel_info all = {.name = k->name, .what = k->what};
    if (cw_kernel_exists(kernel)) {
        all.isa = k->isa;
        all.width = k->width;
        all.needs_build = k->build != NULL;
        all.available = cw_isa_includes(cw_isa_best(), k->isa);
        all.default_leaf = cw_kernel_default_leaf(k);
    }
    cw_fill(info, size, &all, sizeof all);
}

const char *cw_leaf_name(cw_leaf leaf) {
    static const char *const names[CW_LEAF_COUNT] = {"default", "moller-trumbore", "watertight"};
    return (uint32_t)leaf < CW_LEAF_COUNT ? names[leaf] : NULL;
}

const cw_kernel *cw_kernel_default(cw_isa isa) {
    size_t k = KERNEL_COUNT - 1;
    while (k > 0 && !cw_isa_includes(isa, kernels[k].isa)) k--;
    return &kernels[k];
}
