/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench report: results as Markdown, on standard output or into a page between markers, so that the figures in a
 * page are always those of a file. */
#ifndef CELLWALK_BENCH_REPORT_H
#define CELLWALK_BENCH_REPORT_H

#include "error.h"

#include <jansson.h>
#include <stdbool.h>

/* Replaces what stands between the lines <!-- begin:mark --> and <!-- end:mark --> of the file by text. The markers stay,
 * and so does all else to the byte. A file without exactly one such pair is an error and stays as it is. */
bool report_into(const char *path, const char *mark, const char *text, io_error *error);

/* *same: whether exactly that is what stands there. */
bool report_is_in(const char *path, const char *mark, const char *text, bool *same, io_error *error);

/* The whole page, to be freed; NULL with the reason in error. */
char *report_read_page(const char *path, io_error *error);

/* The results of micro: a row a class of rays, a column a field, in each the fastest of the library's kernels and its
 * speed over Embree's best width. NULL if out of memory. */
char *report_micro(const json_t *lines);

int report_main(char **arguments, int count);

#endif
