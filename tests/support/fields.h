/* SPDX-License-Identifier: Apache-2.0 */
/* Height fields that are hard on a tracer, by shape and size, from a seed. */
#ifndef CELLWALK_TESTS_FIELDS_H
#define CELLWALK_TESTS_FIELDS_H

#include "cellwalk.h"
#include "workload/random.h"

typedef enum field_shape {
    FIELD_RANDOM,   /* uniform in [0, 1) */
    FIELD_FLAT,     /* one height, not 0 */
    FIELD_PLANE,    /* a slope with small-integer rise: every triangle in one plane, exactly */
    FIELD_CLIFF,    /* 0 beside 10^6 */
    FIELD_SPIKES,   /* 0 with single samples up to 1000 */
    FIELD_CHECKER,  /* alternating 0 and 1 */
    FIELD_INTEGERS, /* -2 … 2, where most geometry is exact in float */
    FIELD_TINY,     /* random of size 1e-30 */
    FIELD_HUGE,     /* random of size 1e30 */
    FIELD_GENTLE,   /* a plane of slopes 5e-5 and 3e-5 with ripples a thousandth of that */
    FIELD_MIXED,    /* samples of sizes between 1e-30 and 1e30 */
    FIELD_HOLES,    /* uniform in [0, 1), one sample in seven NaN */
    FIELD_SHAPES,
    /* Heights that are denormal. Möller and Trumbore's test has no error bound for them, and most rays that are aimed
     * at them count as level. */
    FIELD_FAINT = FIELD_SHAPES, /* random of size 2^-136: floats there have 13 bits */
    FIELD_LEAST,                /* 0 … 4 times the smallest float */
    FIELD_ALL_SHAPES
} field_shape;

typedef struct field_size {
    size_t nx, ny;
} field_size;
/* 2 × 2, one cell wide, one cell long, square and neither square nor a power of two. */
enum { FIELD_SIZES = 6 };
extern const field_size field_sizes[FIELD_SIZES];
enum { FIELD_SAMPLES_MAX = 1 << 16 };

/* A shape in a size, with facts for the ray generators. */
typedef struct test_field {
    field_shape shape;
    size_t nx, ny;
    float low, high;            /* over samples that are not holes */
    float z[FIELD_SAMPLES_MAX]; /* sample (i, j) is z[j * nx + i] */
} test_field;

void field_make(test_field *f, field_shape shape, size_t nx, size_t ny, uint64_t seed);

/* Rolling land with ripples, and mountains far away, so that blocks before them are passed over. */
void field_make_land(test_field *f, size_t nx, size_t ny);

/* The library's field over f's samples, which are borrowed, with the structures of every kernel built. */
cw_field *field_open(const test_field *f);

/* To stdout, each sample as a hexadecimal float; a field of more than 64 samples by its name alone. */
void field_print(const test_field *f);

#endif
