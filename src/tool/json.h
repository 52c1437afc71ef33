/* SPDX-License-Identifier: Apache-2.0 */
/* The little JSON that the program prints. */
#ifndef CELLWALK_TOOL_JSON_H
#define CELLWALK_TOOL_JSON_H

#include <math.h>
#include <stdio.h>

/* Bytes beyond ASCII pass as they are: file names are UTF-8 on the systems that the tool runs on. */
static inline void json_string(FILE *to, const char *text) {
    fputc('"', to);
    for (; *text; text++) {
        const unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            fprintf(to, "\\%c", c);
        else if (c < 0x20)
            fprintf(to, "\\u%04x", c);
        else
            fputc(c, to);
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
