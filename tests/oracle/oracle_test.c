/* SPDX-License-Identifier: Apache-2.0 */
/* The oracle against a plainer one: every triangle of a small field in rational numbers, by another formula. Hit or miss, t
 * and the set of triangles that hold the hit have to be equal. */

#include "check.h"
#include "oracle_walk.h"
#include "rays.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include <gmp.h>

/* f0 + f1 t for rationals. */
typedef struct linear {
    mpq_t f0, f1;
} linear;

static void linear_init(linear *l) { mpq_inits(l->f0, l->f1, (mpq_ptr)NULL); }
static void linear_clear(linear *l) { mpq_clears(l->f0, l->f1, (mpq_ptr)NULL); }

/* l = c + a x + b y + z, with x, y, z the ray's place; the factors are floats, so doubles hold them exactly. */
static void set_linear(linear *l, const cw_ray *ray, double c, double a, double b, double z) {
    const double factor[3] = {a, b, z};
    mpq_t p, q;
    mpq_inits(p, q, (mpq_ptr)NULL);
    mpq_set_d(l->f0, c);
    mpq_set_ui(l->f1, 0, 1);
    for (int k = 0; k < 3; k++) {
        mpq_set_d(p, factor[k]);
        mpq_set_d(q, (double)ray->org[k]);
        mpq_mul(q, q, p);
        mpq_add(l->f0, l->f0, q);
        mpq_set_d(q, (double)ray->dir[k]);
        mpq_mul(q, q, p);
        mpq_add(l->f1, l->f1, q);
    }
    mpq_clears(p, q, (mpq_ptr)NULL);
}

/* l -= h (c + a x + b y) */
static void subtract(linear *l, const cw_ray *ray, float h, double c, double a, double b) {
    linear m;
    mpq_t q;
    linear_init(&m);
    mpq_init(q);
    set_linear(&m, ray, c, a, b, 0);
    mpq_set_d(q, (double)h);
    mpq_mul(m.f0, m.f0, q);
    mpq_mul(m.f1, m.f1, q);
    mpq_sub(l->f0, l->f0, m.f0);
    mpq_sub(l->f1, l->f1, m.f1);
    mpq_clear(q);
    linear_clear(&m);
}

/* Cuts [t0, t1] down to where l >= 0; false if nothing is left. */
static bool cut(const linear *l, mpq_t t0, mpq_t t1) {
    const int way = mpq_sgn(l->f1);
    if (way == 0) return mpq_sgn(l->f0) >= 0;
    mpq_t root;
    mpq_init(root);
    mpq_div(root, l->f0, l->f1);
    mpq_neg(root, root);
    if (way > 0 && mpq_cmp(root, t0) > 0) mpq_set(t0, root);
    if (way < 0 && mpq_cmp(root, t1) < 0) mpq_set(t1, root);
    mpq_clear(root);
    return mpq_cmp(t0, t1) <= 0;
}

/* The first t on one closed triangle: the t at which three barycentric coordinates are >= 0 and d = 0. */
static bool meet(const test_field *f, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle, mpq_t t) {
    const float *h = &f->z[(size_t)j * f->nx + (size_t)i];
    const bool a = triangle == CW_TRIANGLE_A;
    const float corner = a ? h[1] : h[f->nx], h00 = h[0], h11 = h[f->nx + 1];
    if (!isfinite(corner) || !isfinite(h00) || !isfinite(h11)) return false;
    const double x = (double)i, y = (double)j;
    /* Weights of (i, j), the corner and (i + 1, j + 1) as c + a x + b y. */
    const double weight[3][3] = {{1 + (a ? x : y), a ? -1 : 0, a ? 0 : -1},
                                 {a ? y - x : x - y, a ? 1 : -1, a ? -1 : 1},
                                 {a ? -y : -x, a ? 0 : 1, a ? 1 : 0}};
    linear d, edge;
    mpq_t t0, t1;
    linear_init(&d);
    linear_init(&edge);
    mpq_inits(t0, t1, (mpq_ptr)NULL);
    mpq_set_d(t0, (double)ray->tmin);
    mpq_set_d(t1, (double)ray->tmax);
    set_linear(&d, ray, 0, 0, 0, 1);
    const float height[3] = {h00, corner, h11};
    for (int k = 0; k < 3; k++) subtract(&d, ray, height[k], weight[k][0], weight[k][1], weight[k][2]);
    bool hit = mpq_cmp(t0, t1) <= 0 && cut(&d, t0, t1); /* above */
    mpq_neg(d.f0, d.f0);
    mpq_neg(d.f1, d.f1);
    hit = hit && cut(&d, t0, t1); /* and below */
    for (int k = 0; hit && k < 3; k++) {
        set_linear(&edge, ray, weight[k][0], weight[k][1], weight[k][2], 0);
        hit = cut(&edge, t0, t1);
    }
    mpq_set(t, t0);
    mpq_clears(t0, t1, (mpq_ptr)NULL);
    linear_clear(&edge);
    linear_clear(&d);
    return hit;
}

static bool named(const oracle_truth *truth, int32_t i, int32_t j, uint32_t triangle) {
    for (unsigned k = 0; k < truth->at; k++)
        if (truth->triangle[k].i == i && truth->triangle[k].j == j && truth->triangle[k].triangle == triangle)
            return true;
    return false;
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
    mpq_t t, first;
    mpq_inits(t, first, (mpq_ptr)NULL);
    for (int turn = 0; turn < 2; turn++) /* the first t, then who else has it */
        for (int32_t j = 0; j < (int32_t)f->ny - 1; j++)
            for (int32_t i = 0; i < (int32_t)f->nx - 1; i++)
                for (uint32_t triangle = 0; triangle < 2; triangle++) {
                    if (!meet(f, &ray, i, j, triangle, t)) continue;
                    if (turn == 0 && (!hit || mpq_cmp(t, first) < 0)) mpq_set(first, t);
                    hit = true;
                    if (turn == 0 || mpq_cmp(t, first) != 0) continue;
                    same_t++;
                    found += named(truth, i, j, triangle);
                }
    const double rational = hit ? mpq_get_d(first) : (double)INFINITY;
    const bool right =
        hit == truth->hit &&
        (!hit || (fabs(rational - truth->t) <= 0x1p-49 * fabs(rational) && same_t == truth->at && found == same_t));
    mpq_clears(t, first, (mpq_ptr)NULL);
    if (right) return;
    field_print(f);
    ray_print(given);
    printf("oracle: %s at t %a on %u triangles; plainly: %s at t %a on %u, of which the oracle names %u\n",
           truth->hit ? "hit" : "miss", truth->t, truth->at, hit ? "hit" : "miss", rational, same_t, found);
    check(false, "the oracle is wrong");
}

static void test_against_every_triangle(void **state) {
    (void)state;
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
    (void)state;
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
            check(oracle_exactly_within(o, &t, at, d * far, anything), "height: not within a bound just above");
            check(!oracle_exactly_within(o, &t, at, d * near, anything), "height: within a bound just below");
        }
        if (outside > 0x1p-10) {
            places++;
            check(oracle_exactly_within(o, &t, at, anything, outside * far), "place: not within a bound just above");
            check(!oracle_exactly_within(o, &t, at, anything, outside * near), "place: within a bound just below");
        }
    }
    oracle_destroy(o);
    check(heights > 1000 && places > 1000, "too few for the test to mean anything");
}

/* Right hits are right; taken away they are leaks if the ray passes, and moved by much they are phantoms. */
static void test_wrong_answers_are_seen(void **state) {
    (void)state;
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
