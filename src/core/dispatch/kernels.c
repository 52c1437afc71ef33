/* SPDX-License-Identifier: Apache-2.0 */
#include "kernels.h"

#include "field.h"
#include "isa.h"

#include <string.h>

/* From the plainest to the fastest: the last one available is the default. */
/* clang-format off */
static const cw_kernel kernels[] = {
    {"brute", "every triangle: the ground truth for small fields", CW_ISA_SCALAR, 1, 0, &cw_brute, NULL},
    {"grid3d-early", "uniform 3D grid, 3D-DDA; returns the first hit found, which may be a wrong one",
     CW_ISA_SCALAR, 1, CW_NEEDS_GRID3D, &cw_grid3d_early, NULL},
    {"grid3d", "uniform 3D grid, 3D-DDA", CW_ISA_SCALAR, 1, CW_NEEDS_GRID3D, &cw_grid3d, NULL},
    {"cell", "2D cell walk, one ray at a time", CW_ISA_SCALAR, 1, 0, &cw_cell, NULL},
    {"packet1", "2D cell walk, the packet kernel one ray wide", CW_ISA_SCALAR, 1, 0, &cw_packet1, NULL},
#if CELLWALK_SIMD
    {"packet4", "2D cell walk, 4 rays at once", CW_ISA_SSE42, 4, 0, &cw_packet4, NULL},
    {"packet8", "2D cell walk, 8 rays at once", CW_ISA_AVX2, 8, 0, &cw_packet8, NULL},
    {"packet16", "2D cell walk, 16 rays at once", CW_ISA_AVX512, 16, 0, &cw_packet16, NULL},
#endif
    {"pyramid1", "bounds pyramid, one lane", CW_ISA_SCALAR, 1, CW_NEEDS_PYRAMID, &cw_pyramid1, &cw_tolerant1},
#if CELLWALK_SIMD
    {"pyramid4", "bounds pyramid, 4 lanes", CW_ISA_SSE42, 4, CW_NEEDS_PYRAMID, &cw_pyramid4, &cw_tolerant4},
    {"pyramid4x2", "bounds pyramid, two vectors of 4 lanes in lockstep",
     CW_ISA_SSE42, 8, CW_NEEDS_PYRAMID, &cw_pyramid4x2, &cw_tolerant4x2},
    {"pyramid8", "bounds pyramid, 8 lanes", CW_ISA_AVX2, 8, CW_NEEDS_PYRAMID, &cw_pyramid8, &cw_tolerant8},
    {"pyramid8x2", "bounds pyramid, 8 lanes; single rays in two vectors in lockstep",
     CW_ISA_AVX2, 16, CW_NEEDS_PYRAMID, &cw_pyramid8x2, &cw_tolerant8x2},
    {"pyramid16", "bounds pyramid, 16 lanes", CW_ISA_AVX512, 16, CW_NEEDS_PYRAMID, &cw_pyramid16, &cw_tolerant16},
    {"pyramid16x2", "bounds pyramid, 16 lanes; single rays in two vectors in lockstep",
     CW_ISA_AVX512, 32, CW_NEEDS_PYRAMID, &cw_pyramid16x2, &cw_tolerant16x2},
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
    return kernel->strict->closest[CW_LEAF_WATERTIGHT] ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE;
}

bool cw_kernel_exists(const cw_kernel *kernel) { return kernel != NULL && kernel != &cw_kernel_none; }

cw_kernel_info cw_kernel_describe(const cw_kernel *kernel) {
    if (!cw_kernel_exists(kernel)) return (cw_kernel_info){.name = cw_kernel_none.name, .what = cw_kernel_none.what};
    return (cw_kernel_info){
        .name = kernel->name,
        .what = kernel->what,
        .isa = kernel->isa,
        .width = kernel->width,
        .needs_build = kernel->needs != 0,
        .available = kernel->isa <= cw_isa_best(),
        .default_leaf = cw_kernel_default_leaf(kernel),
    };
}

const char *cw_leaf_name(cw_leaf leaf) {
    static const char *const names[CW_LEAF_COUNT] = {"default", "moller-trumbore", "watertight"};
    return (unsigned)leaf < CW_LEAF_COUNT ? names[leaf] : NULL;
}

const cw_kernel *cw_query_kernel(const cw_field *field, const cw_query *query) {
    if (query && query->kernel) return query->kernel;
    for (size_t k = KERNEL_COUNT - 1; k > 0; k--) {
        if (kernels[k].isa > cw_isa_best()) continue;
        if ((kernels[k].needs & CW_NEEDS_PYRAMID) && field && !field->pyramid) continue;
        if (!(kernels[k].needs & CW_NEEDS_GRID3D)) return &kernels[k];
    }
    return &kernels[0];
}
