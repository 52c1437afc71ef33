/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/cells.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 100, GAP = 2 };

void cells_add(cells *t, const char *format, ...) {
    if (t->row == CELLS_ROWS_MAX || t->column == CELLS_COLUMNS_MAX) return;
    va_list list;
    va_start(list, format);
    if (vasprintf(&t->text[t->row][t->column], format, list) < 0) t->text[t->row][t->column] = NULL;
    va_end(list);
    t->column++;
}

void cells_end_row(cells *t) {
    if (t->row < CELLS_ROWS_MAX) t->row++;
    t->column = 0;
}

static const char *cell(const cells *t, size_t row, size_t column) {
    return t->text[row][column] ? t->text[row][column] : "";
}

static size_t columns_of(const cells *t) {
    size_t n = 0;
    while (n < CELLS_COLUMNS_MAX && t->text[0][n]) n++;
    return n;
}

static int is_left(const cells *t, size_t column) {
    const char *head = cell(t, 0, column);
    return column == 0 || (*head && head[strlen(head) - 1] == ' ');
}

/* ---- Markdown ---- */

static void print_markdown(const cells *t, FILE *to) {
    const size_t columns = columns_of(t);
    for (size_t row = 0; row < t->row; row++) {
        fputc('|', to);
        for (size_t c = 0; c < columns; c++) fprintf(to, " %s |", cell(t, row, c));
        fputc('\n', to);
        if (row > 0) continue;
        fputc('|', to);
        for (size_t c = 0; c < columns; c++) fputs(is_left(t, c) ? "---|" : "--:|", to);
        fputc('\n', to);
    }
}

/* ---- text ---- */

/* Columns of a terminal that so many bytes take. */
static size_t width_of(const char *text, size_t bytes) {
    size_t width = 0;
    for (size_t k = 0; k < bytes; k++) width += ((unsigned char)text[k] & 0xc0) != 0x80;
    return width;
}

/* A line of a cell; only the head has more than one, which end at its commas. */
static const char *line_of(const cells *t, size_t row, size_t column, size_t line, size_t *bytes) {
    const char *at = cell(t, row, column);
    for (size_t skip = line; skip > 0; skip--) {
        at += strcspn(at, row == 0 ? "," : "");
        at += *at == ',';
        at += strspn(at, " ");
    }
    *bytes = row == 0 ? strcspn(at, ",") : line == 0 ? strlen(at) : 0;
    while (*bytes > 0 && at[*bytes - 1] == ' ') --*bytes;
    return at;
}

enum { HEAD_LINES = 3 };

static size_t column_width(const cells *t, size_t column) {
    size_t most = 0, bytes;
    for (size_t row = 0; row < t->row; row++)
        for (size_t line = 0; line < (row == 0 ? HEAD_LINES : 1); line++) {
            const char *text = line_of(t, row, column, line, &bytes);
            const size_t width = width_of(text, bytes);
            most = width > most ? width : most;
        }
    return most;
}

/* One line of the columns [first, last) with column 0 before them; nothing if all are empty. */
static void print_line(const cells *t, FILE *to, size_t row, size_t line, size_t first, size_t last) {
    size_t any = 0, bytes, owed = 0;
    for (size_t c = 0; c < last; c = c == 0 ? first : c + 1) {
        line_of(t, row, c, line, &bytes);
        any += bytes;
    }
    if (any == 0) return;
    for (size_t c = 0; c < last; c = c == 0 ? first : c + 1) {
        const char *text = line_of(t, row, c, line, &bytes);
        const size_t pad = column_width(t, c) - width_of(text, bytes);
        owed += c == 0 ? 0 : GAP;
        if (!is_left(t, c)) owed += pad;
        if (bytes > 0) {
            fprintf(to, "%*s%.*s", (int)owed, "", (int)bytes, text);
            owed = 0;
        }
        if (is_left(t, c)) owed += pad;
    }
    fputc('\n', to);
}

static void print_text(const cells *t, FILE *to) {
    const size_t columns = columns_of(t);
    for (size_t first = 1, last; first < columns; first = last) {
        size_t width = column_width(t, 0);
        for (last = first; last < columns; last++) {
            width += GAP + column_width(t, last);
            if (width > WIDTH && last > first) break;
        }
        if (first > 1) fputc('\n', to);
        for (size_t row = 0; row < t->row; row++)
            for (size_t line = 0; line < (row == 0 ? HEAD_LINES : 1); line++) print_line(t, to, row, line, first, last);
    }
}

void cells_print(cells *t, FILE *to, cells_format format) {
    if (t->column > 0) cells_end_row(t);
    if (format == CELLS_MARKDOWN)
        print_markdown(t, to);
    else
        print_text(t, to);
    for (size_t row = 0; row < t->row; row++)
        for (size_t c = 0; c < CELLS_COLUMNS_MAX; c++) free(t->text[row][c]);
    *t = (cells){.row = 0};
}
