/* SPDX-License-Identifier: Apache-2.0 */
/* Traces the same aimed rays with all contenders and counts faults by class of rays. The test does so for some
 * seconds, the program cellwalk-stability for any time. */
#ifndef CELLWALK_TESTS_STABILITY_RUN_H
#define CELLWALK_TESTS_STABILITY_RUN_H

#include "io_error.h"
#include "oracle.h"
#include "peers/peer.h"
#include "stability/aimed.h"
#include "workload/fields.h"

/* Small fields for aimed rays, from smooth land to whole numbers and cliffs, planes that hardly rise and heights that are denormal.
 * False if out of memory; freed by workload_field_free. */
enum { AIMED_FIELDS = 10 };
bool aimed_field_make(size_t number, workload_field *field);

enum { BATCH_RAYS = 4096, SLOW_RAYS = 512, CONTENDERS_MAX = 48, ULP_BINS = 32 };

typedef enum contender_role {
    ROLE_REFERENCE, /* the default kernel, watertight: before all rays, closest and any, all its hits checked */
    ROLE_SAME_BITS, /* another kernel with the same rules: closest and any hit compared bit for bit with the reference */
    ROLE_OTHER_RULES /* judged without a reference */
} contender_role;

typedef struct tested {
    contender contender;
    contender_role role;
    unsigned every; /* takes part in one round of that many */
    unsigned turn;  /* which one; it does not depend on the other contenders of this machine */
    size_t rays;    /* with that many rays of each batch, the first */
} tested;

typedef struct counts {
    uint64_t rays, hits;
    uint64_t pass;     /* rays that are known to pass */
    uint64_t leaks;    /* misses of those */
    uint64_t phantoms; /* of all hits */
    uint64_t exact;    /* hits that rational numbers had to decide on */
    uint64_t other;    /* rays whose any hit, or for ROLE_SAME_BITS either hit, is not the reference's closest */
    double residual;   /* worst |d| / E of hits that hold */
    double apart;      /* worst distance off the triangle over delta of hits that hold */
    uint64_t sampled;  /* judged in full by the oracle */
    uint64_t verdict[VERDICTS];
    double t_error;         /* worst error of t over its bound */
    uint64_t ulp[ULP_BINS]; /* right hits with an error of t of at most 2^(k - 1) ulp; all beyond in the last */
    uint64_t unfounded;     /* rays known to pass of which the oracle does not say so: the construction is wrong */
} counts;

/* Adds b to a. */
void counts_add(counts *a, const counts *b);

/* A field, for those who trace and for the oracle. */
typedef struct stability_field {
    workload_field samples;
    aimed_field aimed;
    cw_field *field;
    oracle *oracle;
} stability_field;

typedef struct stability {
    stability_field field[AIMED_FIELDS];
    tested tested[AIMED_FIELDS][CONTENDERS_MAX];
    void *peers[AIMED_FIELDS][2]; /* Embree's, plain and robust */
    unsigned contenders;
    counts count[CONTENDERS_MAX][AIM_COUNT][START_COUNT];
    unsigned sample;  /* one ray in so many is judged in full */
    uint64_t batches; /* so far, over all classes and fields */
    bool explain;     /* print the faults of the reference's answers, for the first few */
    unsigned explained;
} stability;

/* Makes fields and contenders. others: every how many rounds kernels but the reference take part; slow: likewise the 3D
 * grid; peers: likewise Embree, 0 for not at all. False with the reason in error; stability_free in any case. */
typedef struct stability_shares {
    unsigned others, slow, peers;
} stability_shares;
bool stability_make(stability *s, stability_shares shares, unsigned sample, io_error *error);
void stability_free(stability *s);

/* Batch number of a run: which field, class and rays follows from it alone. */
void stability_batch(stability *s, uint64_t number);

/* Batches in a round, one for each class and field; all rays of a round start alike: over the field, afar or near. */
enum { ROUND_BATCHES = AIM_COUNT * AIMED_FIELDS };

/* The counts of contender number which in a class, or in all if kind is AIM_COUNT. */
counts stability_sum(const stability *s, unsigned which, aim kind);

/* Faults: of the reference leaks, phantoms, wrong surfaces, and errors of t that exceed their bound; of its like
 * other bits; of the construction unfounded rays. */
uint64_t stability_faults(const stability *s);

#endif
