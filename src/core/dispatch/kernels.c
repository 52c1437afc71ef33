/* SPDX-License-Identifier: Apache-2.0 */
#include "kernels.h"

#include "field.h"
#include "isa.h"
#include "run.h"
#include "visible.h"

#include <string.h>

#if CELLWALK_SIMD && defined(__aarch64__)
#define NEON 1
#else
#define NEON 0
#endif

/* From the plainest to the fastest: the last one available is the default. */
/* clang-format off */
static const cw_kernel kernels[] = {
    {"brute", "every triangle: the ground truth for small fields", CW_ISA_SCALAR, 1, 0, &cw_brute, cw_heading1, &cw_visible1},
    {"grid3d", "uniform 3D grid, 3D-DDA", CW_ISA_SCALAR, 1, CW_NEEDS_GRID3D, &cw_grid3d, cw_heading1, &cw_visible1},
    {"cell", "2D cell walk, one ray at a time", CW_ISA_SCALAR, 1, 0, &cw_cell, cw_heading1, &cw_visible1},
#if NEON
    {"packet4", "2D cell walk, 4 rays at once", CW_ISA_NEON, 4, 0, &cw_packet4, cw_heading4, &cw_visible4},
#elif CELLWALK_SIMD
    {"packet4", "2D cell walk, 4 rays at once", CW_ISA_SSE42, 4, 0, &cw_packet4, cw_heading4, &cw_visible4},
    {"packet8", "2D cell walk, 8 rays at once", CW_ISA_AVX2, 8, 0, &cw_packet8, cw_heading8, &cw_visible8},
    {"packet16", "2D cell walk, 16 rays at once", CW_ISA_AVX512, 16, 0, &cw_packet16, cw_heading16, &cw_visible16},
#endif
    {"pyramid1", "bounds pyramid, one lane", CW_ISA_SCALAR, 1, CW_NEEDS_PYRAMID, &cw_pyramid1, cw_heading1, &cw_visible1},
#if NEON
    {"pyramid4", "bounds pyramid, 4 lanes, single rays in pairs of 4", CW_ISA_NEON, 8, CW_NEEDS_PYRAMID, &cw_pyramid4, cw_heading4, &cw_visible4},
#elif CELLWALK_SIMD
    {"pyramid4", "bounds pyramid, 4 lanes, single rays in pairs of 4", CW_ISA_SSE42, 8, CW_NEEDS_PYRAMID, &cw_pyramid4, cw_heading4, &cw_visible4},
    {"pyramid8", "bounds pyramid, 8 lanes, single rays in pairs of 8",
     CW_ISA_AVX2, 16, CW_NEEDS_PYRAMID, &cw_pyramid8, cw_heading8, &cw_visible8},
    {"pyramid16", "bounds pyramid, 16 lanes, single rays in pairs of 16",
     CW_ISA_AVX512, 32, CW_NEEDS_PYRAMID, &cw_pyramid16, cw_heading16, &cw_visible16},
#endif
};
/* clang-format on */
enum { KERNEL_COUNT = sizeof kernels / sizeof kernels[0] };

const cw_kernel cw_kernel_none = {.name = "none", .what = "there is no kernel of that name"};

size_t cw_kernel_count(void) { return KERNEL_COUNT; }

const cw_kernel *cw_kernel_at(size_t number) { return number < KERNEL_COUNT ? &kernels[number] : NULL; }

const cw_kernel *cw_kernel_find(const char *name) {
    for (size_t k = 0; name && k < KERNEL_COUNT; k++)
        if (strcmp(name, kernels[k].name) == 0) return &kernels[k];
    return &cw_kernel_none;
}

cw_leaf cw_kernel_default_leaf(const cw_kernel *kernel) {
    return kernel->code->closest[CW_LEAF_WATERTIGHT] ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE;
}

bool cw_kernel_exists(const cw_kernel *kernel) { return kernel != NULL && kernel != &cw_kernel_none; }

void cw_kernel_describe_into(const cw_kernel *kernel, cw_kernel_info *info, size_t size) {
    const cw_kernel *k = kernel ? kernel : &cw_kernel_none;
    cw_kernel_info all = {.name = k->name, .what = k->what};
    if (cw_kernel_exists(kernel)) {
        all.isa = k->isa;
        all.width = k->width;
        all.needs_build = k->needs != 0;
        all.available = cw_isa_allows(k->isa);
        all.default_leaf = cw_kernel_default_leaf(k);
    }
    cw_fill(info, size, &all, sizeof all);
}

const char *cw_leaf_name(cw_leaf leaf) {
    static const char *const names[CW_LEAF_COUNT] = {"default", "moller-trumbore", "watertight"};
    return (unsigned)leaf < CW_LEAF_COUNT ? names[leaf] : NULL;
}

const cw_kernel *cw_run_kernel(const cw_field *field, const cw_run *run) {
    if (run && run->kernel) return run->kernel;
    for (size_t k = KERNEL_COUNT - 1; k > 0; k--) {
        if (!cw_isa_allows(kernels[k].isa)) continue;
        if ((kernels[k].needs & CW_NEEDS_PYRAMID) && field && !field->pyramid) continue;
        if (!(kernels[k].needs & CW_NEEDS_GRID3D)) return &kernels[k];
    }
    return &kernels[0];
}
