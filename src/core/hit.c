/* SPDX-License-Identifier: Apache-2.0 */
/* Points and normals of hits. In field space a triangle is z = z0 + a·x + b·y, so its normal is (-a, -b, 1). The
 * length of that vector is twice the triangle's area, as every triangle covers half a cell of the plane. The sum of
 * such vectors, times the inverse transpose of the map, is the area-weighted sum in user space up to a factor, for
 * any map. */

#include "affine.h"
#include "field.h"
#include "run.h"

#include <string.h>

static float sample(const cw_field *f, size_t i, size_t j) { return f->z[j * f->stride + i]; }

/* Slopes (dz/dx, dz/dy) of one triangle. */
static void slopes(const cw_field *f, size_t i, size_t j, uint32_t triangle, double slope[2]) {
    const bool a = triangle == CW_TRIANGLE_A;
    const double h00 = sample(f, i, j), h11 = sample(f, i + 1, j + 1),
                 third = a ? sample(f, i + 1, j) : sample(f, i, j + 1);
    slope[0] = a ? third - h00 : h11 - third;
    slope[1] = a ? h11 - third : third - h00;
}

/* The length of v. If its squares would underflow, v is multiplied by 2^600 first. */
static double length(double v[3]) {
    const double size = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(size < 0x1p-500)) return size;
    for (int c = 0; c < 3; c++) v[c] *= 0x1p600;
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* True if the field has the hit's triangle, or the hole in its place. */
static bool is_hit(const cw_field *f, const cw_hit *hit) {
    return hit->i >= 0 && hit->j >= 0 && (size_t)hit->i < f->nx - 1 && (size_t)hit->j < f->ny - 1 &&
           hit->triangle <= CW_TRIANGLE_B;
}

/* Barycentric weights of the hit's three vertices and the vertices themselves. */
static void vertices(const cw_hit *hit, size_t vertex[3][2], double weight[3]) {
    const size_t i = (size_t)hit->i, j = (size_t)hit->j;
    const bool a = hit->triangle == CW_TRIANGLE_A;
    const size_t v[3][2] = {{i, j}, {i + 1, a ? j : j + 1}, {a ? i + 1 : i, j + 1}};
    memcpy(vertex, v, sizeof v);
    weight[1] = (double)hit->u;
    weight[2] = (double)hit->v;
    weight[0] = 1 - weight[1] - weight[2];
}

/* Position inside the cell; from p1 - p0 and p2 - p0 in the plane. */
static void position(const cw_hit *hit, double xy[2]) {
    const double u = (double)hit->u, v = (double)hit->v;
    const bool a = hit->triangle == CW_TRIANGLE_A;
    xy[0] = (double)hit->i + (a ? u + v : u);
    xy[1] = (double)hit->j + (a ? v : u + v);
}

static void point_of(const cw_field *field, const cw_hit *hit, double point[3]) {
    size_t vertex[3][2];
    double weight[3], p[3] = {0, 0, 0};
    vertices(hit, vertex, weight);
    position(hit, p);
    for (int k = 0; k < 3; k++) p[2] += weight[k] * (double)sample(field, vertex[k][0], vertex[k][1]);
    affine_point(field->to_user, p, point);
}

static void normal_of(const cw_field *field, const cw_hit *hit, double normal[3]) {
    double slope[2];
    slopes(field, (size_t)hit->i, (size_t)hit->j, hit->triangle, slope);
    affine_covector(field->to_normals, (double[3]){-slope[0], -slope[1], 1}, normal);
    const double size = length(normal);
    for (int c = 0; c < 3; c++) normal[c] /= size;
}

/* The vertex normal of (i, j) triangle by triangle, without those that lie outside or have a hole. The six triangles
 * around a vertex: both of the cells to its lower left and upper right, A of the upper left cell, B of the lower right
 * one. */
static void vertex_normal_of_some(const cw_field *f, size_t i, size_t j, double n[3]) {
    static const struct {
        int di, dj;
        uint32_t triangle;
    } around[6] = {{0, 0, CW_TRIANGLE_A},   {0, 0, CW_TRIANGLE_B},  {-1, -1, CW_TRIANGLE_A},
                   {-1, -1, CW_TRIANGLE_B}, {-1, 0, CW_TRIANGLE_A}, {0, -1, CW_TRIANGLE_B}};
    n[0] = n[1] = n[2] = 0;
    for (int k = 0; k < 6; k++) {
        const size_t ci = i + (size_t)around[k].di, cj = j + (size_t)around[k].dj; /* wraps below 0, caught next */
        if (ci >= f->nx - 1 || cj >= f->ny - 1) continue;
        double slope[2];
        slopes(f, ci, cj, around[k].triangle, slope);
        if (isnan(slope[0] + slope[1])) continue;
        n[0] -= slope[0];
        n[1] -= slope[1];
        n[2] += 1;
    }
}

/* The same with all six triangles, the usual case: their slopes are differences along the edges of the hexagon around
 * the vertex, and those of the two edges that run through the vertex are in the sum twice. */
static void vertex_normal(const cw_field *f, size_t i, size_t j, double n[3]) {
    if (i > 0 && j > 0 && i < f->nx - 1 && j < f->ny - 1) {
        const float *z = f->z + j * f->stride + i, *above = z + f->stride, *below = z - f->stride;
        const double west = z[-1], east = z[1], north = above[0], south = below[0], north_east = above[1];
        const double south_west = below[-1];
        n[0] = 2 * (west - east) + (north - north_east) + (south_west - south);
        n[1] = 2 * (south - north) + (east - north_east) + (south_west - west);
        n[2] = 6;
        if (!isnan(n[0] + n[1])) return;
    }
    vertex_normal_of_some(f, i, j, n);
}

static void phong_normal_of(const cw_field *f, const cw_hit *hit, double normal[3]) {
    size_t vertex[3][2];
    double weight[3], n[3][3], mean[3], slope[2];
    slopes(f, (size_t)hit->i, (size_t)hit->j, hit->triangle, slope);
    if (isnan(slope[0] + slope[1])) return;
    vertices(hit, vertex, weight);
    for (int k = 0; k < 3; k++) vertex_normal(f, vertex[k][0], vertex[k][1], n[k]);
    for (int c = 0; c < 3; c++) mean[c] = weight[0] * n[0][c] + weight[1] * n[1][c] + weight[2] * n[2][c];
    affine_covector(f->to_normals, mean, normal);
    const double scale = 1 / length(normal);
    for (int c = 0; c < 3; c++) normal[c] *= scale;
}

/* ---- of many hits ------------------------------------------------------------------------------------------------ */

/* Three numbers of each hit; NaN if the field does not have its triangle. */
typedef void of_hit(const cw_field *field, const cw_hit *hit, double v[3]);
static inline void of_each(const cw_batch *b, size_t begin, size_t end, of_hit *of) {
    for (size_t k = begin; k < end; k++) {
        const cw_hit *hit = (const cw_hit *)b->in + k;
        double *v = (double *)b->out + 3 * k;
        v[0] = v[1] = v[2] = (double)NAN;
        if (is_hit(b->field, hit)) of(b->field, hit, v);
    }
}
static void points_of(void *context, size_t begin, size_t end) { of_each(context, begin, end, point_of); }
static void normals_of(void *context, size_t begin, size_t end) { of_each(context, begin, end, normal_of); }
static void phong_normals_of(void *context, size_t begin, size_t end) { of_each(context, begin, end, phong_normal_of); }

cw_status cw_hit_points(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n, double *points) {
    return cw_run_batch(&(cw_batch){field, points_of, "hits", "hits", hits, "points", points, NULL}, run, n);
}

cw_status cw_hit_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n, double *normals) {
    return cw_run_batch(&(cw_batch){field, normals_of, "hits", "hits", hits, "normals", normals, NULL}, run, n);
}

cw_status cw_hit_phong_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                               double *normals) {
    return cw_run_batch(&(cw_batch){field, phong_normals_of, "hits", "hits", hits, "normals", normals, NULL}, run, n);
}

/* ---- at a place -------------------------------------------------------------------------------------------------- */

static const cw_hit no_hit = {.t = INFINITY, .i = -1, .j = -1};

/* The cell that the place is in, also at the far border, and the rest: within [0, 1]. */
static int32_t split(double x, size_t samples, double *rest) {
    const double last = (double)(samples - 2), cell = x >= last ? last : floor(x);
    *rest = x - cell;
    return (int32_t)cell;
}

static void surface_at(const cw_field *field, double x, double y, cw_hit *hit) {
    *hit = no_hit;
    if (!(x >= 0 && x <= (double)(field->nx - 1) && y >= 0 && y <= (double)(field->ny - 1))) return;
    double u, v;
    cw_hit h = {.i = split(x, field->nx, &u), .j = split(y, field->ny, &v)};
    const bool a = v <= u;
    h.triangle = (uint32_t)(a ? CW_TRIANGLE_A : CW_TRIANGLE_B);
    h.u = (float)(a ? u - v : u);
    h.v = (float)(a ? v : v - u);
    double slope[2];
    slopes(field, (size_t)h.i, (size_t)h.j, h.triangle, slope);
    if (!isnan(slope[0] + slope[1])) *hit = h;
}

static void places(void *context, size_t begin, size_t end) {
    const cw_batch *b = context;
    const double *xy = b->in;
    for (size_t k = begin; k < end; k++) surface_at(b->field, xy[2 * k], xy[2 * k + 1], (cw_hit *)b->out + k);
}

static void user_places(void *context, size_t begin, size_t end) {
    const cw_batch *b = context;
    for (size_t k = begin; k < end; k++) {
        double p[3];
        affine_point_back(b->field->to_field, (const double *)b->in + 3 * k, p);
        surface_at(b->field, p[0], p[1], (cw_hit *)b->out + k);
    }
}

cw_status cw_surface_at(const cw_field *field, const cw_run *run, const double *xy, size_t n, cw_hit *hits) {
    return cw_run_batch(&(cw_batch){field, places, "places", "xy", xy, "hits", hits, NULL}, run, n);
}

cw_status cw_surface_at_user(const cw_field *field, const cw_run *run, const double *xyz, size_t n, cw_hit *hits) {
    return cw_run_batch(&(cw_batch){field, user_places, "places", "xyz", xyz, "hits", hits, NULL}, run, n);
}
