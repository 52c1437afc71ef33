/* SPDX-License-Identifier: Apache-2.0 */
/* The skyline against all edges one by one: edges anywhere, that share ends, that are narrow or a single place, and that are added
 * from where a look last was. */

#include "skyline.h"

#include "check.h"
#include "workload/random.h"

enum { EDGES = 60 };

typedef struct edge {
    double ends[2][2];
} edge;

static double random_direction(random_state *r) { return random_between(r, -1.2, 1.2); }

static edge random_edge(random_state *r, const edge *last) {
    edge e = {.ends = {{random_direction(r), random_unit(r)}, {0, random_unit(r)}}};
    if (last && random_below(r, 3) == 0)
        for (int c = 0; c < 2; c++) e.ends[0][c] = last->ends[1][c];
    const size_t kind = random_below(r, 8);
    const double wide = kind == 0 ? 0.01 * SKYLINE_BLUR : kind == 1 ? 0 : kind == 2 ? 3 * SKYLINE_BLUR : 0.4;
    e.ends[1][0] = e.ends[0][0] + random_between(r, -wide, wide);
    return e;
}

/* What is known of an edge in direction u: false if it is not there. */
static bool look(const edge *e, double u, double *low, double *high) {
    const double *a = e->ends[0], *b = e->ends[1];
    if (a[0] > b[0]) {
        const double *swap = a;
        a = b;
        b = swap;
    }
    if (!(u >= a[0] && u <= b[0])) return false;
    if (b[0] == a[0]) {
        *low = fmin(a[1], b[1]);
        *high = fmax(a[1], b[1]);
    } else {
        *low = *high = a[1] + (b[1] - a[1]) * ((u - a[0]) / (b[0] - a[0]));
    }
    return true;
}

static void check_direction(const edge *edges, size_t n, double u, double low, double high) {
    double lowest = -INFINITY, highest = -INFINITY, there[2];
    for (size_t k = 0; k < n; k++)
        if (look(&edges[k], u, &there[0], &there[1])) {
            lowest = fmax(lowest, there[0]);
            highest = fmax(highest, there[1]);
        }
    check(low <= lowest + 1e-9, "%zu edges, direction %.17g: at least %.17g, but it is %.17g", n, u, low, lowest);
    check(high >= highest - 1e-9, "%zu edges, direction %.17g: at most %.17g, but it is %.17g", n, u, high, highest);
    /* Elsewhere than next to an end the two are one. */
    bool plain = true;
    for (size_t k = 0; k < n; k++) {
        const double *a = edges[k].ends[0], *b = edges[k].ends[1];
        const bool near = u > fmin(a[0], b[0]) - 4 * SKYLINE_BLUR && u < fmax(a[0], b[0]) + 4 * SKYLINE_BLUR;
        plain &= !(near && (fabs(a[0] - b[0]) < SKYLINE_BLUR || fabs(u - a[0]) < 4 * SKYLINE_BLUR ||
                            fabs(u - b[0]) < 4 * SKYLINE_BLUR));
    }
    if (plain && low > -INFINITY)
        check(high - low < 1e-2, "%zu edges, direction %.17g: from %.17g to %.17g", n, u, low, high);
}

static void edges_one_by_one(void **state) {
    (void)state;
    random_state r = {12};
    for (size_t round = 0; round < test_rounds() * test_share(400, 5); round++) {
        edge edges[EDGES];
        const size_t n = 1 + random_below(&r, EDGES);
        skyline s;
        assert_true(cw_skyline_init(&s, -1, 1));
        for (size_t k = 0; k < n; k++) {
            edges[k] = random_edge(&r, k > 0 ? &edges[k - 1] : NULL);
            const double left = fmin(edges[k].ends[0][0], edges[k].ends[1][0]) - 1e-3;
            const uint32_t start =
                random_below(&r, 2) ? SKYLINE_FIRST : skyline_find(&s, SKYLINE_FIRST, fmax(left, -1.5));
            cw_skyline_add(&s, start, edges[k].ends[0], edges[k].ends[1]);
        }
        assert_false(s.failed);
        double low, high, u = -1, until = -1, least = INFINITY;
        uint32_t at = SKYLINE_FIRST;
        for (; u <= 1; u += random_between(&r, 0, 0.01)) {
            skyline_at(&s, &at, u, &low, &high);
            check_direction(edges, n, u, low, high);
            least = fmin(least, high);
            until = u;
        }
        const double all = cw_skyline_least(&s, SKYLINE_FIRST, -1, until);
        check(all <= least, "%zu edges: %.17g is the lowest, but one is %.17g", n, all, least);
        for (size_t k = 0; k < n; k++) /* at the ends themselves */
            for (int end = 0; end < 2; end++) {
                at = SKYLINE_FIRST;
                u = edges[k].ends[end][0];
                if (!(fabs(u) < 1)) continue;
                skyline_at(&s, &at, u, &low, &high);
                check_direction(edges, n, u, low, high);
            }
        cw_skyline_free(&s);
    }
}

/* Added from left to right again and again, as rows are, ever wider, with looks that begin at pieces found before. */
static void rows_of_edges(void **state) {
    (void)state;
    enum { ACROSS = 50, ROWS = 40 };
    static edge edges[ACROSS * ROWS];
    random_state r = {3};
    skyline s;
    size_t n = 0;
    assert_true(cw_skyline_init(&s, -1, 1));
    for (size_t row = 0; row < ROWS; row++) {
        const double wide = 2.2 / (double)(ACROSS - row);
        double last[2] = {-1.1, random_unit(&r)};
        uint32_t start = SKYLINE_FIRST;
        for (size_t i = 0; i < ACROSS - row; i++) {
            edge *e = &edges[n++];
            *e = (edge){.ends = {{last[0], last[1]}, {last[0] + wide, random_unit(&r)}}};
            start = skyline_find(&s, start, last[0] - 1e-2);
            const double far = last[0] + wide + random_between(&r, 0, 0.1);
            const uint32_t behind = skyline_find(&s, start, far);
            cw_skyline_add(&s, start, e->ends[i % 2], e->ends[1 - i % 2]);
            if (s.pieces[behind].from <= far) /* who has found it finds on from it */
                check(skyline_find(&s, behind, far) == skyline_find(&s, SKYLINE_FIRST, far), "a piece behind is lost");
            last[0] = e->ends[1][0];
            last[1] = e->ends[1][1];
        }
        uint32_t at = SKYLINE_FIRST;
        for (double u = -1; u <= 1; u += 0.0037) {
            double low, high;
            skyline_at(&s, &at, u, &low, &high);
            check_direction(edges, n, u, low, high);
        }
    }
    assert_false(s.failed);
    cw_skyline_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(edges_one_by_one), cmocka_unit_test(rows_of_edges)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
