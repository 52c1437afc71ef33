/* SPDX-License-Identifier: Apache-2.0 */
/* What a kernel is to the rest of the library. kernels.c has the table of them all. */
#ifndef CELLWALK_CORE_KERNELS_H
#define CELLWALK_CORE_KERNELS_H

#include "cellwalk.h"

/* Trace rays[0..n) and write hits[0..n) or occluded[0..n). Run in the IEEE default environment. The query is never NULL;
 * its leaf test is one that the kernel has, never CW_LEAF_DEFAULT, and what a kernel has no use for it ignores. */
typedef void cw_closest_fn(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits);
typedef void cw_any_fn(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded);

/* By leaf test; NULL where the kernel has none such. Entry CW_LEAF_DEFAULT is unused. */
typedef struct cw_kernel_code {
    cw_closest_fn *closest[CW_LEAF_COUNT];
    cw_any_fn *any[CW_LEAF_COUNT];
} cw_kernel_code;

struct cw_kernel {
    const char *name, *what;
    cw_isa isa;
    unsigned width;
    unsigned needs; /* CW_NEEDS_… of field.h */
    const cw_kernel_code *strict;
    const cw_kernel_code *tolerant; /* with the watertight test; NULL where the kernel has no use for a tolerance */
};

/* What cw_kernel_find gives for a name that no kernel has. */
extern const cw_kernel cw_kernel_none;

/* The watertight test where the kernel has it. */
cw_leaf cw_kernel_default_leaf(const cw_kernel *kernel);

/* src/scalar/ */
extern const cw_kernel_code cw_brute, cw_cell, cw_grid3d, cw_grid3d_early;

/* simd/packet.c and simd/pyramid.c, each compiled for the rows of the table in simd/CMakeLists.txt */
extern const cw_kernel_code cw_packet1, cw_packet4, cw_packet8, cw_packet16;
extern const cw_kernel_code cw_pyramid1, cw_pyramid4, cw_pyramid4x2, cw_pyramid8, cw_pyramid8x2, cw_pyramid16,
    cw_pyramid16x2;
extern const cw_kernel_code cw_tolerant1, cw_tolerant4, cw_tolerant4x2, cw_tolerant8, cw_tolerant8x2, cw_tolerant16,
    cw_tolerant16x2;

#endif
