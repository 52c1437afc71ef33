/* SPDX-License-Identifier: Apache-2.0 */
#include "los_pairs.h"

#include "line.h"
#include "table.h"

#include <math.h>

enum { X1, Y1, X2, Y2, HEIGHT1, HEIGHT2, NAMES };
static const char *const names[NAMES] = {"x1", "y1", "x2", "y2", "height1", "height2"};

typedef struct job {
    product *product;
    io_table table;
    size_t columns[NAMES];
    double curvature, megahertz;
    profile profile;
    io_output *results, *profiles;
} job;

static bool find_columns(job *j, io_error *error) {
    const io_table *t = &j->table;
    const ground_watch *w = &j->product->ground.watch;
    if (t->rows == 0) return io_fail(error, "%s: holds no pairs", t->path);
    return io_table_columns(t, names, NAMES, HEIGHT1, j->columns, w->warn, w->context, error);
}

enum { TEXT = 300 };

/* One end of a row's line. */
static bool take_place(const job *j, size_t row, int end, ground_place *p, char text[TEXT], io_error *error) {
    const io_table *t = &j->table;
    const size_t *c = j->columns, x = c[end ? X2 : X1], y = c[end ? Y2 : Y1], height = c[end ? HEIGHT2 : HEIGHT1];
    *p = (ground_place){.text = text};
    if (!io_table_number(t, row, x, &p->x, error) || !io_table_number(t, row, y, &p->y, error)) return false;
    if (height < t->columns && !io_table_height(t, row, height, &p->z, &p->absolute, error)) return false;
    snprintf(text, TEXT, "%.150s:%zu: %.10g,%.10g,%s%.10g", t->path, t->lines[row], p->x, p->y, p->absolute ? "=" : "",
             p->z);
    return true;
}

static bool write_row(job *j, size_t row, const line *l, io_error *error) {
    if (!io_output_print(j->results, error, "%zu,%.12g,%.12g,%.12g,%.12g,%d,%.3f,", row + 1, l->ends[0][0],
                         l->ends[0][1], l->ends[1][0], l->ends[1][1], !l->blocked, l->length))
        return false;
    if (!(l->blocked ? io_output_print(j->results, error, "%.3f,%.12g,%.12g,%.3f", l->block_distance, l->block[0],
                                       l->block[1], l->block_height)
                     : io_output_print(j->results, error, ",,,")))
        return false;
    clearance c;
    if (j->megahertz > 0) {
        line_clearance(l, j->megahertz, &j->profile, &c);
        if (!(isnan(c.share) ? io_output_print(j->results, error, ",,,")
                             : io_output_print(j->results, error, ",%.4f,%.3f,%.3f", c.share, c.distance, c.radius)))
            return false;
    }
    return io_output_write(j->results, "\n", 1, error);
}

static bool look(job *j, size_t row, io_error *error) {
    char texts[2][TEXT];
    ground_place places[2];
    line l;
    for (int end = 0; end < 2; end++)
        if (!take_place(j, row, end, &places[end], texts[end], error)) return false;
    profile *p = j->profiles || j->megahertz > 0 ? &j->profile : NULL;
    if (!line_find_on(&l, &j->product->ground, places, j->curvature, p, error) || !write_row(j, row, &l, error))
        return false;
    return j->profiles == NULL || line_write_profile(&l, row + 1, j->megahertz, &j->profile, j->profiles, error);
}

static bool look_at_all(job *j, io_error *error) {
    static const char head[] = "pair,x1,y1,x2,y2,visible,distance,blocked_distance,blocked_x,blocked_y,blocked_height";
    static const char *const more = ",clearance,clearance_distance,fresnel_radius\n";
    const size_t rows = j->table.rows;
    if (!find_columns(j, error) || !io_output_write(j->results, head, sizeof head - 1, error)) return false;
    if (!io_output_print(j->results, error, "%s", j->megahertz > 0 ? more : "\n")) return false;
    if (j->profiles && !line_head_profiles(j->megahertz, j->profiles, error)) return false;
    for (size_t row = 0; row < rows; row++) {
        if (!look(j, row, error)) return false;
        if (!product_tell(j->product, (double)(row + 1) / (double)rows)) return io_fail(error, "interrupted");
    }
    return true;
}

bool los_pairs(product *p, const char *path, double curvature, double megahertz, io_output *results,
               io_output *profiles, io_error *error) {
    job j = {.product = p, .curvature = curvature, .megahertz = megahertz, .results = results, .profiles = profiles};
    ground *g = &p->ground;
    if (ground_is_small(g) && !ground_read(g, ground_all(g), false, error)) return false;
    if (!io_table_read(path, &j.table, error)) return false;
    const bool good = look_at_all(&j, error);
    io_table_free(&j.table);
    profile_free(&j.profile);
    return good;
}
