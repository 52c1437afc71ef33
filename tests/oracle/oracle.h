/* SPDX-License-Identifier: Apache-2.0 */
/* The exact oracle: where a ray meets a height field, decided in numbers so long that
 * nothing is rounded. It shares no code with the library; only the structs of its header.
 *
 * The exact answer to a ray: the smallest t in [tmin, tmax] at which org + t · dir lies on a closed triangle without a
 * hole; with the header's conventions (direction components of at most 2^-128 are zero, those above 2^126 infinite, t
 * is clamped to half of the largest float, NaN, infinite and zero directions miss).
 *
 * Judging a kernel, which computes in float, needs to know what rounding excuses. With d(t) the exact height of the ray
 * above the surface, E(t) the bound of papers/numerics.md on the error of a computed d, and delta(t) its bound on that
 * of a computed place:
 *  - d is *clear* at t if |d(t)| > E(t) + 2 S delta(t), S being the slope: then no triangle within delta of the place
 *    has a computed d of the other sign.
 *  - The ray *passes* on a stretch of its t-range if the stretch lies over solid triangles, everywhere at least delta
 *    from holes and from the field's outer border, and d is clear and of one sign at one crossing of it, clear and of
 *    the other sign at a later one. Crossings: where the ray crosses a border or a diagonal, and the stretch's ends.
 *  - A miss is a *leak* if the ray passes.
 *  - A hit is a *phantom* if its triangle has a hole, or the exact ray at the hit's t is farther than delta from the
 *    triangle or than E from its plane. It is on the *wrong surface* if the ray has passed before the hit's t.
 *  - All other answers are right; *exactly* if hit and triangle are the exact ones, *up to a tie* if they differ by
 *    what lies within the bounds: a neighbour across an edge or vertex, or a touch. */
#ifndef CELLWALK_TESTS_ORACLE_H
#define CELLWALK_TESTS_ORACLE_H

#include "cellwalk.h"

typedef struct oracle oracle;

/* Reads samples until it is destroyed; NULL when out of memory. */
oracle *oracle_create(const float *samples, size_t nx, size_t ny);
void oracle_destroy(oracle *o);

typedef struct oracle_triangle {
    int32_t i, j;
    uint32_t triangle;
} oracle_triangle;

/* The exact answer. */
typedef struct oracle_truth {
    bool hit;
    double t;    /* off by less than 2^-50 relative */
    unsigned at; /* triangles that hold the point: 1 inside, 2 on an edge, up to 6 at a vertex */
    oracle_triangle triangle[6];
    bool coplanar; /* the ray runs within a triangle from the hit on */
    bool passes;   /* clearly passes, at any t */
    double pass_t; /* the first crossing by which it has */
    /* Where it goes through: the distance to its triangle's nearest edge, and how far Möller-Trumbore's place there
     * may be off: it may leak where pass_edge <= pass_blur, and has no excuse elsewhere. */
    double pass_edge, pass_blur;
} oracle_truth;

/* Traces one ray; the truth stays until the next. */
const oracle_truth *oracle_trace(oracle *o, const cw_ray *ray);

/* Whether the exact hit is on a triangle. */
bool oracle_names(const oracle_truth *truth, const oracle_triangle *t);

typedef enum verdict {
    VERDICT_RIGHT,         /* miss and miss, or hit and hit on a triangle that holds the exact point */
    VERDICT_TIE,           /* within the bounds of rounding, not the exact answer */
    VERDICT_LEAK,          /* misses, though the ray passes */
    VERDICT_PHANTOM,       /* hits what is not there */
    VERDICT_WRONG_SURFACE, /* hits after the ray has passed */
    VERDICTS
} verdict;
const char *verdict_name(verdict v);

/* Whether a hit is where ray and surface are. Doubles decide where their error cannot matter, else exact numbers. */
typedef struct hit_check {
    bool holds;        /* no phantom */
    double residual;   /* |d| at the hit's t over E and what t's rounding adds, <= 1 unless a phantom */
    double apart;      /* distance of the exact ray, at the hit's t, from the triangle; <= 0 within */
    double apart_most; /* delta and what t's rounding adds, which it may not exceed */
} hit_check;

typedef struct judgement {
    verdict verdict;
    hit_check at; /* of hits on solid triangles */
    double blur;  /* how far off Möller-Trumbore's place in such a triangle may be; infinite if the ray is parallel */
    /* Of right hits: */
    /* |t - exact t|, and what it may be: half an ulp, and E / |d'| near an edge; infinite if the ray is parallel. */
    double t_error, t_bound;
    /* How far u and v are off, and may be; both 0 where an edge is near. */
    double place_error, place_bound;
} judgement;

/* Whether t, u and v of a right, watertight hit are as good as they have to be. */
static inline bool digits_hold(const judgement *j) {
    return j->verdict != VERDICT_RIGHT ||
           (j->t_error <= j->t_bound && (j->place_bound == 0 || j->place_error <= j->place_bound));
}

/* Judges an answer to the ray last traced. */
judgement oracle_judge(oracle *o, const cw_hit *hit);

/* ---- without tracing: for rays of which the truth is known by construction --------------------------------------- */

/* Makes a ray the present one; false if by the header's conventions it misses. */
bool oracle_ray(oracle *o, const cw_ray *ray);

/* Whether the present ray is, at t, clear of the surface on the side of side (1 above, -1 below), and over the field by
 * more than 2 delta. over: the triangle that it is over; or NULL, and then it is clear of all samples. A ray that is
 * clear on one side and later on the other, on a field without holes, passes. */
bool oracle_clear(const oracle *o, double at, int side, const oracle_triangle *over);

/* Is a hit where the present ray and the surface are, within the bounds? */
hit_check oracle_check(oracle *o, const cw_hit *hit);

#endif
