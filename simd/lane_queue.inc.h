/* SPDX-License-Identifier: Apache-2.0 */
/* The data of the lane walk: rays queued by the tiles, rays in its lanes, and their answers. Two objects with
 * vectors of different widths share it if tiles use single vectors and the lane walk uses pairs (lane_pairs.c). */

#include <stdalign.h>

/* QUEUE_W: lanes of the vectors in which rays are queued. LANES: lanes of the lane walk. */
#ifdef CELLWALK_PAIRS
enum { QUEUE_W = half_W, LANES = W };
#else
enum { QUEUE_W = W, LANES = CELLWALK_LANE_VECTORS * W };
#endif

/* A cache line, so that no vector lies across two. */
enum { ALIGNMENT = 64 };

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

/* A vector of rays made ready. */
typedef struct ready_rays {
    alignas(ALIGNMENT) float f[RAY_FLOATS][QUEUE_W];
    int32_t i[RAY_INTS][QUEUE_W];
} ready_rays;

/* Those in the lanes. */
typedef struct lane_rays {
    alignas(ALIGNMENT) float f[RAY_FLOATS][LANES];
    int32_t i[RAY_INTS][LANES];
} lane_rays;

/* A ray waiting for a lane: its place among the rays made ready, the start of its walk, and the number of its hit. */
typedef struct queued {
    uint16_t packet, lane;
    uint32_t ray;
    float t;
    int32_t x, y, level; /* low corner, mirrored, of its first node, with the level as in lane_walk.inc.h */
} queued;

/* BATCH: rays whose incoherent ones are collected before the lane walk goes on. LANE_RUN: rays after which it ends all
 * of them, so that their numbers stay small. */
enum { BATCH = 256, LANE_RUN = 1 << 16 };

typedef struct lane_queue {
    ready_rays ready[BATCH / QUEUE_W];
    queued rays[BATCH];
    size_t n;
    uint64_t mirrored; /* bits of the present tile's packets that are in ready */
    uint32_t first;    /* number of the batch's first ray, from which those of rays count */
} lane_queue;

/* Numbers of a find. */
enum { FOUND_NUMBERS = 8 };

/* The caller's arrays, indexed by the numbers of rays; and finds of leaf tests that are not yet hits. A leaf test
 * finds two or three at a time, and refinement takes as long for LANES of them as for one. */
typedef struct lane_answers {
    const cw_ray *rays;
    cw_hit *hits;      /* of closest-hit queries */
    uint8_t *occluded; /* of any-hit queries; one of the two is NULL */
    size_t found;
    uint32_t number[2 * LANES];
    /* At most LANES waiting, another LANES as they come, and one more vector that is stored but not used. */
    alignas(ALIGNMENT) float t0[3 * LANES], t1[3 * LANES], i[3 * LANES], j[3 * LANES];
    float h00[3 * LANES], corner[3 * LANES], h11[3 * LANES], b[3 * LANES]; /* b: 1 or 0 */
} lane_answers;

/* The lanes, as they are while they are refilled. */
typedef struct lane_set {
    lane_rays rays;
    alignas(ALIGNMENT) float t[LANES], leave[LANES];
    int32_t x[LANES], y[LANES], level[LANES];
    uint32_t ray[LANES]; /* number of its hit */
    int32_t born[LANES]; /* the clock when it came */
    int32_t clock;       /* steps since all lanes were empty */
    int32_t look_at;     /* the clock at the next look for rays that have kept their lanes for long */
    unsigned living;     /* lanes that hold a ray; if none does, the other members are undefined */
} lane_set;

/* The lane walk in pairs of vectors; see lane_walk. */
extern void CW_CODE(lane_pairs_)(const cw_field *f, const lane_queue *queue, lane_set *l, bool more,
                                 lane_answers *answers);
