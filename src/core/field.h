/* SPDX-License-Identifier: Apache-2.0 */
/* A field as the kernels see it. */
#ifndef CELLWALK_CORE_FIELD_H
#define CELLWALK_CORE_FIELD_H

#include "cellwalk_expert.h"
#include "door.h"
#include "ieee.h"

struct cw_pyramid;

/* What a kernel of another library walks on, which cw_kernel.build has made. An update destroys it. */
typedef struct cw_guest {
    void *structure; /* NULL: there is none */
    void (*destroy)(const cw_allocator *memory, void *structure);
    size_t bytes;
} cw_guest;

struct cw_field {
    const float *z; /* sample (i, j) is z[j * stride + i]; a hole is NaN, never infinite */
    size_t nx, ny, stride;
    float low, high; /* over samples that are not holes; high < low if there is none */
    size_t holes;
    /* A ray whose origin is farther than reach from middle along any axis starts far away: src/scalar/ray.h. */
    float middle[4], reach[4];
    float last[4]; /* numbers of the last samples along x and y. Of all three the rest counts for nothing. */
    float *owned;  /* samples owned by the field; NULL if borrowed */

    double to_user[3][4], to_field[3][4]; /* to_field by affine_invert */

    struct cw_pyramid *pyramid; /* its bounds */
    cw_guest guest;
    cw_allocator memory; /* of the field and all that is made from it */

    double to_normals[3][4]; /* to_field for vectors whose length counts for nothing: neither tiny nor huge */
    door door;               /* queries that run, and updates */
};

/* src/core/bounds/pyramid.c. The first fails if a sample may not be part of a field; the second's have been checked. */
cw_status cw_pyramid_build(cw_field *field, const cw_run *how);
void cw_pyramid_update(cw_field *field, const cw_rectangle *changed, cw_pool *pool);
void cw_pyramid_destroy(const cw_field *field, struct cw_pyramid *pyramid);
/* Fails if one of samples z[0..n), which are (i, j) and on, may not be part of a field. */
cw_status cw_check_samples(const float *z, size_t i, size_t j, size_t n, bool infinities);

#endif
