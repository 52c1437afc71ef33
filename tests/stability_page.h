/* SPDX-License-Identifier: Apache-2.0 */
/* Results of the long run as JSON lines. */
#ifndef CELLWALK_TESTS_STABILITY_PAGE_H
#define CELLWALK_TESTS_STABILITY_PAGE_H

#include "stability_run.h"

/* Writes one line of kind "run", one of kind "field" for each field, one of kind "result" for each contender and class. */
bool stability_write(const stability *s, const char *path, double seconds, io_error *error);

#endif
