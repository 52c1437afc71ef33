/* SPDX-License-Identifier: Apache-2.0 */
/* Coarser fields against definitions in rational numbers: heights, holes, and how far the two surfaces lie apart. The
 * difference is compared at points inside each triangle, found on both surfaces without use of how they overlap, and at the
 * triangle's corners. */

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "check.h"
#include "fields.h"

#include <gmp.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
    size_t nx, ny, factor;
} cases[] = {{2, 2, 2}, {3, 2, 2}, {5, 9, 4}, {9, 8, 2}, {17, 12, 4}, {13, 14, 3}, {7, 21, 5}, {5, 4, 100}, {25, 3, 8}};
enum { CASES = sizeof cases / sizeof cases[0], FILTERS = 3 };
static const char *const filter_names[FILTERS] = {"mean", "highest", "lowest"};

/* A triangle: cell and side of the diagonal. */
typedef struct triangle {
    size_t i, j;
    bool lower;
} triangle;

static bool exists(const cw_field *f, triangle t) {
    return !isnan(cw_field_row(f, t.j)[t.i]) && !isnan(cw_field_row(f, t.j + 1)[t.i + 1]) &&
           !isnan(t.lower ? cw_field_row(f, t.j + 1)[t.i] : cw_field_row(f, t.j)[t.i + 1]);
}

/* Numbers that are used again and again; places are in units of 1 / PARTS cells of the full field. */
enum { PARTS = 64 };
typedef struct numbers {
    mpq_t height[2], term, x, y, least, most, squares, d[3];
} numbers;

static void numbers_init(numbers *n) {
    mpq_inits(n->height[0], n->height[1], n->term, n->x, n->y, n->least, n->most, n->squares, n->d[0], n->d[1], n->d[2],
              NULL);
}
static void numbers_clear(numbers *n) {
    mpq_clears(n->height[0], n->height[1], n->term, n->x, n->y, n->least, n->most, n->squares, n->d[0], n->d[1],
               n->d[2], NULL);
}

static void add_sample(numbers *n, mpq_t sum, const mpq_t weight, const cw_field *f, size_t i, size_t j) {
    mpq_set_d(n->term, (double)cw_field_row(f, j)[i]);
    mpq_mul(n->term, n->term, weight);
    mpq_add(sum, sum, n->term);
}

/* The plane of a triangle at (x, y); the field's cells have size parts. */
static void plane(numbers *n, mpq_t height, const cw_field *f, triangle t, size_t x, size_t y, size_t parts) {
    mpq_t weight;
    mpq_init(weight);
    mpq_set_si(n->x, (long)x - (long)(t.i * parts), (unsigned long)parts);
    mpq_set_si(n->y, (long)y - (long)(t.j * parts), (unsigned long)parts);
    mpq_canonicalize(n->x);
    mpq_canonicalize(n->y);
    mpq_set_si(height, 0, 1);
    /* (0, 0) has weight 1 - the larger, (1, 1) the smaller, the third corner what is between. */
    mpq_ptr along = t.lower ? n->y : n->x, across = t.lower ? n->x : n->y;
    mpq_set_si(weight, 1, 1);
    mpq_sub(weight, weight, along);
    add_sample(n, height, weight, f, t.i, t.j);
    add_sample(n, height, across, f, t.i + 1, t.j + 1);
    mpq_sub(weight, along, across);
    add_sample(n, height, weight, f, t.i + !t.lower, t.j + t.lower);
    mpq_clear(weight);
}

/* The triangle in which a place lies; one of several on an edge. */
static triangle find(const cw_field *f, size_t x, size_t y, size_t parts) {
    const cw_field_info info = cw_field_describe(f);
    triangle t = {x / parts, y / parts, false};
    t.i = t.i < info.nx - 1 ? t.i : info.nx - 2;
    t.j = t.j < info.ny - 1 ? t.j : info.ny - 2;
    t.lower = y - t.j * parts > x - t.i * parts;
    return t;
}

/* coarser - full at (x, y) on these triangles. */
static void subtract(numbers *n, mpq_t d, const cw_field *full, triangle t, const cw_field *coarser, triangle c,
                     size_t factor, size_t x, size_t y) {
    plane(n, n->height[0], full, t, x, y, PARTS);
    plane(n, n->height[1], coarser, c, x, y, PARTS * factor);
    mpq_sub(d, n->height[1], n->height[0]);
}

static bool within(numbers *n, const mpq_t d, const cw_difference *reported) {
    mpq_set_d(n->term, reported->above);
    const bool not_above = mpq_cmp(d, n->term) <= 0;
    mpq_set_d(n->term, -reported->below);
    return not_above && mpq_cmp(d, n->term) >= 0;
}

/* Corners of triangle t, and points inside, some near each corner. */
static void corner_of(triangle t, int k, size_t at[2]) {
    at[0] = (t.i + (k == 2 || (k == 1 && !t.lower))) * PARTS;
    at[1] = (t.j + (k == 2 || (k == 1 && t.lower))) * PARTS;
}
static void inside_of(triangle t, int k, size_t at[2]) {
    static const int weights[4][3] = {{62, 1, 1}, {1, 62, 1}, {1, 1, 62}, {20, 21, 23}};
    at[0] = at[1] = 0;
    for (int c = 0; c < 3; c++) {
        size_t corner[2];
        corner_of(t, c, corner);
        for (int a = 0; a < 2; a++) at[a] += corner[a] / PARTS * (size_t)weights[k][c];
    }
}

typedef struct found {
    uint64_t both, lost, made, beyond;
} found;

/* One triangle of the full field. */
static void look(numbers *n, const cw_field *full, triangle t, const cw_field *coarser, size_t factor,
                 const cw_difference *reported, found *sum) {
    size_t at[2];
    inside_of(t, 3, at);
    const triangle middle = find(coarser, at[0], at[1], PARTS * factor);
    const bool here = exists(full, t), there = exists(coarser, middle);
    sum->both += here && there;
    sum->lost += here && !there;
    sum->made += there && !here;
    if (!here || !there) return;
    for (int k = 0; k < 4; k++) {
        inside_of(t, k, at);
        const triangle c = find(coarser, at[0], at[1], PARTS * factor);
        check(exists(coarser, c), "a triangle is half on a hole of the coarser field");
        subtract(n, n->d[0], full, t, coarser, c, factor, at[0], at[1]);
        sum->beyond += !within(n, n->d[0], reported);
    }
    for (int k = 0; k < 3; k++) {
        corner_of(t, k, at);
        subtract(n, n->d[k], full, t, coarser, middle, factor, at[0], at[1]);
        sum->beyond += !within(n, n->d[k], reported);
        if (mpq_cmp(n->d[k], n->least) < 0) mpq_set(n->least, n->d[k]);
        if (mpq_cmp(n->d[k], n->most) > 0) mpq_set(n->most, n->d[k]);
    }
    for (int k = 0; k < 3; k++) /* the squares' integral, times 12: a² + b² + c² + ab + bc + ca */
        for (int l = k; l < 3; l++) {
            mpq_mul(n->term, n->d[k], n->d[l]);
            mpq_add(n->squares, n->squares, n->term);
        }
}

/* What is reported holds for every point, is attained, and counts the triangles. */
static void check_difference(const char *what, const cw_field *full, const cw_field *coarser, size_t factor,
                             const cw_difference *d) {
    const cw_field_info f = cw_field_describe(full), g = cw_field_describe(coarser);
    numbers n;
    numbers_init(&n);
    found sum = {0};
    for (size_t j = 0; j + 1 < f.ny; j++)
        for (size_t i = 0; i + 1 < f.nx; i++)
            for (int lower = 0; lower < 2; lower++) look(&n, full, (triangle){i, j, lower}, coarser, factor, d, &sum);
    check(sum.beyond == 0, "%s: %zu points lie farther apart than reported, +%.17g -%.17g", what, (size_t)sum.beyond,
          d->above, d->below);
    check(d->lost == sum.lost && d->made == sum.made, "%s: %zu triangles lost and %zu made, not %zu and %zu", what,
          (size_t)sum.lost, (size_t)sum.made, (size_t)d->lost, (size_t)d->made);
    /* src/terrain/difference.c: off by at most 14 · 2^-53 of the largest difference between a sample and a corner. */
    const double range = sum.both ? fmax((double)f.high, (double)g.high) - fmin((double)f.low, (double)g.low) : 0;
    const double slack = 0x1p-49 * range, most = mpq_get_d(n.most), least = mpq_get_d(n.least);
    check(d->above <= most + slack && d->below <= -least + slack, "%s: reported +%.17g -%.17g, but it is +%.17g -%.17g",
          what, d->above, d->below, most, -least);
    /* In the mean square: each difference off by slack at most, sums of n squares by n + 64 roundings. */
    const double rms = sum.both ? sqrt(mpq_get_d(n.squares) / (6 * (double)sum.both)) : 0;
    check(fabs(d->rms - rms) <= slack + rms * ((double)sum.both + 64) * 0x1p-53,
          "%s: root mean square %.17g, not %.17g", what, d->rms, rms);
    numbers_clear(&n);
}

/* The height of sample (i, j) by definition; false at a hole. scale: the largest height that counted. */
static bool mean_at(const cw_field *f, size_t i, size_t j, size_t factor, mpq_t mean, double *scale) {
    const cw_field_info info = cw_field_describe(f);
    long there = 0, possible = 0;
    mpq_t term;
    mpq_init(term);
    mpq_set_si(mean, 0, 1);
    *scale = 0;
    for (size_t y = 0; y < info.ny; y++)
        for (size_t x = 0; x < info.nx; x++) {
            const long across = labs((long)x - (long)(i * factor)), down = labs((long)y - (long)(j * factor));
            if (across >= (long)factor || down >= (long)factor) continue;
            const long weight = ((long)factor - across) * ((long)factor - down);
            const float z = cw_field_row(f, y)[x];
            possible += weight;
            if (isnan(z)) continue;
            there += weight;
            mpq_set_d(term, (double)z);
            mpz_mul_si(mpq_numref(term), mpq_numref(term), weight);
            mpq_canonicalize(term);
            mpq_add(mean, mean, term);
            *scale = fmax(*scale, fabs((double)z));
        }
    mpq_set_si(term, there > 0 ? there : 1, 1);
    mpq_div(mean, mean, term);
    mpq_clear(term);
    return 2 * there >= possible;
}

static float extreme_at(const cw_field *f, size_t i, size_t j, size_t factor, bool highest) {
    const cw_field_info info = cw_field_describe(f);
    float z = NAN;
    for (size_t y = 0; y < info.ny; y++)
        for (size_t x = 0; x < info.nx; x++) {
            const float h = cw_field_row(f, y)[x];
            if (labs((long)x - (long)(i * factor)) > (long)factor || labs((long)y - (long)(j * factor)) > (long)factor)
                continue;
            if (isnan(h) && highest) continue;
            if (isnan(h)) return NAN;
            if (isnan(z) || (highest ? h > z : h < z)) z = h;
        }
    return z;
}

static void check_sample(const char *what, const cw_field *full, const cw_field *coarser, size_t i, size_t j,
                         size_t factor, int32_t filter) {
    const float z = cw_field_row(coarser, j)[i];
    if (filter != CW_FILTER_MEAN) {
        const float right = extreme_at(full, i, j, factor, filter == CW_FILTER_HIGHEST);
        check(z == right || (isnan(z) && isnan(right)), "%s: sample (%zu, %zu) is %g, not %g", what, i, j, (double)z,
              (double)right);
        return;
    }
    mpq_t mean;
    mpq_init(mean);
    double scale;
    const bool some = mean_at(full, i, j, factor, mean, &scale);
    const double right = mpq_get_d(mean);
    /* Rounded to float once; sums in double of fewer than 2^11 terms before. */
    const double slack = 0x1p-24 * fabs(right) + 0x1p-41 * scale + 0x1p-149;
    check(some == !isnan(z), "%s: sample (%zu, %zu) is %g, where %s belongs", what, i, j, (double)z,
          some ? "a height" : "a hole");
    check(!some || fabs((double)z - right) <= slack, "%s: sample (%zu, %zu) is %.9g, not %.9g", what, i, j, (double)z,
          right);
    mpq_clear(mean);
}

static cw_field *make(const cw_field *full, size_t factor, int32_t filter, cw_difference *d) {
    cw_field *coarser;
    check_status(cw_field_coarser(full, NULL, factor, filter, &coarser, d, sizeof *d), CW_OK);
    return coarser;
}

static void check_case(const test_field *f, size_t factor, int32_t filter) {
    char what[128];
    snprintf(what, sizeof what, "%s %zu x %zu, %s of %zu", field_shape_name(f->shape), f->nx, f->ny,
             filter_names[filter], factor);
    cw_field *full = field_open(f);
    cw_difference d;
    cw_field *coarser = make(full, factor, filter, &d);
    const cw_field_info info = cw_field_describe(coarser);
    assert_int_equal(info.nx, (f->nx - 1 + factor - 1) / factor + 1);
    assert_int_equal(info.ny, (f->ny - 1 + factor - 1) / factor + 1);
    for (size_t j = 0; j < info.ny; j++)
        for (size_t i = 0; i < info.nx; i++) check_sample(what, full, coarser, i, j, factor, filter);
    check_difference(what, full, coarser, factor, &d);
    if (filter == CW_FILTER_HIGHEST) check(d.below == 0 && d.lost == 0, "%s: below the full surface", what);
    if (filter == CW_FILTER_LOWEST) check(d.above == 0 && d.made == 0, "%s: above the full surface", what);
    if (f->shape == FIELD_FLAT) check(d.above == 0 && d.below == 0 && d.rms == 0, "%s: a level is not level", what);
    cw_field_destroy(coarser);
    cw_field_destroy(full);
}

static void test_definitions(void **state) {
    (void)state;
    static test_field f;
    for (size_t round = 0; round < test_rounds(); round++)
        for (int shape = 0; shape < FIELD_SHAPES; shape++)
            for (size_t k = 0; k < CASES; k++) {
                field_make(&f, (field_shape)shape, cases[k].nx, cases[k].ny, 100 * round + k + 1);
                for (int filter = 0; filter < FILTERS; filter++)
                    if (test_takes((size_t)(shape + filter) + k, FILTERS)) check_case(&f, cases[k].factor, filter);
            }
}

/* A larger one, with some holes; both fields' bits by several threads are those by one. */
enum { SIDE = 613, HIGH = 409 };
static cw_field *make_large(void) {
    float *z = malloc(sizeof *z * SIDE * HIGH);
    assert_non_null(z);
    random_state r = {7};
    for (size_t k = 0; k < (size_t)SIDE * HIGH; k++)
        z[k] = k > 200000 && random_unit(&r) < 0.01 ? NAN : 100 * (float)random_unit(&r);
    cw_field *field;
    check_status(cw_field_create(&(cw_field_desc){.samples = z, .nx = SIDE, .ny = HIGH}, NULL, &field), CW_OK);
    free(z);
    return field;
}

static void test_threads(void **state) {
    (void)state;
    cw_field *full = make_large();
    cw_pool *pool;
    check_status(cw_pool_create(4, &pool), CW_OK);
    for (size_t factor = 2; factor < 8; factor += 3)
        for (int filter = 0; filter < FILTERS; filter++) {
            cw_difference one, many;
            cw_field *a = make(full, factor, filter, &one), *b;
            const cw_run run = {.pool = pool};
            check_status(cw_field_coarser(full, &run, factor, filter, &b, &many, sizeof(cw_difference)), CW_OK);
            assert_memory_equal(&one, &many, sizeof one);
            const cw_field_info info = cw_field_describe(a);
            for (size_t j = 0; j < info.ny; j++)
                for (size_t i = 0; i < info.nx; i++) {
                    const float z[2] = {cw_field_row(a, j)[i], cw_field_row(b, j)[i]};
                    assert_memory_equal(&z[0], &z[1], sizeof z[0]);
                }
            cw_field_destroy(a);
            cw_field_destroy(b);
        }
    cw_pool_destroy(pool);
    cw_field_destroy(full);
}

/* A place has the same user coordinates in both, and an update finds a field that owns its samples. */
static void test_map(void **state) {
    (void)state;
    const float z[6] = {1, 2, 3, 4, 5, 6};
    const cw_field_desc desc = {
        .samples = z, .nx = 3, .ny = 2, .map = {{3, 0.5, 0.25, 100}, {-1, 2, 0, 200}, {0.125, 0, 0.5, 7}}};
    cw_field *full, *coarser;
    check_status(cw_field_create(&desc, NULL, &full), CW_OK);
    coarser = make(full, 2, CW_FILTER_HIGHEST, NULL);
    double p[3];
    check_status(cw_hit_points(coarser, NULL, &(cw_hit){.i = 0, .j = 0, .u = 1}, 1, p), CW_OK);
    const double there[3] = {2, 0, (double)cw_field_row(coarser, 0)[1]};
    for (int k = 0; k < 3; k++) {
        const double *m = desc.map[k];
        assert_true(p[k] == m[0] * there[0] + m[1] * there[1] + m[2] * there[2] + m[3]);
    }
    const float new_height = 9;
    check_status(cw_field_update(coarser, NULL, &(cw_update){.at = {1, 0, 1, 1}, .samples = &new_height}), CW_OK);
    assert_true(cw_field_row(coarser, 0)[1] == 9);
    cw_field_destroy(coarser);
    cw_field_destroy(full);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_definitions),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
