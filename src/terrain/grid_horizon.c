/* SPDX-License-Identifier: Apache-2.0 */
/* In direction (dx, dy) each sample lies on one line through samples, dx columns and dy rows from one to the next. Between two
 * of them the line crosses rows, columns and diagonals at the same few fractions everywhere. These crossings and the samples
 * are the vertices of the surface's profile along the line, so the profile is exact.
 *
 * From the far end of a line to its near end the upper hull of the profile is kept as a stack (Timonen and Westerholm 2010).
 * A new vertex hides those points of the hull that lie below the straight line from it to the one behind them; the first that
 * is not hidden is the steepest, which is the horizon. Each vertex is put on the stack once and taken off at most once: the
 * cost of a sample does not depend on how far it sees.
 *
 * A curved earth: let u be the position along the line, in steps, growing toward the viewer at v. Then
 * (h - drop (v - u)² - z) / (v - u) = (g(u) - g(v)) / (v - u) - 2 drop v, where g(u) = h - drop u². So the hull is one of
 * lowered heights, and the sum is mended at the end.
 *
 * Lines are walked several at a time, beside each other, row by row, as memory lies. Each line belongs to one thread, and its
 * operations have one order: the same bits for any number of threads. */

#include "grid_horizon.h"

#include "cellwalk_expert.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

/* Lines that are walked beside each other: four cache lines of samples. */
enum { LINES = 64, CROSSINGS_MOST = 16 };

static bool is_prime_to(int a, int b) {
    while (b != 0) {
        const int rest = a % b;
        a = b;
        b = rest;
    }
    return abs(a) == 1;
}

static int by_angle(const void *a, const void *b) {
    const grid_direction *p = a, *q = b;
    const double x = atan2(p->dx, p->dy), y = atan2(q->dx, q->dy), turn = 6.283185307179586;
    const double from_p = x < 0 ? x + turn : x, from_q = y < 0 ? y + turn : y;
    return (from_p > from_q) - (from_p < from_q);
}

bool grid_directions(size_t count, grid_direction *directions) {
    const int step = count == 8 ? 1 : count == 16 ? 2 : count == 32 ? 3 : 0;
    size_t n = 0;
    for (int dx = -step; dx <= step; dx++)
        for (int dy = -step; dy <= step; dy++)
            if (is_prime_to(dx, dy)) directions[n++] = (grid_direction){dx, dy};
    qsort(directions, n, sizeof *directions, by_angle);
    return n > 0;
}

/* A crossing between a sample and the next one on its line: between two samples of an edge. */
typedef struct crossing {
    int at;                  /* how far along, in parts of a step */
    int first[2], second[2]; /* columns and rows to the edge's samples */
    double fraction;         /* of the way from the first to the second */
    ptrdiff_t to_first, to_second;
} crossing;

typedef struct walk {
    const terrain *terrain;
    grid_direction step;
    int parts;    /* of a step: each crossing lies at a whole number of them */
    size_t count; /* crossings in a step, the farthest first */
    crossing crossing[CROSSINGS_MOST];
    size_t rows;      /* from a row of the field to that of the next sample on a line */
    size_t steps;     /* of the longest line */
    ptrdiff_t lowest; /* the first line's number */
    size_t lines;     /* in each of the rows */
    double *inverse;  /* 1 / steps, by parts */
    double *lowered;  /* drop u², by parts; NULL: the earth is flat */
    double drop;
    float *rises;
    atomic_bool out_of_memory;
} walk;

typedef struct point {
    double height;
    int32_t at; /* position, in parts */
} point;

/* A stack with the hull of a line. */
typedef struct line {
    point *points;
    size_t count;
} line;

static int common_multiple(int a, int b) {
    if (a == 0 || b == 0) return a == 0 ? b : a;
    int n = a;
    while (n % b != 0) n += a;
    return n;
}

static int below(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

static void add_crossing(walk *w, int at) {
    const int x = w->step.dx * at, y = w->step.dy * at, m = w->parts;
    const int i = below(x, m), j = below(y, m), beside_x = x - i * m, beside_y = y - j * m;
    crossing c = {.at = at, .first = {i, j}, .second = {i, j}};
    if (beside_x == 0) { /* on a column of samples */
        c.second[1]++;
        c.fraction = (double)beside_y / m;
    } else {
        if (beside_y != 0 && beside_x != beside_y) return; /* inside a triangle */
        c.second[0]++;
        c.second[1] += beside_y != 0;
        c.fraction = (double)beside_x / m;
    }
    const ptrdiff_t nx = (ptrdiff_t)w->terrain->nx;
    c.to_first = c.first[1] * nx + c.first[0];
    c.to_second = c.second[1] * nx + c.second[0];
    w->crossing[w->count++] = c;
}

static inline double slope_to(const walk *w, const point *p, double height, int32_t at) {
    return (p->height - height) * w->inverse[at - p->at];
}

/* The slope from a new vertex to its horizon, or -infinity; the vertex goes onto the hull. */
static inline double add_vertex(const walk *w, line *l, double height, int32_t at) {
    double steepest = -INFINITY;
    if (l->count > 0) steepest = slope_to(w, &l->points[l->count - 1], height, at);
    for (; l->count > 1; l->count--) {
        const double behind = slope_to(w, &l->points[l->count - 2], height, at);
        if (behind < steepest) break;
        steepest = behind;
    }
    l->points[l->count++] = (point){height, at};
    return steepest;
}

static inline double lower_by(const walk *w, double height, int32_t at) {
    return w->lowered ? height - w->lowered[at] : height;
}

static bool is_inside(const walk *w, size_t i, size_t j, const int by[2]) {
    return (size_t)((ptrdiff_t)i + by[0]) < w->terrain->nx && (size_t)((ptrdiff_t)j + by[1]) < w->terrain->ny;
}

/* Sample (i, j), step number of its line; those behind it have been visited. */
static inline void visit(const walk *w, line *l, size_t i, size_t j, size_t number) {
    const int32_t at = (int32_t)((number + 1) * (size_t)w->parts);
    const float *z = w->terrain->z + j * w->terrain->nx + i;
    const bool all = is_inside(w, i, j, (const int[2]){w->step.dx, w->step.dy});
    for (size_t k = 0; k < w->count; k++) {
        const crossing *c = &w->crossing[k];
        if (!all && !(is_inside(w, i, j, c->first) && is_inside(w, i, j, c->second))) continue;
        const double from = (double)z[c->to_first], height = from + c->fraction * ((double)z[c->to_second] - from);
        if (fabs(height) < (double)INFINITY) add_vertex(w, l, lower_by(w, height, at - c->at), at - c->at);
    }
    float *rise = w->rises + (z - w->terrain->z);
    *rise = NAN;
    if (!(fabsf(z[0]) < INFINITY)) return;
    const double steepest = add_vertex(w, l, lower_by(w, (double)z[0], at), at);
    *rise = (float)(w->lowered ? steepest - 2 * w->drop * (double)(number + 1) : steepest);
}

/* Lines beside each other, number first to end in each of the w->rows rows that they begin in, from the far end on. */
static void walk_lines(const walk *w, size_t first, size_t end, line *lines) {
    const size_t nx = w->terrain->nx, ny = w->terrain->ny;
    for (size_t k = 0; k < LINES * w->rows; k++) lines[k].count = 0;
    for (size_t r = 0; r < ny; r++) {
        const size_t number = r / w->rows, j = w->step.dy > 0 ? ny - 1 - r : r;
        /* The line that goes through column i here has the number i + number · dx. */
        const ptrdiff_t here = w->lowest + (ptrdiff_t)first - (ptrdiff_t)number * w->step.dx;
        const ptrdiff_t after = here + (ptrdiff_t)(end - first);
        const ptrdiff_t begin = here > 0 ? here : 0, until = after < (ptrdiff_t)nx ? after : (ptrdiff_t)nx;
        line *l = lines + r % w->rows * LINES;
        for (ptrdiff_t i = begin; i < until; i++) visit(w, &l[i - here], (size_t)i, j, number);
    }
}

/* Along a row: a line is a row. */
static void walk_row(const walk *w, size_t j, line *l) {
    const size_t nx = w->terrain->nx;
    l->count = 0;
    for (size_t number = 0; number < nx; number++) visit(w, l, w->step.dx > 0 ? nx - 1 - number : number, j, number);
}

static void walk_some(void *context, size_t begin, size_t end) {
    walk *w = context;
    const size_t lines = w->step.dy == 0 ? 1 : LINES * w->rows, room = (w->steps + 1) * (w->count + 1);
    line *l = malloc(lines * (sizeof *l + room * sizeof(point)));
    if (l == NULL) {
        atomic_store(&w->out_of_memory, true);
        return;
    }
    for (size_t k = 0; k < lines; k++) l[k].points = (point *)(l + lines) + k * room;
    if (w->step.dy == 0)
        for (size_t j = begin; j < end; j++) walk_row(w, j, l);
    else
        for (size_t k = begin; k < end; k += LINES) walk_lines(w, k, end - k < LINES ? end : k + LINES, l);
    free(l);
}

/* Tables by position, of which there are fewer than 2^31 (GRID_STEP and CW_SIDE_MAX). */
static bool make_tables(walk *w) {
    const size_t n = (w->steps + 2) * (size_t)w->parts;
    w->inverse = malloc(n * sizeof *w->inverse);
    if (w->drop > 0) w->lowered = malloc(n * sizeof *w->lowered);
    if (w->inverse == NULL || (w->drop > 0 && w->lowered == NULL)) return false;
    for (size_t k = 0; k < n; k++) {
        const double steps = (double)k / w->parts;
        w->inverse[k] = 1 / steps; /* of 0: not used */
        if (w->lowered) w->lowered[k] = w->drop * steps * steps;
    }
    return true;
}

cw_status grid_rises(const terrain *t, grid_direction step, double drop, const cw_run *run, float *rises) {
    if (abs(step.dx) > GRID_STEP || abs(step.dy) > GRID_STEP || !is_prime_to(step.dx, step.dy))
        return CW_ERROR_ARGUMENT;
    walk w = {.terrain = t, .step = step, .drop = drop, .rises = rises};
    const int dx = abs(step.dx), dy = abs(step.dy);
    w.parts = common_multiple(common_multiple(dx, dy), abs(step.dx - step.dy));
    for (int at = w.parts - 1; at > 0; at--) add_crossing(&w, at);
    w.rows = dy > 0 ? (size_t)dy : 1;
    w.steps = dy > 0 ? (t->ny - 1) / w.rows + 1 : t->nx;
    const size_t shift = (w.steps - 1) * (size_t)dx;
    w.lowest = dy > 0 && step.dx < 0 ? -(ptrdiff_t)shift : 0;
    w.lines = dy > 0 ? t->nx + shift : t->ny;
    cw_status status = make_tables(&w) ? CW_OK : CW_ERROR_MEMORY;
    if (status == CW_OK) cw_pool_run(run ? run->pool : NULL, w.lines, LINES, walk_some, &w);
    free(w.inverse);
    free(w.lowered);
    return status == CW_OK && atomic_load(&w.out_of_memory) ? CW_ERROR_MEMORY : status;
}
