/* SPDX-License-Identifier: Apache-2.0 */
#include "kernels.h"

#include "field.h"
#include "isa.h"

#include <string.h>

CW_DECLARE_KERNEL(brute_mt)
CW_DECLARE_KERNEL(grid3d_mt)
CW_DECLARE_KERNEL(grid3d_early_mt)
CW_DECLARE_KERNEL(cell_mt)
CW_DECLARE_KERNEL(cell_wt)
CW_DECLARE_KERNEL(packet1_mt)
CW_DECLARE_KERNEL(packet1_wt)
CW_DECLARE_KERNEL(packet4_mt)
CW_DECLARE_KERNEL(packet4_wt)
CW_DECLARE_KERNEL(packet8_mt)
CW_DECLARE_KERNEL(packet8_wt)
CW_DECLARE_KERNEL(packet16_mt)
CW_DECLARE_KERNEL(packet16_wt)
CW_DECLARE_KERNEL(pyramid1_mt)
CW_DECLARE_KERNEL(pyramid1_wt)
CW_DECLARE_KERNEL(near_pyramid1)
CW_DECLARE_KERNEL(pyramid4_mt)
CW_DECLARE_KERNEL(pyramid4_wt)
CW_DECLARE_KERNEL(near_pyramid4)
CW_DECLARE_KERNEL(pyramid4x2_mt)
CW_DECLARE_KERNEL(pyramid4x2_wt)
CW_DECLARE_KERNEL(near_pyramid4x2)
CW_DECLARE_KERNEL(pyramid8_mt)
CW_DECLARE_KERNEL(pyramid8_wt)
CW_DECLARE_KERNEL(near_pyramid8)
CW_DECLARE_KERNEL(pyramid8x2_mt)
CW_DECLARE_KERNEL(pyramid8x2_wt)
CW_DECLARE_KERNEL(near_pyramid8x2)
CW_DECLARE_KERNEL(pyramid16_mt)
CW_DECLARE_KERNEL(pyramid16_wt)
CW_DECLARE_KERNEL(near_pyramid16)

#define MT(path) [CW_LEAF_MOLLER_TRUMBORE] = path##_mt
#define WT(path) [CW_LEAF_WATERTIGHT] = path##_wt
#define ONLY_MT(path)                                                                                                  \
    .default_leaf = CW_LEAF_MOLLER_TRUMBORE, .closest = {MT(cw_closest_##path)}, .any = {MT(cw_any_##path)}
#define BOTH(path)                                                                                                     \
    .default_leaf = CW_LEAF_WATERTIGHT, .closest = {MT(cw_closest_##path), WT(cw_closest_##path)},                     \
    .any = {MT(cw_any_##path), WT(cw_any_##path)}
#define NEAR(path) .closest_near = cw_closest_near_##path, .any_near = cw_any_near_##path

/* From the plainest to the fastest: the last one available is the default. */
static const cw_kernel kernels[] = {
    {.name = "brute", .what = "every triangle, the ground truth for small fields", .width = 1, ONLY_MT(brute)},
    {.name = "grid3d-early",
     .what = "uniform 3D grid, 3D-DDA, returns at the first hit found: the coursework's shortcut, not exact",
     .width = 1,
     .needs = CW_NEEDS_GRID3D,
     ONLY_MT(grid3d_early)},
    {.name = "grid3d",
     .what = "uniform 3D grid, 3D-DDA, a hit counts only inside the voxel",
     .width = 1,
     .needs = CW_NEEDS_GRID3D,
     ONLY_MT(grid3d)},
    {.name = "cell", .what = "2D-DDA from cell to cell, two triangles a cell", .width = 1, BOTH(cell)},
    {.name = "packet1", .what = "the packet kernel one ray wide: the oracle of its lanes", .width = 1, BOTH(packet1)},
#if CELLWALK_SIMD
    {.name = "packet4", .what = "2D cell walk, 4 rays at once", .isa = CW_ISA_SSE42, .width = 4, BOTH(packet4)},
    {.name = "packet8", .what = "2D cell walk, 8 rays at once", .isa = CW_ISA_AVX2, .width = 8, BOTH(packet8)},
    {.name = "packet16", .what = "2D cell walk, 16 rays at once", .isa = CW_ISA_AVX512, .width = 16, BOTH(packet16)},
#endif
    {.name = "pyramid1",
     .what = "bounds pyramid, one lane: the oracle of its lanes",
     .width = 1,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid1),
     NEAR(pyramid1)},
#if CELLWALK_SIMD
    {.name = "pyramid4",
     .what = "bounds pyramid, 4 lanes",
     .isa = CW_ISA_SSE42,
     .width = 4,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid4),
     NEAR(pyramid4)},
    {.name = "pyramid4x2",
     .what = "bounds pyramid, two vectors of 4 lanes in lockstep",
     .isa = CW_ISA_SSE42,
     .width = 8,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid4x2),
     NEAR(pyramid4x2)},
    {.name = "pyramid8",
     .what = "bounds pyramid, 8 lanes",
     .isa = CW_ISA_AVX2,
     .width = 8,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid8),
     NEAR(pyramid8)},
    {.name = "pyramid8x2",
     .what = "bounds pyramid, two vectors of 8 lanes in lockstep",
     .isa = CW_ISA_AVX2,
     .width = 16,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid8x2),
     NEAR(pyramid8x2)},
    {.name = "pyramid16",
     .what = "bounds pyramid, 16 lanes",
     .isa = CW_ISA_AVX512,
     .width = 16,
     .needs = CW_NEEDS_PYRAMID,
     BOTH(pyramid16),
     NEAR(pyramid16)},
#endif
};
enum { KERNEL_COUNT = sizeof kernels / sizeof kernels[0] };

const cw_kernel cw_kernel_none = {.name = "none", .what = "there is no kernel of that name"};

size_t cw_kernel_count(void) { return KERNEL_COUNT; }

const cw_kernel *cw_kernel_at(size_t number) { return number < KERNEL_COUNT ? &kernels[number] : NULL; }

const cw_kernel *cw_kernel_find(const char *name) {
    for (size_t k = 0; name && k < KERNEL_COUNT; k++)
        if (strcmp(name, kernels[k].name) == 0) return &kernels[k];
    return &cw_kernel_none;
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
        .default_leaf = kernel->default_leaf,
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
