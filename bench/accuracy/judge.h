/* SPDX-License-Identifier: Apache-2.0 */
/* Judges an answer. The ray is followed over the surface in double, crossing by crossing. A crossing counts only if
 * the ray is farther from the surface there than rounding (tests/oracle/bounds.h) and the claim of the answer's mode
 * can explain. */
#ifndef CELLWALK_BENCH_ACCURACY_JUDGE_H
#define CELLWALK_BENCH_ACCURACY_JUDGE_H

#include "cellwalk.h"

/* ---- exact.c ---- */

/* The true surface: sample (i, j) is z[j * nx + i]; no holes. The samples must stay. */
typedef struct true_surface {
    const float *z;
    size_t nx, ny;
    double low, high; /* of all samples */
    double steepest;  /* of their differences along edges, in size */
} true_surface;

true_surface true_surface_of(const float *z, size_t nx, size_t ny);

typedef struct exact_hit {
    double t, u, v; /* u and v as in cw_hit */
    int32_t i, j;
    uint32_t triangle;
} exact_hit;

/* Sum of count numbers, rounded about once: its relative error is less than 2^-52. count <= EXACT_SUM_MAX. */
enum { EXACT_SUM_MAX = 16 };
double exact_sum(const double *numbers, int count);

/* Where the ray meets the plane of a triangle; u and v tell whether inside. False if it runs parallel to it. */
bool exact_meet(const true_surface *on, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle, exact_hit *hit);

/* Errors of a t: in units of the float's last place at the exact t; as the distance along the ray between the two
 * places, in cells. */
double exact_error_ulp(double t, double exact);
double exact_error_cells(const cw_ray *ray, double t, double exact);

/* ---- judge.c ---- */

/* How far a mode's surface may be from the true one, in height. Zero for the exact surface. */
typedef struct accuracy_claim {
    double height;
} accuracy_claim;

typedef enum accuracy_verdict {
    ACCURACY_RIGHT = 0, /* the same surface, or both miss: its t can be held against the exact one */
    ACCURACY_TIE,       /* another answer, within rounding and claim: a touch, an end, a silhouette */
    ACCURACY_LEAK,      /* a miss, although the ray passes from clearly above to clearly below, or the reverse */
    ACCURACY_PHANTOM,   /* a hit where the ray is clear of the surface */
    ACCURACY_WRONG,     /* a hit, but the ray has clearly passed through the surface before */
    ACCURACY_VERDICT_COUNT
} accuracy_verdict;

typedef struct accuracy_track {
    bool passes; /* the ray is clear on one side of the surface, and later on the other */
    bool clear;  /* it is clear on one side at every crossing */
    bool near;   /* it might be a hit at all of the crossings; all three are false if it is not over the field */
} accuracy_track;

/* The ray for t in [from, to], as far as it is over the field. */
accuracy_track accuracy_follow(const true_surface *on, const cw_ray *ray, double from, double to,
                               const accuracy_claim *claim);

/* The place where the ray meets the surface that a hit means: on the hit's triangle, or, where the ray exactly
 * passes beside that, on one of the cells around it, the nearest in t that the ray reaches from the hit without
 * getting clear of the surface. Where there is none, on the triangle's plane; where the ray runs within that plane,
 * at the hit's own t. */
exact_hit accuracy_exact(const true_surface *on, const cw_ray *ray, const cw_hit *hit);

/* How far above or below the surface the ray's point at t is, in cells; outside the field, the surface goes on as at
 * its border. Unlike the error of t it stays small where the ray runs along the surface, where a rounding of the ray
 * itself would move t by as much. */
double accuracy_off_surface(const true_surface *on, const cw_ray *ray, double t);

/* truth is the reference's answer and exact the result of accuracy_exact for it, NULL if it misses. */
accuracy_verdict accuracy_judge_closest(const true_surface *on, const cw_ray *ray, const accuracy_claim *claim,
                                        const cw_hit *truth, const exact_hit *exact, const cw_hit *answer);
accuracy_verdict accuracy_judge_any(const true_surface *on, const cw_ray *ray, const accuracy_claim *claim, bool truth,
                                    bool answer);

#endif
