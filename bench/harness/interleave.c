/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/interleave.h"

#include "clock.h"
#include "harness/harness_memory.h"
#include "workload/fractal_terrain.h"

#include <stdlib.h>
#include <string.h>

static void shuffle(size_t *order, size_t count, uint32_t seed, uint32_t round) {
    for (size_t k = count; k > 1; k--) {
        const size_t other = terrain_hash(seed, round, (uint32_t)k) % k, held = order[k - 1];
        order[k - 1] = order[other];
        order[other] = held;
    }
}

static double time_of(interleave_job *job) {
    const double start = clock_seconds(), cpu_start = clock_cpu_seconds();
    job->run(job->context);
    if (job->counts) return *job->counts;
    return job->by_clock ? clock_seconds() - start : clock_cpu_seconds() - cpu_start;
}

static statistics summary(const double *values, size_t n) {
    double sorted[INTERLEAVE_MOST];
    for (size_t k = 0; k < n; k++) sorted[k] = values[k];
    return statistics_of(sorted, n);
}

statistics interleave_ratio(const interleave_job *a, const interleave_job *b) {
    double ratios[INTERLEAVE_MOST];
    for (size_t k = 0; k < a->seconds.n; k++) ratios[k] = a->times[k] / b->times[k];
    return summary(ratios, a->seconds.n);
}

static bool is_narrow(const statistics *s, double width) { return s->sure && s->high - s->low <= width * s->median; }

static bool is_best(interleave_job *const *jobs, size_t count, const interleave_job *of) {
    bool best = true;
    for (size_t k = 0; k < count && of->group; k++)
        best = best && !(jobs[k]->group && strcmp(jobs[k]->group, of->group) == 0 &&
                         jobs[k]->seconds.median < of->seconds.median);
    return best;
}

/* True if all that count have converged in n rounds. */
static bool judge(interleave_job **jobs, size_t count, size_t n, double width) {
    bool all = true;
    for (size_t k = 0; k < count; k++) jobs[k]->seconds = summary(jobs[k]->times, n);
    for (size_t k = 0; k < count; k++) {
        jobs[k]->best = is_best(jobs, count, jobs[k]);
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
    for (size_t k = 0; k < count; k++) order[k] = k;
    for (uint32_t round = 0; count > 0 && round < INTERLEAVE_MOST; round++) {
        shuffle(order, count, limits->seed, round);
        for (size_t k = 0; k < count; k++) jobs[order[k]]->times[round] = time_of(jobs[order[k]]);
        if (judge(jobs, count, round + 1, limits->width) || clock_seconds() >= end) break;
    }
    free(order);
}
