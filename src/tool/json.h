/* SPDX-License-Identifier: Apache-2.0 */
/* The little JSON that the program prints. */
#ifndef CELLWALK_TOOL_JSON_H
#define CELLWALK_TOOL_JSON_H

#include "printable.h"

#include <math.h>
#include <stdio.h>

/* Characters beyond ASCII pass as they are, but for those that command a terminal: their bytes become U+FFFD. */
static inline void json_string(FILE *to, const char *text) {
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

/* JSON has no word for infinities and NaN: they become null. */
static inline void json_number(FILE *to, double value) {
    if (isfinite(value))
        fprintf(to, "%.9g", value);
    else
        fputs("null", to);
}

#endif
