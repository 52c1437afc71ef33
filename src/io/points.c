/* SPDX-License-Identifier: Apache-2.0 */
#include "points.h"

#include "gdal/module.h"
#include "printable.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Names go into messages, tables and metadata: text alone, on one line, and without the rest of a character that was cut. */
static void tidy(char *name, size_t size) {
    size_t length = strlen(name);
    if (length + 1 == size) { /* back to the character's first byte */
        while (length > 0 && ((unsigned char)name[length - 1] & 0xc0) == 0x80) length--;
        if (length > 0 && (unsigned char)name[length - 1] >= 0xc0) length--;
        name[length] = '\0';
    }
    for (char *c = name; *c; c++)
        if ((unsigned char)*c < ' ') *c = ' ';
    make_printable(name);
}

bool io_points_add(io_points *p, const io_point *point) {
    if (p->count == p->room) {
        const size_t room = p->room ? 2 * p->room : 64;
        io_point *points = realloc(p->points, room * sizeof *points);
        if (points == NULL) return false;
        p->points = points;
        p->room = room;
    }
    io_point *to = &p->points[p->count++];
    *to = *point;
    tidy(to->name, sizeof to->name);
    return true;
}

void io_points_free(io_points *p) {
    free(p->points);
    *p = (io_points){0};
}

void io_points_name(const io_points *p, size_t k, char *text, size_t size) {
    const io_point *point = &p->points[k];
    const int used = snprintf(text, size, p->is_table ? "%s:%zu" : "%s: feature %zu", p->path, point->number);
    if (point->name[0] != '\0' && used > 0 && (size_t)used < size)
        snprintf(text + used, size - (size_t)used, " (%s)", point->name);
}

/* ---- tables ------------------------------------------------------------------------------------------------------- */

enum { X, Y, HEIGHT, WEIGHT, NAME, NAMES };
static const char *const names[NAMES] = {"x", "y", "height", "weight", "name"};

static bool take_row(const io_table *t, size_t row, const size_t columns[NAMES], io_points *points, io_error *error) {
    io_point p = {.height = NAN, .weight = 1, .number = t->lines[row]};
    if (!io_table_number(t, row, columns[X], &p.x, error) || !io_table_number(t, row, columns[Y], &p.y, error))
        return false;
    if (columns[HEIGHT] < t->columns && !io_table_height(t, row, columns[HEIGHT], &p.height, &p.absolute, error))
        return false;
    if (columns[WEIGHT] < t->columns && !io_table_number(t, row, columns[WEIGHT], &p.weight, error)) return false;
    if (columns[NAME] < t->columns) snprintf(p.name, sizeof p.name, "%s", t->cells[row * t->columns + columns[NAME]]);
    return io_points_add(points, &p) || io_fail(error, "%s: out of memory", t->path);
}

static bool take_table(const io_table *t, const io_points_options *o, io_points *points, io_error *error) {
    size_t columns[NAMES];
    if (!io_table_columns(t, names, NAMES, HEIGHT, columns, o->warn, o->context, error)) return false;
    points->has_weight = columns[WEIGHT] < t->columns;
    for (size_t row = 0; row < t->rows; row++)
        if (!take_row(t, row, columns, points, error)) return false;
    return true;
}

static bool read_table(const char *path, const io_points_options *o, io_points *points, io_error *error) {
    io_table t;
    if (o->layer) return io_fail(error, "%s: a table has no layers", path);
    if (!io_table_read(path, &t, error)) return false;
    const bool good = take_table(&t, o, points, error);
    io_table_free(&t);
    return good;
}

/* ---- all others ----------------------------------------------------------------------------------------------------- */

static const io_gdal *load(const char *path, const char *what, io_error *error) {
    io_error reason;
    const io_gdal *gdal = io_gdal_load(&reason);
    if (gdal == NULL) io_fail(error, "%s: %s need GDAL: %s", path, what, reason.text);
    return gdal;
}

static bool read_features(const char *path, const io_points_options *o, io_points *points, io_error *error) {
    const io_gdal *gdal = load(path, "places come from .csv; all other files", error);
    return gdal != NULL && gdal->points(path, o, points, error);
}

bool io_areas_read(const char *path, const io_points_options *o, const io_mask *mask, io_error *error) {
    const io_gdal *gdal = load(path, "polygons", error);
    return gdal != NULL && gdal->areas(path, o, mask, error);
}

bool io_points_read(const char *path, const io_points_options *o, io_points *points, io_error *error) {
    *points = (io_points){.path = path, .is_table = io_name_ends(path, ".csv")};
    bool good = points->is_table ? read_table(path, o, points, error) : read_features(path, o, points, error);
    if (good && points->count == 0) good = io_fail(error, "%s: holds no places", path);
    if (!good) io_points_free(points);
    return good;
}
