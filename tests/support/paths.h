/* SPDX-License-Identifier: Apache-2.0 */
/* Every way to an answer: each kernel that this machine runs with each leaf test that it takes. */
#ifndef CELLWALK_TESTS_PATHS_H
#define CELLWALK_TESTS_PATHS_H

#include "cellwalk_expert.h"

typedef struct path {
    cw_run query;
    const char *name; /* of the kernel */
    cw_leaf leaf;
    bool strict; /* follows src/scalar/strict.h, so its bits are those of "cell" with the same leaf test */
} path;

enum { PATHS_MAX = 64 };

/* How many there are; the "cell" comes before the other strict ones. */
size_t paths_find(path paths[PATHS_MAX]);

#endif
