/* SPDX-License-Identifier: Apache-2.0 */
/* Results of the long run as JSON lines, and as the tables of papers/stability.md. */
#ifndef CELLWALK_TESTS_STABILITY_PAGE_H
#define CELLWALK_TESTS_STABILITY_PAGE_H

#include "stability_run.h"

#include <jansson.h>
#include <stdio.h>

/* Writes one line of kind "run", one of kind "field" for each field, one of kind "result" for each contender and class. */
bool stability_write(const stability *s, const char *path, double seconds, io_error *error);

/* Markdown from one or more such files, whose counts are added up; or from the counts of the tests extremes, exhaustive or
 * stress, or from what micro --leaf all wrote. *mark becomes the name of the markers that it goes between. NULL with the
 * reason in error. */
char *stability_page(const char *const *paths, size_t count, const char **mark, io_error *error);

/* stability_tables.c: the tables of these tests; and what the watertight leaf test costs, from cellwalk-bench micro. */
void stability_extremes(FILE *to, const json_t *lines);
void stability_exhaustive(FILE *to, const json_t *lines);
void stability_stress(FILE *to, const json_t *lines);
void stability_leaf(FILE *to, const json_t *lines);

/* 1234567 as "1 234 567". */
void stability_print_count(FILE *to, uint64_t n);

#endif
