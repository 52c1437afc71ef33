/* SPDX-License-Identifier: Apache-2.0 */
#include "sight.h"

#include "way.h"

/* ---- the place --------------------------------------------------------------------------------------------------- */

static double clamped(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/* Multiples of 2^-60 cells: one over a distance is finite, and the products of touch.c do not underflow. */
static double rounded_place(double x) { return rint(x * 0x1p60) * 0x1p-60; }

/* For the same reason. */
static double without_dust(double height) { return fabs(height) < 0x1p-200 ? 0 : height; }

void cw_sight_init(sight *s, const terrain *t, const sight_bounds *bounds, const double eye[3], double curvature) {
    cw_sight_init_line(s, t, eye, eye, curvature);
    s->bounds = bounds;
}

void cw_sight_middle(const double from[2], const double to[2], double middle[2]) {
    for (int a = 0; a < 2; a++) middle[a] = rint(0.5 * (from[a] + to[a]) * 0x1p20) * 0x1p-20;
}

void cw_sight_init_line(sight *s, const terrain *t, const double eye[3], const double middle[2], double curvature) {
    *s = (sight){.terrain = t};
    for (int c = 0; c < 2; c++) {
        s->eye[c] = rounded_place(eye[c]);
        s->corner[c] = floor(s->eye[c]);
        s->near[c] = s->eye[c] - s->corner[c];
    }
    s->eye[2] = without_dust(eye[2]);
    double metres[2];
    cw_terrain_metres(t, middle[0], middle[1], metres);
    const double k = curvature / (2 * t->radius * t->map[2][2]);
    const double(*m)[4] = (const double(*)[4])t->map;
    for (int c = 0; c < 2; c++) {
        const double scale = k * metres[c] * metres[c];
        s->fall[0] += scale * m[c][0] * m[c][0];
        s->fall[1] += scale * 2 * m[c][0] * m[c][1];
        s->fall[2] += scale * m[c][1] * m[c][1];
    }
    for (int c = 0; c < 3; c++) s->fall[c] = without_dust(s->fall[c]);
}

double cw_sight_sample(const sight *s, size_t i, size_t j) {
    return (double)terrain_row(s->terrain, j)[i] - s->eye[2] - sight_fall(s, (double)i, (double)j);
}

/* ---- the steepest rise ------------------------------------------------------------------------------------------- */

/* A crossing within this many cells of an end is at the end, where rises are sought, which are rounded anyway. */
static const double at_end = 0x1p-27;

static inline bool look_for_steepest(void *context, const crossing *c) {
    sight_rise *found = context;
    const double share = c->share, height = c->height, length = c->way->length;
    /* Most are lower by far, which tells without a division. */
    const double line = found->steepest * share;
    if (height < line - 0x1p-50 * (fabs(line) + fabs(height))) return false;
    if (!(share * length > at_end && (1 - share) * length > at_end)) return false;
    const double rise = height / share;
    if (rise > found->steepest) *found = (sight_rise){rise, share};
    return false;
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
    const double x = s->corner[0], x0 = x + way_at(w->place[0], w->step[0], a),
                 x1 = x + way_at(w->place[0], w->step[0], b);
    const double y = s->corner[1], y0 = y + way_at(w->place[1], w->step[1], a),
                 y1 = y + way_at(w->place[1], w->step[1], b);
    const double most_x = (double)(s->terrain->nx - 1), most_y = (double)(s->terrain->ny - 1);
    /* Samples on either side of the way, and one more for rounding. */
    const double first_x = whole_below(x0 < x1 ? x0 : x1) - 1, last_x = whole_above(x0 < x1 ? x1 : x0) + 1;
    const double first_y = whole_below(y0 < y1 ? y0 : y1) - 1, last_y = whole_above(y0 < y1 ? y1 : y0) + 1;
    if (last_x < 0 || first_x > most_x || last_y < 0 || first_y > most_y) return -INFINITY; /* there are none */
    const double left = clamped(first_x, 0, most_x), right = clamped(last_x, 0, most_x);
    const double top = clamped(first_y, 0, most_y), bottom = clamped(last_y, 0, most_y);
    const int shift = SIGHT_FIRST_SHIFT + 2 * level;
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
    /* Shares from the eye. A crossing may count as one of this stretch if that is within rounding: the targets of
     * lines that are decided are samples, so that the way goes at least a cell across all lines between. */
    const double room = 2 * w->slack + 2 * way_share_error, near = 1 - b - room, far = 1 - a + room;
    if (height == -INFINITY) return height;
    /* Slightly more, for the rounding of heights between samples. */
    const double pad = 0x1p-48 * (fabs((double)high) + fabs(s->eye[2]) + fabs(height));
    return height + pad > 0 ? (near > 0 ? (height + pad) / near : INFINITY) : (height + pad) / far;
}

/* All of the way, or from so many cells from the target on, in which something may rise more steeply than *steepest,
 * which look may raise. Stretches end at whole fours of cells. */
static inline void look_along(const way *w, double from, const double *steepest, way_look *look, void *context) {
    const sight_bounds *bounds = w->sight->bounds;
    int level = 0;
    while (from < w->length) {
        const double side = (double)(4 << 2 * level), to = from + side;
        const double a = from / w->length, b = to < w->length ? to / w->length : 1;
        if (from > 0 && bound_between(w, a, b, level) < *steepest) {
            from = to;
            if (level + 1 < bounds->levels && level < 6 && fmod(from, 4 * side) == 0) level++;
        } else if (level > 0) {
            level--;
        } else {
            if (look_between(w, a, b, look, context)) return;
            from = to;
        }
    }
}

sight_rise cw_sight_steepest(const sight *s, double i, double j, double least) {
    const way w = way_to(s, i, j, 0, 0);
    sight_rise found = {least, 0};
    if (w.length > at_end) look_along(&w, 0, &found.steepest, look_for_steepest, &found);
    return found;
}

/* How far the height of a crossing over a line may be off. */
static inline double doubt_of(const crossing *c) {
    const way *w = c->way;
    return w->rough + 2 * (w->slack + 0x1p-49) * c->steps + 0x1p-49 * fabs(c->height);
}

typedef struct tie {
    sight_rise steepest;
    double share; /* the least so far */
} tie;

static inline bool look_for_tie(void *context, const crossing *c) {
    tie *t = context;
    const double share = c->share, length = c->way->length;
    if (!(share < t->share && share * length > at_end && (1 - share) * length > at_end)) return false;
    /* The steepest is off by the same as at its own crossing, which is no nearer than this one. */
    const double line = t->steepest.steepest * share;
    if (c->height + 2 * doubt_of(c) + 0x1p-48 * fabs(line) >= line) t->share = share;
    return false;
}

double cw_sight_nearest(const sight *s, double i, double j, sight_rise steepest) {
    const way w = way_to(s, i, j, 0, 0);
    tie t = {steepest, steepest.share};
    /* Stretches are passed over by a lower rise than any tie has. */
    const double low = steepest.steepest - 0x1p-30 * (fabs(steepest.steepest) + fabs(s->eye[2]));
    /* Only nearer places count, and the last stretch of those that are not. */
    const double fours = floor((1 - steepest.share) * w.length / 4) - 1;
    if (w.length > at_end && steepest.share > 0) look_along(&w, fours > 0 ? 4 * fours : 0, &low, look_for_tie, &t);
    return t.share;
}

/* An edge this near to the eye is crossed at places that rounding moves about. That matters nothing if all of it is
 * below the eye there: it then rises less steeply than its far end. */
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
            const double z = (double)terrain_row(t, (size_t)j)[(size_t)i];
            low = z < low ? z : low;
            high = z > high ? z : high;
        }
    const double ground = cw_terrain_level(t, s->eye[0], s->eye[1]);
    return ground + 2 * clear_of_edges * (high - low) < s->eye[2];
}

/* Seen from the eye, an edge is straight: what of it lies between two directions rises highest at one of them or at
 * a sample between them. Edges that are crossed within a cell of the eye end within two of it. */
double cw_sight_around(const sight *s, const double a[2], const double b[2]) {
    enum { CELLS = 4 };
    if (!is_clear(s)) return INFINITY;
    const terrain *t = s->terrain;
    sight_rise found = {-INFINITY, 0};
    for (int k = 0; k < 2; k++) {
        const double *d = k ? b : a;
        const way w = way_to(s, s->eye[0] + CELLS * d[0], s->eye[1] + CELLS * d[1], 0, 0);
        look_between(&w, 1 - 2.0 / CELLS, 1, look_for_steepest, &found);
    }
    double steepest = found.steepest / CELLS, size = fabs(s->eye[2]);
    for (int k = 0; k < 3; k++) size += 16 * fabs(s->fall[k]);
    double most = 0;
    for (double j = ceil(s->eye[1] - 2); j <= s->eye[1] + 2; j++)
        for (double i = ceil(s->eye[0] - 2); i <= s->eye[0] + 2; i++) {
            if (!(i >= 0 && j >= 0 && i < (double)t->nx && j < (double)t->ny)) continue;
            const double x = i - s->eye[0], y = j - s->eye[1], away = fmax(fabs(x), fabs(y));
            const double turn = a[0] * b[1] - a[1] * b[0] < 0 ? -1 : 1;
            const bool between = turn * (a[0] * y - a[1] * x) >= -at_end && turn * (x * b[1] - y * b[0]) >= -at_end;
            const double height = cw_sight_sample(s, (size_t)i, (size_t)j);
            most = isfinite(height) && fabs(height) > most ? fabs(height) : most;
            if (between && x * a[0] + y * a[1] > 0 && height / away > steepest && height < INFINITY)
                steepest = height / away;
        }
    /* Elsewhere places of crossings are off by less than 2^-27 cells, which is 2^-17 of the way there, and heights
     * by 2^-50 of the numbers that they are made of, 2^-10 cells from the eye or farther. */
    return steepest + 0x1p-16 * fabs(steepest) + 0x1p-38 * (size + most);
}

/* ---- decisions --------------------------------------------------------------------------------------------------- */

/* Whether the surface is not below the line at a crossing; over is how far it is above, rounded. */
static inline bool is_blocked(const crossing *c, double *over) {
    const way *w = c->way;
    *over = c->height - c->share * w->top;
    const double doubt = doubt_of(c);
    if (*over < -doubt) return false;
    const bool inside = c->share > way_share_error && c->share < 1 - way_share_error;
    if (*over > doubt && inside && !c->at_sample) return true;
    const touch t = cw_touch_at(c);
    return t.crosses && t.side >= 0;
}

static inline bool look_for_block(void *context, const crossing *c) {
    bool *blocked = context;
    double over;
    return *blocked = is_blocked(c, &over);
}

bool cw_sight_sees(const sight *s, double i, double j, double z, double above, sight_parts parts) {
    const way w = way_to(s, i, j, z, without_dust(above));
    bool blocked = false;
    if (w.length == 0) return true;
    if (parts.close < w.length) {
        if (parts.close > 0 && look_between(&w, 0, parts.close / w.length, look_for_block, &blocked)) return false;
        return !(parts.eye && look_between(&w, 1 - 1 / w.length, 1, look_for_block, &blocked));
    }
    look_along(&w, 0, &w.top, look_for_block, &blocked);
    return !blocked;
}

/* The height needed over a target of height 0. */
typedef struct need {
    double steepest; /* the steepest rise that is more than the target's for sure, or less than that */
    double excess;   /* of what is in doubt */
} need;

static inline bool look_for_need(void *context, const crossing *c) {
    need *n = context;
    const way *w = c->way;
    const double line = n->steepest * c->share;
    const double doubt = doubt_of(c);
    if (c->height < line - doubt) return false;
    const bool inside = c->share > way_share_error && c->share < 1 - way_share_error;
    if (c->height - c->share * w->top > doubt && inside && !c->at_sample) {
        n->steepest = fmax(n->steepest, c->height / c->share);
        return false;
    }
    const touch t = cw_touch_at(c);
    if (t.crosses && t.excess > n->excess) n->excess = t.excess;
    return false;
}

double cw_sight_need(const sight *s, double i, double j, double z, double low) {
    const way w = way_to(s, i, j, z, 0);
    need n = {fmax(low, w.top), 0};
    if (w.length > 0) look_along(&w, 0, &n.steepest, look_for_need, &n);
    return fmax(n.steepest - w.top, n.excess);
}

double cw_sight_need_known(const sight *s, double i, double j, double z, double rise, double error, sight_parts parts) {
    const double top = z - s->eye[2] - sight_fall(s, i, j), steepest = rise > top ? rise : top;
    if (!(fabs(rise - top) > error)) return NAN;
    if (!(parts.close > 0 || parts.eye)) return steepest - top;
    const way w = way_to(s, i, j, z, 0);
    need n = {steepest, 0};
    if (parts.close > 0) look_between(&w, 0, fmin(parts.close / w.length, 1), look_for_need, &n);
    if (parts.eye) look_between(&w, 1 - 1 / w.length, 1, look_for_need, &n);
    return fmax(n.steepest - w.top, n.excess);
}

/* ---- the first block --------------------------------------------------------------------------------------------- */

typedef struct obstacle {
    double first;  /* share of the nearest crossing at which the surface is not below the line */
    double over;   /* how far it is above it there */
    double before, /* the crossing before that */
        gap;       /* how far the surface is above the line there: less than nothing */
} obstacle;

static bool look_for_obstacle(void *context, const crossing *c) {
    obstacle *o = context;
    double over;
    if (c->share < o->first && is_blocked(c, &over)) {
        o->first = c->share;
        o->over = fmax(over, 0);
    }
    return false;
}

/* Where there is no surface, the gap is NaN. */
static bool look_before(void *context, const crossing *c) {
    obstacle *o = context;
    if (c->share < o->first && c->share > fmax(o->before, way_share_error)) { /* not the eye's own sample */
        o->before = c->share;
        o->gap = c->height - c->share * c->way->top;
    }
    return false;
}

/* By how much the triangle that the eye stands over is lowered there, as its corners are. */
static double fall_of_triangle(const sight *s) {
    const double i = s->corner[0], j = s->corner[1], x = s->near[0], y = s->near[1];
    const double across = x > y ? x : y, along = x > y ? y : x;
    return (1 - across) * sight_fall(s, i, j) + (across - along) * sight_fall(s, i + (x > y), j + !(x > y)) +
           along * sight_fall(s, i + 1, j + 1);
}

double cw_sight_first_block(const sight *s, double i, double j, double z) {
    way w = way_to(s, rounded_place(i), rounded_place(j), without_dust(z), 0);
    obstacle o = {.first = INFINITY};
    if (w.length == 0) return INFINITY;
    look_between(&w, 0, 1, look_for_obstacle, &o);
    if (o.first == INFINITY) return INFINITY;
    o.gap = cw_terrain_level(s->terrain, s->eye[0], s->eye[1]) - s->eye[2] - fall_of_triangle(s);
    w.gaps = true;
    look_between(&w, 0, 1, look_before, &o);
    /* Between the two the surface is plane, if the crossing before has one. */
    return o.gap < 0 ? o.before + (o.first - o.before) * (o.gap / (o.gap - o.over)) : o.first;
}
