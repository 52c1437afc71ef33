/* SPDX-License-Identifier: Apache-2.0 */
/* The C library's own conversions of decimal numbers, with a point in any locale. */
#ifndef CELLWALK_TESTS_PLAIN_H
#define CELLWALK_TESTS_PLAIN_H

#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static inline locale_t plain_enter(void) { return uselocale(newlocale(LC_ALL_MASK, "C", (locale_t)0)); }

static inline double plain_double(const char *text) {
    const locale_t before = plain_enter();
    const double number = strtod(text, NULL);
    uselocale(before);
    return number;
}

static inline float plain_float(const char *text) {
    const locale_t before = plain_enter();
    const float number = strtof(text, NULL);
    uselocale(before);
    return number;
}

__attribute__((format(printf, 3, 4))) static inline void plain_print(char *text, size_t size, const char *format, ...) {
    const locale_t before = plain_enter();
    va_list list;
    va_start(list, format);
    vsnprintf(text, size, format, list);
    va_end(list);
    uselocale(before);
}

#endif
