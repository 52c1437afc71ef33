/* SPDX-License-Identifier: Apache-2.0 */
/* The data of the lane walk: rays queued by the tiles, rays in its lanes, and their answers. Tiles have vectors of one
 * register. The lane walk has two, but for its last rays (lane_walk.h). */
#ifndef CELLWALK_SIMD_LANE_QUEUE_H
#define CELLWALK_SIMD_LANE_QUEUE_H

#include "../src/scalar/strict.h"
#include "field.h"
#include "vocabulary.h"

#include <stdalign.h>

/* Lanes of the lane walk: two registers. One lane wide, a second one would only take longer. */
enum { SLOTS = W > 1 ? 2 * W : W };

/* Numbers of a ray. */
enum {
    RAY_ORG,     /* mirrored, like all on an axis */
    RAY_EARLY,   /* org, set back by more than the rounding of org + t · dir within the field */
    RAY_DIR,     /* never negative */
    RAY_CENTER,  /* the origin of crossings: vaxis.center */
    RAY_INVERSE, /* 1 / dir */
    RAY_FIRST,   /* the field's border at which rays enter */
    RAY_LAST,    /* and the one at which they leave */
    RAY_SIGN,    /* -0 where the axis is mirrored, else 0 */
    RAY_AXIS,    /* numbers an axis */
    RAY_OZ = 2 * RAY_AXIS,
    RAY_DZ,
    RAY_PAD,   /* rounding error of the height above a slab, beyond the slab's own margin */
    RAY_UNTIL, /* the walk ends here */
    RAY_T0,    /* of the leaf tests: see vray */
    RAY_T1,
    RAY_FLOATS
};
enum { RAY_TURNED_X, RAY_TURNED_Y, RAY_INTS };

/* A vector of rays made ready. Aligned as a cache line, so that no vector lies across two. */
typedef struct ready_rays {
    alignas(64) float f[RAY_FLOATS][W];
    int32_t i[RAY_INTS][W];
} ready_rays;

/* Those in the lanes. */
typedef struct lane_rays {
    alignas(64) float f[RAY_FLOATS][SLOTS];
    int32_t i[RAY_INTS][SLOTS];
} lane_rays;

/* A ray waiting for a lane: its place among the rays made ready, the start of its walk, and the number of its hit. */
typedef struct queued {
    uint16_t packet, lane;
    uint32_t ray;
    float t;
    int32_t x, y, level; /* low corner, mirrored, of its first node, with the level as in lane_walk.h */
} queued;

/* BATCH: rays whose incoherent ones are collected before the lane walk goes on. LANE_RUN: rays after which it ends all
 * of them, so that their numbers stay small. */
enum { BATCH = 256, LANE_RUN = 1 << 16 };

typedef struct lane_queue {
    ready_rays *ready; /* a batch's, or those of a call of few rays */
    queued *rays;
    size_t n;
    uint64_t mirrored; /* bits of the present tile's packets that are in ready */
    uint32_t first;    /* number of the batch's first ray, from which those of rays count */
} lane_queue;

/* Numbers of a find; FOUND_B: 1 or 0. */
enum { FOUND_T0, FOUND_T1, FOUND_I, FOUND_J, FOUND_H00, FOUND_CORNER, FOUND_H11, FOUND_B, FOUND_NUMBERS };

/* The caller's arrays, indexed by the numbers of rays; and fewer than W finds of leaf tests that are not yet hits. Few
 * come at a time, and refinement takes as long for W of them as for one. */
typedef struct lane_answers {
    const cw_ray *rays;
    cw_hit *hits;      /* of closest-hit queries */
    uint8_t *occluded; /* of any-hit queries; one of the two is NULL */
    size_t found;
    uint32_t number[W];
    alignas(64) float find[FOUND_NUMBERS][W];
} lane_answers;

/* The lanes, as they are between two runs of steps. */
typedef struct lane_set {
    lane_rays rays;
    alignas(64) float t[SLOTS], leave[SLOTS];
    int32_t x[SLOTS], y[SLOTS], level[SLOTS];
    uint32_t ray[SLOTS]; /* number of its hit */
    int32_t born[SLOTS]; /* the clock when it came */
    int32_t clock;       /* steps since all lanes were empty */
    int32_t look_at;     /* the clock at the next look for rays that have kept their lanes for long */
    unsigned living;     /* lanes that hold a ray; if none does, the other members are undefined */
} lane_set;

/* Turns the finds into hits. */
void CW_CODE(lane_write)(lane_answers *a, const cw_field *f);
/* lane_walk in vectors of two registers (lane_pairs_kernel.c). */
void CW_CODE(lane_pairs)(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, lane_answers *answers);
/* A cell's row in the upper 32 bits, its column in the lower; or none. One number: of two, GCC makes two stores and one
 * load, which waits for both. */
typedef int64_t one_cell;
enum { NO_CELL = -1 };
/* Walks a ray from t on to its end (one_kernel.c). If it hits, find is set. */
one_cell CW_CODE(one_late)(const cw_field *f, const cw_ray *ray, float t, strict_find *find);

#endif
