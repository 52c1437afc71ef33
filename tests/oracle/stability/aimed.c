/* SPDX-License-Identifier: Apache-2.0 */
#include "stability/aimed.h"

#include <math.h>

const char *aim_name(aim kind) {
    static const char *const names[AIM_COUNT] = {"inside",  "vertex",   "edge",  "diagonal", "borders", "axis",
                                                 "corners", "vertical", "steep", "long",     "grazing"};
    return names[kind];
}

/* A ray in the making: it goes through p, n · step before it and m · step behind it being clear of all samples, while
 * it rises by rise with every step. */
typedef struct plan {
    double p[3], step[2], rise;
    double n, m;
    double farther; /* steps before all that, which the ray starts ahead */
    int side;       /* it comes from above if 1, from below if -1 */
    bool exact;     /* places and steps are whole or halves: keep them so */
    bool near;      /* clear of the surface where it begins and ends, not of all samples */
} plan;

aimed_field aimed_field_of(const cw_field *field) {
    const cw_field_info info = cw_field_describe(field);
    return (aimed_field){
        .field = field, .nx = info.nx, .ny = info.ny, .low = (double)info.low, .high = (double)info.high};
}

static double height_at(const aimed_field *f, size_t i, size_t j) { return (double)cw_field_row(f->field, j)[i]; }

/* p becomes the place at x, y in [0, 1] of cell (i, j). */
static void surface(const aimed_field *f, size_t i, size_t j, double x, double y, double p[3]) {
    const double h00 = height_at(f, i, j), h11 = height_at(f, i + 1, j + 1);
    const double corner = x >= y ? height_at(f, i + 1, j) : height_at(f, i, j + 1);
    p[0] = (double)i + x;
    p[1] = (double)j + y;
    p[2] = h00 + fmax(x, y) * (corner - h00) + fmin(x, y) * (h11 - corner);
}

static double sign(random_state *r) { return random_bits(r) >> 63 ? 1 : -1; }

/* A place of that kind in the cell, or on the borders that begin at its sample; x, y as for surface. */
static void place_of(aim kind, const aimed_field *f, random_state *r, size_t i, size_t j, double x, double y,
                     double p[3]) {
    if (kind == AIM_EDGE) {
        const double along = random_unit(r);
        const bool along_x = random_below(r, 2);
        surface(f, i, j, along_x ? along : 0, along_x ? 0 : along, p);
    } else {
        surface(f, i, j, kind == AIM_VERTEX ? 0 : x, kind == AIM_VERTEX ? 0 : kind == AIM_DIAGONAL ? x : y, p);
    }
}

/* How many steps from p stay within the field, most of a cell off its border. */
static double room(const aimed_field *f, const double p[3], const double step[2], double direction) {
    const double margin = 0.75, last[2] = {(double)(f->nx - 1), (double)(f->ny - 1)};
    double most = 1e300;
    for (int c = 0; c < 2; c++) {
        const double d = direction * step[c];
        if (d > 0) most = fmin(most, (last[c] - margin - p[c]) / d);
        if (d < 0) most = fmin(most, (margin - p[c]) / d);
    }
    return most;
}

static void turn(random_state *r, double step[2]) {
    const double angle = random_between(r, 0, 6.283185307179586);
    step[0] = cos(angle);
    step[1] = sin(angle);
}

static void aim_at(aim kind, aim_start start, const aimed_field *f, random_state *r, plan *q) {
    const size_t i = 1 + random_below(r, f->nx - 3), j = 1 + random_below(r, f->ny - 3); /* an inner sample */
    const size_t longest = start == START_NEAR ? 1 : 3;                                  /* step over samples */
    const double x = random_unit(r), y = random_unit(r);
    turn(r, q->step);
    switch (kind) {
    case AIM_BORDERS:
    case AIM_AXIS: {
        const bool along_x = random_below(r, 2);
        q->step[0] = along_x ? sign(r) : 0;
        q->step[1] = along_x ? 0 : sign(r);
        q->exact = kind == AIM_BORDERS && random_below(r, 2);
        const bool any_x = kind == AIM_AXIS || (along_x && !q->exact),
                   any_y = kind == AIM_AXIS || !(along_x || q->exact);
        surface(f, i, j, any_x ? x : 0, any_y ? y : 0, q->p);
        break;
    }
    case AIM_CORNERS:
        surface(f, i, j, 0, 0, q->p);
        do {
            q->step[0] = (double)random_below(r, 2 * longest + 1) - (double)longest;
            q->step[1] = (double)random_below(r, 2 * longest + 1) - (double)longest;
        } while (q->step[0] == 0 && q->step[1] == 0);
        q->exact = room(f, q->p, q->step, -1) >= 1 && room(f, q->p, q->step, 1) >= 1;
        break;
    case AIM_STEEP: {
        const double tiny = pow(10, random_between(r, -12, -2)) * (random_below(r, 8) ? 1 : 1e-28);
        place_of(AIM_EDGE, f, r, i, j, x, y, q->p);
        q->step[0] *= tiny;
        q->step[1] *= random_below(r, 4) ? tiny : 0;
        break;
    }
    case AIM_VERTICAL: {
        static const aim places[4] = {AIM_VERTEX, AIM_EDGE, AIM_DIAGONAL, AIM_INSIDE};
        q->step[0] = q->step[1] = 0;
        place_of(places[random_below(r, 4)], f, r, i, j, x, y, q->p);
        for (int c = 0; c < 2; c++) q->p[c] = (double)(float)q->p[c];
        break;
    }
    case AIM_LONG:
        place_of(random_below(r, 2) ? AIM_EDGE : AIM_VERTEX, f, r, i, j, x, y, q->p);
        break;
    default:
        place_of(kind, f, r, i, j, x, y, q->p);
    }
}

/* The triangle over or under (x, y), as a hit without a place on it. */
static cw_hit triangle_at(double x, double y) {
    const double i = floor(x), j = floor(y);
    return (cw_hit){.i = (int32_t)i, .j = (int32_t)j, .triangle = x - i < y - j};
}

/* Height of the surface so many steps on from p. */
static double height_after(const aimed_field *f, const plan *q, double steps) {
    const double x = q->p[0] + steps * q->step[0], y = q->p[1] + steps * q->step[1];
    double place[3];
    surface(f, (size_t)x, (size_t)y, x - floor(x), y - floor(y), place);
    return place[2];
}

/* Where the ray starts and how steep it is: clear of all samples n steps before p and m steps behind it. One that
 * starts near is clear of the surface at these places alone. */
static void place_ends(aim kind, aim_start start, const aimed_field *f, random_state *r, plan *q) {
    const double span = f->high - f->low, tall = span > 0 ? span : fmax(fabs(f->high), 1);
    const double most = start == START_NEAR ? 2 : 1e6;
    const double back = fmin(room(f, q->p, q->step, -1), most), ahead = fmin(room(f, q->p, q->step, 1), most);
    double clear = tall * pow(10, random_between(r, -3, 0)), high = f->high, low = f->low;
    if (q->exact) {
        q->n = 1 + floor(random_unit(r) * (back - 1));
        q->m = 1 + floor(random_unit(r) * (ahead - 1));
    } else if (kind == AIM_LONG && start != START_NEAR) {
        q->n = back;
        q->m = ahead;
        clear = tall * pow(10, random_between(r, -4, -2));
    } else {
        q->n = back * random_between(r, 0.001, 1);
        q->m = ahead * random_between(r, 0.001, 1);
    }
    if (start == START_NEAR) {
        q->near = true;
        high = height_after(f, q, -q->n);
        low = height_after(f, q, q->m);
        clear *= fmax(1e-3, fmax(fabs(high - q->p[2]), fabs(low - q->p[2])) / tall);
    }
    if (tall < 0x1p-100) clear = fmax(clear, 0.1 * tall); /* denormal, and so are the errors of less */
    const double above = high - q->p[2] + clear, below = q->p[2] - low + clear;
    q->rise = -fmax(above / q->n, below / q->m);
    if (f->bounded) {
        q->n = above / -q->rise;
        q->m = below / -q->rise;
    }
    q->side = 1;
    if (random_below(r, 2)) { /* upwards, from below */
        const double n = q->n;
        q->n = q->m;
        q->m = n;
        q->step[0] = -q->step[0];
        q->step[1] = -q->step[1];
        q->rise = -q->rise;
        q->side = -1;
    }
    if (start != START_AFAR) return;
    const double length = fmax(hypot(q->step[0], q->step[1]), fabs(q->rise)),
                 side = (double)(f->nx > f->ny ? f->nx : f->ny);
    const double away = kind == AIM_VERTICAL ? fmin(side, 10 * tall) : side; /* else nothing is left of faint heights */
    q->farther = away * pow(10, random_between(r, 0.3, kind == AIM_VERTICAL ? 12 : 7)) / length;
    if (q->exact) q->farther = floor(fmin(q->farther, 4e6 * random_unit(r))); /* where whole numbers are floats */
}

/* A scale of the direction, or that times a power of 2 for which its rise does not count as zero. */
static double rising(double scale, double rise) {
    const double least = 0x1p-120, got = fabs(rise) * scale;
    return got < least && got > 0 ? scale * exp2(ceil(log2(least / got))) : scale;
}

/* A length for the direction: as it comes, normalised, or any. */
static double any_length(random_state *r, const double d[3]) {
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const size_t kind = random_below(r, 4);
    return rising(kind == 0 ? 1 : (kind == 1 ? exp2(random_between(r, -20, 20)) : 1) / length, d[2]);
}

/* Where the range begins, so far behind that t = from is in it. */
static float begin_behind(random_state *r, double from) {
    const double least = fmax(-from, 0x1p-126), tmin = least * exp2((double)random_below(r, 64));
    return random_below(r, 4) && tmin < 0x1p127 ? -(float)exp2(ceil(log2(tmin))) : -INFINITY;
}

/* The ray starts at the height of the highest sample if it comes from above, of the lowest if from below. */
static aimed_ray from_behind(random_state *r, const plan *q, const aimed_field *f) {
    const double height = q->side > 0 ? f->high : f->low, start = (height - q->p[2]) / q->rise;
    const double step[3] = {q->step[0], q->step[1], q->rise};
    const double scale = q->exact ? rising(exp2((double)random_below(r, 5) - 2), q->rise) : any_length(r, step);
    aimed_ray a = {.ray = {.tmax = INFINITY}, .over = {{.i = -1}, {.i = -1}}, .side = q->side};
    for (int c = 0; c < 3; c++) {
        a.ray.org[c] = (float)(c < 2 ? q->p[c] + start * step[c] : height);
        a.ray.dir[c] = (float)(step[c] * scale);
    }
    a.from = (-q->n - start) / scale;
    a.to = (q->m - start) / scale;
    a.ray.tmin = begin_behind(r, a.from);
    return a;
}

static aimed_ray from_plan(random_state *r, const plan *q, aim_start start, bool bounded) {
    const double total = q->n + q->farther;
    const double step[3] = {q->step[0], q->step[1], q->rise};
    aimed_ray a = {.ray = {.tmin = 0, .tmax = INFINITY}, .over = {{.i = -1}, {.i = -1}}, .side = q->side};
    double d[3];
    for (int c = 0; c < 3; c++) {
        a.ray.org[c] = (float)(q->p[c] - total * step[c]);
        d[c] = q->p[c] - (double)a.ray.org[c];
    }
    const double scale = q->exact ? rising(exp2((double)random_below(r, 5) - 2) / total, d[2]) : any_length(r, d);
    for (int c = 0; c < 3; c++) a.ray.dir[c] = (float)(d[c] * scale);
    const double one = 1 / (scale * total), end = (total + q->m) * one;
    if (random_below(r, 2) || bounded) a.ray.tmax = (float)end;
    a.from = q->farther * one;
    if (start == START_AFAR && random_below(r, 2)) a.from = (double)(a.ray.tmin = (float)a.from);
    a.to = isinf(a.ray.tmax) ? end : (double)a.ray.tmax;
    for (int end_of = 0; q->near && end_of < 2; end_of++) {
        const double t = end_of ? a.to : a.from;
        a.over[end_of] = triangle_at((double)a.ray.org[0] + t * (double)a.ray.dir[0],
                                     (double)a.ray.org[1] + t * (double)a.ray.dir[1]);
    }
    return a;
}

/* Through a place well inside a triangle, at a small angle to it. */
static aimed_ray grazing(aim_start start, const aimed_field *f, random_state *r) {
    static const double from[START_COUNT] = {-1, 0.3, -2, -1}, to[START_COUNT] = {2, 7, 0.3, 2};
    const double unit = start == START_AFAR ? (double)(f->nx > f->ny ? f->nx : f->ny) : 1;
    const size_t i = random_below(r, f->nx - 1), j = random_below(r, f->ny - 1);
    const bool in_a = random_below(r, 2);
    double p[3], step[2], x = random_unit(r), y = random_unit(r);
    if (x + y > 1) x = 1 - x, y = 1 - y;
    const double u = 0.1 + 0.7 * x, v = 0.1 + 0.7 * y; /* barycentric, 0.1 to 0.9 in sum */
    surface(f, i, j, in_a ? u + v : u, in_a ? v : u + v, p);
    turn(r, step);
    const double h00 = height_at(f, i, j), h11 = height_at(f, i + 1, j + 1);
    const double along_x = in_a ? height_at(f, i + 1, j) - h00 : h11 - height_at(f, i, j + 1);
    const double along_y = in_a ? h11 - height_at(f, i + 1, j) : height_at(f, i, j + 1) - h00;
    const double slope = along_x * step[0] + along_y * step[1];
    const double angle = sign(r) * 0.017453292519943295 * pow(10, random_between(r, -6, 0));
    const double rise = slope + angle * sqrt(1 + slope * slope),
                 back = unit * pow(10, random_between(r, from[start], to[start]));
    const double d[3] = {step[0] * back, step[1] * back, rise * back};
    const double scale = any_length(r, d);
    aimed_ray a = {.ray = {.tmin = 0, .tmax = INFINITY}};
    for (int c = 0; c < 3; c++) {
        a.ray.org[c] = (float)(p[c] - d[c]);
        a.ray.dir[c] = (float)((p[c] - (double)a.ray.org[c]) * scale);
    }
    /* 0.04 steps off p it is still inside, and behind its origin by most of the way. */
    const double at = 1 / scale, off = fmin(0.04, 0.9 * back) * at / back;
    a.over[0] = a.over[1] =
        (cw_hit){.i = (int32_t)i, .j = (int32_t)j, .triangle = in_a ? CW_TRIANGLE_A : CW_TRIANGLE_B};
    a.from = at - off;
    a.to = at + off;
    a.side = angle < 0 ? 1 : -1;
    if (start == START_BEHIND) a.ray.tmin = begin_behind(r, a.from);
    return a;
}

aimed_ray aimed_ray_make(aim kind, aim_start start, const aimed_field *f, random_state *r) {
    if (kind == AIM_GRAZING) return grazing(start, f, r);
    plan q = {.farther = 0};
    aim_at(kind, start, f, r, &q);
    place_ends(kind, start, f, r, &q);
    if (start == START_BEHIND) return from_behind(r, &q, f);
    return from_plan(r, &q, start, f->bounded);
}
