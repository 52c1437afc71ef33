/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/counts.h"

#include "harness/results.h"

#include <math.h>
#include <stdlib.h>

enum { VOXELS_MAX = 64 }; /* an axis, as in src/scalar/grid3d.c */

struct tradeoff_counter {
    tradeoff_ground ground;
    double low[3], high[3], size[3]; /* of the box; of a voxel */
    int n[3];
    size_t *begin;   /* voxel v lists entries [begin[v], begin[v + 1]) */
    uint32_t *entry; /* (sample number of (i, j)) · 2 + triangle */
};

/* ---- building the 3D grid ---- */

static int voxel_of(const tradeoff_counter *c, double at, int axis) {
    if (!(c->size[axis] > 0)) return 0;
    const double v = floor((at - c->low[axis]) / c->size[axis]);
    return (int)fmax(0, fmin((double)(c->n[axis] - 1), v));
}

static size_t voxel_number(const tradeoff_counter *c, const int v[3]) {
    return ((size_t)v[2] * (size_t)c->n[1] + (size_t)v[1]) * (size_t)c->n[0] + (size_t)v[0];
}

static void triangle_heights(const tradeoff_ground *g, size_t number, float z[3]) {
    const float *at = g->z + number / 2;
    z[0] = at[0];
    z[1] = number % 2 == CW_TRIANGLE_A ? at[1] : at[g->nx];
    z[2] = at[g->nx + 1];
}

/* Counts a triangle in begin[voxel + 1] of all voxels that its box touches, or enters it there. */
static void enter_triangle(tradeoff_counter *c, size_t number, bool write) {
    const size_t i = number / 2 % c->ground.nx, j = number / 2 / c->ground.nx;
    float z[3];
    triangle_heights(&c->ground, number, z);
    const double low[3] = {(double)i, (double)j, (double)fminf(z[0], fminf(z[1], z[2]))};
    const double high[3] = {(double)i + 1, (double)j + 1, (double)fmaxf(z[0], fmaxf(z[1], z[2]))};
    int first[3], last[3], v[3];
    for (int a = 0; a < 3; a++) { /* with the slack of src/scalar/grid3d.c, since it makes for part of the tests */
        first[a] = voxel_of(c, low[a] - c->size[a] * 1e-4, a);
        last[a] = voxel_of(c, high[a] + c->size[a] * 1e-4, a);
    }
    for (v[2] = first[2]; v[2] <= last[2]; v[2]++)
        for (v[1] = first[1]; v[1] <= last[1]; v[1]++)
            for (v[0] = first[0]; v[0] <= last[0]; v[0]++) {
                size_t *slot = &c->begin[voxel_number(c, v)];
                if (write)
                    c->entry[(*slot)++] = (uint32_t)number;
                else
                    slot[1]++;
            }
}

static void enter_all(tradeoff_counter *c, bool write) {
    for (size_t j = 0; j + 1 < c->ground.ny; j++)
        for (size_t i = 0; i + 1 < c->ground.nx; i++)
            for (size_t triangle = 0; triangle < 2; triangle++)
                enter_triangle(c, 2 * (j * c->ground.nx + i) + triangle, write);
}

static void set_resolution(tradeoff_counter *c) {
    const tradeoff_ground *g = &c->ground;
    c->low[2] = INFINITY, c->high[2] = -INFINITY;
    for (size_t k = 0; k < g->nx * g->ny; k++) {
        c->low[2] = fmin(c->low[2], (double)g->z[k]);
        c->high[2] = fmax(c->high[2], (double)g->z[k]);
    }
    c->high[0] = (double)(g->nx - 1);
    c->high[1] = (double)(g->ny - 1);
    double longest = 0;
    for (int a = 0; a < 3; a++) longest = fmax(longest, c->high[a] - c->low[a]);
    const double per_unit = 3 * cbrt(2 * c->high[0] * c->high[1]) / longest;
    for (int a = 0; a < 3; a++) {
        const double extent = c->high[a] - c->low[a];
        c->n[a] = (int)fmax(1, fmin(VOXELS_MAX, rint(extent * per_unit)));
        c->size[a] = extent / c->n[a];
    }
}

tradeoff_counter *tradeoff_counter_make(const tradeoff_ground *ground) {
    tradeoff_counter *c = calloc(1, sizeof *c);
    if (c == NULL) return NULL;
    c->ground = *ground;
    set_resolution(c);
    const size_t voxels = (size_t)c->n[0] * (size_t)c->n[1] * (size_t)c->n[2];
    c->begin = calloc(voxels + 2, sizeof *c->begin);
    if (c->begin) {
        enter_all(c, false);
        for (size_t v = 0; v < voxels; v++) c->begin[v + 1] += c->begin[v];
        c->entry = malloc((c->begin[voxels] ? c->begin[voxels] : 1) * sizeof *c->entry);
    }
    if (c->entry == NULL) {
        tradeoff_counter_free(c);
        return NULL;
    }
    enter_all(c, true);
    for (size_t v = voxels; v > 0; v--) c->begin[v] = c->begin[v - 1]; /* writing moved each begin to its end */
    c->begin[0] = 0;
    return c;
}

void tradeoff_counter_free(tradeoff_counter *c) {
    if (c == NULL) return;
    free(c->begin);
    free(c->entry);
    free(c);
}

/* ---- both walks ---- */

/* Where the ray is inside the box of the field. */
static bool enter_box(const tradeoff_counter *c, const cw_ray *ray, double *from, double *to) {
    *from = (double)ray->tmin;
    *to = (double)ray->tmax;
    for (int a = 0; a < 3; a++) {
        const double org = (double)ray->org[a], dir = (double)ray->dir[a];
        if (dir == 0) {
            if (org < c->low[a] || org > c->high[a]) return false;
            continue;
        }
        const double t0 = (c->low[a] - org) / dir, t1 = (c->high[a] - org) / dir;
        *from = fmax(*from, fmin(t0, t1));
        *to = fmin(*to, fmax(t0, t1));
    }
    return *from <= *to;
}

/* One axis of a walk: cells of equal size. */
typedef struct axis {
    double org, dir, low, size;
    int at, step, end;
} axis;

static double axis_next(const axis *a) {
    if (a->dir == 0) return INFINITY;
    return (a->low + (a->at + (a->step > 0)) * a->size - a->org) / a->dir;
}

static axis axis_start(const cw_ray *ray, int number, double from, double low, double size, int n) {
    axis a = {.org = (double)ray->org[number], .dir = (double)ray->dir[number], .low = low, .size = size};
    const double at = size > 0 ? floor((a.org + from * a.dir - low) / size) : 0;
    a.at = (int)fmax(0, fmin((double)(n - 1), at));
    a.step = a.dir > 0 ? 1 : -1;
    a.end = a.dir > 0 ? n : -1;
    return a;
}

/* Closest hit among those so far. */
static void meet_triangle(const tradeoff_counter *c, const cw_ray *ray, size_t number, cw_hit *best) {
    const int32_t i = (int32_t)(number / 2 % c->ground.nx), j = (int32_t)(number / 2 / c->ground.nx);
    tradeoff_place p;
    if (!tradeoff_meet(&c->ground, ray, i, j, (uint32_t)(number % 2), &p)) return;
    if (p.u < 0 || p.v < 0 || p.u + p.v > 1 || p.t < (double)ray->tmin || p.t > (double)ray->tmax) return;
    if (best->i >= 0 && (double)best->t <= p.t) return;
    *best = (cw_hit){.t = (float)p.t, .u = (float)p.u, .v = (float)p.v, .i = i, .j = j, .triangle = p.triangle};
}

static cw_hit walk_voxels(const tradeoff_counter *c, const cw_ray *ray, bool any, tradeoff_counts *sum) {
    cw_hit hit = {.t = INFINITY, .i = -1, .j = -1};
    double from, to;
    if (!enter_box(c, ray, &from, &to)) return hit;
    axis axes[3];
    for (int a = 0; a < 3; a++) axes[a] = axis_start(ray, a, from, c->low[a], c->size[a], c->n[a]);
    for (;;) {
        const int v[3] = {axes[0].at, axes[1].at, axes[2].at};
        const size_t number = voxel_number(c, v);
        sum->voxels++;
        for (size_t k = c->begin[number]; k < c->begin[number + 1]; k++) meet_triangle(c, ray, c->entry[k], &hit);
        sum->voxel_triangles += c->begin[number + 1] - c->begin[number];
        int next = 0;
        for (int a = 1; a < 3; a++)
            if (axis_next(&axes[a]) < axis_next(&axes[next])) next = a;
        const double t = axis_next(&axes[next]);
        if (hit.i >= 0 && (any || (double)hit.t <= t)) return hit;
        if (t > to) return hit;
        axes[next].at += axes[next].step;
        if (axes[next].at == axes[next].end) return hit;
    }
}

static bool meets_heights(const tradeoff_ground *g, const cw_ray *ray, const float *z, double from, double to) {
    const double a = (double)ray->org[2] + from * (double)ray->dir[2],
                 b = (double)ray->org[2] + to * (double)ray->dir[2];
    const float low = fminf(fminf(z[0], z[1]), fminf(z[g->nx], z[g->nx + 1]));
    const float high = fmaxf(fmaxf(z[0], z[1]), fmaxf(z[g->nx], z[g->nx + 1]));
    return fmax(a, b) >= (double)low && fmin(a, b) <= (double)high;
}

static cw_hit walk_cells(const tradeoff_counter *c, const cw_ray *ray, tradeoff_counts *sum) {
    cw_hit hit = {.t = INFINITY, .i = -1, .j = -1};
    const tradeoff_ground *g = &c->ground;
    double from, to;
    if (!enter_box(c, ray, &from, &to)) return hit;
    axis x = axis_start(ray, 0, from, 0, 1, (int)g->nx - 1), y = axis_start(ray, 1, from, 0, 1, (int)g->ny - 1);
    for (;;) {
        const double tx = axis_next(&x), ty = axis_next(&y), out = fmin(tx, ty);
        const size_t number = (size_t)y.at * g->nx + (size_t)x.at;
        sum->cells++;
        if (meets_heights(g, ray, g->z + number, from, fmin(out, to))) {
            sum->cell_triangles += 2;
            meet_triangle(c, ray, 2 * number, &hit);
            meet_triangle(c, ray, 2 * number + 1, &hit);
            if (hit.i >= 0) return hit;
        }
        if (out > to) return hit;
        from = out;
        axis *next = tx <= ty ? &x : &y;
        next->at += next->step;
        if (next->at == next->end) return hit;
    }
}

/* Each must be right if the other is taken for the truth, so that neither a wrong walk nor a wrong hit to compare with goes
 * unnoticed. */
static bool is_astray(const tradeoff_counter *c, const cw_ray *ray, const cw_hit *truth, const cw_hit *found) {
    static const tradeoff_claim none;
    const cw_hit *pair[2] = {truth, found};
    for (int k = 0; k < 2; k++) {
        const bool hit = pair[k]->i >= 0;
        tradeoff_place exact;
        if (hit) exact = tradeoff_exact(&c->ground, ray, pair[k]);
        if (tradeoff_judge_closest(&c->ground, ray, &none, pair[k], hit ? &exact : NULL, pair[1 - k]) > TRADEOFF_TIE)
            return true;
    }
    return false;
}

void tradeoff_count(const tradeoff_counter *c, const cw_ray *rays, size_t n, const cw_hit *hits, bool any,
                    tradeoff_counts *sum) {
    for (size_t k = 0; k < n; k++) {
        const cw_hit flat = walk_cells(c, &rays[k], sum), deep = walk_voxels(c, &rays[k], any, sum);
        bool astray = is_astray(c, &rays[k], &hits[k], &flat);
        if (any)
            astray = astray || (deep.i >= 0) != (flat.i >= 0);
        else
            astray = astray || is_astray(c, &rays[k], &hits[k], &deep);
        sum->astray += astray;
    }
    sum->rays += n;
}

void tradeoff_counts_set(json_t *line, const tradeoff_counts *c) {
    const double rays = c->rays ? (double)c->rays : 1;
    results_set_count(line, "ray_count", c->rays);
    results_set_count(line, "astray", c->astray);
    results_set_number(line, "voxels", (double)c->voxels / rays);
    results_set_number(line, "voxel_triangles", (double)c->voxel_triangles / rays);
    results_set_number(line, "cells", (double)c->cells / rays);
    results_set_number(line, "cell_triangles", (double)c->cell_triangles / rays);
}
