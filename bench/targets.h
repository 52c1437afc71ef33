/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench report --targets: what is aimed at in speed and size, held against what cellwalk-bench measure found. */
#ifndef CELLWALK_BENCH_TARGETS_H
#define CELLWALK_BENCH_TARGETS_H

#include "error.h"

#include <jansson.h>
#include <stdio.h>

enum { TARGETS_ISAS = 3 };

/* The files of a folder; NULL where there is none. speed: AVX-512, AVX2, SSE4.2. */
typedef struct targets_data {
    json_t *speed[TARGETS_ISAS], *building, *threads;
} targets_data;

/* False if a file cannot be read or there is no file of speeds at all. To be closed either way. */
bool targets_open(targets_data *data, const char *folder, io_error *error);
void targets_close(targets_data *data);

typedef enum target_kind {
    TARGET_MEAN = 0,   /* geometric mean of speed over Embree's best width, all classes, 257 to 4097 samples a side */
    TARGET_PRIMARY,    /* the lowest such ratio on land of any size */
    TARGET_SHADOW,     /* likewise */
    TARGET_SCATTERED,  /* ambient occlusion and bounce: the lower of their geometric means, 257 to 4097 */
    TARGET_INCOHERENT, /* random and grazing: likewise */
    TARGET_MEMORY,     /* most bytes a cell, samples included, beyond the first megabyte */
    TARGET_BUILD_TRIANGLES, /* least ratio of Embree's time to build its triangles to ours, 1025 and 4097 */
    TARGET_BUILD_GRID,
    TARGET_SCALING, /* the most that a class takes longer for a ray at 8193 than at 257 */
    TARGET_THREADS, /* least speed of two threads over that of one */
    TARGET_COUNT
} target_kind;

typedef struct target {
    double wanted;
    bool at_most;    /* else at least */
    double measured; /* 0: the data do not say */
    char where[48];  /* on which field and class the measured value stands, "" if on many */
} target;

const char *target_title(target_kind kind);
/* The instruction set's name as the data have it: "avx512", "avx2", "sse4.2". */
const char *targets_isa(size_t isa);
/* Whether the row holds for each instruction set alike: memory, building, threads. */
bool target_is_general(target_kind kind);
target target_of(const targets_data *data, size_t isa, target_kind kind);
bool target_is_met(const target *t);

/* The library's own kernel and the fastest width of Embree's triangles; NULL where there is none or it was left out. */
const json_t *targets_own(const json_t *lines, const char *field, const char *rays);
const json_t *targets_embree(const json_t *lines, const char *field, const char *rays);

/* targets_text.c: the whole page, and the same figures with commas. */
void targets_markdown(FILE *to, const targets_data *data);
/* Its three parts: what is aimed at, speeds, and memory with building, which is nothing without its file. */
void targets_put_table(FILE *to, const targets_data *data);
void targets_put_speeds(FILE *to, const targets_data *data);
void targets_put_building(FILE *to, const targets_data *data);
void targets_csv(FILE *to, const targets_data *data);

#endif
