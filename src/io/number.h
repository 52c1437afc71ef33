/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers in files and options: as C writes them, with a decimal point, whatever locale the process has set. These are
 * the only functions that read and write them: strtod in a process with a decimal comma stops at the point. */
#ifndef CELLWALK_IO_NUMBER_H
#define CELLWALK_IO_NUMBER_H

#include <locale.h>
#include <stdarg.h>
#include <stdio.h>

/* strtod and strtof. end may be NULL. */
double number_read(const char *text, char **end);
float number_read_float(const char *text, char **end);

/* For more than one call: from here on this thread's numbers are plain, until uselocale sets the result back. */
locale_t number_enter_plain(void);

/* vfprintf. */
__attribute__((format(printf, 2, 0))) int number_print(FILE *file, const char *format, va_list arguments);

#endif
