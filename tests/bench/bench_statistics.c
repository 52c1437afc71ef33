/* SPDX-License-Identifier: Apache-2.0 */
/* Medians, deviations, intervals and verdicts against samples worked out by hand. */
#include "harness/interleave.h"
#include "harness/statistics.h"

#include "check.h"

#include <math.h>

static void same(const char *what, double got, double wanted) {
    check(fabs(got - wanted) <= 1e-12 * fabs(wanted) + 1e-300, "%s is %.17g instead of %.17g", what, got, wanted);
}

static void location_and_spread(void **state) {
    (void)state;
    double odd[] = {9, 1, 4, 2, 100}; /* deviations from 4: 0 2 3 5 96 */
    statistics s = statistics_of(odd, 5);
    same("minimum", s.min, 1);
    same("median", s.median, 4);
    same("deviation", s.mad, 3);

    double even[] = {3, 1, 8, 6}; /* median 4.5, deviations 1.5 1.5 3.5 3.5 */
    s = statistics_of(even, 4);
    same("median", s.median, 4.5);
    same("deviation", s.mad, 2.5);

    double equal[] = {2, 2, 2};
    s = statistics_of(equal, 3);
    same("median", s.median, 2);
    check(s.mad == 0, "equal samples deviate by %g", s.mad);

    double one[] = {7};
    s = statistics_of(one, 1);
    same("median", s.median, 7);
    check(s.mad == 0 && s.low == 7 && s.high == 7 && !s.sure, "a single sample is not alone in its interval");

    s = statistics_of(one, 0);
    check(s.n == 0 && s.median == 0, "no samples have a median");
}

/* Against the definition, on all arrays of 0, 1, 2, 5 of up to 6 samples. */
static void deviations_by_definition(void **state) {
    (void)state;
    static const double values[] = {0, 1, 2, 5};
    for (size_t n = 1; n <= 6; n++)
        for (size_t code = 0; code < (size_t)1 << (2 * n); code++) {
            double samples[6], distances[6];
            for (size_t k = 0; k < n; k++) samples[k] = values[code >> 2 * k & 3];
            const statistics s = statistics_of(samples, n);
            for (size_t k = 0; k < n; k++) distances[k] = fabs(samples[k] - s.median);
            const double wanted = statistics_of(distances, n).median;
            check(s.mad == wanted, "deviation %g instead of %g (%zu samples, code %zu)", s.mad, wanted, n, code);
        }
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

static void verdicts(void **state) {
    (void)state;
    const statistics slow = {.n = 9, .median = 10, .low = 9.9, .high = 10.1, .sure = true};
    const statistics fast = {.n = 9, .median = 8, .low = 7.9, .high = 8.1, .sure = true};
    const statistics wide = {.n = 9, .median = 8, .low = 7, .high = 10, .sure = true};
    statistics few = fast;
    few.sure = false;
    check(statistics_ratio(&slow, &fast, 0.02).verdict == VERDICT_LOWER, "8 against 10 is not lower");
    check(statistics_ratio(&fast, &slow, 0.02).verdict == VERDICT_HIGHER, "10 against 8 is not higher");
    check(statistics_ratio(&slow, &slow, 0).verdict == VERDICT_UNDECIDED, "equal samples are told apart");
    check(statistics_ratio(&slow, &wide, 0).verdict == VERDICT_UNDECIDED, "overlapping intervals are told apart");
    check(statistics_ratio(&slow, &few, 0).verdict == VERDICT_UNDECIDED, "too few samples decide");
    check(statistics_ratio(&slow, &fast, 0.2).verdict == VERDICT_UNDECIDED, "a difference inside the margin decides");
    const ratio r = statistics_ratio(&slow, &fast, 0);
    same("ratio", r.value, 0.8);
    same("lower end", r.low, 7.9 / 10.1);
    same("upper end", r.high, 8.1 / 9.9);
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(location_and_spread),  cmocka_unit_test(deviations_by_definition),
        cmocka_unit_test(interval_ranks),       cmocka_unit_test(verdicts),
        cmocka_unit_test(ratios_are_of_rounds),
    };
    return cmocka_run_group_tests_name("bench_statistics", tests, NULL, NULL);
}
