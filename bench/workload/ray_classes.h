/* SPDX-License-Identifier: Apache-2.0 */
/* The classes of rays of benchmark and tests. Rays depend on field, class, seed and number alone: random numbers come
 * from integer hashes, and only operations that IEEE rounds correctly are used, so they are the same everywhere. */
#ifndef CELLWALK_BENCH_WORKLOAD_RAY_CLASSES_H
#define CELLWALK_BENCH_WORKLOAD_RAY_CLASSES_H

#include "cellwalk.h"

typedef enum workload_class {
    WORKLOAD_PRIMARY = 0, /* a pinhole view of 1024 × 1024 pixels in tiles of 4 × 4, half of it sky */
    WORKLOAD_SHADOW,      /* from the primary hits to the sun */
    WORKLOAD_AO,          /* ambient occlusion: one ray a primary hit, cosine-distributed about the normal */
    WORKLOAD_BOUNCE,      /* diffuse: as ambient occlusion, with another set of directions, and the closest hit asked */
    WORKLOAD_RANDOM,      /* along lines through two uniform points of the field's box, from where they enter it */
    WORKLOAD_GRAZING,     /* across the whole field from one side to the opposite one, within 1 degree of the horizon */
    WORKLOAD_AFAR, /* a sensor's and an orthographic view of the field, from 1000 times its longer side at 45 degrees */
    WORKLOAD_CLASS_COUNT,
    /* Aimed (aimed.h) through a vertex of the surface, or a point of an edge along x, along y or diagonal, from above
     * all samples to below all or the reverse, so that a miss is a leak: for counting errors, not for timing. */
    WORKLOAD_VERTICES = WORKLOAD_CLASS_COUNT,
    WORKLOAD_EDGES,
    /* To places anywhere on the surface from 0.5 to 2 cells before them: for counting errors too. */
    WORKLOAD_WITHIN_TWO,
    /* For the worst case, timed on request only. Three quarters run at random places and in random directions parallel
     * to the plane through the field's corners, 10^-2 to 10^-5 above or below the highest sample over that plane. One
     * quarter runs along x, lower, but above the lowest sample. */
    WORKLOAD_BESIDE,
    WORKLOAD_NAMES
} workload_class;

/* As in a plan: "primary" to "beside"; NULL if there is no such class. */
const char *workload_class_name(workload_class c);
/* True if queries of the class find any hit, false if the closest. */
bool workload_class_is_any(workload_class c);
/* True if neighbours in the array run side by side: primary and shadow rays, and rays from afar. */
bool workload_class_is_coherent(workload_class c);

enum { WORKLOAD_TILE = 16, WORKLOAD_PRIMARY_MAX = 1024 * 1024 };

/* Writes at most n rays in field space and returns how many. Primary rays come in whole tiles, spread over the picture
 * in runs of tiles that are neighbours, at most WORKLOAD_PRIMARY_MAX; shadow, ambient occlusion and bounce rays start
 * from the hits of about 2 n such primary rays, so that they may be some fewer than n. Rays to holes of the field are
 * left out. 0 if out of memory. The field's map is to be the identity, and aimed rays need 4 samples a side. */
size_t workload_rays_make(const cw_field *field, workload_class c, uint32_t seed, size_t n, cw_ray *rays);

#endif
