/* SPDX-License-Identifier: Apache-2.0 */
/* The main function of a program that is a table of tests. */
#ifndef CELLWALK_TESTS_ROWS_H
#define CELLWALK_TESTS_ROWS_H

#include "check.h"

#include <fnmatch.h>

/* Runs the n rows whose names match one of the program's arguments, which are patterns as of a shell; all without arguments. */
static inline int rows_run(const char *name, struct CMUnitTest *rows, size_t n, int argc, char **argv,
                           CMFixtureFunction begin, CMFixtureFunction end) {
    size_t chosen = 0;
    for (size_t k = 0; k < n; k++) {
        bool in = argc == 1;
        for (int a = 1; a < argc; a++) in |= fnmatch(argv[a], rows[k].name, 0) == 0;
        if (in) rows[chosen++] = rows[k];
    }
    if (chosen > 0) return _cmocka_run_group_tests(name, rows, chosen, begin, end);
    print_error("%s: no row has a name like that\n", name);
    return EXIT_FAILURE;
}

#endif
