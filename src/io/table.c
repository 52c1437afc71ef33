/* SPDX-License-Identifier: Apache-2.0 */
#include "table.h"

#include "inputs.h"
#include "number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct scanner {
    const io_table *table;
    char *at, *end;
    size_t line;
    io_error *error;
} scanner;

static bool is_end_of_line(const scanner *s) { return s->at == s->end || *s->at == '\n' || *s->at == '\r'; }

static void next_line(scanner *s) {
    if (s->at < s->end && *s->at == '\r') s->at++;
    if (s->at < s->end && *s->at == '\n') s->at++;
    s->line++;
}

static void skip_blanks(scanner *s) {
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t')) s->at++;
}

/* A cell in quotation marks, without them, in place. */
static bool take_quoted(scanner *s, char **cell, char **end) {
    const size_t line = s->line;
    char *to = *cell = ++s->at;
    for (; s->at < s->end; s->at++) {
        if (*s->at == '"') {
            if (s->at + 1 == s->end || s->at[1] != '"') break;
            s->at++;
        }
        if (*s->at == '\n' || (*s->at == '\r' && s->at[1] != '\n')) s->line++;
        *to++ = *s->at;
    }
    if (s->at == s->end) return io_fail(s->error, "%s:%zu: a quotation mark has no end", s->table->path, line);
    s->at++;
    *end = to;
    skip_blanks(s);
    if (s->at == s->end || *s->at == ',' || is_end_of_line(s)) return true;
    return io_fail(s->error, "%s:%zu: text stands behind a quotation mark that ends a cell", s->table->path, s->line);
}

/* A cell; *last: it ends its row. Its end is put where the comma or the line's end was, after looking at that. */
static bool take_cell(scanner *s, char **cell, bool *last) {
    char *end = s->at;
    skip_blanks(s);
    if (s->at < s->end && *s->at == '"') {
        if (!take_quoted(s, cell, &end)) return false;
    } else {
        *cell = s->at;
        while (s->at < s->end && *s->at != ',' && !is_end_of_line(s)) s->at++;
        for (end = s->at; end > *cell && (end[-1] == ' ' || end[-1] == '\t');) end--;
    }
    *last = is_end_of_line(s);
    if (*last)
        next_line(s);
    else
        s->at++;
    *end = '\0';
    return true;
}

/* Files of programs that separate cells by something else. */
static bool check_separator(const scanner *s) {
    const size_t length = strcspn(s->at, "\r\n");
    const char *by = memchr(s->at, ';', length) ? "semicolons" : memchr(s->at, '\t', length) ? "tabs" : NULL;
    return by == NULL || memchr(s->at, ',', length) != NULL ||
           io_fail(
               s->error,
               "%s:%zu: cells are separated by %s; a comma should stand between them, and a point in decimal numbers",
               s->table->path, s->line, by);
}

/* The cells of a line, for which there is room, and how many there are; 0 after an error. */
static size_t take_row(scanner *s, char **cells) {
    size_t count = 0;
    for (bool last = false; !last; count++)
        if (!take_cell(s, &cells[count], &last)) return 0;
    return count;
}

/* Each cell ends at a comma, at the end of its line or at that of the text. */
static bool make_room(io_table *t, size_t size) {
    size_t cells = 1;
    for (size_t k = 0; k < size; k++) cells += t->text[k] == ',' || t->text[k] == '\n' || t->text[k] == '\r';
    t->names = malloc(cells * sizeof *t->names);
    t->lines = malloc(cells * sizeof *t->lines);
    return t->names && t->lines;
}

static bool take_table(io_table *t, size_t size, io_error *error) {
    scanner s = {.table = t, .at = t->text, .end = t->text + size, .line = 1, .error = error};
    if (!make_room(t, size)) return io_fail(error, "%s: out of memory", t->path);
    if (size >= 3 && memcmp(s.at, "\xef\xbb\xbf", 3) == 0) s.at += 3;
    if (memchr(s.at, '\0', (size_t)(s.end - s.at)))
        return io_fail(error, "%s: is no text in UTF-8: it has zero bytes, as UTF-16 has", t->path);
    for (skip_blanks(&s); s.at < s.end && is_end_of_line(&s); skip_blanks(&s)) next_line(&s);
    if (s.at == s.end) return io_fail(error, "%s: is empty; its first line should name the columns", t->path);
    const size_t first = s.line;
    if (!check_separator(&s) || (t->columns = take_row(&s, t->names)) == 0) return false;
    if (t->columns > IO_TABLE_COLUMNS_MAX)
        return io_fail(error, "%s:%zu: names more than %d columns", t->path, first, (int)IO_TABLE_COLUMNS_MAX);
    t->cells = t->names + t->columns;
    while (s.at < s.end) {
        skip_blanks(&s);
        if (is_end_of_line(&s)) {
            next_line(&s);
            continue;
        }
        const size_t line = s.line, count = take_row(&s, t->cells + t->rows * t->columns);
        if (count == 0) return false;
        if (count != t->columns)
            return io_fail(error, "%s:%zu: the line has %zu cell%s where the first one names %zu column%s", t->path,
                           line, count, count == 1 ? "" : "s", t->columns, t->columns == 1 ? "" : "s");
        t->lines[t->rows++] = line;
    }
    return true;
}

bool io_table_read(const char *path, io_table *t, io_error *error) {
    size_t size = 0;
    *t = (io_table){.path = path};
    t->text = io_file_read(path, &size, error);
    if (t->text != NULL && take_table(t, size, error)) return true;
    io_table_free(t);
    return false;
}

void io_table_free(io_table *t) {
    free(t->names);
    free(t->lines);
    free(t->text);
    *t = (io_table){0};
}

bool io_table_fail(const io_table *t, size_t row, size_t column, const char *wanted, io_error *error) {
    const char *cell = t->cells[row * t->columns + column];
    if (cell[0] == '\0')
        return io_fail(error, "%s:%zu: %s is empty where %s should stand", t->path, t->lines[row], t->names[column],
                       wanted);
    return io_fail(error, "%s:%zu: '%.40s' stands where %s should, in %s", t->path, t->lines[row], cell, wanted,
                   t->names[column]);
}

bool io_table_number(const io_table *t, size_t row, size_t column, double *number, io_error *error) {
    const char *cell = t->cells[row * t->columns + column];
    char *end = NULL;
    /* number_read would also read hexadecimal numbers and words. */
    if (cell[0] != '\0' && cell[strspn(cell, "+-.0123456789eE")] == '\0') *number = number_read(cell, &end);
    return (end != NULL && *end == '\0' && isfinite(*number)) || io_table_fail(t, row, column, "a number", error);
}

bool io_table_height(const io_table *t, size_t row, size_t column, double *height, bool *absolute, io_error *error) {
    char **cell = &t->cells[row * t->columns + column], *given = *cell;
    if (given[0] == '\0') return true;
    *absolute = given[0] == '=';
    *cell += *absolute;
    const bool good = io_table_number(t, row, column, height, NULL);
    *cell = given;
    return good || io_table_fail(t, row, column, "a height, as 2 or =1250,", error);
}

/* The names of columns that are none of count; false if there are none. */
static bool list_others(const io_table *t, const char *const *names, size_t count, const char *mark, char *text,
                        size_t size) {
    text[0] = '\0';
    for (size_t k = 0; k < t->columns; k++) {
        bool known = false;
        for (size_t n = 0; n < count; n++) known |= strcasecmp(t->names[k], names[n]) == 0;
        if (!known) io_list(text, size, "%s%s%s", mark, t->names[k], mark);
    }
    return text[0] != '\0';
}

static bool find_column(const io_table *t, const char *name, bool needed, size_t *column, io_error *error) {
    char there[200];
    *column = t->columns;
    for (size_t k = 0; k < t->columns; k++) {
        if (strcasecmp(t->names[k], name) != 0) continue;
        if (*column < t->columns) return io_fail(error, "%s: two columns have the name '%s'", t->path, name);
        *column = k;
    }
    if (*column < t->columns || !needed) return true;
    list_others(t, NULL, 0, "", there, sizeof there);
    return io_fail(error, "%s: has no column '%s'; its first line names %s", t->path, name, there);
}

bool io_table_columns(const io_table *t, const char *const *names, size_t count, size_t needed, size_t *columns,
                      const io_warner *warn, io_error *error) {
    char others[200], all[200];
    size_t used = 0;
    for (size_t n = 0; n < count; n++) {
        if (!find_column(t, names[n], n < needed, &columns[n], error)) return false;
        const char *between = n == 0 ? "" : n + 1 == count ? " and " : ", ";
        used += (size_t)snprintf(all + used, sizeof all - used, "%s%s", between, names[n]);
    }
    if (list_others(t, names, count, "'", others, sizeof others))
        io_warn(warn, "%s: passed over: %s; columns with a meaning are %s", t->path, others, all);
    return true;
}

bool io_table_write_cell(io_output *to, const char *text, io_error *error) {
    if (text[strcspn(text, ",\"\r\n")] == '\0') return io_output_print(to, error, ",%s", text);
    if (!io_output_write(to, ",\"", 2, error)) return false;
    for (; *text; text++)
        if (!io_output_write(to, *text == '"' ? "\"\"" : text, *text == '"' ? 2 : 1, error)) return false;
    return io_output_write(to, "\"", 1, error);
}
