/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that describe an error in a sentence, and fail the cmocka test that runs. */
#ifndef CELLWALK_TESTS_CHECK_H
#define CELLWALK_TESTS_CHECK_H

#include "cellwalk.h"
#include "reference.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#pragma GCC diagnostic ignored                                                                                         \
    "-Wunused-parameter" /* tests, rows and what is called back have one form, and need not use all of it */

/* Every test in C tries the reference kernels like all others. */
__attribute__((constructor)) static void add_reference(void) { cw_reference_add(); }

/* Ends the test unless truth holds; the rest is printf's. */
__attribute__((format(printf, 2, 3))) static inline void check(bool truth, const char *format, ...) {
    if (truth) return;
    va_list list;
    va_start(list, format);
    vprint_error(format, list);
    va_end(list);
    print_error("\n");
    fail();
}

/* The number in an environment variable, but no less than this. */
static inline size_t test_number(const char *variable, size_t least) {
    const char *text = getenv(variable);
    const size_t number = text ? strtoul(text, NULL, 10) : least;
    return number > least ? number : least;
}

/* How often tests with random parts repeat themselves: once, or as often as the environment variable
 * CELLWALK_TEST_ROUNDS says for, each time with other numbers. */
static inline size_t test_rounds(void) { return test_number("CELLWALK_TEST_ROUNDS", 1); }

/* What tests divide their rays by where machine or build are slow (register.cmake), or where they have run in full
 * elsewhere: that, times the environment variable CELLWALK_TEST_DIVIDE. */
static inline size_t test_divisor(void) {
    size_t slow = TEST_SCALE_DOWN * test_number("CELLWALK_TEST_DIVIDE", 1);
#ifdef CELLWALK_EMULATES_AVX512 /* where the machine has it, emulated kernels only have to show that emulation works */
    if (__builtin_cpu_supports("avx512f")) slow *= 8;
#endif
    return slow;
}

/* That share of n, but no fewer than least, with which a test still means something. */
static inline size_t test_share(size_t n, size_t least) {
    const size_t share = n / test_divisor();
    return share > least ? share : least;
}

/* CELLWALK_TEST_TURN: a number, which .ci/run takes from the commit, so that in time each case is taken. */
static inline size_t test_turn(void) { return test_number("CELLWALK_TEST_TURN", 0); }

/* Whether case k is taken: one in so many of things too few to divide and unlike each other, at least one in most. */
static inline bool test_takes(size_t k, size_t most) {
    return (k + test_turn()) % (test_divisor() < most ? test_divisor() : most) == 0;
}

static inline void check_status(cw_status got, cw_status wanted) {
    check(got == wanted, "status \"%s\" instead of \"%s\"", cw_status_message(got), cw_status_message(wanted));
}

/* A field of a copy of these samples. */
static inline cw_field *field_of(const float *samples, size_t nx, size_t ny) {
    const cw_field_desc desc = {.samples = samples, .nx = nx, .ny = ny};
    cw_field *made;
    check_status(cw_field_create(&desc, NULL, &made), CW_OK);
    return made;
}

#endif
