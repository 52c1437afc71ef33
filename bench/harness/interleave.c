/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/interleave.h"

#include "clock.h"
#include "harness/memory.h"
#include "workload/terrain.h"

#include <stdlib.h>

typedef struct samples {
    double seconds[INTERLEAVE_SAMPLES_MAX], ticks[INTERLEAVE_SAMPLES_MAX], sorted[INTERLEAVE_SAMPLES_MAX];
    double spent, cpu; /* seconds of the clock, of the CPU */
    size_t n;
    bool done;
} samples;

static void shuffle(size_t *order, size_t count, uint32_t seed, uint32_t round) {
    for (size_t k = count; k > 1; k--) {
        const size_t other = terrain_hash(seed, round, (uint32_t)k) % k, held = order[k - 1];
        order[k - 1] = order[other];
        order[other] = held;
    }
}

static void take_sample(interleave_job *job, samples *s) {
    const double start = clock_seconds(), cpu_start = clock_cpu_seconds();
    const uint64_t first = clock_ticks();
    job->run(job->context);
    const uint64_t last = clock_ticks();
    const double cpu = clock_cpu_seconds() - cpu_start, seconds = clock_seconds() - start;
    const double counts = job->by_clock ? seconds : cpu;
    s->seconds[s->n] = counts;
    s->ticks[s->n++] = (double)(last - first) * (counts / seconds);
    s->spent += seconds;
    s->cpu += cpu;
}

static statistics sorted_copy(samples *s, const double *from) {
    for (size_t k = 0; k < s->n; k++) s->sorted[k] = from[k];
    return statistics_of(s->sorted, s->n);
}

void interleave(interleave_job **jobs, size_t count, const interleave_limits *limits) {
    samples *all = memory(count, sizeof *all);
    size_t *order = memory(count, sizeof *order), running = count;
    const size_t most = limits->most < INTERLEAVE_SAMPLES_MAX ? limits->most : INTERLEAVE_SAMPLES_MAX;
    const double end = clock_seconds() + limits->seconds;
    for (size_t k = 0; k < count; k++) order[k] = k;
    for (uint32_t round = 0; running > 0; round++) {
        shuffle(order, count, limits->seed, round);
        for (size_t k = 0; k < count; k++) {
            samples *s = &all[order[k]];
            if (!s->done) take_sample(jobs[order[k]], s);
        }
        const bool late = clock_seconds() >= end;
        for (size_t k = 0; k < count; k++) {
            samples *s = &all[k];
            if (s->done) continue;
            const double share = 2 * limits->seconds / (double)count;
            /* A job that is slow as a whole is not repeated until it has eaten the others' time. */
            const bool slow = s->spent > share * (double)s->n;
            if (s->n < limits->least && !slow) continue;
            const statistics now = sorted_copy(s, s->seconds);
            jobs[k]->converged = now.sure && now.high - now.low <= limits->width * now.median;
            s->done = jobs[k]->converged || late || s->spent > share || s->n >= most;
            running -= s->done;
        }
    }
    for (size_t k = 0; k < count; k++) {
        jobs[k]->seconds = sorted_copy(&all[k], all[k].seconds);
        jobs[k]->ticks = sorted_copy(&all[k], all[k].ticks);
        jobs[k]->cpu_share = all[k].cpu / all[k].spent;
    }
    free(all);
    free(order);
}
