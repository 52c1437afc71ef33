/* SPDX-License-Identifier: Apache-2.0 */
/* The ground in sight along a direction: against all edges of the field in double, with bounds on rounding that are carried
 * through; the same bits for every instruction set, number of threads, part of the eyes and place of the land. */

#include "visible.h"

#include "cellwalk_expert.h"
#include "check.h"
#include "crossings.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct looking {
    double dir[2], reach, drop;
    float eye, target;
} looking;

/* ---- brute force ----------------------------------------------------------------------------------------------------- */

typedef struct profile {
    const test_field *field;
    const looking *how;
    double start[3]; /* the eye */
    size_t count;
    crossing crossing[CROSSINGS_MAX];
} profile;

static double height(const profile *p, size_t x, size_t y) { return (double)p->field->z[y * p->field->nx + x]; }

static void make_profile(profile *p, size_t i, size_t j) {
    const test_field *f = p->field;
    p->start[0] = (double)i;
    p->start[1] = (double)j;
    p->start[2] = (double)(f->z[j * f->nx + i] + p->how->eye);
    p->count = crossings_find(f, p->start, p->how->dir, p->how->drop, p->crossing);
}

/* A float's slope is off by 2^-20 of the higher rise at most: eight roundings of 2^-24, of differences that are at most twice as
 * large. */
static double error_of(const looking *l, const crossing *c) {
    return 0x1p-20 * (c->steep + (double)l->target / c->t) + 0x1p-22 * l->drop * c->t + 0x1p-140;
}

typedef struct sight {
    double area, farthest, units; /* units: what parts lose if each area is cut to a multiple of its run's unit */
} sight;

static void see(sight *s, double from, double to, double reach) {
    if (reach > 0) to = fmin(to, reach);
    if (!(to > from)) return;
    s->area += (to * to - from * from) / 2;
    s->units += fmax(0x1p-20, 0x1p-29 * 129 * (2 * from + 129)) / 2;
    s->farthest = fmax(s->farthest, to);
}

/* The part of a piece whose slopes, w0 at t0 and w1 at t1, are greater than m. */
static void see_piece(sight *s, double t0, double t1, double w0, double w1, double m, double reach) {
    const double d0 = (w0 - m) * t0, d1 = (w1 - m) * t1, span = t1 - t0;
    if (d0 > 0 && d1 > 0)
        see(s, t0, t1, reach);
    else if (d0 > 0)
        see(s, t0, t0 + span * d0 / (d0 - d1), reach);
    else if (d1 > 0)
        see(s, t1 - span * d1 / (d1 - d0), t1, reach);
}

/* What is in sight at least and at most, if every slope may be off by its error: with all targets lower and what hides them
 * higher, and the other way round. */
static void brute(const profile *p, sight *least, sight *most) {
    const looking *l = p->how;
    const double ground = height(p, (size_t)p->start[0], (size_t)p->start[1]);
    double low = -INFINITY, high = -INFINITY;
    *least = *most = (sight){0, 0, 0};
    for (size_t k = 0; k < p->count; k++) {
        const crossing c = p->crossing[k], b = k > 0 ? p->crossing[k - 1] : (crossing){1, 0, 0};
        const double up = (double)l->target, error = error_of(l, &c), before = error_of(l, &b);
        if (!isnan(c.slope) && !isnan(b.slope)) {
            if (k == 0 && (p->start[2] > ground || up > 0)) {
                see(least, 0, c.t, l->reach);
                see(most, 0, c.t, l->reach);
            } else if (k > 0) {
                const double w0 = b.slope + up / b.t, w1 = c.slope + up / c.t;
                see_piece(least, b.t, c.t, w0 - before, w1 - error, high, l->reach);
                see_piece(most, b.t, c.t, w0 + before, w1 + error, low, l->reach);
            }
        }
        if (isnan(c.slope)) continue;
        low = fmax(low, c.slope - error);
        high = fmax(high, c.slope + error);
    }
}

/* ---- what the library finds ------------------------------------------------------------------------------------------ */

static double area[FIELD_SAMPLES_MAX];
static float farthest[FIELD_SAMPLES_MAX], direction[FIELD_SAMPLES_MAX];

static cw_visible_desc desc_of(const looking *l) {
    return (cw_visible_desc){.dir = {l->dir[0], l->dir[1]},
                             .reach = l->reach,
                             .drop = l->drop,
                             .eye = l->eye,
                             .target = l->target,
                             .weight = 1,
                             .length = 1,
                             .label = 7};
}

static void clear(size_t n) {
    memset(area, 0, n * sizeof *area);
    memset(farthest, 0, n * sizeof *farthest);
    for (size_t k = 0; k < n; k++) direction[k] = NAN;
}

static void look(cw_visible *v, const cw_run *run, const looking *l, size_t row, size_t rows, size_t samples) {
    const cw_visible_desc desc = desc_of(l);
    clear(samples);
    check_status(cw_visible_add(v, run, &desc, row, rows, (cw_visible_sums){area, farthest, direction}), CW_OK);
}

static double inexact, all; /* how much the bounds leave open, of how much */

static void check_eye(const profile *p, size_t at) {
    const test_field *f = p->field;
    if (isnan(f->z[at])) {
        check(isnan(area[at]) && isnan(farthest[at]) && isnan(direction[at]), "%g, %g, %g at a hole", area[at],
              (double)farthest[at], (double)direction[at]);
        return;
    }
    sight least, most;
    brute(p, &least, &most);
    inexact += most.area - least.area;
    all += most.area;
    /* Floats have the ends of the last piece, if the reach ends it. */
    const double slack = 0x1p-20, far = (double)farthest[at], ends = 0x1p-22 * p->how->reach * p->how->reach;
    check(area[at] >= least.area * (1 - slack) - least.units - ends && area[at] <= most.area * (1 + slack) + ends &&
              far >= least.farthest * (1 - slack) && far <= most.farthest * (1 + slack),
          "%s %zu x %zu, from (%zu, %zu) along (%a, %a), reach %g, drop %g, eye %g, target %g: %.9g to %.9g, not %.9g "
          "to %.9g; up to %.9g, not %.9g to %.9g",
          field_shape_name(f->shape), f->nx, f->ny, at % f->nx, at / f->nx, p->how->dir[0], p->how->dir[1],
          p->how->reach, p->how->drop, (double)p->how->eye, (double)p->how->target, area[at], area[at], least.area,
          most.area, far, least.farthest, most.farthest);
    check(far > 0 ? direction[at] == 7 : isnan(direction[at]), "direction %g", (double)direction[at]);
}

static profile line;

/* All lines of small fields, some of large ones, in so many directions. */
static void check_against_brute(const test_field *f, looking l, size_t directions, uint64_t seed) {
    random_state r = {seed};
    cw_field *field = field_open(f);
    cw_visible *v = NULL;
    const double reach = l.reach;
    check_status(cw_visible_create(field, (cw_rectangle){0, 0, f->nx, f->ny}, 1, &v), CW_OK);
    for (size_t d = 0; d < directions; d += test_step(10)) {
        line_direction(&r, d, l.dir);
        const double length = hypot(l.dir[0], l.dir[1]);
        l.reach = reach / length;
        looking in_steps = l;
        in_steps.drop = l.drop * length * length;
        look(v, NULL, &in_steps, 0, f->ny, f->nx * f->ny);
        const size_t samples = f->nx * f->ny, some = test_share(120, 40), count = samples > some ? some : samples;
        line.field = f;
        line.how = &in_steps;
        for (size_t k = 0; k < count; k++) {
            const size_t at = count == samples ? k : random_below(&r, samples);
            make_profile(&line, at % f->nx, at / f->nx);
            check_eye(&line, at);
        }
    }
    cw_visible_destroy(v);
    cw_field_destroy(field);
}

static test_field field_a, field_b;

/* Eyes and targets: on the ground, above it, the one or the other higher. */
static const float heights[][2] = {{2, 0}, {0.25f, 0}, {0, 1}, {0.5f, 3}, {3, 0.5f}, {0, 0}};
enum { HEIGHTS = sizeof heights / sizeof heights[0] };

static void every_line_counts(void **state) {
    (void)state;
    for (field_shape shape = 0; shape < FIELD_SHAPES; shape++)
        for (size_t s = 0; s < FIELD_SIZES; s++) {
            if (shape == FIELD_HUGE || shape == FIELD_MIXED) continue; /* whose slopes are no floats */
            const float *h = heights[((size_t)shape + s) % HEIGHTS];
            field_make(&field_a, shape, field_sizes[s].nx, field_sizes[s].ny, 7 + s);
            check_against_brute(&field_a, (looking){.eye = h[0], .target = h[1]}, 30, 11 * (uint64_t)shape + s);
        }
    inexact = all = 0; /* above, cliffs and planes seen edge-on leave much to rounding */
    for (size_t k = 0; k < 3 * HEIGHTS; k++) {
        const float *h = heights[k % (HEIGHTS - 1)];
        field_make(&field_a, k % 3 == 0 ? FIELD_HOLES : k % 3 == 1 ? FIELD_RANDOM : FIELD_INTEGERS, 17 + k, 15, k);
        check_against_brute(&field_a, (looking){.eye = 0.1f * h[0], .target = 0.1f * h[1]}, 40, 50 + k);
    }
    check(inexact < 1e-3 * all, "%g of %g is left open by rounding", inexact, all);
}

/* Rolling land, under water up to some height. */
static void make_lakes(test_field *f, size_t nx, size_t ny, float water) {
    field_make_land(f, nx, ny);
    for (size_t k = 0; k < nx * ny; k++) f->z[k] = fmaxf(f->z[k], water);
}

static void large_land_is_seen_rightly(void **state) {
    (void)state;
    inexact = all = 0;
    for (size_t k = 0; k < HEIGHTS - 1; k++) {
        const looking l = {.eye = heights[k][0], .target = heights[k][1], .drop = k % 2 ? 1e-4 : 0};
        if (!test_takes(k, 3)) continue;
        make_lakes(&field_a, k % 2 ? 255 : 90, k % 2 ? 130 : 300, 980);
        check_against_brute(&field_a, l, 20, 5 + k);
    }
    check(inexact < 0.01 * all, "%g of %g is left open by rounding", inexact, all);
}

/* Single high samples, which a bound must not miss: the earth's curvature hides all flat land that is not near. */
static void spikes_are_not_passed_over(void **state) {
    (void)state;
    random_state r = {4};
    for (size_t round = 0; round < 6; round++) {
        if (!test_takes(round, 3)) continue;
        field_make(&field_a, FIELD_FLAT, 160, 170, round);
        for (size_t k = 0; k < 400; k++)
            field_a.z[random_below(&r, field_a.nx * field_a.ny)] += (float)random_between(&r, 0, 60);
        const looking l = {.eye = round % 2 ? 2 : 0.5f, .target = round % 3 ? 0 : 1, .drop = 0.005};
        check_against_brute(&field_a, l, 45, round);
    }
}

/* Distances end within pieces, at borders and beyond; the earth is flat, a little curved, and as round as a ball. */
static void reach_and_curvature_count(void **state) {
    (void)state;
    static const double reaches[] = {0, 0.3137, 5.2713, 61.317, 1}, drops[] = {0, 1e-4, 0.05};
    for (size_t k = 1; k < 15; k++) {
        const looking l = {.reach = reaches[k % 5],
                           .drop = drops[k / 5],
                           .eye = heights[k % HEIGHTS][0],
                           .target = heights[k % HEIGHTS][1]};
        if (!test_takes(k, 4)) continue;
        make_lakes(&field_a, 155, 130, k % 2 ? 990 : 0);
        check_against_brute(&field_a, l, 17, 20 + k);
        field_make(&field_a, FIELD_HOLES, 40, 31, k);
        check_against_brute(&field_a, l, 17, 40 + k);
    }
}

/* ---- bits ------------------------------------------------------------------------------------------------------------ */

enum { NX = 203, NY = 187 };
static double first_area[NX * NY];
static float first_farthest[NX * NY];

/* Eye (x, y) of a grid whose first is sample (i, j) has the bits of the same eye on its own. */
static void check_part(const char *what, size_t i, size_t j, size_t nx, size_t ny, size_t every) {
    for (size_t k = 0; k < nx * ny; k++) {
        const size_t at = (j + k / nx * every) * NX + i + k % nx * every;
        check(memcmp(&area[k], &first_area[at], sizeof area[k]) == 0 &&
                  memcmp(&farthest[k], &first_farthest[at], sizeof farthest[k]) == 0,
              "%s: %zu x %zu eyes from (%zu, %zu), every %zu: number %zu has %a, %a, not %a, %a", what, nx, ny, i, j,
              every, k, area[k], (double)farthest[k], first_area[at], (double)first_farthest[at]);
    }
}

/* Eyes at every k-th column and row of some rectangle, in two calls. */
static void check_some_eyes(const cw_field *field, const cw_run *run, const looking *l, random_state *r) {
    cw_visible *v = NULL;
    const size_t i = random_below(r, NX), j = random_below(r, NY), nx = 1 + random_below(r, NX - i),
                 ny = 1 + random_below(r, NY - j), every = 1 + random_below(r, 2) * random_below(r, 20),
                 wide = (nx + every - 1) / every, high = (ny + every - 1) / every, row = random_below(r, high);
    check_status(cw_visible_create(field, (cw_rectangle){i, j, nx, ny}, every, &v), CW_OK);
    look(v, run, l, row, high - row, NX * NY);
    check_part("part", i, j + row * every, wide, high - row, every);
    look(v, run, l, 0, row, NX * NY);
    check_part("part", i, j, wide, row, every);
    cw_visible_destroy(v);
}

/* The land amid holes, so that blocks begin elsewhere, and bounds are others. */
static void check_elsewhere(const looking *l, random_state *r) {
    const size_t i = random_below(r, 40), j = random_below(r, 40), nx = NX + i + random_below(r, 10),
                 ny = NY + j + random_below(r, 10);
    field_make(&field_b, FIELD_FLAT, nx, ny, 1);
    for (size_t k = 0; k < nx * ny; k++) field_b.z[k] = NAN;
    for (size_t k = 0; k < NX * NY; k++) field_b.z[(j + k / NX) * nx + i + k % NX] = field_a.z[k];
    cw_field *field = field_open(&field_b);
    cw_visible *v = NULL;
    check_status(cw_visible_create(field, (cw_rectangle){i, j, NX, NY}, 1, &v), CW_OK);
    look(v, NULL, l, 0, NY, NX * NY);
    check_part("elsewhere", 0, 0, NX, NY, 1);
    cw_visible_destroy(v);
    cw_field_destroy(field);
}

static void bits_are_the_same(void **state) {
    (void)state;
    random_state r = {99};
    cw_pool *pool = NULL;
    check_status(cw_pool_create(3, &pool), CW_OK);
    for (size_t d = 0; d < 30; d++) {
        looking l = {.eye = heights[d % HEIGHTS][0], .target = heights[d % HEIGHTS][1]};
        l.drop = d % 4 == 1 ? 1e-4 : 0;
        l.reach = d % 5 == 2 ? 33.3 : 0;
        line_direction(&r, d, l.dir);
        if (!test_takes(d, 16)) continue;
        make_lakes(&field_a, NX, NY, d % 2 ? 990 : 0);
        for (size_t k = 0; k < 300; k++) field_a.z[random_below(&r, NX * NY)] = NAN;
        cw_field *field = field_open(&field_a);
        cw_visible *v = NULL;
        check_status(cw_visible_create(field, (cw_rectangle){0, 0, NX, NY}, 1, &v), CW_OK);
        for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
            cw_isa_limit((cw_isa)isa);
            if ((int)cw_isa_best() != isa) continue;
            const cw_run run = {.pool = isa % 2 ? pool : NULL};
            look(v, &run, &l, 0, NY, NX * NY);
            if (isa == CW_ISA_SCALAR) {
                memcpy(first_area, area, sizeof first_area);
                memcpy(first_farthest, farthest, sizeof first_farthest);
            }
            check_part("instruction set", 0, 0, NX, NY, 1);
            for (int k = 0; k < 4; k++) check_some_eyes(field, &run, &l, &r);
        }
        cw_isa_limit(CW_ISA_ANY);
        check_elsewhere(&l, &r);
        cw_visible_destroy(v);
        cw_field_destroy(field);
    }
    cw_pool_destroy(pool);
}

/* Over water that is in sight as a whole, slopes must rise after rounding, too: where crossings nearly coincide, and where curvature
 * or a low eye leaves little. Blocks that begin elsewhere have other crossings amid them. */
static void lakes_are_the_same_elsewhere(void **state) {
    (void)state;
    random_state r = {17};
    static const double ways[] = {1.0 / 3, -0.5, 0.75, -1.0 / 7}, drops[] = {0, 1e-7, 1e-5};
    static const float eyes[] = {0x1p-10f, 2, 300};
    for (size_t d = 0; d < 108; d++) {
        if (!test_takes(d, 16)) continue;
        const double beside =
            ldexp(d / 12 % 2 ? 1 : -1, -18 - (int)(d % 9)); /* so crossings come soon after another, or before */
        const looking l = {
            .dir = {ways[d % 4] + beside, d % 8 < 4 ? 1 : -1}, .drop = drops[d % 3], .eye = eyes[d / 3 % 3]};
        make_lakes(&field_a, NX, NY, 1035);
        cw_field *field = field_open(&field_a);
        cw_visible *v = NULL;
        check_status(cw_visible_create(field, (cw_rectangle){0, 0, NX, NY}, 1, &v), CW_OK);
        look(v, NULL, &l, 0, NY, NX * NY);
        memcpy(first_area, area, sizeof first_area);
        memcpy(first_farthest, farthest, sizeof first_farthest);
        for (int k = 0; k < 4; k++) check_elsewhere(&l, &r);
        cw_visible_destroy(v);
        cw_field_destroy(field);
    }
}

/* Directions close to each other share bounds. */
static void slack_changes_nothing(void **state) {
    (void)state;
    make_lakes(&field_a, NX, NY, 990);
    cw_field *field = field_open(&field_a);
    cw_visible *each = NULL, *shared = NULL;
    const cw_rectangle whole = {0, 0, NX, NY};
    check_status(cw_visible_create(field, whole, 1, &shared), CW_OK);
    for (int k = 0; k < 40; k++) {
        const looking l = {.dir = {-0.31 + 0.0004 * (k < 20 ? k : k - 50), 1}, .eye = 2};
        if (!test_takes((size_t)k, 5)) continue; /* some on each side */
        check_status(cw_visible_create(field, whole, 1, &each), CW_OK);
        look(each, NULL, &l, 0, NY, NX * NY);
        memcpy(first_area, area, sizeof first_area);
        memcpy(first_farthest, farthest, sizeof first_farthest);
        cw_visible_desc desc = desc_of(&l);
        desc.slack = 0x1p-7;
        clear(NX * NY);
        check_status(cw_visible_add(shared, NULL, &desc, 0, NY, (cw_visible_sums){area, farthest, direction}), CW_OK);
        check_part("slack", 0, 0, NX, NY, 1);
        cw_visible_destroy(each);
    }
    cw_visible_destroy(shared);
    cw_field_destroy(field);
}

static void misuse_is_refused(void **state) {
    (void)state;
    field_make(&field_a, FIELD_RANDOM, 5, 4, 1);
    cw_field *field = field_open(&field_a);
    cw_visible *v = NULL;
    const cw_rectangle whole = {0, 0, 5, 4};
    check_status(cw_visible_create(field, whole, 1, NULL), CW_ERROR_ARGUMENT);
    check_status(cw_visible_create(NULL, whole, 1, &v), CW_ERROR_ARGUMENT);
    check_status(cw_visible_create(field, whole, 0, &v), CW_ERROR_ARGUMENT);
    check_status(cw_visible_create(field, (cw_rectangle){1, 0, 5, 4}, 1, &v), CW_ERROR_ARGUMENT);
    assert_null(v);
    check_status(cw_visible_create(field, whole, 1, &v), CW_OK);
    const cw_visible_desc good = {.dir = {1, 0}, .weight = 1, .length = 1};
    cw_visible_desc bad[] = {good, good, good, good, good, good, good};
    bad[0].dir[0] = 0;
    bad[1].dir[1] = NAN;
    bad[2].reach = -1;
    bad[3].drop = 0x1p80;
    bad[4].eye = -1;
    bad[5].target = NAN;
    bad[6].slack = 1;
    const cw_visible_sums to = {.area = area};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        check_status(cw_visible_add(v, NULL, &bad[k], 0, 4, to), CW_ERROR_ARGUMENT);
    check_status(cw_visible_add(NULL, NULL, &good, 0, 4, to), CW_ERROR_ARGUMENT);
    check_status(cw_visible_add(v, NULL, NULL, 0, 4, to), CW_ERROR_ARGUMENT);
    check_status(cw_visible_add(v, NULL, &good, 2, 3, to), CW_ERROR_ARGUMENT);
    check_status(cw_visible_add(v, NULL, &good, 0, 4, (cw_visible_sums){.farthest = farthest}), CW_ERROR_ARGUMENT);
    const cw_run misspelt = {.expert.kernel = cw_kernel_find("packet99")};
    check_status(cw_visible_add(v, &misspelt, &good, 0, 4, to), CW_ERROR_KERNEL);
    check_status(cw_visible_add(v, NULL, &good, 4, 0, to), CW_OK);
    cw_visible_destroy(v);
    cw_visible_destroy(NULL);
    cw_field_destroy(field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_line_counts),          cmocka_unit_test(large_land_is_seen_rightly),
        cmocka_unit_test(spikes_are_not_passed_over), cmocka_unit_test(reach_and_curvature_count),
        cmocka_unit_test(bits_are_the_same),          cmocka_unit_test(lakes_are_the_same_elsewhere),
        cmocka_unit_test(slack_changes_nothing),      cmocka_unit_test(misuse_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
