/* SPDX-License-Identifier: Apache-2.0 */
#include "json.h"

#include "printable.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>

/* Characters beyond ASCII pass as they are, but for those that command a terminal: their bytes become U+FFFD. */
static void print_string(FILE *to, const char *text) {
    fputc('"', to);
    while (*text) {
        const unsigned char c = (unsigned char)*text;
        const size_t length = printable_length((const unsigned char *)text);
        if (c == '"' || c == '\\')
            fprintf(to, "\\%c", c);
        else if (length > 0)
            fwrite(text, 1, length, to);
        else
            fprintf(to, "\\u%04x", c < 0x80 ? c : 0xfffd);
        text += length > 0 ? length : 1;
    }
    fputc('"', to);
}

static void print_number(FILE *to, int digits, double value) {
    if (isfinite(value))
        fprintf(to, "%.*g", digits, value);
    else
        fputs("null", to);
}

void json_print(FILE *to, const char *format, ...) {
    va_list values;
    va_start(values, format);
    for (const char *c = format; *c; c++) {
        if (*c != '%') {
            fputc(*c == '\'' ? '"' : *c, to);
            continue;
        }
        const char *text;
        switch (*++c) {
        case 's':
            text = va_arg(values, const char *);
            if (text)
                print_string(to, text);
            else
                fputs("null", to);
            break;
        case 'b':
            fputs(va_arg(values, int) ? "true" : "false", to);
            break;
        case 'u':
            fprintf(to, "%zu", va_arg(values, size_t));
            break;
        default:
            print_number(to, *c == 'G' ? 17 : 9, va_arg(values, double));
        }
    }
    va_end(values);
}
