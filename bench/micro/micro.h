/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench micro: every kernel × ray class × field. */
#ifndef CELLWALK_BENCH_MICRO_MICRO_H
#define CELLWALK_BENCH_MICRO_MICRO_H

#include "harness/agree.h"
#include "harness/interleave.h"
#include "harness/run.h"
#include "output.h"
#include "peers/contender.h"
#include "peers/embree.h"
#include "workload/fields.h"
#include "workload/ray_classes.h"

enum {
    MICRO_CONTENDERS_MAX = 96,
    PEER_KINDS = 4,
    MICRO_KERNELS_MAX = 32,
    MICRO_THREADS_MAX = 16,
    MICRO_BUILDS_MAX = MICRO_KERNELS_MAX * MICRO_THREADS_MAX
};

typedef struct micro_options {
    run_options run;
    option_list kernels, rays, fields, leaves, peers; /* numbers: of kernels, classes, fields, peers */
    option_list threads;                              /* how many to run each kernel with */
    option_list backs; /* how many times the field's longer side rays start farther back */
    const char *json;
    unsigned count, call;
    int quality; /* of Embree: 0 high, 1 medium */
    double seconds, width, pass;
    bool longer, small_pages;
    cw_pool *pools[MICRO_THREADS_MAX]; /* for each number of threads above 1, else NULL */
    bool by_clock;                     /* time by the clock, as is done for all once one has more than one thread */
} micro_options;

/* The structures of a contender. seconds: CPU time, or by the clock if everything is, median of the builds. */
typedef struct micro_build {
    const char *name; /* a kernel's, or "embree/triangles" */
    unsigned threads; /* of a kernel; 0 for Embree */
    double seconds;
    double update_seconds; /* elapsed, median: an update of 64 x 64 samples; 0 if there is no separate update */
    size_t builds, bytes;
    const char *quality; /* "high" or "medium" for Embree, NULL for kernels */
} micro_build;

typedef struct micro_peer {
    micro_build build;
    peer_embree *embree;
} micro_peer;

/* A field with all that is measured on it. */
typedef struct micro_field {
    workload_field samples;
    cw_field *field;
    const char *default_kernel; /* the library's choice for it */
    micro_peer peers[PEER_KINDS];
    size_t peer_count;
    micro_build builds[MICRO_BUILDS_MAX]; /* of the kernels that need something built, with each number of threads */
    size_t build_count;
} micro_field;

/* Both build as often as fits half a second, from once to five times, since one build of a small field is too short
 * to time. on->field exists already; the kernels build on another field. */
bool micro_build_kernels(micro_field *on, const micro_options *options, io_error *error);
bool micro_build_peer(micro_peer *peer, const cw_field *field, const peer_options *options, io_error *error);

/* One contender's figures in a group: one class of rays on one field. */
typedef struct micro_row {
    contender contender;
    double predicted; /* seconds of a pass by the probe, where the contender was left out; else 0 */
    contender_pass pass;
    interleave_job job;
    agreement agreement;
    double to_embree; /* Embree's best median over this one's: above 1 is faster than Embree; 0 without Embree */
} micro_row;

typedef struct micro_group {
    micro_field *on;
    workload_class c;
    double back;
    char name[32]; /* "random", or "random+5" if they start 5 times the field's longer side farther back */
    cw_ray *rays;
    size_t ray_count;
    contender reference; /* whose answers all others are held against */
    micro_row rows[MICRO_CONTENDERS_MAX];
    size_t row_count;
    double hit_share;
} micro_group;

/* Fills group from the options, verifies, and measures. on, c, back and name are given, all else is zero;
 * rays are to be freed. seconds is for all that. */
bool micro_group_run(micro_group *group, const micro_options *options, double seconds, io_error *error);

/* Human text on standard output. */
void micro_print_field(const micro_field *on);
void micro_print_group(const micro_group *group);

/* JSON lines; does nothing if out->file is NULL. */
bool micro_write_field(io_output *out, const micro_field *on, io_error *error);
bool micro_write_group(io_output *out, const micro_group *group, io_error *error);

/* ---- compare.c ---- */

/* How many comparisons came out which way. */
typedef struct compare_counts {
    size_t faster, slower, undecided, unmatched;
    size_t controls; /* compared too, without a verdict */
} compare_counts;

/* Prints a line for each result that both files have; fails if there is none. margin: see statistics_ratio. */
bool compare_files(const char *path_a, const char *path_b, double margin, compare_counts *counts, io_error *error);

#endif
