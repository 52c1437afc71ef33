/* SPDX-License-Identifier: Apache-2.0 */
/* Checks that say what went wrong in a sentence, and fail the cmocka test that runs. */
#ifndef CELLWALK_TESTS_CHECK_H
#define CELLWALK_TESTS_CHECK_H

#include "cellwalk.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

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

/* How often tests with random parts repeat themselves: once, or what the environment variable CELLWALK_TEST_ROUNDS asks
 * for, each time with other numbers. */
static inline size_t test_rounds(void) {
    const char *text = getenv("CELLWALK_TEST_ROUNDS");
    const long rounds = text ? strtol(text, NULL, 10) : 1;
    return rounds > 1 ? (size_t)rounds : 1;
}

/* What tests of slow, emulated CPUs and kernels divide their rays by: the environment variable CELLWALK_TEST_DIVIDE, or 1. */
static inline size_t test_divisor(void) {
    const char *text = getenv("CELLWALK_TEST_DIVIDE");
    const long by = text ? strtol(text, NULL, 10) : 1;
    return by > 1 ? (size_t)by : 1;
}

/* That share of n, but never nothing. */
static inline size_t test_share(size_t n) { return n >= test_divisor() ? n / test_divisor() : n; }

static inline void check_status(cw_status got, cw_status wanted) {
    check(got == wanted, "status \"%s\" instead of \"%s\"", cw_status_message(got), cw_status_message(wanted));
}

#endif
