/* SPDX-License-Identifier: Apache-2.0 */
#include "number.h"

#include <pthread.h>
#include <stdlib.h>

static locale_t plain;

/* Of all categories: glibc has this one at hand, so that it cannot fail. */
static void make_plain(void) { plain = newlocale(LC_ALL_MASK, "C", (locale_t)0); }

locale_t number_enter_plain(void) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, make_plain);
    return uselocale(plain); /* 0 changes nothing */
}

double number_read(const char *text, char **end) {
    const locale_t before = number_enter_plain();
    const double number = strtod(text, end);
    uselocale(before);
    return number;
}

float number_read_float(const char *text, char **end) {
    const locale_t before = number_enter_plain();
    const float number = strtof(text, end);
    uselocale(before);
    return number;
}

int number_print(FILE *file, const char *format, va_list arguments) {
    const locale_t before = number_enter_plain();
    const int length = vfprintf(file, format, arguments);
    uselocale(before);
    return length;
}
