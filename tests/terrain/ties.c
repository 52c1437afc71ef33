/* SPDX-License-Identifier: Apache-2.0 */
/* Viewsheds and lines of sight where the line touches the surface, or passes it by less than doubles can tell, against rational
 * arithmetic over all edges. */

#include "columns.h"
#include "ground.h"
#include "viewshed.h"
#include "workload/random.h"

#include <gmp.h>
#include <string.h>

/* ---- the judge ---------------------------------------------------------------------------------------------------- */

/* One line of sight, as rational numbers from the eye. */
typedef struct judge {
    const sight *sight;
    mpq_t x, y, top;              /* the target */
    mpq_t ax, ay, az, bx, by, bz; /* samples */
    mpq_t side, other, a, b, c, d;
    double place[2], rise; /* of the target, and how high it is over the eye */
    int highest;           /* 1: something is above the line, 0: something touches it, -1: neither */
} judge;

static void judge_each(judge *q, void (*each)(mpq_t)) {
    mpq_t *const all[] = {&q->x,  &q->y,    &q->top,   &q->ax, &q->ay, &q->az, &q->bx, &q->by,
                          &q->bz, &q->side, &q->other, &q->a,  &q->b,  &q->c,  &q->d};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) each(*all[k]);
}
static void each_init(mpq_t number) { mpq_init(number); }
static void each_clear(mpq_t number) { mpq_clear(number); }

static void set_difference(mpq_t out, double a, double b) {
    mpq_t second;
    mpq_init(second);
    mpq_set_d(out, a);
    mpq_set_d(second, b);
    mpq_sub(out, out, second);
    mpq_clear(second);
}

static void cross(judge *q, mpq_t out, mpq_t ax, mpq_t ay, mpq_t bx, mpq_t by) {
    mpq_mul(q->c, ax, by);
    mpq_mul(q->d, ay, bx);
    mpq_sub(out, q->c, q->d);
}

static void set_sample(judge *q, size_t i, size_t j, mpq_t x, mpq_t y, mpq_t z) {
    const sight *s = q->sight;
    set_difference(x, (double)i, s->eye[0]);
    set_difference(y, (double)j, s->eye[1]);
    set_difference(z, (double)s->terrain->z[j * s->terrain->nx + i], s->eye[2]);
    mpq_set_d(q->c, cw_sight_fall(s, (double)i, (double)j));
    mpq_sub(z, z, q->c);
}

static void note(judge *q, int side) { q->highest = side > q->highest ? side : q->highest; }

/* The crossing at the place (a, b), of height c: if it is between the ends, on which side of the line it is. */
static void judge_place(judge *q) {
    const bool by_x = mpq_sgn(q->x) != 0;
    mpq_div(q->d, by_x ? q->a : q->b, by_x ? q->x : q->y);
    if (mpq_sgn(q->d) <= 0 || mpq_cmp_ui(q->d, 1, 1) >= 0) return;
    mpq_mul(q->d, q->d, q->top);
    const int side = mpq_cmp(q->c, q->d);
    note(q, (side > 0) - (side < 0));
}

static void judge_edge(judge *q, size_t i, size_t j, size_t di, size_t dj) {
    const terrain *t = q->sight->terrain;
    const double *e = q->sight->eye;
    if (i + di >= t->nx || j + dj >= t->ny) return;
    if (!isfinite(t->z[j * t->nx + i]) || !isfinite(t->z[(j + dj) * t->nx + i + di])) return;
    /* Most are on one side by far. */
    const double x = q->place[0] - e[0], y = q->place[1] - e[1];
    const double one = x * ((double)j - e[1]) - y * ((double)i - e[0]), two = one + x * (double)dj - y * (double)di;
    if ((one > 1e-3 && two > 1e-3) || (one < -1e-3 && two < -1e-3)) return;
    if (fabs(one) > 1e-3 &&
        fabs(two) > 1e-3) { /* heights are below 10^4: what is that far off the line is so for doubles too */
        const double f = one / (one - two), a = (double)i + f * (double)di - e[0],
                     b = (double)j + f * (double)dj - e[1];
        const double low = cw_sight_sample(q->sight, i, j), high = cw_sight_sample(q->sight, i + di, j + dj);
        const double way = (a * x + b * y) / (x * x + y * y), off = low + f * (high - low) - way * q->rise;
        if (way > 1e-3 && way < 1 - 1e-3 && fabs(off) > 1e-3) {
            note(q, off > 0 ? 1 : -1);
            return;
        }
    }
    set_sample(q, i, j, q->ax, q->ay, q->az);
    set_sample(q, i + di, j + dj, q->bx, q->by, q->bz);
    cross(q, q->side, q->x, q->y, q->ax, q->ay);
    cross(q, q->other, q->x, q->y, q->bx, q->by);
    if (mpq_sgn(q->side) * mpq_sgn(q->other) >= 0) return; /* samples are judged by themselves */
    mpq_sub(q->c, q->side, q->other);
    mpq_div(q->d, q->side, q->c); /* how far from a to b */
    mpq_t *const from[3] = {&q->ax, &q->ay, &q->az}, *const to[3] = {&q->bx, &q->by, &q->bz};
    for (int k = 0; k < 3; k++) {
        mpq_sub(*to[k], *to[k], *from[k]);
        mpq_mul(*to[k], *to[k], q->d);
        mpq_add(*to[k], *to[k], *from[k]);
    }
    mpq_set(q->a, q->bx);
    mpq_set(q->b, q->by);
    mpq_set(q->c, q->bz);
    judge_place(q);
}

static void judge_sample(judge *q, size_t i, size_t j) {
    const terrain *t = q->sight->terrain;
    const double *e = q->sight->eye, x = q->place[0] - e[0], y = q->place[1] - e[1];
    if (!isfinite(t->z[j * t->nx + i])) return;
    if (fabs(x * ((double)j - e[1]) - y * ((double)i - e[0])) > 1e-3) return;
    set_sample(q, i, j, q->ax, q->ay, q->az);
    cross(q, q->side, q->x, q->y, q->ax, q->ay);
    if (mpq_sgn(q->side) != 0) return;
    mpq_set(q->a, q->ax);
    mpq_set(q->b, q->ay);
    mpq_set(q->c, q->az);
    judge_place(q);
}

/* The highest that there is on the way from the eye to a place at height z, and above over it: see judge. */
static int judge_line(const sight *s, double i, double j, double z, double above) {
    judge q = {.sight = s, .place = {i, j}, .highest = -1};
    judge_each(&q, each_init);
    set_difference(q.x, i, s->eye[0]);
    set_difference(q.y, j, s->eye[1]);
    set_difference(q.top, z, s->eye[2]);
    mpq_set_d(q.c, above);
    mpq_add(q.top, q.top, q.c);
    mpq_set_d(q.c, cw_sight_fall(s, i, j));
    mpq_sub(q.top, q.top, q.c);
    q.rise = mpq_get_d(q.top);
    const double line[2] = {i - s->eye[0], j - s->eye[1]};
    for (size_t y = 0; y < s->terrain->ny && q.highest < 1; y++) {
        size_t x = 0, until = s->terrain->nx;
        columns_near_line(s->eye, line, y, &x, &until);
        for (; x < until; x++) {
            judge_sample(&q, x, y);
            judge_edge(&q, x, y, 1, 0);
            judge_edge(&q, x, y, 0, 1);
            judge_edge(&q, x, y, 1, 1);
        }
    }
    judge_each(&q, each_clear);
    return q.highest;
}

/* ---- what is judged ----------------------------------------------------------------------------------------------- */

enum { SIDE = 24, SAMPLES = SIDE * SIDE, SAMPLES_STEP = 5 };

typedef struct tally {
    size_t seen, touched, hidden;
} tally;

/* Nothing is above the line to so much over the ground, and something is above that to less; both by more than floats and
 * the search's rounding leave open. */
static void check_need(const sight *s, double x, double y, double z, double need) {
    const double slack = 1e-4 + 1e-6 * need;
    if (need > 1e6) return; /* an edge so near to the eye that its share of the way, known to 2^-49, is far below 1 */
    check(judge_line(s, x, y, z, need + slack) <= 0, "(%g, %g) from (%.17g, %.17g, %.17g): %g m are not enough", x, y,
          s->eye[0], s->eye[1], s->eye[2], need);
    check(!(need > slack) || judge_line(s, x, y, z, need - slack) >= 0,
          "(%g, %g) from (%.17g, %.17g, %.17g): %g m are too much", x, y, s->eye[0], s->eye[1], s->eye[2], need);
}

/* All samples, or one in so many of larger land: whether they are seen, and what is needed for that; and whether a line of sight says the same. */
static void check_view(const ground *g, const viewshed_desc *d, tally *sum) {
    static uint16_t seen[SAMPLES];
    static float need[SAMPLES];
    const terrain *t = &g->terrain;
    viewshed *v = NULL;
    check_status(cw_viewshed_create(t, g->bounds, d, &v), CW_OK);
    const sight *s = cw_viewshed_sight(v);
    memset(seen, 0, sizeof seen);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = seen}), CW_OK);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.needed = need}), CW_OK);
    for (size_t k = 0; k < t->nx * t->ny; k++) {
        if (t->nx >= SIDE && !test_takes(k, SAMPLES_STEP)) continue;
        const double x = (double)(k % t->nx), y = (double)(k / t->nx), z = (double)g->z[k];
        if (isnan(z) || (x == s->eye[0] && y == s->eye[1])) continue;
        const int highest = judge_line(s, x, y, z, d->target_height);
        check(seen[k] == (highest < 0), "(%g, %g) from (%.17g, %.17g, %.17g) is %s, but %s", x, y, s->eye[0], s->eye[1],
              s->eye[2], seen[k] ? "seen" : "hidden", highest < 0 ? "all is below the line" : "something touches it");
        const int ground_highest = d->target_height == 0 ? highest : judge_line(s, x, y, z, 0);
        check((need[k] > 0) == (ground_highest > 0), "(%g, %g) from (%.17g, %.17g, %.17g): %g m are needed, verdict %d",
              x, y, s->eye[0], s->eye[1], s->eye[2], (double)need[k], ground_highest);
        if (k % 4 == 0) check_need(s, x, y, z, (double)need[k]);
        const double block = cw_sight_first_block(s, x, y, z);
        check((block < INFINITY) == (ground_highest >= 0), "(%g, %g) from (%.17g, %.17g, %.17g): the line is %s", x, y,
              s->eye[0], s->eye[1], s->eye[2], block < INFINITY ? "blocked" : "free");
        sum->seen += highest < 0;
        sum->touched += highest == 0;
        sum->hidden += highest > 0;
    }
    cw_viewshed_destroy(v);
}

static void make_ground(ground *g, size_t nx, size_t ny, double (*height)(void *context, size_t i, size_t j),
                        void *context) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    for (size_t k = 0; k < nx * ny; k++) z[k] = (float)height(context, k % nx, k / nx);
    ground_take(g, nx, ny, z, ground_map);
}

/* One obstacle between an eye half a metre up and a target of 2 m: the line touches its top. */
static double one_touch(void *context, size_t i, size_t j) {
    (void)context;
    return j > 0 ? -50 : i == 1 ? 1 : i == 3 ? 2 : i == 0 ? 0 : -50;
}

static void a_touch_blocks(void **state) {
    (void)state;
    ground g;
    tally sum = {0};
    make_ground(&g, 5, 4, one_touch, NULL);
    check_view(&g, &(viewshed_desc){.place = {0, 0}, .height = 0.5}, &sum);
    assert_true(sum.touched > 0);
    ground_free(&g);
}

/* Whole heights: some samples in a plane with the eye, the others far below it, a few above it and holes. */
typedef struct plane {
    random_state r;
    double slopes[2], base;
} plane;

static double whole(void *context, size_t i, size_t j) {
    plane *p = context;
    const double z = p->base + p->slopes[0] * (double)i + p->slopes[1] * (double)j;
    const uint64_t kind = random_below(&p->r, 100);
    return kind == 0 ? (double)NAN : kind < 4 ? z + 1 : kind < 40 ? z : z - 50;
}

static void tilt(plane *p) {
    p->base = (double)random_below(&p->r, 5);
    for (int c = 0; c < 2; c++) p->slopes[c] = (double)random_below(&p->r, 5) - 2;
}

static void whole_heights(void **state) {
    (void)state;
    plane p = {.r = {11}};
    random_state *r = &p.r;
    tally sum = {0};
    const size_t lands = 60 / test_step(8) * test_rounds();
    for (size_t land = 0; land < lands; land++) {
        ground g;
        tilt(&p);
        make_ground(&g, SIDE, SIDE - land % 5, whole, &p);
        viewshed_desc d = {.absolute = true, .target_height = land % 3 == 2 ? 0.5 : 0};
        for (int c = 0; c < 2; c++) d.place[c] = 0.5 * (double)random_below(r, 2 * (SIDE - 5));
        d.height = p.base + p.slopes[0] * d.place[0] + p.slopes[1] * d.place[1];
        check_view(&g, &d, &sum);
        ground_free(&g);
    }
    const size_t least = 40 * lands / test_step(SAMPLES_STEP);
    check(sum.touched > least && sum.seen > least && sum.hidden > least, "%zu seen, %zu touched, %zu hidden", sum.seen,
          sum.touched, sum.hidden);
}

/* A plane through the eye, with ridges that come up to it: but for the rounding of the eye's height and the samples', all are
 * ties, and the last digits decide. */
static double ridges(void *context, size_t i, size_t j) {
    const double *slopes = context, z = slopes[0] * (double)i + slopes[1] * (double)j;
    return (i + 2 * j) % 4 == 0 ? z : z - 10;
}

static void last_digits(void **state) {
    (void)state;
    random_state r = {12};
    tally sum = {0};
    for (size_t land = 0; land < 30 / test_step(4) * test_rounds(); land++) {
        double slopes[2] = {0.5, 0.25};
        ground g;
        if (land % 2)
            for (int c = 0; c < 2; c++) slopes[c] = random_between(&r, -1, 1);
        make_ground(&g, SIDE, SIDE, ridges, slopes);
        viewshed_desc d = {.absolute = true, .curvature = land % 5 == 4 ? 1 : 0};
        for (int c = 0; c < 2; c++) d.place[c] = random_between(&r, -3, SIDE + 3);
        if (land % 3 == 0) d.place[1] = floor(d.place[1]);
        /* Within rounding of a row: what is between eye and row counts. */
        if (land % 6 == 3) d.place[0] = floor(d.place[0]) + 1e-12;
        d.height = slopes[0] * d.place[0] + slopes[1] * d.place[1];
        check_view(&g, &d, &sum);
        ground_free(&g);
    }
    const size_t least = 500 / test_step(4) / test_step(SAMPLES_STEP);
    assert_true(sum.seen > least && sum.touched + sum.hidden > least);
}

/* A spike at (12, 12) whose flanks are under the eye or over it, and cross a row or column at all but the eye's place. */
static double spike(void *context, size_t i, size_t j) {
    (void)context;
    return i == 12 && j == 12 ? 1000 : 0;
}

static void next_to_a_row(void **state) {
    (void)state;
    static const double eyes[][2] = {{1e-10, 0.3}, {0.3, -1e-10}, {1e-12, 1e-12}, {0.2, 0.3}, {0.3, 0.3 + 1e-13}};
    tally sum = {0};
    ground g;
    make_ground(&g, SIDE, SIDE, spike, NULL);
    for (size_t n = 0; n < sizeof eyes / sizeof *eyes; n++)
        check_view(&g, &(viewshed_desc){.place = {12 + eyes[n][0], 12 + eyes[n][1]}, .height = 5, .absolute = true},
                   &sum);
    const size_t least = 100 / test_step(SAMPLES_STEP);
    check(sum.seen > least && sum.hidden > least, "%zu seen, %zu hidden", sum.seen, sum.hidden);
    ground_free(&g);
}

/* Land on one side of a line of samples, with nothing on its other side, and an eye that is next to the line, on either
 * side or on it. */
typedef struct shore {
    random_state r;
    int kind;      /* of the line: along x, along y, a diagonal */
    bool after;    /* land is where the coordinate is larger */
    double n;      /* of the line */
    bool on_holes; /* the other side is holes; else the raster ends there */
} shore;

static double shore_side(const shore *s, double i, double j) {
    const double side = (s->kind == 0 ? j : s->kind == 1 ? i : j - i) - s->n;
    return s->after ? side : -side;
}

static double shore_height(void *context, size_t i, size_t j) {
    shore *s = context;
    const double z = 10 * (double)random_below(&s->r, 1 << 12) / (1 << 12);
    return shore_side(s, (double)i, (double)j) < 0 ? (double)NAN : z;
}

static void beside_lines_holes_and_borders(void **state) {
    (void)state;
    enum { LONG = 90, THIN = 3 };
    shore s = {.r = {15}};
    random_state *r = &s.r;
    tally sum = {0};
    const size_t lands = 80 / test_step(8) * test_rounds();
    for (size_t land = 0; land < lands; land++) {
        ground g;
        s.kind = (int)random_below(r, 3);
        s.after = random_below(r, 2) == 0;
        s.on_holes = random_below(r, 3) > 0;
        const size_t nx = s.kind == 0   ? LONG
                          : s.kind == 1 ? THIN
                                        : SIDE,
                     ny = s.kind == 0   ? THIN
                          : s.kind == 1 ? LONG
                                        : SIDE;
        const double last = (double)(s.kind == 0 ? ny : nx) - 1;
        s.n = s.kind == 2 ? (double)random_below(r, 5) - 2 : s.on_holes ? 1 : s.after ? 0 : last;
        make_ground(&g, nx, ny, shore_height, &s);
        const double off = ldexp(random_below(r, 2) ? 1 : -1, -(int)(18 + random_below(r, 43)));
        viewshed_desc d = {.absolute = true, .height = 10 * random_between(r, -0.2, 1.5), .curvature = land % 7 == 6};
        d.place[0] = random_between(r, -2, (double)nx + 1);
        d.place[1] = random_between(r, -2, (double)ny + 1);
        if (s.kind == 2)
            d.place[1] = d.place[0] + s.n + off;
        else
            d.place[s.kind == 0] = s.n + (land % 8 == 7 ? 0 : off);
        check_view(&g, &d, &sum);
        ground_free(&g);
    }
    check(sum.seen > 20 * lands && sum.hidden > 5 * lands, "%zu seen, %zu touched, %zu hidden", sum.seen, sum.touched,
          sum.hidden);
}

/* Lines of sight between any two places. */
static void lines_between_places(void **state) {
    (void)state;
    plane p = {.r = {13}};
    random_state *r = &p.r;
    size_t blocked = 0, touched = 0, free_lines = 0;
    for (size_t land = 0; land < 40 / test_step(4) * test_rounds(); land++) {
        ground g;
        tilt(&p);
        make_ground(&g, SIDE, SIDE, whole, &p);
        for (int n = 0; n < 60; n++) {
            double ends[2][3];
            for (int e = 0; e < 2; e++) {
                for (int c = 0; c < 2; c++)
                    ends[e][c] = n % 3 == 0   ? random_between(r, 0, SIDE - 1)
                                 : n % 3 == 1 ? 0.25 * (double)random_below(r, 4 * SIDE - 4)
                                              : floor(random_between(r, 0, SIDE - 1)) + 0x1p-43 * (double)e;
            }
            if (n % 6 == 5) /* all but along a diagonal */
                for (int e = 0; e < 2; e++) ends[e][1] = ends[e][0] + (e ? 0x1p-40 : -0x1p-40);
            for (int e = 0; e < 2; e++) ends[e][2] = p.base + p.slopes[0] * ends[e][0] + p.slopes[1] * ends[e][1];
            sight s;
            for (int e = 0; e < 2; e++)
                for (int c = 0; c < 2; c++) ends[e][c] = rint(ends[e][c] * 0x1p44) * 0x1p-44; /* see sight.h */
            cw_sight_init(&s, &g.terrain, NULL, ends[0], 0);
            const double *to = ends[1];
            if (to[0] == s.eye[0] && to[1] == s.eye[1]) continue;
            const int highest = judge_line(&s, to[0], to[1], to[2], 0);
            const double block = cw_sight_first_block(&s, to[0], to[1], to[2]);
            check((block < INFINITY) == (highest >= 0), "(%.17g, %.17g, %g) to (%.17g, %.17g, %g) is %s, verdict %d",
                  s.eye[0], s.eye[1], s.eye[2], to[0], to[1], to[2], block < INFINITY ? "blocked" : "free", highest);
            blocked += highest > 0;
            touched += highest == 0;
            free_lines += highest < 0;
        }
        ground_free(&g);
    }
    const size_t least = 40 / test_step(4);
    check(blocked > least && touched > least && free_lines > least, "%zu blocked, %zu touched, %zu free", blocked,
          touched, free_lines);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_touch_blocks),       cmocka_unit_test(whole_heights),
        cmocka_unit_test(last_digits),          cmocka_unit_test(next_to_a_row),
        cmocka_unit_test(lines_between_places), cmocka_unit_test(beside_lines_holes_and_borders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
