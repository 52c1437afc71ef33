/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of which the truth is known by construction, as cheap to make as to trace: they start clearly above all samples
 * and are clearly below all of them somewhere over the field, or the reverse; so a miss is a leak, without an oracle. In
 * between they are aimed at what rounding can miss. Those that graze a triangle cross it well inside, by more than the
 * bound on a computed height where they can. */
#ifndef CELLWALK_TESTS_AIMED_H
#define CELLWALK_TESTS_AIMED_H

#include "oracle.h"
#include "random.h"

typedef enum aim {
    AIM_INSIDE,   /* at a place inside a triangle: the others' control */
    AIM_VERTEX,   /* at a sample */
    AIM_EDGE,     /* at a place on a border edge */
    AIM_DIAGONAL, /* at a place on a diagonal */
    AIM_BORDERS,  /* along a grid line, exactly above or on its edges and samples */
    AIM_AXIS,     /* along x or y between two grid lines */
    AIM_CORNERS,  /* over samples in whole steps, where x and y borders and diagonals are crossed at once */
    AIM_VERTICAL, /* straight up or down, at a sample, an edge, a diagonal or inside */
    AIM_STEEP,    /* all but vertical, down to directions so small that they count as zero */
    AIM_LONG,     /* across the whole field, hardly above its highest sample to hardly below its lowest */
    AIM_FAR,      /* at a sample or edge from up to a million cells away */
    AIM_GRAZING,  /* at 1 to 1e-6 degrees to a triangle */
    AIM_COUNT
} aim;

/* "inside", "vertex" … */
const char *aim_name(aim kind);
/* A few words for a table. */
const char *aim_text(aim kind);

typedef struct aimed_field {
    const char *name, *text;
    size_t nx, ny;
    float *z;
    double low, high;
    cw_field *field;
    oracle *oracle;
} aimed_field;

enum { AIMED_FIELDS = 8 };

/* Field number in [0, AIMED_FIELDS); false when out of memory. */
bool aimed_field_make(aimed_field *f, size_t number);
void aimed_field_free(aimed_field *f);

typedef struct aimed_ray {
    cw_ray ray;
    bool passes; /* a miss is a leak; else nothing is known about misses */
} aimed_ray;

aimed_ray aimed_ray_make(aim kind, const aimed_field *f, random_state *r);

#endif
