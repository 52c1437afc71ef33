/* SPDX-License-Identifier: Apache-2.0 */
#include "surface.h"

#include <string.h>

double cylinder_hit(const cylinder *c, const double org[3], const double dir[3], double tmin, double tmax) {
    double o[3], d[3];
    transform_point(&c->to_object, org, o);
    transform_vector(&c->to_object, dir, d);
    /* |o + t d|² = 1 in x and y; with half = b / 2 and the root that does not cancel. */
    const double a = d[0] * d[0] + d[1] * d[1], half = o[0] * d[0] + o[1] * d[1];
    const double square = half * half - a * (o[0] * o[0] + o[1] * o[1] - 1);
    if (!(a > 0) || !(square >= 0)) return INFINITY;
    const double q = half < 0 ? sqrt(square) - half : -sqrt(square) - half;
    const double root = q != 0 ? (o[0] * o[0] + o[1] * o[1] - 1) / q : 0;
    const double other = q / a, t[2] = {other < root ? other : root, other < root ? root : other};
    for (int k = 0; k < 2; k++)
        if (t[k] >= tmin && t[k] <= tmax && fabs(o[2] + t[k] * d[2]) <= 1) return t[k];
    return INFINITY;
}

void surface_of_field(const heightfield *h, const cw_hit *hit, bool phong, surface *s) {
    s->material = &h->surface;
    cw_hit_point(h->field, hit, s->point);
    cw_hit_normal(h->field, hit, s->normal);
    if (phong)
        cw_hit_phong_normal(h->field, hit, s->shading);
    else
        memcpy(s->shading, s->normal, sizeof s->shading);
    s->offset = surface_offset_field * (double)hit->t;
}

/* The sides of the parameter rectangle at a point, in the world. */
static void cylinder_axes(const cylinder *c, const double object[3], double du[3], double dv[3]) {
    const double turn = 2 * acos(-1);
    transform_vector(&c->to_world, (double[3]){-turn * object[1], turn * object[0], 0}, du);
    transform_vector(&c->to_world, (double[3]){0, 0, 2}, dv);
}

void surface_of_cylinder(const cylinder *c, const double org[3], const double dir[3], double t, surface *s) {
    double object[3], du[3], dv[3];
    s->material = &c->surface;
    for (int k = 0; k < 3; k++) s->point[k] = org[k] + t * dir[k];
    transform_point(&c->to_object, s->point, object);
    cylinder_axes(c, object, du, dv);
    cross(du, dv, s->normal);
    normalise(s->normal);
    memcpy(s->shading, s->normal, sizeof s->shading);
    s->offset = surface_offset_cylinder * t;
}

void surface_spread(const surface *s, const double org[3], const double dir[3], const ray_spread *spread,
                    double change[2][3]) {
    for (int k = 0; k < 2; k++) {
        double o[3], d[3], gap[3];
        for (int c = 0; c < 3; c++) {
            o[c] = org[c] + (double)spread->org[k][c];
            d[c] = dir[c] + (double)spread->dir[k][c];
            gap[c] = s->point[c] - o[c];
        }
        const double t = dot(gap, s->normal) / dot(d, s->normal);
        for (int c = 0; c < 3; c++) change[k][c] = t * d[c] - gap[c];
        /* A neighbour that runs along the surface says nothing about the size of the sample's footprint. */
        if (!isfinite(dot(change[k], change[k]))) memset(change[k], 0, sizeof change[k]);
    }
}

/* Solves change = share[0] · a + share[1] · b for vectors in the plane with this normal, in the two coordinates in which
 * the plane's projection is largest. */
static void solve(const double a[3], const double b[3], const double normal[3], const double change[3],
                  double share[2]) {
    int drop = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    if (fabs(normal[2]) > fabs(normal[drop])) drop = 2;
    const int p = (drop + 1) % 3, q = (drop + 2) % 3;
    const double determinant = a[p] * b[q] - a[q] * b[p];
    share[0] = (change[p] * b[q] - change[q] * b[p]) / determinant;
    share[1] = (a[p] * change[q] - a[q] * change[p]) / determinant;
    if (!isfinite(share[0]) || !isfinite(share[1])) share[0] = share[1] = 0;
}

/* The two sides of the hit's triangle that its u and v count along. */
static void triangle_sides(const heightfield *h, const cw_hit *hit, double side[2][3]) {
    cw_hit corner = *hit;
    double origin[3];
    corner.u = corner.v = 0;
    cw_hit_point(h->field, &corner, origin);
    corner.u = 1;
    cw_hit_point(h->field, &corner, side[0]);
    corner.u = 0;
    corner.v = 1;
    cw_hit_point(h->field, &corner, side[1]);
    for (int k = 0; k < 2; k++)
        for (int c = 0; c < 3; c++) side[k][c] -= origin[c];
}

void surface_uv_of_field(const heightfield *h, const cw_hit *hit, const surface *s, double change[2][3], double uv[2],
                         double uv_change[2][2]) {
    float place[2];
    double side[2][3];
    cw_hit_uv(h->field, hit, place);
    uv[0] = (double)place[0];
    uv[1] = (double)place[1];
    triangle_sides(h, hit, side);
    for (int k = 0; k < 2; k++) {
        double share[2];
        solve(side[0], side[1], s->normal, change[k], share);
        /* One of the sides is the cell's diagonal, the other lies along x (A) or y (B). */
        const bool a = hit->triangle == CW_TRIANGLE_A;
        uv_change[k][0] = (a ? share[0] + share[1] : share[0]) / (double)(h->nx - 1);
        uv_change[k][1] = (a ? share[1] : share[0] + share[1]) / (double)(h->ny - 1);
    }
}

void surface_uv_of_cylinder(const cylinder *c, const surface *s, double change[2][3], double uv[2],
                            double uv_change[2][2]) {
    const double turn = 2 * acos(-1);
    double object[3], du[3], dv[3];
    transform_point(&c->to_object, s->point, object);
    const double angle = atan2(object[1], object[0]);
    uv[0] = (angle < 0 ? angle + turn : angle) / turn;
    uv[1] = (object[2] + 1) / 2;
    cylinder_axes(c, object, du, dv);
    for (int k = 0; k < 2; k++) solve(du, dv, s->normal, change[k], uv_change[k]);
}

void surface_normal_change(const heightfield *h, const cw_hit *hit, const surface *s, double change[2][3],
                           double normal_change[2][3]) {
    /* Derivatives along the triangle's sides by a step that is small against the triangle and large against the rounding
     * of u and v. */
    const float step = 1.0f / 64;
    double side[2][3], slope[2][3];
    triangle_sides(h, hit, side);
    for (int k = 0; k < 2; k++) {
        cw_hit moved = *hit;
        *(k == 0 ? &moved.u : &moved.v) += step;
        cw_hit_phong_normal(h->field, &moved, slope[k]);
        for (int c = 0; c < 3; c++) slope[k][c] = (slope[k][c] - s->shading[c]) / (double)step;
    }
    for (int k = 0; k < 2; k++) {
        double share[2];
        solve(side[0], side[1], s->normal, change[k], share);
        for (int c = 0; c < 3; c++) normal_change[k][c] = share[0] * slope[0][c] + share[1] * slope[1][c];
    }
}
