/* SPDX-License-Identifier: Apache-2.0 */
/* One thread's paths, as structures of arrays. They go through the scene in waves of up to SCENE_BATCH rays: all are
 * traced, then shaded, then all their shadow rays are traced; those that met a mirror are the next wave. So a tracer
 * always has an array of rays to work on, neighbours in the picture being neighbours in the array, and shading is
 * loops that compilers vectorise. */
#ifndef CELLWALK_SCENE_WAVE_H
#define CELLWALK_SCENE_WAVE_H

#include "plan.h"

enum {
    WAVE_TILE = 32,   /* pixels a side of the tiles that threads take */
    WAVE_SAMPLES = 4, /* of each pixel of a tile in a wave */
    WAVE_BLOCK = 4,   /* pixels a side of a block whose rays fill the lanes of a vector */
    WAVE_LANES = 16,  /* loops run over whole multiples of this, also beyond the last ray */
    WAVE_STRIP = 128, /* paths that are shaded together: all about them stays in the nearest cache */
    WAVE_ROOM = SCENE_BATCH + WAVE_STRIP,
    WAVE_WINDOW = 16, /* samples around a cell */
    WAVE_MISS = -1,   /* in place of a shape */
    WAVE_WATER = -2   /* likewise */
};

/* Whole lanes for n paths. */
static inline size_t wave_lanes(size_t n) { return (n + WAVE_LANES - 1) / WAVE_LANES * WAVE_LANES; }

/* The same number, for loops over whole lanes: compilers then need no code for a rest. */
static inline size_t wave_whole(size_t n) {
    if (n % WAVE_LANES != 0) __builtin_unreachable();
    return n;
}

/* How many of the paths from first to before end go into a strip. */
static inline size_t wave_strip_of(size_t first, size_t end) {
    return end - first < WAVE_STRIP ? end - first : WAVE_STRIP;
}

/* The number of pixel (x, y) of a tile: block by block, as sixteen neighbours stand side by side in a wave. */
static inline uint32_t wave_pixel(uint32_t x, uint32_t y) {
    const uint32_t block = y / WAVE_BLOCK * (WAVE_TILE / WAVE_BLOCK) + x / WAVE_BLOCK;
    return block * WAVE_LANES + y % WAVE_BLOCK * WAVE_BLOCK + x % WAVE_BLOCK;
}

/* Floats of each ray in a wave, for three coordinates. */
typedef float wave_vector[3][WAVE_ROOM];

/* Rays that begin in one space. */
typedef struct wave_segment {
    size_t home, begin, end;
} wave_segment;

/* How a ray's origin and direction change to the next sample on the right and below (Igehy 1999). */
typedef struct wave_spread {
    wave_vector org[2], dir[2];
} wave_spread;

typedef struct wave_rays {
    size_t count, segment_count;
    wave_segment *segments;
    wave_vector org, dir; /* dir is one long in the world; org of camera rays is 0 and not written */
    float tmin[WAVE_ROOM];
    float share[3][WAVE_ROOM]; /* of this ray's light that arrives at the pixel; camera rays: 1 and not written */
    uint32_t pixel[WAVE_ROOM]; /* of the tile, as wave_pixel counts */
    wave_spread *spread;       /* where the plan says so; not of camera rays */
} wave_rays;

/* Ways to one light: t = 1 is the light, dir follows from org. */
typedef struct wave_shadows {
    size_t count, segment_count;
    wave_segment *segments;
    wave_vector org;
    float tmin[WAVE_ROOM];
    float light[3][WAVE_ROOM]; /* light that arrives at the pixel unless it is blocked */
    uint32_t pixel[WAVE_ROOM];
} wave_shadows;

/* Sides of a cell. */
enum { EAST, NORTH, WEST, SOUTH };

/* Paths of one shape while they are shaded, in the shape's space. */
typedef struct wave_strip {
    size_t n;                          /* a multiple of WAVE_LANES; the last path stands behind the end, too */
    uint32_t path[WAVE_STRIP];         /* in the wave */
    float dir[3][WAVE_STRIP];          /* of the ray that came */
    float t[WAVE_STRIP];               /* the length of its way */
    float at[3][WAVE_STRIP];           /* where it ended */
    float flat[3][WAVE_STRIP];         /* normal of the flat surface */
    float normal[3][WAVE_STRIP];       /* for shading; of any length */
    float turn[2][3][WAVE_STRIP];      /* its change where x and y grow by 1 */
    float apart[2][3][WAVE_STRIP];     /* how far neighbouring samples are from at */
    float apart_dir[2][3][WAVE_STRIP]; /* and how their directions differ */
    float colour[3][WAVE_STRIP];

    float in[3][WAVE_STRIP];                                 /* from the wave, in the space where the ray began */
    int32_t i[WAVE_STRIP], j[WAVE_STRIP], lower[WAVE_STRIP]; /* cell, and whether its lower triangle was hit */
    float u[WAVE_STRIP], v[WAVE_STRIP];
    float window[WAVE_WINDOW][WAVE_STRIP]; /* 4 x 4 samples around the cell, or its own four alone */
    float goes_on[4][WAVE_STRIP];          /* 1 or 0: there is field to the east, north, west, south of the cell */
    float uv[2][WAVE_STRIP], uv_apart[2][2][WAVE_STRIP];
} wave_strip;

/* The reads of an image by each path of a strip: at a level and, if share is not 0, at the next coarser one, so many
 * places along an axis of its footprint. */
typedef struct wave_footprints {
    int32_t level[WAVE_STRIP], count[WAVE_STRIP];
    float share[WAVE_STRIP], axis[2][WAVE_STRIP];
} wave_footprints;

/* Places to be read, for a path each. */
enum { WAVE_PROBES = WAVE_STRIP * 16 };
typedef struct wave_probes {
    size_t n;
    float u[WAVE_PROBES], v[WAVE_PROBES], weight[WAVE_PROBES];
    int32_t level[WAVE_PROBES], of[WAVE_PROBES];
    /* Texels (x, y) and (x, y + 1), to the right of which stand their neighbours, and the place between these four. */
    int32_t above[WAVE_PROBES], below[WAVE_PROBES];
    float right[WAVE_PROBES], down[WAVE_PROBES];
} wave_probes;

typedef struct wave {
    const plan *plan;
    const scene_tracer *tracer;
    wave_rays rays[2];     /* the wave at hand and the next one */
    wave_shadows *shadows; /* of each light */

    float t[WAVE_ROOM]; /* where each ray ends; infinity where nothing is */
    int32_t shape[WAVE_ROOM];
    uint32_t hit[WAVE_ROOM];  /* where shape is a height field: number of its answer */
    uint32_t path[WAVE_ROOM]; /* those of one shape, in order */
    wave_strip strip;
    wave_footprints footprints;
    wave_probes probes;

    /* One query of the tracer: the field, the rays and the answers. */
    cw_ray asked[WAVE_ROOM];
    uint32_t asked_of[WAVE_ROOM];
    cw_hit (*answers)[SCENE_BATCH]; /* of each field: they are read when the paths are shaded */
    uint8_t yes[SCENE_BATCH];
    uint8_t hidden[WAVE_ROOM]; /* 1 or 0 */

    double sum[3][WAVE_TILE * WAVE_TILE]; /* over the samples of each pixel */
    scene_render_stats stats;
} wave;

/* NULL when out of memory. */
wave *wave_create(const plan *p, const scene_tracer *tracer);
void wave_free(wave *w);

/* Renders the part of the tile at (x, y) that lies in the region, of which image is the picture; x and y are
 * multiples of WAVE_TILE. There is one such function for each instruction set, all from wave_tile.c. */
typedef void wave_tile_fn(wave *w, size_t x, size_t y, const scene_crop *region, io_image *image);

#endif
