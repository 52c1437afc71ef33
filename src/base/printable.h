/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BASE_PRINTABLE_H
#define CELLWALK_BASE_PRINTABLE_H

/* Names and words that come from a file may hold characters that command a terminal: C0, DEL and, in UTF-8, C1. */
static inline void make_printable(char *text) {
    for (unsigned char *c = (unsigned char *)text; *c; c++) {
        if (*c < 0x20 || *c == 0x7f) *c = '?';
        if (c[0] == 0xc2 && c[1] >= 0x80 && c[1] <= 0x9f) c[0] = c[1] = '?';
    }
}

#endif
