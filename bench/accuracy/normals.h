/* SPDX-License-Identifier: Apache-2.0 */
/* "Barycentric Phong beats bilinear": normals interpolated between the vertices of the triangle hit, and between the four
 * of its cell, held against those of a smooth surface that is known by its formula. */
#ifndef CELLWALK_BENCH_ACCURACY_NORMALS_H
#define CELLWALK_BENCH_ACCURACY_NORMALS_H

#include "accuracy/exact.h"
#include "error.h"

#include <jansson.h>

typedef enum tradeoff_normal {
    TRADEOFF_FACET,       /* the triangle's own */
    TRADEOFF_BARYCENTRIC, /* what cw_hit_phong_normal does */
    TRADEOFF_BILINEAR,    /* of the cell's four vertex normals */
    TRADEOFF_NORMAL_COUNT
} tradeoff_normal;

/* "facet", "barycentric", "bilinear". */
const char *tradeoff_normal_name(tradeoff_normal kind);

/* Unit normal at a hit, in field space, of samples without holes. The vertex normals are those of cw_hit_phong_normal;
 * hits in the cells at the field's border are not to be asked for. */
void tradeoff_normal_at(const true_surface *surface, const cw_hit *hit, tradeoff_normal kind, double normal[3]);

/* Adds a line of kind "normal" for each of several waves, from steep and short to flat and long. */
bool tradeoff_normals_run(uint32_t seed, json_t *lines, io_error *error);

#endif
