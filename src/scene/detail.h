/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail: near cells of the full field, far ones of coarser fields, for rays of one view. */
#ifndef CELLWALK_SCENE_DETAIL_H
#define CELLWALK_SCENE_DETAIL_H

#include "cellwalk.h"
#include "error.h"
#include "scene.h"

enum { DETAIL_LEVELS_MAX = 24 };

/* Level k has every 2^k-th place of the full field, which is level 0. */
typedef struct detail_level {
    const cw_field *field;
    const float *z;       /* its samples, row by row */
    const float *samples; /* for normals: the same, unless a user puts others here */
    size_t nx, ny;
    float scale; /* 2^-k: x and y of the full field times this are those of the level */
    /* No point of the level lies farther above or below the full field, nor above or below level k - 1. */
    double above, below, near_above, near_below;
} detail_level;

typedef struct detail {
    size_t count; /* of levels */
    detail_level level[DETAIL_LEVELS_MAX];
    cw_field *own[DETAIL_LEVELS_MAX]; /* own[0] is NULL: the full field is the caller's */
    float low[3], high[3];            /* a box around the full field */
    double edge, steep; /* largest difference of heights along an edge or diagonal, and the same over its cell's side */
} detail;

/* From which t on each level serves. */
typedef struct detail_view {
    double begin[DETAIL_LEVELS_MAX];
} detail_view;

/* Makes levels with the mean filter until a side would have fewer than 16 cells. The field must live as long as they do.
 * False, with error, when out of memory or with the text "cancelled"; then there is nothing to free. */
bool detail_make(detail *d, const cw_field *full, const cw_run *run, io_error *error);
void detail_free(detail *d);

/* Finds from which t on each level serves a ray of reach 1: from begin[k] to begin[k + 1], the last one to infinity. From
 * there on a cell of the level, and how far its surface may lie from the full one, is no longer than seen at that distance,
 * where seen is a length at t = 1. cell is the longer side of a cell of the full field, height the length of one unit
 * of height. begin[0] is 0. */
detail_view detail_view_of(const detail *d, double cell, double height, double seen);

/* What detail_closest works with: one for each thread. */
typedef struct detail_room {
    uint32_t of[SCENE_BATCH];
    float begin[SCENE_BATCH], end[SCENE_BATCH], until[SCENE_BATCH];
    bool asked[SCENE_BATCH];
    cw_ray rays[SCENE_BATCH];
    cw_hit hits[SCENE_BATCH];
} detail_room;

/* The closest hits of at most SCENE_BATCH rays of the full field's space: hits[k] is a hit on level levels[k]. Rays meet the
 * levels within the full field's box alone, which coarser fields may reach beyond. reach[k] multiplies begin for ray k. tracer
 * is called with the level in place of the field. Returns how many rays it was given in all. */
size_t detail_closest(const detail *d, const detail_view *view, const scene_tracer *tracer, const cw_ray *rays,
                      const float *reach, size_t n, cw_hit *hits, uint8_t *levels, detail_room *room);

#endif
