/* SPDX-License-Identifier: Apache-2.0 */
/* A field as the kernels see it. */
#ifndef CELLWALK_CORE_FIELD_H
#define CELLWALK_CORE_FIELD_H

#include "cellwalk.h"
#include "door.h"
#include "ieee.h"

struct cw_grid3d;
struct cw_pyramid;
struct cw_survey;
struct cw_tiles;

/* Structures that kernels may need; bits of cw_kernel.needs. */
enum { CW_NEEDS_GRID3D = 1, CW_NEEDS_PYRAMID = 2 };

struct cw_field {
    const float *z; /* sample (i, j) is z[j * stride + i]; a hole is NaN, never infinite */
    size_t nx, ny, stride;
    float low, high; /* over samples that are not holes; high < low if there is none */
    size_t holes;
    /* A ray whose origin is farther than reach from middle along any axis starts far away: src/scalar/ray.h. */
    float middle[3], reach[3];
    float *owned;                      /* samples owned by the field; NULL if borrowed */
    struct cw_survey *tile, *tile_row; /* of each tile, row by row, and of each row of them: survey.h */

    double to_user[3][4], to_field[3][4]; /* to_field by affine_invert */

    struct cw_grid3d *grid3d; /* NULL until built */
    struct cw_pyramid *pyramid;
    size_t bytes_built;
    double build_seconds;

    double to_normals[3][4]; /* to_field for vectors whose length counts for nothing: neither tiny nor huge */
    door door;               /* queries that run, and updates */
};

/* src/core/bounds/pyramid.c */
/* survey: the samples have not been looked at. */
cw_status cw_pyramid_build(cw_field *field, const cw_run *how, bool survey);
void cw_pyramid_update(cw_field *field, struct cw_tiles changed, cw_pool *pool);
void cw_pyramid_destroy(struct cw_pyramid *pyramid);

/* src/scalar/grid3d.c */
cw_status cw_grid3d_build(cw_field *field);
void cw_grid3d_destroy(struct cw_grid3d *grid);

#endif
