/* SPDX-License-Identifier: Apache-2.0 */
/* Messages for a person: one line that names file, place and value. */
#ifndef CELLWALK_IO_IO_ERROR_H
#define CELLWALK_IO_IO_ERROR_H

#include "printable.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

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

/* Adds to a list in text, behind a comma unless it is the first; what has no room is cut. */
__attribute__((format(printf, 3, 4))) static inline void io_list(char *text, size_t size, const char *format, ...) {
    size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    if (used > 0 && used + 2 < size) used += (size_t)snprintf(text + used, size - used, ", ");
    vsnprintf(text + used, size - used, format, arguments);
    va_end(arguments);
}

/* Who is told of warnings, which are sentences without a full stop. call may be NULL: nobody. */
typedef struct io_warner {
    void (*call)(void *context, const char *text);
    void *context;
} io_warner;

__attribute__((format(printf, 2, 3))) static inline void io_warn(const io_warner *to, const char *format, ...) {
    char text[1024];
    if (to->call == NULL) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    to->call(to->context, text);
}

#endif
