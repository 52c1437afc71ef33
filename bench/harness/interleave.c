/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/interleave.h"

#include "clock.h"
#include "harness/harness_memory.h"
#include "workload/fractal_terrain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- statistics ---- */

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double middle(const double *sorted, size_t n) {
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

int statistics_interval_rank(size_t n, double confidence) {
    /* [x(k), x(n - 1 - k)] misses the median if at most k samples lie on one side of it. */
    double tail = 0, term = pow(0.5, (double)n); /* n choose k, over 2^n */
    int k = 0;
    while ((size_t)k <= n / 2) {
        tail += term;
        if (1 - 2 * tail < confidence) break;
        term *= (double)(n - (size_t)k) / (double)(k + 1);
        k++;
    }
    return k - 1;
}

statistics statistics_of(double *samples, size_t n) {
    if (n == 0) return (statistics){0};
    qsort(samples, n, sizeof *samples, compare_doubles);
    statistics s = {.n = n, .min = samples[0], .median = middle(samples, n)};
    const int rank = statistics_interval_rank(n, STATISTICS_CONFIDENCE);
    const size_t drop = rank < 0 ? 0 : (size_t)rank;
    s.sure = rank >= 0;
    s.low = samples[drop];
    s.high = samples[n - 1 - drop];
    return s;
}

/* ---- rounds ---- */

enum { TRIAL = 3, RUNS_MOST = 8 };
#define SLOWER 1.2
#define SHARE  0.25

static void shuffle(size_t *order, size_t count, uint32_t seed, uint32_t round) {
    for (size_t k = count; k > 1; k--) {
        const size_t other = terrain_hash(seed, round, (uint32_t)k) % k, held = order[k - 1];
        order[k - 1] = order[other];
        order[other] = held;
    }
}

/* Of one run, the mean of as many as the job has in a round. */
static double time_of(interleave_job *job) {
    const double start = clock_seconds(), cpu_start = clock_cpu_seconds();
    double told = 0;
    for (unsigned k = 0; k < job->runs; k++) {
        job->run(job->context);
        if (job->counts) told += *job->counts;
    }
    const double passed = job->by_clock ? clock_seconds() - start : clock_cpu_seconds() - cpu_start;
    return (job->counts ? told : passed) / job->runs;
}

/* A short run beside a long one sees a moment of the machine where the other sees its mean, and rounds take as long as
 * the long one. So from the second round on each job gets SHARE of the longest one's time, in whole runs. */
static void set_runs(interleave_job **jobs, size_t count) {
    double longest = 0;
    for (size_t k = 0; k < count; k++) longest = fmax(longest, jobs[k]->times[0]);
    for (size_t k = 0; k < count; k++)
        jobs[k]->runs = (unsigned)fmax(1, fmin(RUNS_MOST, floor(SHARE * longest / jobs[k]->times[0])));
}

static statistics summary(const double *values, size_t n) {
    double sorted[INTERLEAVE_MOST];
    for (size_t k = 0; k < n; k++) sorted[k] = values[k];
    return statistics_of(sorted, n);
}

statistics interleave_ratio(const interleave_job *a, const interleave_job *b) {
    double ratios[INTERLEAVE_MOST];
    const size_t n = a->seconds.n < b->seconds.n ? a->seconds.n : b->seconds.n;
    for (size_t k = 0; k < n; k++) ratios[k] = a->times[k] / b->times[k];
    return summary(ratios, n);
}

static bool is_narrow(const statistics *s, double width) { return s->sure && s->high - s->low <= width * s->median; }

/* The fastest of a job's group so far. */
static const interleave_job *best_of(interleave_job *const *jobs, size_t count, const interleave_job *of) {
    const interleave_job *best = of;
    for (size_t k = 0; k < count && of->group; k++)
        if (jobs[k]->group && strcmp(jobs[k]->group, of->group) == 0 && !jobs[k]->ended &&
            jobs[k]->seconds.median < best->seconds.median)
            best = jobs[k];
    return best;
}

/* Clearly slower than its group's fastest, by SLOWER after at least TRIAL passes: it would take the others' time. */
static bool is_hopeless(const interleave_job *job, const interleave_job *best) {
    return job->seconds.n >= TRIAL && job->seconds.low > SLOWER * best->seconds.high;
}

/* After n rounds: true if all that count have converged. */
static bool judge(interleave_job **jobs, size_t count, size_t n, double width) {
    bool all = true;
    for (size_t k = 0; k < count; k++)
        if (!jobs[k]->ended) jobs[k]->seconds = summary(jobs[k]->times, n);
    for (size_t k = 0; k < count; k++) {
        const interleave_job *best = best_of(jobs, count, jobs[k]);
        jobs[k]->best = best == jobs[k] && !jobs[k]->ended;
        /* The first is what the others are measured against. */
        jobs[k]->ended = jobs[k]->ended || (k > 0 && is_hopeless(jobs[k], best));
        const statistics s = k ? interleave_ratio(jobs[k], jobs[0]) : jobs[0]->seconds;
        /* Alone, a job is measured against itself; else its ratio counts, and the first has none. */
        jobs[k]->converged = k == 0 && count > 1 ? s.sure : is_narrow(&s, width);
        all = all && (jobs[k]->converged || !jobs[k]->best);
    }
    return all;
}

void interleave(interleave_job **jobs, size_t count, const interleave_limits *limits) {
    size_t *order = memory(count, sizeof *order);
    const double end = clock_seconds() + limits->seconds;
    for (size_t k = 0; k < count; k++) {
        order[k] = k;
        jobs[k]->ended = false;
        jobs[k]->runs = 1;
    }
    for (uint32_t round = 0; count > 0 && round < INTERLEAVE_MOST; round++) {
        shuffle(order, count, limits->seed, round);
        for (size_t k = 0; k < count; k++)
            if (!jobs[order[k]]->ended) jobs[order[k]]->times[round] = time_of(jobs[order[k]]);
        if (round == 0) set_runs(jobs, count);
        if (judge(jobs, count, round + 1, limits->width) || clock_seconds() >= end) break;
    }
    free(order);
}
