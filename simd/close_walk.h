/* SPDX-License-Identifier: Apache-2.0 */
/* The close walk, for a ray that keeps its lane for long: as a rule it runs beside a surface, nearer than slabs can tell, and a
 * lane would test hundreds of its cells one after another. Here the ray has all lanes: each tests the cells of a column. Nodes
 * are judged one after another, in double, by slabs that are wider than their samples only by what the leaf test's own
 * rounding needs this far from the ray's origin.
 *
 * Invariants: all cells on the ray's walk that may be hit are tested, and the first hit in the order of the walk counts. In
 * mirrored coordinates that order is by columns, and by rows in a column, along either axis. A node is passed over only if
 * the leaf test's sign is strict on all of it; papers/numerics.md derives how wide a slab has to be for that.
 *
 * The staircase of crossings is that of Amanatides and Woo 1987. Rejected: narrow slabs in the lane walk. They depend on the
 * ray's distance, so each step of each lane would pay for them, and only on large fields do other rays gain by them. Not
 * possible: slabs that shrink with the node alone. The leaf test computes from the origin, and its bits are given. */
#ifndef CELLWALK_SIMD_CLOSE_WALK_H
#define CELLWALK_SIMD_CLOSE_WALK_H

#include "../src/scalar/ray.h"
#include "lane_queue.h"
#include "pyramid.h"
#include "vector_watertight.h"

#include <float.h>
#include <math.h>

/* Nodes of this pyramid level, 16 × 16 cells, are the smallest ones judged. In fields without larger nodes no way is long. */
enum { CLOSE_LEVEL = CLOSE_LEVELS - 2 };

/* The number of each lane: its column, counted from the box's first one. */
static const float close_column[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

/* A ray out of its lane. */
typedef struct close_ray {
    float n[RAY_FLOATS];
    int32_t turned[2];
    float t; /* nothing before it can be hit */
} close_ray;

/* An axis' numbers. */
static inline const float *close_axis(const close_ray *r, int axis) { return r->n + axis * RAY_AXIS; }

static inline float close_crossing(const close_ray *r, int axis, int32_t border) {
    const float *n = close_axis(r, axis);
    return ((float)border - n[RAY_CENTER]) * n[RAY_INVERSE];
}

/* Low corner of the node of the given side in which the ray is at t, or of an earlier one; kept to the four from begin on. */
static inline int32_t close_corner(const close_ray *r, int axis, float t, int32_t side, int32_t begin) {
    const float *n = close_axis(r, axis);
    const float at = max_second(min_second(n[RAY_EARLY] + t * n[RAY_DIR], n[RAY_LAST] - 0.5f), n[RAY_FIRST]);
    const float number = floorf((at - (float)begin) / (float)side);
    return begin + side * (number > 0 ? number < 3 ? (int32_t)number : 3 : 0);
}

/* Cells to test: from begin on, an axis each, to before end; mirrored. */
typedef struct close_box {
    int32_t begin[2], end[2];
} close_box;

/* The ray in all lanes, as leaf tests take it. */
static inline vray close_vectors(const close_ray *r) {
    vray v; /* no initialisers: they would clear all of it first */
    vaxis *const axis[2] = {&v.x, &v.y};
    for (int c = 0; c < 2; c++) {
        const float *n = close_axis(r, c), sign = r->turned[c] ? -1.0f : 1.0f;
        axis[c]->org = vf_set(sign * n[RAY_ORG]);
        axis[c]->dir = vf_set(sign * n[RAY_DIR]);
        axis[c]->up = vm_set(!r->turned[c]);
    }
    v.oz = vf_set(r->n[RAY_OZ]);
    v.dz = vf_set(r->n[RAY_DZ]);
    v.t0 = vf_set(r->n[RAY_T0]);
    v.t1 = vf_set(r->n[RAY_T1]);
    return v;
}

/* Stores the first of the found lanes in first, if it is before *column and *row, the place of the find stored there. */
static inline void close_keep(vmask found, const vfind *find, const vcell *c, vfloat columns, vfloat rows,
                              float *column, float *row, float first[FOUND_NUMBERS]) {
    float all[FOUND_NUMBERS][W], at[W], in[W];
    const vfloat corner = vf_select(find->b, c->h01, c->h10), b = vf_select(find->b, vf_set(1), vf_set(0));
    const vfloat numbers[FOUND_NUMBERS] = {find->t0, find->t1, c->i, c->j, c->h00, corner, c->h11, b};
    for (int m = 0; m < FOUND_NUMBERS; m++) vf_store(all[m], numbers[m]);
    vf_store(at, columns);
    vf_store(in, rows);
    for (unsigned bits = vm_bits(found); bits != 0; bits &= bits - 1) {
        const int k = __builtin_ctz(bits);
        if (!(at[k] < *column || (at[k] == *column && in[k] < *row))) continue;
        *column = at[k];
        *row = in[k];
        for (int m = 0; m < FOUND_NUMBERS; m++) first[m] = all[m][k];
    }
}

/* Tests the cells of a box, with columns along the axis on which the ray is faster; true if one of them is hit. Not inlined, as
 * its vectors would be in each frame of the recursion. */
static __attribute__((noinline)) bool close_test(const close_ray *r, const cw_field *f, const close_box *box,
                                                 float first[FOUND_NUMBERS]) {
    const bool along_x = r->n[RAY_INVERSE] <= r->n[RAY_AXIS + RAY_INVERSE];
    const int axis = along_x ? 0 : 1;
    const vmask is_x = vm_set(along_x);
    const float *a = close_axis(r, axis), *b = close_axis(r, 1 - axis);
    const vray v = close_vectors(r);
    const vfloat one = vf_set(1), lowest = vf_set(max_second((float)box->begin[1 - axis], b[RAY_FIRST]));
    const vfloat first_column = vf_set(a[RAY_FIRST]),
                 end_column = vf_set(min_second((float)box->end[axis], a[RAY_LAST]));
    const vfloat center_a = vf_set(a[RAY_CENTER]), center_b = vf_set(b[RAY_CENTER]);
    const vfloat inverse_a = vf_set(a[RAY_INVERSE]), inverse_b = vf_set(b[RAY_INVERSE]);
    const vfloat end = vf_set(min_second((float)box->end[1 - axis], b[RAY_LAST]));
    float column = INFINITY, row = INFINITY;
    for (int32_t k = box->begin[axis]; k < box->end[axis] && !(column < INFINITY); k += (int32_t)W) {
        const vfloat columns = vf_add(vf_set((float)k), vf_load(close_column));
        const vfloat a_in = vf_mul(vf_sub(columns, center_a), inverse_a);
        const vfloat a_out = vf_mul(vf_sub(vf_add(columns, one), center_a), inverse_a);
        const vmask inside = vm_and(vf_ge(columns, first_column), vf_lt(columns, end_column));
        /* The row of a column in which the ray is when it comes, or an earlier one: as the lane walk picks a child. */
        const vfloat t = vf_max(a_in, v.t0);
        vfloat rows = vf_floor(vf_add(vf_set(b[RAY_EARLY]), vf_mul(t, vf_set(b[RAY_DIR]))));
        rows = vf_max(vf_min(rows, end), lowest);
        vfloat b_in = vf_mul(vf_sub(rows, center_b), inverse_b);
        for (;; rows = vf_add(rows, one), b_in = vf_mul(vf_sub(rows, center_b), inverse_b)) {
            vmask todo = vm_and(inside, vf_le(columns, vf_set(column)));
            todo = vm_and(todo, vm_and(vf_lt(rows, end), vf_le(b_in, a_out)));
            if (!vm_any(todo)) break;
            const vfloat b_out = vf_mul(vf_sub(vf_add(rows, one), center_b), inverse_b);
            const vint i = vi_xor(vi_from_vf(vf_select(is_x, columns, rows)), vi_set(r->turned[0]));
            const vint j = vi_xor(vi_from_vf(vf_select(is_x, rows, columns)), vi_set(r->turned[1]));
            vcell c;
            c.i = vf_from_vi(i);
            c.j = vf_from_vi(j);
            c.x_in = vf_select(is_x, a_in, b_in);
            c.x_out = vf_select(is_x, a_out, b_out);
            c.y_in = vf_select(is_x, b_in, a_in);
            c.y_out = vf_select(is_x, b_out, a_out);
            c.t0 = vf_max(vf_max(c.x_in, c.y_in), v.t0);
            c.t1 = vf_min(vf_min(c.x_out, c.y_out), v.t1);
            const vint sample = vi_add(vi_mul(j, vi_set((int32_t)f->stride)), i);
            vf_gather_pairs(f->z, sample, todo, &c.h00, &c.h10);
            vf_gather_pairs(f->z + f->stride, sample, todo, &c.h01, &c.h11);
            const vmask gate = vm_and(todo, cell_gate(&v, &c));
            if (!vm_any(gate)) continue;
            vfind find;
            const vmask found = wt_cell(&v, &c, gate, &find);
            if (vm_any(found)) close_keep(found, &find, &c, columns, rows, &column, &row, first);
        }
    }
    return column < INFINITY;
}

/* True if nothing in node (x, y), its low corner mirrored, can be hit between t0 and t1, the ends of the ray's way over it. */
static inline bool close_misses(const close_ray *r, const cw_field *f, int level, int32_t x, int32_t y, float t0,
                                float t1) {
    const struct cw_pyramid *p = f->pyramid;
    const int shift = 2 * level + 2, side = 4 << 2 * level;
    const size_t i = (size_t)((x ^ r->turned[0]) >> shift), j = (size_t)((y ^ r->turned[1]) >> shift);
    const cw_pyramid_slab *s = &p->slab[(size_t)p->first[level + 1] + j * cw_pyramid_across(f, level) + i];
    const float *bounds = cw_pyramid_node(&p->level[level], i, j);
    if (!(s->low <= s->high)) return true;
    const float *nx = close_axis(r, 0), *ny = close_axis(r, 1);
    const double u = (double)(FLT_EPSILON / 2), low = (double)s->low, high = (double)s->high, half = 0.5 * side;
    const double oz = (double)r->n[RAY_OZ], dz = (double)r->n[RAY_DZ];
    const double a = (double)(r->turned[0] ? -s->slope_x : s->slope_x);
    const double b = (double)(r->turned[1] ? -s->slope_y : s->slope_y);
    const double dx = (double)nx[RAY_DIR], dy = (double)ny[RAY_DIR];
    const double px = (double)nx[RAY_ORG] - ((double)x + half), py = (double)ny[RAY_ORG] - ((double)y + half);
    const double steep = fabs(a) + fabs(b), sigma = steep + (high - low),
                 absolute = max_second_d(fabs(low), fabs(high));
    /* Slabs with a slope have been set outward for rays from anywhere (cw_slab_outward). That is taken back, and replaced by
     * the width that this ray needs here. */
    const double k = (double)SLAB_ROUNDING * 2 * (double)(f->nx + f->ny);
    const double wide = steep > 0 ? k / (1 + 2 * k) * (1 - 0x1p-20) * max_second_d(0, sigma - 2 * u * absolute) : 0;
    const double away = fabs(px) + fabs(py) + 2 * half + 2;
    const double heights = max_second_d(fabs((double)bounds[0] - oz), fabs((double)bounds[16] - oz));
    const double least =
        (double)FLT_MIN * (1 + fabs((double)t0) + fabs((double)t1) + 0x1p-14 * (fabs(dz) + sigma * (dx + dy)));
    const double own = 1.001 * u * (sigma * (8 * away + 2 * side) + 4 * (heights + absolute)) + least - wide;
    /* The slab as it is stored suits every ray with the pad of the lane walk. That is narrower far from the origin, in fields so
     * long that slabs are level. */
    const double pad = min_second_d(own, (double)r->n[RAY_PAD]);
    const double o = oz - (a * px + b * py), rate = dz - (a * dx + b * dy);
    const double d0 = o + (double)t0 * rate, d1 = o + (double)t1 * rate;
    return min_second_d(d0, d1) > high + pad || max_second_d(d0, d1) < low - pad;
}

/* Goes through the nodes of a level in the order of the walk, from the one with its corner at (x, y) to the end of their
 * parent. Cells are tested when the smallest nodes' parent ends, from the first to the last node that does not miss: more
 * lanes have a column then. */
static bool close_nodes(const close_ray *r, const cw_field *f, int level, int32_t x, int32_t y,
                        float first[FOUND_NUMBERS]) {
    const int32_t side = (int32_t)4 << 2 * level, parent = -4 * side;
    const float until = r->n[RAY_UNTIL];
    const int32_t in_x = x & parent, in_y = y & parent;
    close_box box = {{0, 0}, {0, 0}};
    bool some = false;
    do {
        const float out_x = close_crossing(r, 0, x + side), out_y = close_crossing(r, 1, y + side);
        const float t0 = max_second(max_second(close_crossing(r, 0, x), close_crossing(r, 1, y)), r->t);
        const float out = min_second(out_x, out_y), t1 = min_second(out, until);
        if (t0 <= t1 && !close_misses(r, f, level, x, y, t0, t1)) {
            if (level == CLOSE_LEVEL) {
                if (!some) box = (close_box){{x, y}, {0, 0}};
                some = true;
                box.end[0] = x + side;
                box.end[1] = y + side;
            } else {
                const int32_t child_x = close_corner(r, 0, t0, side / 4, x);
                const int32_t child_y = close_corner(r, 1, t0, side / 4, y);
                if (close_nodes(r, f, level - 1, child_x, child_y, first)) return true;
            }
        }
        const bool over_x = out_x <= out_y;
        const float border = (float)((over_x ? x : y) + side);
        if (out > until || border >= close_axis(r, over_x ? 0 : 1)[RAY_LAST]) break;
        if (over_x)
            x += side;
        else
            y += side;
    } while ((x & parent) == in_x && (y & parent) == in_y);
    if (!some) return false;
    return close_test(r, f, &box, first);
}

bool CW_CODE(close_walk)(const cw_field *f, const lane_set *l, size_t lane, float find[FOUND_NUMBERS]) {
    const int top = f->pyramid->levels - 1;
    close_ray r = {.turned = {l->rays.i[RAY_TURNED_X][lane], l->rays.i[RAY_TURNED_Y][lane]}, .t = l->t[lane]};
    for (int k = 0; k < RAY_FLOATS; k++) r.n[k] = l->rays.f[k][lane];
    const int32_t side = (int32_t)4 << 2 * top, begin_x = r.turned[0] * 4 * side, begin_y = r.turned[1] * 4 * side;
    const int32_t x = close_corner(&r, 0, r.t, side, begin_x), y = close_corner(&r, 1, r.t, side, begin_y);
    return close_nodes(&r, f, top, x, y, find);
}

#endif
