/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/timing.h"
#include "clock.h"

#include <sched.h>

double timing_tick_rate(void) {
    const double start = clock_seconds();
    const uint64_t first = timing_ticks();
    double now = start;
    while (now < start + 0.02) now = clock_seconds();
    return (double)(timing_ticks() - first) / (now - start);
}

int timing_pin(int cpu) {
    if (cpu < 0) cpu = sched_getcpu();
    if (cpu < 0 || cpu >= CPU_SETSIZE) return -1;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)cpu, &set);
    return sched_setaffinity(0, sizeof set, &set) == 0 ? cpu : -1;
}
