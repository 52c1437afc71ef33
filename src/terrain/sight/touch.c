/* SPDX-License-Identifier: Apache-2.0 */
/* Seen from the eye, let D be the way to the target, on the map, and A and B the ends of an edge, with heights t, a and
 * b over the eye. With × for the cross product, the way crosses the edge where D×A and D×B have unlike signs, at the
 * share -(A×B) / (D×A - D×B), where the surface is (D×A b - D×B a) / (D×A - D×B) high. So it is above the line if
 *
 *     (D×A) b - (D×B) a + (A×B) t
 *
 * has the sign of D×A. Coordinates and heights are sums of a few doubles each, all summed without rounding. */
#include "way.h"

/* A number that is the sum of some doubles. */
typedef struct parts {
    int count;
    double part[4];
} parts;

static parts difference(double a, double b) {
    parts p = {2, {0}};
    p.part[0] = exact_two_sum(a, -b, &p.part[1]);
    if (p.part[1] == 0) p.count = 1;
    return p;
}

/* A vector on the map from the eye. */
typedef struct vector {
    parts x, y;
} vector;

static vector vector_to(const sight *s, double i, double j) {
    return (vector){difference(i, s->eye[0]), difference(j, s->eye[1])};
}

static void add_cross(exact_sum *s, const parts *a, const parts *b, double sign) {
    for (int k = 0; k < a->count; k++)
        for (int l = 0; l < b->count; l++) exact_add_product(s, sign * a->part[k], b->part[l]);
}

static exact_sum cross(const vector *a, const vector *b) {
    exact_sum s;
    s.count = 0;
    add_cross(&s, &a->x, &b->y, 1);
    add_cross(&s, &a->y, &b->x, -1);
    return s;
}

static void add_times(exact_sum *s, const exact_sum *a, const parts *height, double sign) {
    for (int k = 0; k < a->count; k++)
        for (int l = 0; l < height->count; l++) exact_add_product(s, sign * a->parts[k], height->part[l]);
}

/* A sample on the line, if there is one: its place and its height. */
typedef struct sample {
    bool exists;
    vector at;
    parts height;
    exact_sum side; /* the way's vector cross that to the sample */
} sample;

static void take_sample(const crossing *c, double m, const vector *to_target, sample *out) {
    const sight *s = c->way->sight;
    const double i = s->corner[0] + (c->kind == WAY_COLUMN ? c->n : m),
                 j = s->corner[1] + (c->kind == WAY_COLUMN ? m
                                     : c->kind == WAY_ROW  ? c->n
                                                           : m - c->n);
    const float *z = way_sample(s, c->kind, c->n, m);
    out->exists = z != NULL && isfinite(*z);
    if (!out->exists) return;
    out->at = vector_to(s, i, j);
    out->height = difference((double)*z, s->eye[2]);
    const double fall = sight_fall(s, i, j);
    if (fall != 0) out->height.part[out->height.count++] = -fall;
    out->side = cross(to_target, &out->at);
}

/* The sign of a - b - n. n is a multiple of high's last digit, so that low counts only if they are equal. */
static int side_of(double a, double b, double n) {
    double low;
    const double high = exact_two_sum(a, -b, &low), over = high == n ? low : high - n;
    return (over > 0) - (over < 0);
}

/* Whether the line is crossed between the ends of the way. */
static bool is_between(const crossing *c) {
    const double *eye = c->way->sight->eye, *target = c->way->target, *corner = c->way->sight->corner;
    if (c->kind == WAY_DIAGONAL) {
        const double n = c->n + (corner[0] - corner[1]);
        return side_of(eye[0], eye[1], n) * side_of(target[0], target[1], n) < 0;
    }
    const int axis = c->kind == WAY_ROW;
    const double n = c->n + corner[axis];
    return side_of(eye[axis], 0, n) * side_of(target[axis], 0, n) < 0;
}

/* over times sign is how far the surface is above the line, times something positive; over it is over / per_height. */
static touch verdict(const exact_sum *over, int sign, double per_height) {
    const int side = sign * exact_sign(over);
    return (touch){true, side, side == 0 ? 0 : fabs(exact_value(over) / per_height) * side};
}

/* The sample is on the way, at the share of it that its longer axis tells. */
static touch at_sample(const way *w, const sample *a, const vector *to_target, const parts *top) {
    const parts *to = w->longer ? &to_target->y : &to_target->x, *from = w->longer ? &a->at.y : &a->at.x;
    exact_sum over, one, other;
    over.count = one.count = other.count = 0;
    for (int k = 0; k < to->count; k++) exact_add(&one, to->part[k]);
    for (int k = 0; k < from->count; k++) exact_add(&other, from->part[k]);
    add_times(&over, &one, &a->height, 1);
    add_times(&over, &other, top, -1);
    return verdict(&over, exact_sign(&one), exact_value(&other));
}

static touch on_edge(const sample *a, const sample *b, const parts *top) {
    const exact_sum area = cross(&a->at, &b->at);
    exact_sum over;
    over.count = 0;
    add_times(&over, &a->side, &b->height, 1);
    add_times(&over, &b->side, &a->height, -1);
    add_times(&over, &area, top, 1);
    return verdict(&over, exact_sign(&a->side), exact_value(&area));
}

touch cw_touch_at(const crossing *c) {
    const way *w = c->way;
    const sight *s = w->sight;
    if (!is_between(c)) return (touch){.side = -1};
    const vector to_target = vector_to(s, w->target[0], w->target[1]);
    parts top = difference(w->z, s->eye[2]);
    if (w->above != 0) top.part[top.count++] = w->above;
    if (w->fall != 0) top.part[top.count++] = -w->fall;
    const double first = whole_below(c->other - w->slack), last = whole_below(c->other + w->slack);
    sample samples[2];
    sample *a = &samples[0], *b = &samples[1];
    take_sample(c, first, &to_target, a);
    for (double m = first; m <= last; m++) {
        take_sample(c, m + 1, &to_target, b);
        const int side_a = a->exists ? exact_sign(&a->side) : 0, side_b = b->exists ? exact_sign(&b->side) : 0;
        if (a->exists && side_a == 0) return at_sample(w, a, &to_target, &top);
        if (b->exists && side_b == 0) return at_sample(w, b, &to_target, &top);
        if (side_a * side_b < 0) return on_edge(a, b, &top);
        sample *const swap = a;
        a = b;
        b = swap;
    }
    return (touch){.side = -1};
}
