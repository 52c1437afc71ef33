/* SPDX-License-Identifier: Apache-2.0 */
/* An error message: one line that names file, place and value. */
#ifndef CELLWALK_IO_IO_ERROR_H
#define CELLWALK_IO_IO_ERROR_H

#include "printable.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>

typedef struct io_error {
    char text[512];
} io_error;

/* Fills error (which may be NULL) and returns false, so that a failing function ends with `return io_fail(…)`. */
__attribute__((format(printf, 2, 3))) static inline bool io_fail(io_error *error, const char *format, ...) {
    if (error == NULL) return false;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    make_printable(error->text);
    return false;
}

#endif
