/* SPDX-License-Identifier: Apache-2.0 */
/* The oracle against a plainer one: every triangle of a small field in rational numbers, by another formula. Hit or
 * miss, t and the set of triangles that hold the hit have to be equal. */

#include "check.h"
#include "oracle_walk.h"
#include "rays.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

enum { T0, T1, FIRST, P, Q, WAY, U, V, ONE, F, NUMBERS = F + 8 };

/* q[P] is the ray's coordinate c at t = 0 or 1. */
static void place(mpq_t *q, const cw_ray *ray, int c, int t) {
    mpq_set_d(q[P], (double)ray->org[c]);
    mpq_set_d(q[Q], t ? (double)ray->dir[c] : 0);
    mpq_add(q[P], q[P], q[Q]);
}

/* Cuts [T0, T1] down to where sign times what is f[0] at t = 0 and f[1] at t = 1, and linear in between, is >= 0. */
static void cut(mpq_t *q, mpq_t *f, int sign) {
    mpq_sub(q[WAY], f[1], f[0]);
    const int way = sign * mpq_sgn(q[WAY]);
    if (way == 0) {
        if (sign * mpq_sgn(f[0]) < 0) mpq_sub(q[T1], q[T0], q[ONE]);
        return;
    }
    mpq_div(q[P], f[0], q[WAY]);
    mpq_neg(q[P], q[P]);
    if (way > 0 && mpq_cmp(q[P], q[T0]) > 0) mpq_set(q[T0], q[P]);
    if (way < 0 && mpq_cmp(q[P], q[T1]) < 0) mpq_set(q[T1], q[P]);
}

/* T0 becomes the first t on one closed triangle: the t at which three barycentric coordinates are >= 0 and the ray is
 * as high as the mean of the corners that they weigh. */
static bool meet(mpq_t *q, const test_field *f, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle) {
    const float *h = &f->z[(size_t)j * f->nx + (size_t)i];
    const bool a = triangle == CW_TRIANGLE_A;
    const float height[3] = {h[0], a ? h[1] : h[f->nx], h[f->nx + 1]};
    if (!isfinite(height[0]) || !isfinite(height[1]) || !isfinite(height[2])) return false;
    mpq_t *above = &q[F + 6];
    for (int at = 0; at < 2; at++) {
        /* U: along the axis on which the triangle's middle corner lies, V: along the other one. */
        for (int c = 0; c < 2; c++) {
            place(q, ray, c, at);
            mpq_set_si(q[Q], c ? j : i, 1);
            mpq_sub(q[a == (c == 0) ? U : V], q[P], q[Q]);
        }
        mpq_sub(q[F + at], q[ONE], q[U]);
        mpq_sub(q[F + 2 + at], q[U], q[V]);
        mpq_set(q[F + 4 + at], q[V]);
        place(q, ray, 2, at);
        mpq_set(above[at], q[P]);
        for (int k = 0; k < 3; k++) {
            mpq_set_d(q[Q], (double)height[k]);
            mpq_mul(q[Q], q[Q], q[F + 2 * k + at]);
            mpq_sub(above[at], above[at], q[Q]);
        }
    }
    mpq_set_d(q[T0], (double)ray->tmin);
    mpq_set_d(q[T1], (double)ray->tmax);
    cut(q, above, 1);
    cut(q, above, -1);
    for (int k = 0; k < 3; k++) cut(q, &q[F + 2 * k], 1);
    return mpq_cmp(q[T0], q[T1]) <= 0;
}

static void compare(const test_field *f, const cw_ray *given, const oracle_truth *truth) {
    cw_ray ray = *given;
    bool good = ray.tmin <= ray.tmax, moves = false;
    for (int c = 0; c < 3; c++) {
        if (!isfinite(ray.org[c]) || !(fabsf(ray.dir[c]) <= 0x1p126f)) good = false;
        if (fabsf(ray.dir[c]) <= 0x1p-128f) ray.dir[c] = 0;
        if (ray.dir[c] != 0) moves = true;
    }
    ray.tmin = fmaxf(ray.tmin, -FLT_MAX / 2);
    ray.tmax = fminf(ray.tmax, FLT_MAX / 2);
    if (!good || !moves || ray.tmin > ray.tmax) {
        check(!truth->hit, "the oracle hits with a ray that is none");
        return;
    }
    bool hit = false;
    unsigned same_t = 0, found = 0;
    mpq_t q[NUMBERS];
    for (int k = 0; k < NUMBERS; k++) mpq_init(q[k]);
    mpq_set_ui(q[ONE], 1, 1);
    for (int32_t j = 0; j < (int32_t)f->ny - 1; j++)
        for (int32_t i = 0; i < (int32_t)f->nx - 1; i++)
            for (uint32_t triangle = 0; triangle < 2; triangle++) {
                if (!meet(q, f, &ray, i, j, triangle)) continue;
                const int order = hit ? mpq_cmp(q[T0], q[FIRST]) : -1;
                if (order > 0) continue;
                if (order < 0) same_t = found = 0;
                mpq_set(q[FIRST], q[T0]);
                hit = true;
                same_t++;
                found += oracle_names(truth, &(oracle_triangle){i, j, triangle});
            }
    const double rational = hit ? mpq_get_d(q[FIRST]) : (double)INFINITY;
    const bool right =
        hit == truth->hit &&
        (!hit || (fabs(rational - truth->t) <= 0x1p-49 * fabs(rational) && same_t == truth->at && found == same_t));
    for (int k = 0; k < NUMBERS; k++) mpq_clear(q[k]);
    if (right) return;
    field_print(f);
    ray_print(given);
    printf("oracle: %s at t %a on %u triangles; plainly: %s at t %a on %u, of which the oracle names %u\n",
           truth->hit ? "hit" : "miss", truth->t, truth->at, hit ? "hit" : "miss", rational, same_t, found);
    check(false, "the oracle is wrong");
}

static void test_against_every_triangle(void **state) {
    static const field_size sizes[] = {{2, 2}, {4, 3}, {2, 5}};
    static test_field f;
    random_state r = {99};
    size_t rays = 0, hits = 0, ties = 0, coplanar = 0;
    for (size_t s = 0; s < 3; s++)
        for (int shape = 0; shape < FIELD_SHAPES; shape++) {
            field_make(&f, (field_shape)shape, sizes[s].nx, sizes[s].ny, s + 5);
            oracle *o = oracle_create(f.z, f.nx, f.ny);
            assert_non_null(o);
            for (int kind = 0; kind < RAY_CLASSES; kind++)
                for (int k = 0; k < (kind == RAY_LATTICE ? 200 : 20); k++) {
                    const cw_ray ray = ray_make((ray_class)kind, &f, &r);
                    const oracle_truth *truth = oracle_trace(o, &ray);
                    compare(&f, &ray, truth);
                    rays++;
                    hits += truth->hit;
                    ties += truth->at > 1;
                    coplanar += truth->coplanar;
                }
            oracle_destroy(o);
        }
    printf("%zu rays, %zu hits, %zu on an edge or vertex, %zu within a triangle's plane: the oracle is right\n", rays,
           hits, ties, coplanar);
    check(hits > rays / 4 && ties > 200 && coplanar > 50, "too few hits or ties for the test to mean anything");
}

/* Places of which doubles know well how far they are from a triangle and its plane: rational numbers must agree, with
 * bounds a little above and a little below. */
static void test_uncertain_hits_are_decided(void **state) {
    static test_field f;
    random_state r = {7};
    size_t heights = 0, places = 0;
    field_make(&f, FIELD_HOLES, 9, 7, 3);
    oracle *o = oracle_create(f.z, f.nx, f.ny);
    assert_non_null(o);
    for (int k = 0; k < 5000; k++) {
        const cw_ray ray = ray_make(RAY_RANDOM, &f, &r);
        const oracle_triangle t = {(int32_t)random_below(&r, 8), (int32_t)random_below(&r, 6),
                                   (uint32_t)random_below(&r, 2)};
        if (!oracle_ray(o, &ray) || !oracle_solid(o, t.i, t.j, t.triangle)) continue;
        const double at = (double)(float)random_between(&r, -2, 2), d = fabs(oracle_height(o, &t, at));
        const double x = o->ox + at * o->dx - t.i, y = o->oy + at * o->dy - t.j;
        const bool a = t.triangle == CW_TRIANGLE_A;
        const double outside = fmax(fmax(a ? -y : -x, a ? x - 1 : y - 1), a ? y - x : x - y);
        const double near = 1 - 0x1p-20, far = 1 + 0x1p-20, anything = 100;
        if (d > 0x1p-10) {
            heights++;
            check(exact_within(o, &t, at, d * far, anything), "height: not within a bound just above");
            check(!exact_within(o, &t, at, d * near, anything), "height: within a bound just below");
        }
        if (outside > 0x1p-10) {
            places++;
            check(exact_within(o, &t, at, anything, outside * far), "place: not within a bound just above");
            check(!exact_within(o, &t, at, anything, outside * near), "place: within a bound just below");
        }
    }
    oracle_destroy(o);
    check(heights > 1000 && places > 1000, "too few for the test to mean anything");
}

/* Right hits are right; taken away they are leaks if the ray passes, and moved by much they are phantoms. */
static void test_wrong_answers_are_seen(void **state) {
    static test_field f;
    random_state r = {8};
    size_t hits = 0, leaks = 0;
    field_make(&f, FIELD_RANDOM, 33, 33, 4);
    cw_field *field = field_open(&f);
    oracle *o = oracle_create(f.z, f.nx, f.ny);
    for (int k = 0; k < 2000; k++) {
        const cw_ray ray = ray_make(RAY_VERTEX, &f, &r);
        const bool passes = oracle_trace(o, &ray)->passes;
        cw_hit hit;
        check_status(cw_closest(field, NULL, &ray, 1, &hit), CW_OK);
        check(oracle_judge(o, &hit).verdict <= VERDICT_TIE, "a right hit is %s",
              verdict_name(oracle_judge(o, &hit).verdict));
        if (hit.i < 0) continue;
        hits++;
        hit.t += 1 / fabsf(ray.dir[2]);
        check(oracle_judge(o, &hit).verdict == VERDICT_PHANTOM && !oracle_check(o, &hit).holds,
              "a hit a cell off holds");
        const verdict missed = oracle_judge(o, &(cw_hit){.t = INFINITY, .i = -1, .j = -1}).verdict;
        check((missed == VERDICT_LEAK) == passes, "a lost hit is %s", verdict_name(missed));
        leaks += passes;
    }
    oracle_destroy(o);
    cw_field_destroy(field);
    check(hits > 1000 && leaks > 1000, "%zu hits, %zu passes: too few for the test to mean anything", hits, leaks);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_every_triangle),
                                       cmocka_unit_test(test_uncertain_hits_are_decided),
                                       cmocka_unit_test(test_wrong_answers_are_seen)};
    return cmocka_run_group_tests_name("oracle", tests, NULL, NULL);
}
