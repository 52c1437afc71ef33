/* SPDX-License-Identifier: Apache-2.0 */
/* Medians, intervals and ratios of rounds against samples worked out by hand. */
#include "harness/interleave.h"

#include "check.h"

#include <math.h>

static void same(const char *what, double got, double wanted) {
    check(fabs(got - wanted) <= 1e-12 * fabs(wanted) + 1e-300, "%s is %.17g instead of %.17g", what, got, wanted);
}

static void location(void **state) {
    (void)state;
    double odd[] = {9, 1, 4, 2, 100}, even[] = {3, 1, 8, 6}, one[] = {7};
    statistics s = statistics_of(odd, 5);
    same("minimum", s.min, 1);
    same("median", s.median, 4);
    s = statistics_of(even, 4);
    same("median", s.median, 4.5);
    s = statistics_of(one, 1);
    same("median", s.median, 7);
    check(s.low == 7 && s.high == 7 && !s.sure, "a single sample is not alone in its interval");
    s = statistics_of(one, 0);
    check(s.n == 0 && s.median == 0, "no samples have a median");
}

/* The chance that fewer than k + 1 of n fair coins show heads, twice, is what an interval without the k outermost samples
 * at either end misses: at n = 10, k = 1 that is 2 (1 + 10) / 1024 = 0.0215, at k = 2 it is 0.109. */
static void interval_ranks(void **state) {
    (void)state;
    static const struct {
        size_t n;
        double confidence;
        int rank;
    } cases[] = {{1, 0.975, -1}, {6, 0.975, -1}, {7, 0.975, 0}, {9, 0.975, 0},   {10, 0.975, 1},
                 {5, 0.95, -1},  {6, 0.95, 0},   {9, 0.95, 1},  {100, 0.95, 39}, {1000, 0.95, 468}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const int rank = statistics_interval_rank(cases[k].n, cases[k].confidence);
        check(rank == cases[k].rank, "of %zu samples at %g, rank %d instead of %d", cases[k].n, cases[k].confidence,
              rank, cases[k].rank);
    }
    double ten[] = {10, 9, 8, 7, 6, 5, 4, 3, 2, 1};
    const statistics s = statistics_of(ten, 10);
    check(s.sure && s.low == 2 && s.high == 9, "interval [%g, %g] instead of [2, 9]", s.low, s.high);
}

/* Times that are given, not measured: the machine slows down from round to round, and all jobs alike. */
typedef struct given {
    double share, seconds;
    unsigned rounds;
} given;

static void take_given(void *context) {
    given *g = context;
    g->seconds = g->share * (1 + g->rounds++);
}

static void ratios_are_of_rounds(void **state) {
    (void)state;
    static interleave_job jobs[4];
    static given times[4] = {{.share = 2}, {.share = 5}, {.share = 3}, {.share = 4}};
    interleave_job *all[4];
    for (size_t k = 0; k < 4; k++) {
        jobs[k] = (interleave_job){.run = take_given, .context = &times[k], .counts = &times[k].seconds};
        jobs[k].group = k > 0 && k < 3 ? "a" : NULL;
        all[k] = &jobs[k];
    }
    interleave(all, 4, &(interleave_limits){.width = 0.01, .seconds = 1e6, .seed = 1});
    for (size_t k = 0; k < 4; k++) {
        const statistics s = interleave_ratio(&jobs[k], &jobs[0]);
        check(jobs[k].seconds.n == INTERLEAVE_LEAST, "not as many rounds as an interval needs");
        check(jobs[k].converged && s.sure, "equal ratios have not converged");
        check(s.median == times[k].share / 2 && s.low == s.median && s.high == s.median, "not the rounds' ratio");
        check(jobs[k].best == (k != 1), "the fastest of a group is another");
    }
    interleave(all, 4, &(interleave_limits){.width = 0.01, .seconds = 0, .seed = 1});
    check(jobs[0].seconds.n == 1 && !jobs[2].converged, "one round has converged");
}

static void take_constant(void *context) {
    given *g = context;
    g->seconds = g->share + 1e-9 * g->rounds++;
}

static void clearly_slower_ones_of_a_group_end(void **state) {
    (void)state;
    enum { FIRST, FAST, SLOW, NEAR, ALONE, COUNT };
    static interleave_job jobs[COUNT];
    static given times[COUNT] = {{.share = 2}, {.share = 1}, {.share = 1.3}, {.share = 1.1}, {.share = 40}};
    static const unsigned runs[COUNT] = {5, 8, 7, 8, 1}; /* of a round, so that each gets a fair part of it */
    interleave_job *all[COUNT];
    for (size_t k = 0; k < COUNT; k++) {
        jobs[k] = (interleave_job){.run = take_constant, .context = &times[k], .counts = &times[k].seconds};
        jobs[k].group = k == FIRST || k == ALONE ? NULL : "a";
        all[k] = &jobs[k];
    }
    interleave(all, COUNT, &(interleave_limits){.width = 0.01, .seconds = 1e6, .seed = 1});
    for (size_t k = 0; k < COUNT; k++)
        check(jobs[k].seconds.n == (k == SLOW ? 3 : INTERLEAVE_LEAST) &&
                  times[k].rounds == 1 + runs[k] * (jobs[k].seconds.n - 1),
              "job %zu: %zu rounds, %u runs", k, jobs[k].seconds.n, times[k].rounds);
    check(jobs[FAST].best && !jobs[SLOW].best && !jobs[SLOW].converged, "the fastest of a group is another");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(location),
        cmocka_unit_test(interval_ranks),
        cmocka_unit_test(ratios_are_of_rounds),
        cmocka_unit_test(clearly_slower_ones_of_a_group_end),
    };
    return cmocka_run_group_tests_name("bench_statistics", tests, NULL, NULL);
}
