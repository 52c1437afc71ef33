/* SPDX-License-Identifier: Apache-2.0 */
#include "markdown.h"

#include "words.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { WIDTH = 100, GAP = 2, COLUMNS_MAX = 40, HEAD_LINES = 3 };

/* Line number of a cell of a row "| a | b |"; only heads have more than one, which end at commas. */
static const char *cell_line(const char *row, size_t column, bool head, size_t line, size_t *bytes) {
    const char *at = row + 1;
    for (; column > 0; column--) at += strcspn(at, "|") + 1;
    const char *end = at + strcspn(at, "|");
    for (;; line--) {
        at += strspn(at, " ");
        const size_t length = head ? strcspn(at, ",|") : line > 0 ? (size_t)(end - at) : strcspn(at, "|");
        *bytes = at < end ? length : 0;
        if (line == 0) break;
        at = at + length < end ? at + length + 1 : end;
    }
    while (*bytes > 0 && at[*bytes - 1] == ' ') --*bytes;
    return at;
}

typedef struct table {
    const char *rows; /* the head, the dashes, the others, a line each */
    size_t columns, width[COLUMNS_MAX];
    bool left[COLUMNS_MAX];
} table;

static const char *next_row(const char *row) { return row + strcspn(row, "\n") + 1; }

static table measure_table(const char *rows) {
    table t = {.rows = rows};
    size_t bytes;
    for (const char *c = rows + 1; *c != '\n'; c++) t.columns += *c == '|';
    if (t.columns > COLUMNS_MAX) t.columns = COLUMNS_MAX;
    for (size_t column = 0; column < t.columns; column++) {
        const char *dashes = cell_line(next_row(rows), column, false, 0, &bytes);
        t.left[column] = bytes == 0 || dashes[bytes - 1] != ':';
        for (const char *row = rows; *row == '|'; row = row == rows ? next_row(next_row(row)) : next_row(row))
            for (size_t line = 0; line < (row == rows ? HEAD_LINES : 1); line++) {
                const char *text = cell_line(row, column, row == rows, line, &bytes);
                if (words_columns(text, bytes) > t.width[column]) t.width[column] = words_columns(text, bytes);
            }
    }
    return t;
}

/* One line of a row: the first column and those from first on, up to last. Nothing if all are empty. */
static void print_row(const table *t, const char *row, size_t line, size_t first, size_t last) {
    size_t owed = 0, bytes;
    bool any = false;
    for (size_t c = 0; c < last; c = c == 0 ? first : c + 1) {
        const char *text = cell_line(row, c, row == t->rows, line, &bytes);
        const size_t pad = t->width[c] - words_columns(text, bytes);
        owed += (c == 0 ? 0 : GAP) + (t->left[c] ? 0 : pad);
        if (bytes > 0) {
            printf("%*s%.*s", (int)owed, "", (int)bytes, text);
            owed = 0;
            any = true;
        }
        owed += t->left[c] ? pad : 0;
    }
    if (any) putchar('\n');
}

/* Returns the text behind the table. */
static const char *print_table(const char *rows) {
    const table t = measure_table(rows);
    const char *row = rows;
    for (size_t first = 1, last; first < t.columns; first = last) {
        size_t width = t.width[0];
        for (last = first; last < t.columns; last++) {
            width += GAP + t.width[last];
            if (width > WIDTH && last > first) break;
        }
        if (first > 1) putchar('\n');
        for (row = rows; *row == '|'; row = row == rows ? next_row(next_row(row)) : next_row(row))
            for (size_t line = 0; line < (row == rows ? HEAD_LINES : 1); line++) print_row(&t, row, line, first, last);
    }
    return row;
}

void markdown_print(const char *text) {
    while (*text) {
        if (*text == '|') {
            text = print_table(text);
            continue;
        }
        const size_t length = strcspn(text, "\n");
        words_fold(text, length, 0, 0, WIDTH);
        putchar('\n');
        text += length + (text[length] == '\n');
        /* A paragraph stands on its table. */
        if (length > 0 && text[0] == '\n' && text[1] == '|') text++;
    }
}
