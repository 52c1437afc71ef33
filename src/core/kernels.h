/* SPDX-License-Identifier: Apache-2.0 */
/* The table of kernels: the one place that knows them all. */
#ifndef CELLWALK_CORE_KERNELS_H
#define CELLWALK_CORE_KERNELS_H

#include "cellwalk.h"

/* Trace rays[0..n) and write hits[0..n) or occluded[0..n). Run in the IEEE default environment. The query is never NULL;
 * what a kernel has no use for it passes over, and which kernel and leaf test it names is settled. */
typedef void cw_closest_fn(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits);
typedef void cw_any_fn(const cw_field *field, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded);

struct cw_kernel {
    const char *name, *what;
    cw_isa isa;
    unsigned width;
    unsigned needs; /* CW_NEEDS_… of field.h */
    cw_leaf default_leaf;
    /* By leaf test; NULL where the kernel has none such. Entry CW_LEAF_DEFAULT is unused. */
    cw_closest_fn *closest[CW_LEAF_COUNT];
    cw_any_fn *any[CW_LEAF_COUNT];
    /* For tolerant queries, with the watertight test; NULL where the kernel has no use for a tolerance. */
    cw_closest_fn *closest_near;
    cw_any_fn *any_near;
};

/* What cw_kernel_find gives for a name that no kernel has. */
extern const cw_kernel cw_kernel_none;

/* The two functions of each compiled combination of path, leaf test and width. */
#define CW_DECLARE_KERNEL(name)                                                                                        \
    cw_closest_fn cw_closest_##name;                                                                                   \
    cw_any_fn cw_any_##name;

#endif
