/* SPDX-License-Identifier: Apache-2.0 */
/* Do two contenders find the same hits, and if not, why not? Möller–Trumbore decides each triangle separately, in its
 * own order of operations, so right programs differ where rounding decides; any other difference is a defect of one. */
#ifndef CELLWALK_BENCH_HARNESS_AGREE_H
#define CELLWALK_BENCH_HARNESS_AGREE_H

#include "cellwalk.h"
#include "peers/peer.h"

/* Why one contender has a hit that the other has not. Rounding moves a hit along the surface's normal by at most
 * AGREE_ROUNDINGS roundings of the largest coordinate, along the surface by that over the cosine of ray and normal. */
typedef enum agree_reason {
    AGREE_END = 0,  /* the hit is that close to tmin or tmax */
    AGREE_EDGE,     /* the hit is that close to an edge of its triangle: a tie, or a leak between two triangles */
    AGREE_GRAZING,  /* the ray lies so flat that the hit's place is uncertain by more than AGREE_PLACE */
    AGREE_UNJUDGED, /* coordinates so large, as from afar, that all places are that uncertain: nothing can be said */
    AGREE_OTHER,    /* none of these: a defect */
    AGREE_REASON_COUNT
} agree_reason;

/* "end", "edge", "grazing", "unjudged", "other". */
const char *agree_reason_name(agree_reason reason);

/* The subtraction of the ray's origin, two cross products and a dot product round 3 coordinates 8 times or so each, in
 * both contenders: 64 halves of the last place. */
enum { AGREE_ROUNDINGS = 64 };
#define AGREE_PLACE 0.25 /* of a cell */

typedef struct agreement {
    size_t rays;
    size_t hits_a, hits_b;
    size_t only_a, only_b; /* rays that one alone hits with */
    size_t far; /* both hit, t further apart than rounding, or on different triangles where nothing can be judged */
    size_t why[AGREE_REASON_COUNT]; /* of only_a, only_b and far together */
    size_t other_triangle;          /* both hit at the same t within rounding, on different triangles: ties */
    size_t same_bits;               /* rays whose answers are equal bit for bit */
} agreement;

/* Both add to *sum, which starts all zero. a and b are the answers to rays[0..n) on the field. */
void agree_closest(agreement *sum, const cw_field *field, const cw_ray *rays, size_t n, const cw_hit *a,
                   const cw_hit *b);
/* Where the answers differ, both contenders also find the closest hits, which show why. */
void agree_any(agreement *sum, const cw_field *field, const cw_ray *rays, size_t n, const uint8_t *a, const uint8_t *b,
               const contender *of_a, const contender *of_b);

#endif
