/* SPDX-License-Identifier: Apache-2.0 */
/* What follows from a hit - point, normals, their changes, uv - agrees with formulas in long double, and is NaN where there
 * is no hit. */

#include "case.h"
#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- by hand ----------------------------------------------------------------------------------------------------- */
typedef struct vec3 {
    long double x[3];
} vec3;

static vec3 minus(vec3 a, vec3 b) { return (vec3){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}}; }
static vec3 cross(vec3 a, vec3 b) {
    return (vec3){
        {a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}
static vec3 unit(vec3 a) {
    const long double length = sqrtl(a.x[0] * a.x[0] + a.x[1] * a.x[1] + a.x[2] * a.x[2]);
    return (vec3){{a.x[0] / length, a.x[1] / length, a.x[2] / length}};
}

static void check_vector(const double v[3], vec3 wanted, const char *what) {
    long double size = 0, off = 0;
    for (int c = 0; c < 3; c++) {
        size = fmaxl(size, fabsl(wanted.x[c]));
        off = fmaxl(off, fabsl((long double)v[c] - wanted.x[c]));
    }
    check(off <= 1e-13L * size, "%s is off by %Lg of %Lg", what, off, size);
}

/* A map with shear, rotation and a far origin; mirrored, so that orientation is not taken for granted. */
static const double map[3][4] = {{2, -0.5, 0.125, 300}, {0.75, 3, 0, -20}, {0.25, 0, -1.5, 7}};

static vec3 vertex_in_user_space(size_t i, size_t j) {
    const long double p[3] = {(long double)i, (long double)j, (long double)shape.z[j * shape.nx + i]};
    vec3 v;
    for (int r = 0; r < 3; r++)
        v.x[r] = (long double)map[r][0] * p[0] + (long double)map[r][1] * p[1] + (long double)map[r][2] * p[2] +
                 (long double)map[r][3];
    return v;
}

static void corners(size_t i, size_t j, uint32_t triangle, vec3 p[3]) {
    p[0] = vertex_in_user_space(i, j);
    p[1] = triangle == CW_TRIANGLE_A ? vertex_in_user_space(i + 1, j) : vertex_in_user_space(i + 1, j + 1);
    p[2] = triangle == CW_TRIANGLE_A ? vertex_in_user_space(i + 1, j + 1) : vertex_in_user_space(i, j + 1);
}

/* Twice the area times the unit normal on the side of growing field z. */
static vec3 area_normal(size_t i, size_t j, uint32_t triangle) {
    vec3 p[3];
    corners(i, j, triangle, p);
    vec3 n = cross(minus(p[1], p[0]), minus(p[2], p[0]));
    long double up = 0;
    for (int c = 0; c < 3; c++) up += n.x[c] * (long double)map[c][2];
    for (int c = 0; c < 3; c++) n.x[c] = up < 0 ? -n.x[c] : n.x[c];
    return n;
}

/* Area-weighted over the triangles that have (vi, vj) as a corner, found by looking at all; those with a hole count for nothing. */
static vec3 vertex_normal(size_t vi, size_t vj) {
    vec3 sum = {{0, 0, 0}};
    for (size_t j = vj ? vj - 1 : 0; j <= vj && j + 1 < shape.ny; j++)
        for (size_t i = vi ? vi - 1 : 0; i <= vi && i + 1 < shape.nx; i++)
            for (uint32_t triangle = 0; triangle < 2; triangle++) {
                const size_t ci[3] = {i, i + 1, triangle == CW_TRIANGLE_A ? i + 1 : i};
                const size_t cj[3] = {j, triangle == CW_TRIANGLE_A ? j : j + 1, j + 1};
                bool corner = false;
                for (int k = 0; k < 3; k++) corner |= ci[k] == vi && cj[k] == vj;
                const vec3 n = area_normal(i, j, triangle);
                for (int c = 0; corner && !isnan(n.x[2]) && c < 3; c++) sum.x[c] += n.x[c];
            }
    return sum;
}

/* ---- by the library ---------------------------------------------------------------------------------------------- */

/* A miss, and hits that this field cannot have. */
static void test_what_follows_from_no_hit(void **state) {
    (void)state;
    const cw_hit none[] = {{.t = INFINITY, .i = -1, .j = -1}, {.i = 16},        {.j = 16},
                           {.i = INT32_MAX, .j = INT32_MAX},  {.i = INT32_MIN}, {.triangle = 2},
                           {.triangle = UINT32_MAX}};
    for (size_t k = 0; k < sizeof none / sizeof none[0]; k++) {
        double v[3][3] = {{0}};
        cw_hit_points(field, NULL, &none[k], 1, v[0]);
        cw_hit_normals(field, NULL, &none[k], 1, v[1]);
        cw_hit_phong_normals(field, NULL, &none[k], 1, v[2]);
        for (int c = 0; c < 9; c++) check(isnan(v[c / 3][c % 3]), "case %zu: %g", k, v[c / 3][c % 3]);
    }
}

static void test_what_follows_from_a_hit(void **state) {
    (void)state;
    static double points[RAYS][3], normals[RAYS][3], smooth[RAYS][3];
    cw_field *mapped = field_mapped(shape.z, shape.nx, shape.ny, map);
    size_t hits = 0;
    check_status(cw_hit_points(mapped, NULL, expected, RAYS, points[0]), CW_OK);
    check_status(cw_hit_normals(mapped, NULL, expected, RAYS, normals[0]), CW_OK);
    check_status(cw_hit_phong_normals(mapped, NULL, expected, RAYS, smooth[0]), CW_OK);
    for (size_t k = 0; k < RAYS; k++) {
        const cw_hit *hit = &expected[k];
        if (hit->i < 0) continue;
        hits++;
        const size_t i = (size_t)hit->i, j = (size_t)hit->j;
        const long double u = (long double)hit->u, v = (long double)hit->v, w = 1 - u - v;
        check(hit->u >= 0 && hit->v >= 0 && hit->u + hit->v <= 1 + 0x1p-22f, "u %a, v %a", (double)hit->u,
              (double)hit->v);
        vec3 p[3], point, phong = {{0, 0, 0}};
        corners(i, j, hit->triangle, p);
        for (int c = 0; c < 3; c++) point.x[c] = w * p[0].x[c] + u * p[1].x[c] + v * p[2].x[c];
        check_vector(points[k], point, "point");
        check_vector(normals[k], unit(area_normal(i, j, hit->triangle)), "normal");

        const bool a = hit->triangle == CW_TRIANGLE_A;
        const vec3 n[3] = {vertex_normal(i, j), vertex_normal(i + 1, a ? j : j + 1),
                           vertex_normal(a ? i + 1 : i, j + 1)};
        for (int c = 0; c < 3; c++) phong.x[c] = w * n[0].x[c] + u * n[1].x[c] + v * n[2].x[c];
        check_vector(smooth[k], unit(phong), "Phong normal");
    }
    check(hits > RAYS / 4, "only %zu hits", hits);
    cw_field_destroy(mapped);
}

/* Whatever the user's unit of length is: a map that is so many times as large gives the same normals to the bit. */
static void test_normals_of_maps_of_any_size(void **state) {
    (void)state;
    static const int exponents[] = {0, -1010, -600, 600, 1010};
    static double first[2][RAYS][3], v[RAYS][3];
    for (size_t e = 0; e < 2 * (sizeof exponents / sizeof exponents[0]); e++) {
        double scaled[3][4];
        for (int k = 0; k < 12; k++) scaled[k / 4][k % 4] = ldexp(map[k / 4][k % 4], exponents[e / 2]);
        cw_field *mapped = field_mapped(shape.z, shape.nx, shape.ny, (const double(*)[4])scaled);
        check_status((e % 2 ? cw_hit_phong_normals : cw_hit_normals)(mapped, NULL, expected, RAYS, v[0]), CW_OK);
        if (e < 2) memcpy(first[e], v, sizeof v);
        for (size_t k = 0; k < RAYS; k++)
            check(expected[k].i < 0 || memcmp(first[e % 2][k], v[k], sizeof v[k]) == 0, "2^%d: another normal",
                  exponents[e / 2]);
        cw_field_destroy(mapped);
    }
}

static int set_up(void **state) {
    (void)state;
    case_make(FIELD_HOLES, 17, 17, 7, RAYS);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_follows_from_no_hit),
        cmocka_unit_test(test_what_follows_from_a_hit),
        cmocka_unit_test(test_normals_of_maps_of_any_size),
    };
    return cmocka_run_group_tests_name("hits", tests, set_up, case_end);
}
