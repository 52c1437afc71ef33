/* SPDX-License-Identifier: Apache-2.0 */
/* Results of the long run as JSON lines, and as the tables of papers/stability.md. */
#ifndef CELLWALK_TESTS_STABILITY_PAGE_H
#define CELLWALK_TESTS_STABILITY_PAGE_H

#include "stability_run.h"

/* Writes one line of kind "run", one of kind "field" for each field, one of kind "result" for each contender and class. */
bool stability_write(const stability *s, const char *path, double seconds, io_error *error);

/* Markdown from one or more such files, whose counts are added up. NULL with the reason in error. */
char *stability_page(const char *const *paths, size_t count, io_error *error);

#endif
