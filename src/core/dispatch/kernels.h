/* SPDX-License-Identifier: Apache-2.0 */
/* The interface of a kernel to the rest of the library. kernels.c has the table of kernels. */
#ifndef CELLWALK_CORE_KERNELS_H
#define CELLWALK_CORE_KERNELS_H

#include "cellwalk_expert.h"

#include <stdatomic.h>

/* Calls of so many rays take at most 16 KiB of stack. */
enum { CW_FEW_RAYS = 8, CW_SHORT_LANES = 4 };

/* Traces rays[0..n) and writes hits[0..n), or occluded[0..n) if hits is NULL. Runs in the IEEE default environment. */
typedef void cw_trace_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded);

/* The same for few rays, with the watertight test; false if another walk is better: then answers are unspecified. */
typedef bool cw_short_fn(const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded);

/* cw_rays_to_field; m is the field's to_field. */
typedef void cw_to_field_fn(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out);

/* By leaf test; NULL where the kernel does not have it. Entry CW_LEAF_DEFAULT is unused. */
typedef struct cw_kernel_code {
    cw_trace_fn *trace[CW_LEAF_COUNT];
} cw_kernel_code;

struct cw_kernel {
    const char *name, *what;
    cw_isa isa;
    unsigned width; /* lanes of the widest vectors it walks with */
    const cw_kernel_code *code;
    cw_to_field_fn *to_field; /* for the same instruction set */
    /* Calls of at most CW_FEW_RAYS rays that force no kernel: of one alone (NULL: there is none); of at most
     * CW_SHORT_LANES and of more that are all short by a guess; and of all others. */
    cw_trace_fn *one;
    cw_short_fn *if_short[2];
    const cw_kernel_code *few;
    cw_status (*build)(cw_field *field); /* makes the field's guest, if the bounds alone do not serve it */
};

/* The kernel that cw_kernel_find returns for an unknown name. */
extern const cw_kernel cw_kernel_none;

/* What cw_isa_best returns; CW_ISA_ANY before its first call. */
extern atomic_int cw_isa_in_use;

/* The widest instruction set that both include; b may be CW_ISA_ANY. */
cw_isa cw_isa_common(cw_isa a, cw_isa b);

/* The best kernel within an instruction set. */
const cw_kernel *cw_kernel_default(cw_isa isa);

/* The watertight test where the kernel has it. */
cw_leaf cw_kernel_default_leaf(const cw_kernel *kernel);

/* Kernels of another library, which come before those of this one. Before the first other call, and once. */
void cw_kernels_add(const cw_kernel *first, size_t count);

/* src/scalar/cell.c. cw_cell_few traces a ray through so many cells at most; false, with no answer, if it goes on. */
extern const cw_kernel_code cw_cell;
bool cw_cell_few(const cw_field *field, const cw_ray *ray, int most, cw_hit *hit, uint8_t *occluded);

/* simd/packet_kernel.c and simd/pyramid_kernel.c, each compiled for the instruction sets of simd/isas.cmake */
extern const cw_kernel_code cw_packet4, cw_packet8, cw_packet16;
cw_short_fn cw_short4, cw_short8;
extern const cw_kernel_code cw_pyramid1, cw_pyramid4, cw_pyramid8, cw_pyramid16;

cw_trace_fn cw_one1, cw_one4, cw_one8, cw_one16; /* simd/one_kernel.c */

cw_to_field_fn cw_to_field1, cw_to_field4, cw_to_field8, cw_to_field16; /* simd/to_field_kernel.c */

#endif
