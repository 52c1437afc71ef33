/* SPDX-License-Identifier: Apache-2.0 */
#include "sight.h"

#include <math.h>
#include <stdlib.h>

/* ---- bounds ------------------------------------------------------------------------------------------------------- */

enum { LEVELS_MOST = 12, FIRST_SHIFT = 2 };

struct sight_bounds {
    int levels;
    size_t across[LEVELS_MOST], down[LEVELS_MOST];
    float *high
        [LEVELS_MOST]; /* node (x, y) of level l, 4 << 2 l cells wide, at high[l][y * across[l] + x]; -infinity: none */
};

static inline float higher(float z, float h) { return z > h && z < INFINITY ? z : h; }

/* Samples of a node's closed cells: those on its far borders belong to it as well. columns: the row of nodes, sample by sample. */
static void bound_row(const terrain *t, size_t y, float *columns, float *high, size_t across) {
    const size_t first = y << FIRST_SHIFT,
                 last = first + (1 << FIRST_SHIFT) < t->ny - 1 ? first + (1 << FIRST_SHIFT) : t->ny - 1;
    for (size_t i = 0; i < t->nx; i++) columns[i] = -INFINITY;
    for (size_t j = first; j <= last; j++) {
        const float *z = t->z + j * t->nx;
        for (size_t i = 0; i < t->nx; i++) columns[i] = higher(z[i], columns[i]);
    }
    for (size_t x = 0; x < across; x++) {
        const size_t begin = x << FIRST_SHIFT,
                     end = begin + (1 << FIRST_SHIFT) < t->nx - 1 ? begin + (1 << FIRST_SHIFT) : t->nx - 1;
        high[x] = -INFINITY;
        for (size_t i = begin; i <= end; i++) high[x] = columns[i] > high[x] ? columns[i] : high[x];
    }
}

static bool bound(const terrain *t, sight_bounds *b) {
    float *columns = malloc(t->nx * sizeof *columns);
    if (columns == NULL) return false;
    size_t across = (t->nx + 2) >> FIRST_SHIFT, down = (t->ny + 2) >> FIRST_SHIFT;
    for (;; across = (across + 3) / 4, down = (down + 3) / 4) {
        const int l = b->levels;
        b->across[l] = across;
        b->down[l] = down;
        b->high[l] = malloc(across * down * sizeof(float));
        if (b->high[l] == NULL) break;
        b->levels++;
        for (size_t y = 0; y < down; y++) {
            float *row = b->high[l] + y * across;
            if (l == 0) {
                bound_row(t, y, columns, row, across);
                continue;
            }
            const size_t fine = b->across[l - 1], last = 4 * y + 4 < b->down[l - 1] ? 4 * y + 4 : b->down[l - 1];
            for (size_t x = 0; x < across; x++) row[x] = -INFINITY;
            for (size_t v = 4 * y; v < last; v++)
                for (size_t u = 0; u < fine; u++) {
                    const float h = b->high[l - 1][v * fine + u];
                    row[u / 4] = h > row[u / 4] ? h : row[u / 4];
                }
        }
        if ((across == 1 && down == 1) || b->levels == LEVELS_MOST) {
            free(columns);
            return true;
        }
    }
    free(columns);
    return false;
}

cw_status sight_bounds_create(const terrain *t, sight_bounds **bounds) {
    sight_bounds *b = *bounds = calloc(1, sizeof *b);
    if (b && bound(t, b)) return CW_OK;
    sight_bounds_destroy(b);
    *bounds = NULL;
    return CW_ERROR_MEMORY;
}

void sight_bounds_destroy(sight_bounds *b) {
    if (b == NULL) return;
    for (int l = 0; l < b->levels; l++) free(b->high[l]);
    free(b);
}

/* ---- the place ---------------------------------------------------------------------------------------------------- */

static double clamped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* Cells; what is less is 0 but for rounding. */
static const double least_step = 0x1p-60;

void sight_init(sight *s, const terrain *t, const sight_bounds *bounds, const double eye[3], double curvature) {
    *s = (sight){.terrain = t, .bounds = bounds, .eye = {eye[0], eye[1], eye[2]}};
    for (int c = 0; c < 2; c++) /* a place next to row or column 0 is on it: one over the distance might be infinite */
        if (fabs(s->eye[c]) < least_step) s->eye[c] = 0;
    double metres[2];
    terrain_metres(t, eye[0], eye[1], metres);
    const double k = curvature / (2 * t->radius * t->map[2][2]);
    const double(*m)[4] = (const double(*)[4])t->map;
    for (int c = 0; c < 2; c++) {
        const double scale = k * metres[c] * metres[c];
        s->fall[0] += scale * m[c][0] * m[c][0];
        s->fall[1] += scale * 2 * m[c][0] * m[c][1];
        s->fall[2] += scale * m[c][1] * m[c][1];
    }
}

double sight_fall(const sight *s, double i, double j) {
    const double x = i - s->eye[0], y = j - s->eye[1];
    return s->fall[0] * x * x + s->fall[1] * x * y + s->fall[2] * y * y;
}

double sight_sample(const sight *s, size_t i, size_t j) {
    return (double)s->terrain->z[j * s->terrain->nx + i] - s->eye[2] - sight_fall(s, (double)i, (double)j);
}

/* ---- the way ------------------------------------------------------------------------------------------------------ */

/* A place within this many cells of an end is the end: places are computed to 2^-52 of coordinates of up to 2^23. */
static const double at_end = 0x1p-27;

/* The way from the target back to the eye. place[a] + share step[a] is where it is, share being 0 at the target. */
typedef struct way {
    const sight *sight;
    double place[2], step[2];
    double length; /* cells along the longer axis */
    int longer;
    double least; /* shares nearer to an end than this are the end */
    double fall;  /* the lowering at the target */
} way;

static way way_to(const sight *s, double i, double j) {
    way w = {.sight = s, .place = {i, j}, .step = {s->eye[0] - i, s->eye[1] - j}};
    w.longer = fabs(w.step[1]) > fabs(w.step[0]);
    w.length = fabs(w.step[w.longer]);
    w.least = at_end / w.length;
    w.fall = sight_fall(s, i, j);
    return w;
}

/* What is seen at the crossings of a stretch: height over the eye at a share of the way from the eye. True ends the way. */
typedef bool way_look(void *context, double share, double height);

static inline double at(double from, double step, double share) { return from + share * step; }

/* Places on the way are within 2^24 of the field. A cast is an instruction where floor may be a call. */
static inline double whole_below(double x) {
    const double n = (double)(long)x;
    return n > x ? n - 1 : n;
}
static inline double whole_above(double x) { return -whole_below(-x); }

/* What is nearer to a whole number than rounding can tell is that number. */
static inline double snapped(double x) {
    const double n = whole_below(x + 0.5);
    return fabs(x - n) < at_end ? n : x;
}

/* Sees the crossing at share, on the edge from sample (i, j) in direction (di, dj), that far along it. The lowering is a
 * quadratic form q around the eye: q(s v) = s² q(v), and a mean of its values at two ends of an edge e, at f of it, is the
 * value there plus f (1 - f) q(e). */
static inline bool see_edge(const way *w, double share, double i, double j, long di, long dj, double along,
                            way_look *look, void *context) {
    const sight *s = w->sight;
    const terrain *t = s->terrain;
    if (!(share > w->least && share < 1 - w->least)) return false;
    if (!(i >= 0 && j >= 0 && i < (double)t->nx && j < (double)t->ny)) return false;
    const float *z = t->z + (size_t)j * t->nx + (size_t)i;
    const double from_eye = 1 - share;
    double height = (double)*z;
    if (along > 0) {
        if (!(i + (double)di < (double)t->nx && j + (double)dj < (double)t->ny)) return false;
        const double edge = (di ? s->fall[0] : 0) + (di && dj ? s->fall[1] : 0) + (dj ? s->fall[2] : 0);
        height += along * ((double)z[(size_t)dj * t->nx + (size_t)di] - height) - along * (1 - along) * edge;
    }
    height -= s->eye[2] + from_eye * from_eye * w->fall;
    return isfinite(height) && look(context, from_eye, height);
}

/* The crossings between two shares, a <= b, both included, so that none is lost between two stretches. */
static inline bool look_between(const way *w, double a, double b, way_look *look, void *context) {
    const double *p = w->place, *d = w->step;
    for (int axis = 0; axis < 2; axis++) {
        if (fabs(d[axis]) < least_step) continue; /* along an edge */
        const double from = at(p[axis], d[axis], a), to = at(p[axis], d[axis], b), per_step = 1 / d[axis];
        const double low = whole_above(from < to ? from : to), high = whole_below(from < to ? to : from);
        for (double n = low; n <= high; n++) {
            const double share = (n - p[axis]) * per_step, other = snapped(at(p[1 - axis], d[1 - axis], share));
            const double first = whole_below(other);
            const bool end = axis == 0 ? see_edge(w, share, n, first, 0, 1, other - first, look, context)
                                       : see_edge(w, share, first, n, 1, 0, other - first, look, context);
            if (end) return true;
        }
    }
    const double across = d[0] - d[1], start = p[0] - p[1];
    if (fabs(across) * 0x1p27 <= w->length) return false; /* along the diagonals */
    const double from = at(start, across, a), to = at(start, across, b), per_step = 1 / across;
    const double low = whole_above(from < to ? from : to), high = whole_below(from < to ? to : from);
    for (double n = low; n <= high; n++) {
        const double share = (n - start) * per_step, x = snapped(at(p[0], d[0], share)), first = whole_below(x);
        if (see_edge(w, share, first, first - n, 1, 1, x - first, look, context)) return true;
    }
    return false;
}

/* ---- the steepest rise -------------------------------------------------------------------------------------------- */

typedef struct search {
    sight_rise rise;
    double enough;
} search;

static inline bool look_for_steepest(void *context, double share, double height) {
    search *s = context;
    /* Most are lower by far, which tells without a division. */
    const double line = s->rise.steepest * share;
    if (height < line - 0x1p-50 * (fabs(line) + fabs(height))) return false;
    const double rise = height / share;
    const bool nearer = rise == s->rise.steepest && share < s->rise.share; /* of equals the nearest to the eye */
    if (!(rise > s->rise.steepest || nearer || rise >= s->enough)) return false;
    s->rise = (sight_rise){rise, share};
    return rise >= s->enough;
}

/* The least lowering in a rectangle of field coordinates. */
static double least_fall(const sight *s, double left, double right, double top, double bottom) {
    if (s->fall[0] == 0 && s->fall[2] == 0) return 0;
    const double i = clamped(s->eye[0], left, right), j = clamped(s->eye[1], top, bottom);
    if (s->fall[1] == 0) return sight_fall(s, i, j);
    /* Turned: in units of the shorter of the ellipse's axes. */
    const double mean = 0.5 * (s->fall[0] + s->fall[2]), half = 0.5 * (s->fall[0] - s->fall[2]);
    const double least = mean - sqrt(half * half + 0.25 * s->fall[1] * s->fall[1]), x = i - s->eye[0],
                 y = j - s->eye[1];
    return least > 0 ? least * (x * x + y * y) : 0;
}

/* The steepest that anything between two shares can be. */
static double bound_between(const way *w, double a, double b, int level) {
    const sight *s = w->sight;
    const sight_bounds *bounds = s->bounds;
    const double x0 = at(w->place[0], w->step[0], a), x1 = at(w->place[0], w->step[0], b);
    const double y0 = at(w->place[1], w->step[1], a), y1 = at(w->place[1], w->step[1], b);
    const double most_x = (double)(s->terrain->nx - 1), most_y = (double)(s->terrain->ny - 1);
    /* Samples on either side of the way, and one more for rounding. */
    const double left = clamped(whole_below(x0 < x1 ? x0 : x1) - 1, 0, most_x),
                 right = clamped(whole_above(x0 < x1 ? x1 : x0) + 1, 0, most_x);
    const double top = clamped(whole_below(y0 < y1 ? y0 : y1) - 1, 0, most_y),
                 bottom = clamped(whole_above(y0 < y1 ? y1 : y0) + 1, 0, most_y);
    const int shift = FIRST_SHIFT + 2 * level;
    const size_t across = bounds->across[level], down = bounds->down[level];
    size_t u0 = (size_t)left >> shift, u1 = (size_t)right >> shift, v0 = (size_t)top >> shift,
           v1 = (size_t)bottom >> shift;
    u1 = u1 < across ? u1 : across - 1;
    v1 = v1 < down ? v1 : down - 1;
    u0 = u0 < u1 ? u0 : u1;
    v0 = v0 < v1 ? v0 : v1;
    float high = -INFINITY;
    for (size_t v = v0; v <= v1; v++)
        for (size_t u = u0; u <= u1; u++)
            high = bounds->high[level][v * across + u] > high ? bounds->high[level][v * across + u] : high;
    const double height = (double)high - s->eye[2] - least_fall(s, left, right, top, bottom);
    const double near = 1 - b, far = 1 - a; /* shares from the eye */
    if (height == -INFINITY) return height;
    /* A hair more for what rounding adds to heights between samples. */
    const double pad = 0x1p-48 * (fabs((double)high) + fabs(s->eye[2]) + fabs(height));
    return height + pad > 0 ? (near > 0 ? (height + pad) / near : INFINITY) : (height + pad) / far;
}

/* Goes on from so many cells from the target, whole fours of them. Stretches end at whole numbers of cells from it. */
static void search_from(const way *w, double from, search *found) {
    const sight_bounds *bounds = w->sight->bounds;
    int level = 0;
    while (from < w->length) {
        const double side = (double)(4 << 2 * level), to = from + side;
        const double a = from / w->length, b = to < w->length ? to / w->length : 1;
        if (from > 0 && bound_between(w, a, b, level) < found->rise.steepest) {
            from = to;
            if (level + 1 < bounds->levels && level < 6 && fmod(from, 4 * side) == 0) level++;
        } else if (level > 0) {
            level--;
        } else {
            if (look_between(w, a, b, look_for_steepest, found)) return;
            from = to;
        }
    }
}

sight_rise sight_steepest(const sight *s, double i, double j, double least, double enough) {
    const way w = way_to(s, i, j);
    search found = {{least, 0}, enough};
    if (w.length > at_end) search_from(&w, 0, &found);
    return found.rise;
}

/* An edge this near to the eye is crossed at places that rounding moves about. That matters nothing if all of it is below the
 * eye there: it then rises less steeply than its far end. */
static const double clear_of_edges = 0x1p-10;

static bool is_clear(const sight *s) {
    const terrain *t = s->terrain;
    const double places[3] = {s->eye[0], s->eye[1], s->eye[0] - s->eye[1]};
    bool beside = false;
    for (int k = 0; k < 3; k++) beside |= fabs(places[k] - nearbyint(places[k])) < clear_of_edges;
    if (!beside) return true;
    double low = INFINITY, high = -INFINITY;
    for (double j = floor(s->eye[1]) - 1; j <= s->eye[1] + 2; j++)
        for (double i = floor(s->eye[0]) - 1; i <= s->eye[0] + 2; i++) {
            if (!(i >= 0 && j >= 0 && i < (double)t->nx && j < (double)t->ny)) continue;
            const double z = (double)t->z[(size_t)j * t->nx + (size_t)i];
            low = z < low ? z : low;
            high = z > high ? z : high;
        }
    const double ground = terrain_height(t, s->eye[0], s->eye[1]) / t->map[2][2];
    return ground + 2 * clear_of_edges * (high - low) < s->eye[2];
}

/* Seen from the eye, an edge is straight: what of it lies between two directions rises highest at one of them or at a sample
 * between them. Edges that are crossed within a cell of the eye end within two of it. */
double sight_around(const sight *s, const double a[2], const double b[2]) {
    enum { CELLS = 4 };
    if (!is_clear(s)) return INFINITY;
    const terrain *t = s->terrain;
    search found = {{-INFINITY, 0}, INFINITY};
    for (int k = 0; k < 2; k++) {
        const double *d = k ? b : a;
        const way w = way_to(s, s->eye[0] + CELLS * d[0], s->eye[1] + CELLS * d[1]);
        look_between(&w, 1 - 2.0 / CELLS, 1, look_for_steepest, &found);
    }
    double steepest = found.rise.steepest / CELLS;
    for (double j = ceil(s->eye[1] - 2); j <= s->eye[1] + 2; j++)
        for (double i = ceil(s->eye[0] - 2); i <= s->eye[0] + 2; i++) {
            if (!(i >= 0 && j >= 0 && i < (double)t->nx && j < (double)t->ny)) continue;
            const double x = i - s->eye[0], y = j - s->eye[1], away = fmax(fabs(x), fabs(y));
            const double turn = a[0] * b[1] - a[1] * b[0] < 0 ? -1 : 1;
            const bool between = turn * (a[0] * y - a[1] * x) >= -at_end && turn * (x * b[1] - y * b[0]) >= -at_end;
            const double height = sight_sample(s, (size_t)i, (size_t)j);
            if (between && x * a[0] + y * a[1] > 0 && height / away > steepest && height < INFINITY)
                steepest = height / away;
        }
    /* Elsewhere places of crossings are off by less than 2^-27 cells, which is 2^-17 of the way there. */
    return steepest + 0x1p-16 * fabs(steepest);
}

bool sight_sees(const sight *s, double i, double j, double height, sight_parts parts) {
    const way w = way_to(s, i, j);
    search found = {{height, 0}, height};
    if (!(w.length > at_end)) return true;
    if (parts.close < w.length) {
        if (parts.close > 0 && look_between(&w, 0, parts.close / w.length, look_for_steepest, &found)) return false;
        return !(parts.eye && look_between(&w, 1 - 1 / w.length, 1, look_for_steepest, &found));
    }
    search_from(&w, 0, &found);
    return found.rise.share == 0;
}

/* ---- the first block ---------------------------------------------------------------------------------------------- */

typedef struct obstacle {
    double height; /* of the way's far end over the eye */
    double first;  /* share of the nearest crossing at which the surface is not below the line */
    double over;   /* how far it is above it there */
    double before,
        gap; /* the crossing before that, and how far the surface is above the line there: less than nothing */
} obstacle;

static bool look_for_obstacle(void *context, double share, double height) {
    obstacle *o = context;
    const double over = height - share * o->height;
    if (over >= 0 && share < o->first) {
        o->first = share;
        o->over = over;
    }
    return false;
}

static bool look_before(void *context, double share, double height) {
    obstacle *o = context;
    if (share < o->first && share > o->before) {
        o->before = share;
        o->gap = height - share * o->height;
    }
    return false;
}

double sight_first_block(const sight *s, double i, double j, double height) {
    const way w = way_to(s, i, j);
    obstacle o = {.height = height, .first = INFINITY};
    if (!(w.length > at_end)) return INFINITY;
    look_between(&w, 0, 1, look_for_obstacle, &o);
    if (o.first == INFINITY) return INFINITY;
    o.gap = terrain_height(s->terrain, s->eye[0], s->eye[1]) / s->terrain->map[2][2] - s->eye[2];
    look_between(&w, 0, 1, look_before, &o);
    /* Between the two the surface is plane, if it is there. */
    return o.gap < 0 ? o.before + (o.first - o.before) * (o.gap / (o.gap - o.over)) : o.first;
}
