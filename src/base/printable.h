/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BASE_PRINTABLE_H
#define CELLWALK_BASE_PRINTABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* How many bytes the character at c takes; 0 if it is none of UTF-8, or commands a terminal: C0, DEL, C1, and those
 * that turn the direction of text or end a line. */
static inline size_t printable_length(const unsigned char *c) {
    if (c[0] < 0x80) return c[0] >= 0x20 && c[0] != 0x7f;
    const size_t length = c[0] >= 0xf0 ? 4 : c[0] >= 0xe0 ? 3 : 2;
    unsigned long code = length == 4 ? c[0] & 7u : length == 3 ? c[0] & 15u : c[0] & 31u;
    if (c[0] < 0xc2 || c[0] > 0xf4) return 0;
    for (size_t k = 1; k < length; k++) {
        if ((c[k] & 0xc0) != 0x80) return 0;
        code = code << 6 | (c[k] & 0x3fu);
    }
    const bool overlong = code < (length == 4 ? 0x10000u : length == 3 ? 0x800u : 0x80u);
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    const bool turns = code == 0x61c || code == 0x200e || code == 0x200f || (code >= 0x2028 && code <= 0x202e) ||
                       (code >= 0x2066 && code <= 0x2069);
    return overlong || surrogate || code > 0x10ffff || code < 0xa0 || turns ? 0 : length;
}

/* Names and words that come from a file may hold more than text: all that is not becomes '?', byte by byte. */
static inline void make_printable(char *text) {
    for (unsigned char *c = (unsigned char *)text; *c;) {
        const size_t length = printable_length(c);
        if (length == 0) *c = '?';
        c += length > 0 ? length : 1;
    }
}

/* Prints such a name on standard output or elsewhere. */
static inline void print_text(FILE *to, const char *text) {
    for (const unsigned char *c = (const unsigned char *)text; *c;) {
        const size_t length = printable_length(c);
        if (length > 0)
            fwrite(c, 1, length, to);
        else
            fputc('?', to);
        c += length > 0 ? length : 1;
    }
}

#endif
