/* SPDX-License-Identifier: Apache-2.0 */

/* Kernels, instruction sets and what is measured and tested of them: for benchmarks, tests and the project's own
 * programs. The rules of cellwalk.h hold, but for its promise: anything here may change or go in any version. */

#ifndef CELLWALK_EXPERT_H
#define CELLWALK_EXPERT_H

#include "cellwalk.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- instruction sets ------------------------------------------------------------------------------------------- */

typedef int32_t cw_isa;
enum {
    CW_ISA_ANY = 0, /* as a limit: none */
    CW_ISA_SCALAR = 1,
    CW_ISA_SSE42 = 2,
    CW_ISA_AVX2 = 3,
    CW_ISA_AVX512 = 4,
    CW_ISA_NEON = 5,
    CW_ISA_COUNT = 6
};

/* "scalar", "sse4.2", "avx2", "avx512", "neon"; NULL for any other value. */
CW_API const char *cw_isa_name(cw_isa isa);

/* True if code for part runs wherever code for whole does: avx512 includes avx2 includes sse4.2, each includes
 * scalar and itself, neon includes scalar. */
CW_API bool cw_isa_includes(cw_isa whole, cw_isa part);

/* The instruction set in use, which is the widest that is included in all of these: the CPU's and the operating
 * system's (CPUID and XGETBV); the environment variable CELLWALK_ISA, one of the names above, read once, of which
 * another value limits nothing, so a program should check it at its start; and the last cw_isa_limit. */
CW_API cw_isa cw_isa_best(void);
/* Limits the process to an instruction set and those that it includes. CW_ISA_ANY lifts the limit. Queries that have
 * begun are not affected. */
CW_API void cw_isa_limit(cw_isa most);

/* ---- kernels ---------------------------------------------------------------------------------------------------- */

/* A leaf test decides where a ray meets one cell's two triangles. */
typedef int32_t cw_leaf;
enum {
    CW_LEAF_DEFAULT = 0,         /* the kernel's default_leaf */
    CW_LEAF_MOLLER_TRUMBORE = 1, /* each triangle separately (Möller and Trumbore 1997): a ray may slip between two */
    CW_LEAF_WATERTIGHT = 2, /* the sign of ray height minus surface height at each crossing, which neighbours share */
    CW_LEAF_COUNT = 3
};

/* "default", "moller-trumbore", "watertight"; NULL for any other value. */
CW_API const char *cw_leaf_name(cw_leaf leaf);

/* A kernel is one way to find hits. Kernels live as long as the program. cell, packet* and pyramid* return the same
 * bits for the same leaf test. A program may add reference kernels, in no installed library: brute and grid3d use other
 * operations and may differ in last bits and near edges. */
typedef struct cw_kernel cw_kernel;

/* Members of cw_run.expert: kernel, NULL for the best one; leaf, a cw_leaf; isa, a cw_isa that this run keeps within
 * besides the limits above. A query whose kernel is not available fails with CW_ERROR_KERNEL when it begins. */

typedef struct cw_kernel_info {
    const char *name; /* "packet8" */
    const char *what; /* a description in one line */
    cw_isa isa;       /* the instruction set it needs */
    uint32_t width;   /* lanes of the vectors that it walks with */
    bool needs_build; /* it needs another structure than a field's bounds: only reference kernels do */
    bool available;   /* on this machine under the present limit */
    cw_leaf default_leaf;
} cw_kernel_info;

CW_API size_t cw_kernel_count(void);
/* NULL from cw_kernel_count() on. */
CW_API const cw_kernel *cw_kernel_at(size_t number);
/* For a name that no kernel has: a stand-in, with which a query fails with CW_ERROR_KERNEL, so that a typo never
 * selects the default kernel. */
CW_API const cw_kernel *cw_kernel_find(const char *name);
/* False for the stand-in of cw_kernel_find and for NULL. */
CW_API bool cw_kernel_exists(const cw_kernel *kernel);
/* Fills in the first size bytes of a cw_kernel_info. NULL is described like the stand-in. */
CW_API void cw_kernel_describe_into(const cw_kernel *kernel, cw_kernel_info *info, size_t size);
static inline cw_kernel_info cw_kernel_describe(const cw_kernel *kernel) {
    cw_kernel_info info;
    cw_kernel_describe_into(kernel, &info, sizeof info);
    return info;
}

/* CW_OK if a query with this run on this field would start; field NULL stands for one that has every structure. */
CW_API cw_status cw_run_check(const cw_field *field, const cw_run *run);

/* The kernel that a query of many rays with this run uses; field is ignored and may be NULL. */
CW_API const cw_kernel *cw_run_kernel(const cw_field *field, const cw_run *run);

/* Makes the structure that run's kernel needs beside the bounds, if any, unless the field has it. cw_field_create does
 * so for the kernel of its run; an update drops it. Nothing else may be running on the field. On failure the field does
 * not change: CW_ERROR_ARGUMENT, _KERNEL, _MEMORY. */
CW_API cw_status cw_field_build(cw_field *field, const cw_run *run);

/* ---- threads ---------------------------------------------------------------------------------------------------- */

/* 1 for NULL. */
CW_API uint32_t cw_pool_threads(const cw_pool *pool);

/* Items [begin, end) of a piece of work. */
typedef void cw_work_fn(void *context, size_t begin, size_t end);
/* Runs the caller's work over [0, n) on the pool's threads, in pieces of grain items (0 counts as 1) and in any
 * order; on one thread in one piece. Returns when all is done. */
CW_API void cw_pool_run(cw_pool *pool, size_t n, size_t grain, cw_work_fn *work, void *context);

/* ---- headings --------------------------------------------------------------------------------------------------- */

/* A heading traces rays that leave many samples in one direction, as for sunlight. It is in libcellwalk_terrain. Each
 * ray starts exactly on the surface at its sample and meets everything beyond it, so no ray has to be lifted off the
 * ground. This is faster than a query with one ray for each sample.
 *
 * A heading is a direction (dir[0], dir[1]) in field coordinates, prepared for one field: it keeps the 2 to 4
 * edges that a ray crosses per cell, as far as the longest ray goes, in some 20 bytes each. From sample (i, j) with
 * height z, the surface at (i + t dir[0], j + t dir[1]) rises by (height - z) / t, t > 0. The steepest rise is at a
 * triangle's edge, so only edges are examined. An edge counts if neither of its samples is a hole, even if both
 * triangles beside it have a hole. */
typedef struct cw_heading cw_heading;

typedef struct cw_heading_desc {
    double dir[2]; /* the longer component is from 2^-40 to 2^40 */
    /* Only edges crossed at t <= reach count, up to rounding in the last bits; finite; 0: all. */
    double reach;
    /* The surface at t counts as lower by drop t²: at (i + t dir[0], j + t dir[1]) it rises by (height - drop t² -
     * z) / t, and is straight between the lowered edges. The error of a rise grows by up to 2^-23 drop t. 0: the
     * earth is flat. At most 2^77 times dir's longer component. */
    double drop;
    uint64_t reserved[4]; /* 0 */
} cw_heading_desc;

/* The caller owns the heading and destroys it before the field. On failure *heading is NULL: CW_ERROR_ARGUMENT,
 * _MEMORY. */
CW_API cw_status cw_heading_create(const cw_field *field, const cw_heading_desc *desc, cw_heading **heading);
/* NULL is allowed. */
CW_API void cw_heading_destroy(cw_heading *heading);

/* The steepest rise seen from each sample of a rectangle: slope[y * at.nx + x] for sample (at.i + x, at.j + y), NaN
 * at a hole. Its error is less than 2^-21 of the steeper of the rises to the edge's two samples, by their sizes. A rise
 * beyond the largest float is infinite. Rises are clamped to [low, high]; if the ray meets nothing, the rise is low. So
 * -infinity may be either, unless low is finite. A narrow range is fast; -infinity and infinity clamp
 * nothing. Of run's kernel only the instruction set is used; the answers are the same for any. */
CW_API cw_status cw_heading_steepest(const cw_heading *heading, const cw_run *run, float low, float high,
                                     cw_rectangle at, float *slope);

/* occluded[y * at.nx + x] = 1 if the steepest rise is at least slope; else 0, also at a hole or where the ray meets
 * nothing. slope may be infinite. */
CW_API cw_status cw_heading_occluded(const cw_heading *heading, const cw_run *run, float slope, cw_rectangle at,
                                     uint8_t *occluded);

#ifdef __cplusplus
}
#endif

#endif
