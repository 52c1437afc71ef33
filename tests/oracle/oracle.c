/* SPDX-License-Identifier: Apache-2.0 */
/* The exact walk. Doubles decide wherever their error cannot matter, exact numbers (exact.c) where it could; so the
 * walk is as fast as the kernels on most rays and never wrong on any. */

#include "oracle_walk.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

static float sample(const oracle *o, int32_t i, int32_t j) { return o->z[(size_t)j * o->nx + (size_t)i]; }

bool oracle_solid(const oracle *o, int32_t i, int32_t j, uint32_t triangle) {
    if (i < 0 || j < 0 || i >= (int32_t)o->nx - 1 || j >= (int32_t)o->ny - 1) return false;
    const float third = triangle == CW_TRIANGLE_A ? sample(o, i + 1, j) : sample(o, i, j + 1);
    return isfinite(sample(o, i, j)) && isfinite(third) && isfinite(sample(o, i + 1, j + 1));
}

plane oracle_plane(const oracle *o, const oracle_triangle *t) {
    const double h00 = (double)sample(o, t->i, t->j), h11 = (double)sample(o, t->i + 1, t->j + 1);
    const bool a = t->triangle == CW_TRIANGLE_A;
    const double corner = (double)(a ? sample(o, t->i + 1, t->j) : sample(o, t->i, t->j + 1));
    plane p = {
        .h = h00, .a1 = a ? corner : h11, .a0 = a ? h00 : corner, .b1 = a ? h11 : corner, .b0 = a ? corner : h00};
    p.a = p.a1 - p.a0;
    p.b = p.b1 - p.b0;
    return p;
}

double oracle_height(const oracle *o, const oracle_triangle *t, double at) {
    const plane p = oracle_plane(o, t);
    const double x = o->ox + at * o->dx - t->i, y = o->oy + at * o->dy - t->j;
    return (o->oz + at * o->dz - p.h) - p.a * x - p.b * y;
}

/* ---- the field's bounds ------------------------------------------------------------------------------------------ */

static const bounds_surface nothing = {(double)INFINITY, -(double)INFINITY, 0};

static void note_edge(bounds_surface *b, float p, float q) {
    if (!isfinite(p) || !isfinite(q)) return;
    b->S = fmax(b->S, fabs((double)p - (double)q));
    b->low = fmin(b->low, fmin((double)p, (double)q));
    b->high = fmax(b->high, fmax((double)p, (double)q));
}

static cell_bounds bounds_around(const oracle *o, int32_t i, int32_t j) {
    bounds_surface s = nothing;
    bool all_solid = true;
    for (int32_t y = j - 1; y <= j + 1; y++)
        for (int32_t x = i - 1; x <= i + 1; x++) {
            if (!oracle_solid(o, x, y, CW_TRIANGLE_A) || !oracle_solid(o, x, y, CW_TRIANGLE_B)) all_solid = false;
            if (x < 0 || y < 0 || x >= (int32_t)o->nx - 1 || y >= (int32_t)o->ny - 1) continue;
            const float h00 = sample(o, x, y), h10 = sample(o, x + 1, y);
            const float h01 = sample(o, x, y + 1), h11 = sample(o, x + 1, y + 1);
            note_edge(&s, h00, h10);
            note_edge(&s, h00, h01);
            note_edge(&s, h01, h11);
            note_edge(&s, h10, h11);
            note_edge(&s, h00, h11);
        }
    if (!(s.low <= s.high)) s.low = s.high = 0; /* nothing but holes */
    return (cell_bounds){s, all_solid};
}

oracle *oracle_create(const float *samples, size_t nx, size_t ny) {
    oracle *o = calloc(1, sizeof *o);
    if (o == NULL) return NULL;
    o->z = samples;
    o->nx = nx;
    o->ny = ny;
    o->cell = malloc((nx - 1) * (ny - 1) * sizeof *o->cell);
    o->segment = malloc((3 * (nx + ny) + 8) * sizeof *o->segment);
    exact_init(o);
    if (o->cell == NULL || o->segment == NULL) {
        oracle_destroy(o);
        return NULL;
    }
    o->all = nothing;
    for (size_t k = 0; k < nx * ny; k++) {
        note_edge(&o->all, samples[k], samples[k]);
        o->holes |= !isfinite(samples[k]);
    }
    for (int32_t j = 0; j < (int32_t)ny - 1; j++)
        for (int32_t i = 0; i < (int32_t)nx - 1; i++) {
            cell_bounds *b = &o->cell[(size_t)j * (nx - 1) + (size_t)i];
            *b = bounds_around(o, i, j);
            o->all.S = fmax(o->all.S, b->surface.S);
        }
    return o;
}

void oracle_destroy(oracle *o) {
    if (o == NULL) return;
    exact_clear(o);
    free(o->cell);
    free(o->segment);
    free(o);
}

/* ---- crossings --------------------------------------------------------------------------------------------------- */

/* In double: a difference and a quotient, each within 2^-53 relative. Only the diagonal's numerator can cancel. */
static crossing cross(const oracle *o, crossing_kind kind, int32_t number) {
    crossing c = {.kind = kind, .number = number};
    if (kind == CROSSING_DIAGONAL) {
        const double num = number - (o->ox - o->oy), den = o->dx - o->dy;
        c.t = num / den;
        c.error = 0x1p-51 * (fabs(c.t) + (fabs(o->ox) + fabs(o->oy) + fabs((double)number)) / fabs(den));
    } else {
        c.t = kind == CROSSING_X ? (number - o->ox) / o->dx : (number - o->oy) / o->dy;
        c.error = 0x1p-51 * fabs(c.t);
    }
    return c;
}

static crossing constant(float t) { return (crossing){.kind = CROSSING_CONSTANT, .constant = t, .t = (double)t}; }

/* Sign of a - b. */
static int order(oracle *o, const crossing *a, const crossing *b) {
    const double gap = a->t - b->t;
    if (fabs(gap) > a->error + b->error) return gap > 0 ? 1 : -1;
    return exact_order(o, a, b);
}

/* Sign of d at a crossing, above a triangle. */
static int side(oracle *o, const oracle_triangle *t, const crossing *at) {
    const plane p = oracle_plane(o, t);
    const double reach = fabs(p.a) + fabs(p.b);
    const double highest = fmax(fmax(fabs(p.a1), fabs(p.a0)), fmax(fabs(p.b1), fabs(p.b0)));
    const double size =
        fabs(o->oz) + fabs(at->t * o->dz) + highest +
        reach * (fabs(o->ox) + fabs(o->oy) + fabs(at->t * o->dx) + fabs(at->t * o->dy) + t->i + t->j + 2);
    const double error = 0x1p-48 * size + at->error * (fabs(o->dz) + reach * (fabs(o->dx) + fabs(o->dy)));
    const double d = oracle_height(o, t, at->t);
    if (fabs(d) > error) return d > 0 ? 1 : -1;
    return exact_side(o, at, t);
}

/* ---- the walk ---------------------------------------------------------------------------------------------------- */

/* x, y or x - y along the ray. */
typedef struct axis {
    crossing_kind kind;
    int step;       /* sign of its direction */
    int32_t number; /* moving: of the next crossing; standing still: floor of the place */
    bool on;        /* standing still: the place is whole */
    crossing next;
} axis;

/* Where the ray is on an axis: on a whole number, or between it and the next. */
typedef struct position {
    int32_t floor;
    bool on;
} position;

static position between(const axis *a) {
    if (a->step == 0) return (position){a->number, a->on};
    return (position){a->step > 0 ? a->number - 1 : a->number, false};
}

/* At a crossing with t. */
static position at_end(oracle *o, const axis *a, const crossing *t) {
    if (a->step != 0 && order(o, &a->next, t) == 0) return (position){a->number, true};
    return between(a);
}
static position at_start(oracle *o, const axis *a, const crossing *t) {
    if (a->step == 0) return (position){a->number, a->on};
    const crossing behind = cross(o, a->kind, a->number - a->step);
    if (order(o, &behind, t) == 0) return (position){behind.number, true};
    return between(a);
}

/* The axis just after t: its next crossing is the first one after t. */
static axis axis_at(oracle *o, crossing_kind kind, double origin, double direction, const crossing *t) {
    axis a = {.kind = kind, .step = (direction > 0) - (direction < 0)};
    if (a.step == 0) {
        if (kind == CROSSING_DIAGONAL) {
            a.on = exact_diagonal(o, &a.number);
        } else {
            a.number = (int32_t)floor(origin);
            a.on = floor(origin) == origin;
        }
        return a;
    }
    const double low = kind == CROSSING_DIAGONAL ? -(double)o->ny : -1;
    const double high = kind == CROSSING_Y ? (double)o->ny : (double)o->nx;
    a.number = (int32_t)fmin(high, fmax(low, floor(origin + t->t * direction)));
    a.next = cross(o, kind, a.number);
    while (order(o, &a.next, t) > 0) a.next = cross(o, kind, a.number -= a.step);
    while (order(o, &a.next, t) <= 0) a.next = cross(o, kind, a.number += a.step);
    return a;
}

static void add_triangle(const oracle *o, segment *s, int32_t i, int32_t j, uint32_t triangle) {
    s->whole++;
    if (i < 0 || j < 0 || i >= (int32_t)o->nx - 1 || j >= (int32_t)o->ny - 1) return;
    const oracle_triangle t = {i, j, triangle};
    s->triangle[s->count++] = t;
    if (!oracle_solid(o, i, j, triangle)) return;
    s->triangle[s->count - 1] = s->triangle[s->solid]; /* solid ones first */
    s->triangle[s->solid++] = t;
}

/* The triangles that hold a place, given by x, y and x - y: of the six at a sample all, the two at an edge, or one. */
static void add_triangles(const oracle *o, segment *s, position x, position y, position diagonal) {
    enum { A = CW_TRIANGLE_A, B = CW_TRIANGLE_B };
    static const oracle_triangle at[6] = {{0, 0, A}, {0, 0, B}, {-1, 0, A}, {0, -1, B}, {-1, -1, A}, {-1, -1, B}};
    const int one = diagonal.floor >= x.floor - y.floor ? 1 : 2;
    const int of = x.on ? (y.on ? 63 : 2 + 4) : y.on ? 1 + 8 : diagonal.on ? 1 + 2 : one;
    s->count = s->whole = s->solid = 0;
    for (int k = 0; k < 6; k++)
        if (of >> k & 1) add_triangle(o, s, x.floor + at[k].i, y.floor + at[k].j, at[k].triangle);
}

/* The exact hit is at a crossing, on all solid triangles that hold the place. */
static void hit_at(oracle *o, const crossing *at, const segment *place) {
    oracle_truth *truth = &o->truth;
    truth->hit = true;
    truth->t = exact_value(o, at);
    truth->at = place->solid;
    for (unsigned k = 0; k < place->solid; k++) truth->triangle[k] = place->triangle[k];
}

/* Whether the surface is at the place that the ray is at. */
static bool touches(oracle *o, const segment *place, const crossing *at) {
    return place->solid > 0 && side(o, &place->triangle[0], at) == 0;
}

/* Looks for the first hit in a segment that is not yet among those without. */
static void search(oracle *o, const segment *s, axis axes[3]) {
    segment place;
    if (s->side_from == 0) {
        add_triangles(o, &place, at_start(o, &axes[0], &s->from), at_start(o, &axes[1], &s->from),
                      at_start(o, &axes[2], &s->from));
        hit_at(o, &s->from, &place);
    } else if (s->side_to == 0) {
        add_triangles(o, &place, at_end(o, &axes[0], &s->to), at_end(o, &axes[1], &s->to), at_end(o, &axes[2], &s->to));
        hit_at(o, &s->to, &place);
    } else if (s->side_from != s->side_to) {
        hit_at(o, &s->from, s);
        o->truth.t = exact_meet(o, &s->triangle[0]);
    }
}

static void walk(oracle *o, crossing start, crossing end) {
    axis axes[3] = {axis_at(o, CROSSING_X, o->ox, o->dx, &start), axis_at(o, CROSSING_Y, o->oy, o->dy, &start),
                    axis_at(o, CROSSING_DIAGONAL, o->ox - o->oy, o->dx - o->dy, &start)};
    segment place;
    add_triangles(o, &place, at_start(o, &axes[0], &start), at_start(o, &axes[1], &start),
                  at_start(o, &axes[2], &start));
    if (touches(o, &place, &start)) hit_at(o, &start, &place);
    while (order(o, &start, &end) < 0) {
        segment *s = &o->segment[o->segments++];
        s->from = start;
        s->to = end;
        for (int k = 0; k < 3; k++)
            if (axes[k].step != 0 && order(o, &axes[k].next, &s->to) < 0) s->to = axes[k].next;
        add_triangles(o, s, between(&axes[0]), between(&axes[1]), between(&axes[2]));
        if (s->solid > 0) {
            s->side_from = side(o, &s->triangle[0], &s->from);
            s->side_to = side(o, &s->triangle[0], &s->to);
            if (!o->truth.hit) search(o, s, axes);
            if (s->side_from == 0 && s->side_to == 0 && o->truth.t == exact_value(o, &s->from))
                o->truth.coplanar = true;
        }
        /* A vertex between holes may belong to a solid triangle that the ray touches nowhere else. */
        if (o->holes && !o->truth.hit) {
            add_triangles(o, &place, at_end(o, &axes[0], &s->to), at_end(o, &axes[1], &s->to),
                          at_end(o, &axes[2], &s->to));
            if (touches(o, &place, &s->to)) hit_at(o, &s->to, &place);
        }
        for (int k = 0; k < 3; k++)
            if (axes[k].step != 0 && order(o, &axes[k].next, &s->to) == 0)
                axes[k].next = cross(o, axes[k].kind, axes[k].number += axes[k].step);
        start = s->to;
    }
}

/* Cuts the t-range off at the field's two borders of one axis; false if nothing is left. */
static bool clip(oracle *o, crossing_kind kind, double origin, double direction, size_t samples, crossing *start,
                 crossing *end) {
    const int32_t last = (int32_t)samples - 1;
    if (direction == 0) return origin >= 0 && origin <= last;
    const crossing in = cross(o, kind, direction > 0 ? 0 : last), out = cross(o, kind, direction > 0 ? last : 0);
    if (order(o, &in, start) > 0) *start = in;
    if (order(o, &out, end) < 0) *end = out;
    return order(o, start, end) <= 0;
}

static float counted(float direction) { return fabsf(direction) <= 0x1p-128f ? 0 : direction; }

bool oracle_ray(oracle *o, const cw_ray *ray) {
    o->ray = *ray;
    cw_ray *r = &o->ray;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(r->org[c]) || !(fabsf(r->dir[c]) <= 0x1p126f)) return false;
        r->dir[c] = counted(r->dir[c]);
    }
    if (!(r->tmin <= r->tmax) || (r->dir[0] == 0 && r->dir[1] == 0 && r->dir[2] == 0)) return false;
    if (r->tmin < -FLT_MAX / 2) r->tmin = -FLT_MAX / 2;
    if (r->tmax > FLT_MAX / 2) r->tmax = FLT_MAX / 2;
    o->ox = (double)r->org[0], o->oy = (double)r->org[1], o->oz = (double)r->org[2];
    o->dx = (double)r->dir[0], o->dy = (double)r->dir[1], o->dz = (double)r->dir[2];
    const double org[3] = {o->ox, o->oy, o->oz}, dir[3] = {o->dx, o->dy, o->dz};
    o->bounds = bounds_ray_of(org, dir, o->nx, o->ny, o->all.low, o->all.high);
    return r->tmin <= r->tmax;
}

const oracle_truth *oracle_trace(oracle *o, const cw_ray *ray) {
    o->truth = (oracle_truth){.t = (double)INFINITY};
    o->segments = 0;
    if (!oracle_ray(o, ray)) return &o->truth;
    crossing start = constant(o->ray.tmin), end = constant(o->ray.tmax);
    if (!clip(o, CROSSING_X, o->ox, o->dx, o->nx, &start, &end)) return &o->truth;
    if (!clip(o, CROSSING_Y, o->oy, o->dy, o->ny, &start, &end)) return &o->truth;
    walk(o, start, end);
    oracle_find_pass(o);
    return &o->truth;
}
