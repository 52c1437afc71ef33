/* SPDX-License-Identifier: Apache-2.0 */
/* Traces the same aimed rays with all contenders and counts faults by class of rays. */
#ifndef CELLWALK_TESTS_STABILITY_RUN_H
#define CELLWALK_TESTS_STABILITY_RUN_H

#include "io_error.h"
#include "oracle.h"
#include "peers/peer.h"
#include "stability/aimed.h"
#include "workload/fields.h"

/* Batches in a round, one for each class and field; all rays of a round start alike: over the field, afar or near. */
enum { AIMED_FIELDS = 10, BATCH_RAYS = 4096, ROUND_BATCHES = AIM_COUNT * AIMED_FIELDS, CONTENDERS_MAX = 48 };

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

typedef enum counted {
    RAYS,
    HITS,
    OTHER,     /* rays whose any hit, or for ROLE_SAME_BITS either hit, is not the reference's closest */
    PASS,      /* rays that are known to pass */
    LEAKS,     /* misses of those */
    PHANTOMS,  /* of all hits */
    SAMPLED,   /* judged in full by the oracle */
    UNFOUNDED, /* known to pass, but the oracle does not say so: the construction is wrong */
    RIGHT,     /* and further verdicts on those that were judged in full */
    WHATS = RIGHT + VERDICTS
} counted;

typedef struct counts {
    size_t of[WHATS];
    double residual; /* worst |d| / E of hits that hold */
    double apart;    /* worst distance off the triangle over delta of hits that hold */
    double t_error;  /* worst error of t over its bound */
} counts;

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
    unsigned sample; /* one ray in so many is judged in full */
    unsigned explained;
} stability;

/* Makes fields and contenders. others: every how many rounds kernels but the reference take part; slow: likewise the 3D
 * grid; peers: likewise Embree, 0 for not at all. False with the reason in error; stability_free in any case. */
typedef struct stability_shares {
    unsigned others, slow, peers;
} stability_shares;
bool stability_make(stability *s, stability_shares shares, unsigned sample, io_error *error);
void stability_free(stability *s);

/* Batch number of a run: which field, class and rays follows from it alone. Prints the first faults of the reference's answers. */
void stability_batch(stability *s, uint64_t number);

/* The counts of contender number which in a class, or in all if kind is AIM_COUNT. */
counts stability_sum(const stability *s, unsigned which, aim kind);

/* Faults: of the reference leaks, phantoms, wrong surfaces, and errors of t that exceed their bound; of its like
 * other bits; of the construction unfounded rays. */
size_t stability_faults(const stability *s);

#endif
