/* SPDX-License-Identifier: Apache-2.0 */
/* Lowest and highest of samples of which some are holes, and the least of two numbers. */
#ifndef CELLWALK_CORE_EXTENT_H
#define CELLWALK_CORE_EXTENT_H

#include <stddef.h>

/* a < b ? a : b with a the sample: a hole compares false and drops out; compilers turn it into one instruction. */
static inline float lower(float a, float b) { return a < b ? a : b; }
static inline float higher(float a, float b) { return a > b ? a : b; }

static inline size_t least(size_t a, size_t b) { return a < b ? a : b; }

#endif
