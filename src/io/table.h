/* SPDX-License-Identifier: Apache-2.0 */
/* Tables in text files: CSV as RFC 4180 has it, in UTF-8. The first line names the columns; blank lines are passed
 * over; cells may stand in quotation marks. Lines end in LF, CRLF or CR, and a byte order mark is passed over. */
#ifndef CELLWALK_IO_TABLE_H
#define CELLWALK_IO_TABLE_H

#include "output.h"

#include <stddef.h>

/* As many as a sheet of the usual programs has. */
enum { IO_TABLE_COLUMNS_MAX = 16384 };

typedef struct io_table {
    const char *path;
    size_t columns, rows;
    char **names;  /* of the columns */
    char **cells;  /* row by row, without blanks around them; behind names in its memory */
    size_t *lines; /* on which each row begins, from 1 on */
    char *text;    /* of the file; names and cells point into it */
} io_table;

/* path must stay. An error for a file without a line, for rows with fewer or more cells than there are columns, and for
 * a first line with semicolons or tabs between its names. On failure the table needs no freeing. */
bool io_table_read(const char *path, io_table *table, io_error *error);
void io_table_free(io_table *table);

/* Numbers of columns by name, whatever its case. The first `needed` must be there; others are table->columns if they
 * are not. An error if two columns have one of the names. Warns of columns with other names: a misspelt one would
 * change an answer without a word. */
bool io_table_columns(const io_table *table, const char *const *names, size_t count, size_t needed, size_t *columns,
                      const io_warner *warn, io_error *error);

/* The decimal number in a cell. An error with file, line and cell if there is none. */
bool io_table_number(const io_table *table, size_t row, size_t column, double *number, io_error *error);

/* A height above ground, or behind "=" an absolute one; an empty cell leaves both as they are. */
bool io_table_height(const io_table *table, size_t row, size_t column, double *height, bool *absolute, io_error *error);

/* Writes a comma and text as one more cell. */
bool io_table_write_cell(io_output *to, const char *text, io_error *error);

/* Fails with file, line, column's name and "'cell' stands where WANTED should". */
bool io_table_fail(const io_table *table, size_t row, size_t column, const char *wanted, io_error *error);

#endif
