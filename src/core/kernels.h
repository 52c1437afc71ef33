/* SPDX-License-Identifier: Apache-2.0 */
/* The table of kernels: the one place that knows them all. */
#ifndef CELLWALK_CORE_KERNELS_H
#define CELLWALK_CORE_KERNELS_H

#include "cellwalk.h"

/* Trace rays[0..n) and write hits[0..n) or occluded[0..n). Run in the IEEE default environment. */
typedef void cw_closest_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits);
typedef void cw_any_fn(const cw_field *field, const cw_ray *rays, size_t n, uint8_t *occluded);

/* The same of kernels that walk rays in groups. */
typedef void cw_closest_group_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_coherence hint, cw_hit *hits);
typedef void cw_any_group_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_coherence hint, uint8_t *occluded);

/* How far off a tolerant query's hits may be: see cw_query. */
typedef struct cw_tolerance {
    float height, cone;
} cw_tolerance;

/* The same within a tolerance. */
typedef void cw_closest_near_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits,
                                const cw_tolerance *tolerance);
typedef void cw_any_near_fn(const cw_field *field, const cw_ray *rays, size_t n, uint8_t *occluded,
                            const cw_tolerance *tolerance);

struct cw_kernel {
    const char *name, *what;
    cw_isa isa;
    unsigned width;
    unsigned needs; /* CW_NEEDS_… of field.h */
    cw_leaf default_leaf;
    /* By leaf test; NULL where the kernel has none such. Entry CW_LEAF_DEFAULT is unused. */
    cw_closest_fn *closest[CW_LEAF_COUNT];
    cw_any_fn *any[CW_LEAF_COUNT];
    cw_closest_group_fn *closest_group[CW_LEAF_COUNT]; /* these instead, in kernels that walk rays in groups */
    cw_any_group_fn *any_group[CW_LEAF_COUNT];
    /* With the watertight test; NULL where the kernel has no use for a tolerance. */
    cw_closest_near_fn *closest_near;
    cw_any_near_fn *any_near;
};

/* The two functions of each compiled combination of path, leaf test and width. */
#define CW_DECLARE_KERNEL(name)                                                                                        \
    cw_closest_fn cw_closest_##name;                                                                                   \
    cw_any_fn cw_any_##name;
#define CW_DECLARE_GROUP_KERNEL(name)                                                                                  \
    cw_closest_group_fn cw_closest_##name;                                                                             \
    cw_any_group_fn cw_any_##name;
#define CW_DECLARE_NEAR(name)                                                                                          \
    cw_closest_near_fn cw_closest_near_##name;                                                                         \
    cw_any_near_fn cw_any_near_##name;

#endif
