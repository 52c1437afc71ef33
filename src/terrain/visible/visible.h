/* SPDX-License-Identifier: Apache-2.0 */
/* The ground in sight: from each eye of a grid, what is seen of the surface along one direction after another.
 *
 * An eye stands above a sample. Ground is in sight, or a target above it, if the straight line from the eye to it
 * passes above all ground before it; a line that touches the ground is blocked. The surface between two edges is
 * straight, so the parts in sight have ends that are solved for. Holes are neither seen nor do they hide anything. The
 * answers are the same for any instruction set, pool and part of rows. */
#ifndef CELLWALK_TERRAIN_VISIBLE_H
#define CELLWALK_TERRAIN_VISIBLE_H

#include "cellwalk_expert.h"

typedef struct cw_visible cw_visible;

typedef struct cw_visible_desc {
    double dir[2]; /* in field coordinates, as of a heading */
    double reach;  /* what is seen at t <= reach counts; 0: all */
    double drop;   /* as of cw_heading_desc */
    float eye;     /* height of the eye above its sample, from 0 to CW_HEIGHT_MAX */
    float target;  /* height above the ground that must be seen, likewise */
    double slack;  /* later directions whose shorter component differs by at most that share of the longer one take less
                      time; from 0 to 1 / 128 */
    double weight; /* of areas */
    double length; /* of a step dir */
    float label;   /* of the direction */
} cw_visible_desc;

/* Sums over directions, eye by eye. */
typedef struct cw_visible_sums {
    double *area; /* grows by weight times the integral of t over the parts in sight; NaN at a hole. NULL: none */
    /* The greatest t in sight times length, if that exceeds the number there, and its direction's label; NaN at a hole.
     * Both NULL: none. */
    float *farthest, *direction;
} cw_visible_sums;

/* Eyes at each every-th column and row of the rectangle, from its first ones on: ceil(nx / every) a row. The caller
 * owns it, and destroys it before the field, which must not be changed meanwhile. It has a copy of the field's samples,
 * and a quarter more. On failure *visible is NULL. */
cw_status cw_visible_create(const cw_field *field, cw_rectangle at, size_t every, cw_visible **visible);
/* NULL is allowed. */
void cw_visible_destroy(cw_visible *visible);
/* Adds a direction for rows row to row + rows - 1 of the eyes, of which there are some; the sums begin with the first
 * of these. Directions of the same longer axis and sign should follow each other. In the IEEE default environment, and
 * not from two threads at once. Of the run's kernel only the instruction set is used. */
cw_status cw_visible_add(cw_visible *visible, const cw_run *run, const cw_visible_desc *desc, size_t row, size_t rows,
                         cw_visible_sums sums);

#endif
