/* SPDX-License-Identifier: Apache-2.0 */
/* The skyline: how high the highest of many straight edges stands in each direction of a range, as pieces of those
 * edges. Directions u and rises w are those of a projection, so that edges stay straight.
 *
 * A piece keeps the line w = a + b u of its edge from end to end, however often it is cut, so that cutting adds no
 * error to it. Where two pieces meet is rounded: who looks in a direction sees all pieces within SKYLINE_BLUR of it and
 * gets the lowest and the highest of them. Pieces also keep how much higher an edge may be that was left out by
 * rounding. Edges narrower than half of that would be too steep for lines: they become level pieces as high as their
 * higher end, which say how far below the truth may be. These fill whole eighths of SKYLINE_BLUR, and those in one
 * eighth are joined. Otherwise each edge beside a strip would keep a bit of it, and looks would see thousands. */
#ifndef CELLWALK_TERRAIN_SKYLINE_H
#define CELLWALK_TERRAIN_SKYLINE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* b if a is NaN. fmax is a call into the library. */
static inline double skyline_larger(double a, double b) { return a > b ? a : b; }

#define SKYLINE_BLUR 0x1p-19

typedef struct skyline_piece {
    double from; /* up to where the next one begins */
    double a, b;
    float below; /* the truth may be lower by that */
    float above; /* and higher by that, since rounding may have left out a higher edge */
} skyline_piece;

typedef struct skyline {
    skyline_piece *pieces;
    /* Of each piece; 0 is the end: piece 0 begins at infinity. Walks wait for it, so it is not in the pieces, whose
     * place takes longer to find. */
    uint32_t *next;
    uint32_t count, room, unused; /* unused: a list of pieces */
    skyline_piece *cuts;          /* the parts into which an edge cuts pieces */
    size_t cuts_room;
    double from, until; /* the range */
    double steepest;    /* greatest b so far, without its sign */
    bool failed;        /* memory is short */
} skyline;

/* The piece with which all begins: it stays the first. */
enum { SKYLINE_FIRST = 1 };

bool cw_skyline_init(skyline *s, double from, double until); /* nothing stands anywhere */
void cw_skyline_free(skyline *s);

/* An edge from one (u, w) to another. start: a piece that begins before it. */
void cw_skyline_add(skyline *s, uint32_t start, const double one[2], const double other[2]);

/* The last piece that begins at or before u; start begins there or before. */
static inline uint32_t skyline_find(const skyline *s, uint32_t start, double u) {
    const skyline_piece *p = s->pieces;
    while (p[s->next[start]].from <= u) start = s->next[start];
    return start;
}

/* Bounds on the skyline in direction u, to which the errors of the edges come. The look begins at piece
 * *at, which moves on, so that it serves any greater u. */
static inline void skyline_at(const skyline *s, uint32_t *at, double u, double *low, double *high) {
    const skyline_piece *p = s->pieces;
    *at = skyline_find(s, *at, u - SKYLINE_BLUR);
    uint32_t k = *at;
    *high = p[k].a + p[k].b * u;
    *low = *high - (double)p[k].below;
    for (k = s->next[k]; p[k].from < u + SKYLINE_BLUR; k = s->next[k]) {
        const double w = p[k].a + p[k].b * u, under = w - (double)p[k].below;
        *high = w > *high ? w : *high;
        *low = under < *low ? under : *low;
    }
}

/* How far the line of a piece, or of an edge, may be from the true one at height w: papers/terrain.md. */
static inline double skyline_rounding(double w, double b) { return 0x1p-48 * (fabs(w) + fabs(b)); }

/* The same of pieces within 2^-40 alone: enough where no narrow edge is near, since pieces that cross meet to rounding,
 * and ends of edges are rounded by 2^-52. False where one is near. at is not behind the last piece that begins before u
 * less SKYLINE_BLUR. The edges' errors included, the truth is between *low - *doubt and *high + *doubt. */
static inline bool skyline_at_closely(const skyline *s, uint32_t at, double u, double *low, double *high,
                                      double *doubt) {
    const skyline_piece *p = s->pieces;
    *low = INFINITY;
    *high = -INFINITY;
    *doubt = 0;
    for (uint32_t k = at; k == at || p[k].from < u + SKYLINE_BLUR; k = s->next[k]) {
        if (p[k].below > 0) return false;
        if (p[s->next[k]].from < u - 0x1p-40 || p[k].from > u + 0x1p-40) continue;
        const double w = p[k].a + p[k].b * u, here = (double)p[k].above + skyline_rounding(w, p[k].b);
        *high = w > *high ? w : *high;
        *low = w < *low ? w : *low;
        *doubt = here > *doubt ? here : *doubt;
    }
    return true;
}

/* The lowest between two directions. */
double cw_skyline_least(const skyline *s, uint32_t start, double from, double until);

#endif
