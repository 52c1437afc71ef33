/* SPDX-License-Identifier: Apache-2.0 */
/* A table of texts, for a terminal or as Markdown. */
#ifndef CELLWALK_BENCH_HARNESS_CELLS_H
#define CELLWALK_BENCH_HARNESS_CELLS_H

#include <stddef.h>
#include <stdio.h>

enum { CELLS_COLUMNS_MAX = 40, CELLS_ROWS_MAX = 256 };

typedef enum cells_format {
    CELLS_TEXT, /* columns side by side; what is beyond the 100th column of the terminal goes below, the first column again */
    CELLS_MARKDOWN
} cells_format;

/* All zero at first. The first row is the head; the first column stands to the left, and so does any whose head ends with a
 * space. */
typedef struct cells {
    char *text[CELLS_ROWS_MAX][CELLS_COLUMNS_MAX];
    size_t row, column;
} cells;

/* The next cell of the row; what does not fit is dropped. */
__attribute__((format(printf, 2, 3))) void cells_add(cells *table, const char *format, ...);
void cells_end_row(cells *table);

/* Prints it and empties it. A comma in the head of a column ends its line in a terminal. */
void cells_print(cells *table, FILE *to, cells_format format);

#endif
