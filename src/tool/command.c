/* SPDX-License-Identifier: Apache-2.0 */
#include "command.h"

#include "error.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int command_fail(const char *name, const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    io_make_printable(text);
    fprintf(stderr, "cellwalk %s: %s\n", name, text);
    return EXIT_FAILURE;
}

enum { WORD_MAX = 32 };

/* Levenshtein distance, one row at a time. Words longer than WORD_MAX are far from everything. */
static size_t edit_distance(const char *a, const char *b) {
    const size_t na = strlen(a), nb = strlen(b);
    if (na > WORD_MAX || nb > WORD_MAX) return WORD_MAX;
    size_t row[WORD_MAX + 1];
    for (size_t j = 0; j <= nb; j++) row[j] = j;
    for (size_t i = 1; i <= na; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= nb; j++) {
            const size_t replace = diagonal + (a[i - 1] != b[j - 1]);
            const size_t one_more = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            diagonal = row[j];
            row[j] = replace < one_more ? replace : one_more;
        }
    }
    return row[nb];
}

const char *closest_match(const char *word, const char *const *words, size_t count) {
    const char *best = NULL;
    size_t best_distance = strlen(word) / 3 + 2; /* a slip or two in a short word, more in a long one */
    for (size_t k = 0; k < count; k++) {
        if (words[k] == NULL) continue;
        const size_t distance = edit_distance(word, words[k]);
        if (distance < best_distance && distance < strlen(words[k])) {
            best = words[k];
            best_distance = distance;
        }
    }
    return best;
}
