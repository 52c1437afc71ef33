/* SPDX-License-Identifier: Apache-2.0 */
/* Every way to an answer: each kernel that this machine runs with each leaf test that it takes. Programs that try all
 * of them are tables of tests. */
#ifndef CELLWALK_TESTS_PATHS_H
#define CELLWALK_TESTS_PATHS_H

#include "cellwalk_expert.h"
#include "check.h"

typedef struct path {
    cw_run query;
    const char *name; /* of the kernel */
    cw_leaf leaf;
    bool strict; /* follows src/scalar/strict.h, so its bits are those of "cell" with the same leaf test */
} path;

enum { PATHS_MAX = 64 };

/* The "cell" comes before the other strict ones. */
extern path paths[PATHS_MAX];
extern size_t path_count;

/* Finds all paths and runs the n rows whose names match one of the program's arguments, which are patterns as of a
 * shell; all without arguments. */
int paths_run(const char *name, struct CMUnitTest *rows, size_t n, int argc, char **argv);

#endif
