/* SPDX-License-Identifier: Apache-2.0 */
/* Verdicts of the oracle, counted and printed. */
#ifndef CELLWALK_TESTS_TALLY_H
#define CELLWALK_TESTS_TALLY_H

#include "oracle.h"
#include "rays.h"

typedef struct tally {
    size_t rays, hits, passes;
    size_t verdict[VERDICTS];
    double residual; /* worst */
    size_t
        digits; /* right hits whose t, u or v is off by more than judgement allows, which watertight ones may not be */
    size_t nearest; /* right hits whose t was held to half a unit in the last place */
} tally;

void tally_add(tally *t, const cw_hit *hit, const oracle_truth *truth, const judgement *j);
void tally_print(const char *what, const tally *t);

/* To stdout: all that is needed to repeat and to understand a verdict. */
void tally_explain(const test_field *f, const cw_ray *ray, const cw_hit *hit, const oracle_truth *truth,
                   const judgement *j);

#endif
