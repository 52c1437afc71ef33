/* SPDX-License-Identifier: Apache-2.0 */
/* Seeded random numbers: splitmix64 (Steele, Lea and Flood 2014), so that a failure can be repeated on any machine. */
#ifndef CELLWALK_BENCH_WORKLOAD_RANDOM_H
#define CELLWALK_BENCH_WORKLOAD_RANDOM_H

#include <stddef.h>
#include <stdint.h>

typedef struct random_state {
    uint64_t state;
} random_state;

static inline uint64_t random_bits(random_state *r) {
    uint64_t z = r->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* In [0, 1), a multiple of 2^-53. */
static inline double random_unit(random_state *r) { return (double)(random_bits(r) >> 11) * 0x1p-53; }

static inline double random_between(random_state *r, double low, double high) {
    return low + (high - low) * random_unit(r);
}

/* In [0, n), n small. */
static inline size_t random_below(random_state *r, size_t n) { return (size_t)((random_bits(r) >> 32) * n >> 32); }

#endif
