/* SPDX-License-Identifier: Apache-2.0 */
#include "points.h"

#include "gdal/module.h"
#include "printable.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Names go into messages, tables and metadata: text alone, on one line, without the rest of a cut character. */
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

bool io_points_add(io_points *p, const io_place *place) {
    if (p->count == p->room) {
        const size_t room = p->room ? 2 * p->room : 64;
        io_place *list = realloc(p->list, room * sizeof *list);
        if (list == NULL) return false;
        p->list = list;
        p->room = room;
    }
    io_place *to = &p->list[p->count];
    *to = *place;
    to->order = p->count++;
    tidy(to->name, sizeof to->name);
    p->has_names |= to->name[0] != '\0';
    return true;
}

void io_points_free(io_points *p) {
    free(p->list);
    *p = (io_points){0};
}

const char *io_place_text(const io_place *p, char text[IO_PLACE_ROOM]) {
    char file[240] = "", way[60] = "";
    if (p->from == IO_PLACE_TEXT && isnan(p->along)) return p->text;
    if (p->from != IO_PLACE_TEXT)
        snprintf(file, sizeof file, p->from == IO_PLACE_ROW ? "%.150s:%zu%s%s%s" : "%.150s: feature %zu%s%s%s", p->text,
                 p->number, p->name[0] ? " (" : "", p->name, p->name[0] ? ")" : "");
    if (!isnan(p->along)) snprintf(way, sizeof way, "%s%.10g m along the line", file[0] ? ", " : "", p->along);
    snprintf(text, IO_PLACE_ROOM, "%s%s: %.10g,%.10g,%s%.10g", file, way, p->x, p->y, p->absolute ? "=" : "", p->z);
    return text;
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

enum { X, Y, HEIGHT, WEIGHT, NAME, NAMES };
static const char *const names[NAMES] = {"x", "y", "height", "weight", "name"};

bool io_place_take(const io_table *t, size_t row, size_t x, size_t y, size_t height, size_t name, io_place *p,
                   io_error *error) {
    p->from = IO_PLACE_ROW;
    p->text = t->path;
    p->number = t->lines[row];
    p->along = NAN;
    if (name < t->columns) snprintf(p->name, sizeof p->name, "%s", t->cells[row * t->columns + name]);
    tidy(p->name, sizeof p->name);
    return io_table_number(t, row, x, &p->x, error) && io_table_number(t, row, y, &p->y, error) &&
           (height >= t->columns || io_table_height(t, row, height, &p->z, &p->absolute, error));
}

static bool take_table(const io_table *t, const io_points_options *o, io_points *points, io_error *error) {
    size_t of[NAMES];
    bool good = io_table_columns(t, names, NAMES, HEIGHT, of, &o->warn, error);
    points->has_weight = good && of[WEIGHT] < t->columns;
    for (size_t row = 0; row < t->rows && good; row++) {
        io_place p = {.z = o->height, .weight = 1};
        good = io_place_take(t, row, of[X], of[Y], of[HEIGHT], of[NAME], &p, error) &&
               (!points->has_weight || io_table_number(t, row, of[WEIGHT], &p.weight, error)) &&
               (io_points_add(points, &p) || io_fail(error, "%s: out of memory", t->path));
    }
    return good;
}

static bool read_table(const char *path, const io_points_options *o, io_points *points, io_error *error) {
    io_table t;
    if (o->layer) return io_fail(error, "%s: a table has no layers", path);
    if (!io_table_read(path, &t, error)) return false;
    const bool good = take_table(&t, o, points, error);
    io_table_free(&t);
    return good;
}

/* ---- all others -------------------------------------------------------------------------------------------------- */

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
    *points = (io_points){0};
    bool good = io_name_ends(path, ".csv") ? read_table(path, o, points, error) : read_features(path, o, points, error);
    if (good && points->count == 0) good = io_fail(error, "%s: holds no places", path);
    if (!good) io_points_free(points);
    return good;
}
