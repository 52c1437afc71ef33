/* SPDX-License-Identifier: Apache-2.0 */
/* Words on the command line and in the help. */
#include "command.h"

#include <stdio.h>
#include <string.h>

enum { WORD_MAX = 32, COLUMNS = 80 };

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

const char *words_closest(const char *word, const char *const *words, size_t count) {
    const char *best = NULL;
    size_t best_distance = strlen(word) / 3 + 2; /* a slip or two in a short word, more in a long one */
    for (size_t k = 0; k < count; k++) {
        const bool begun = word[0] != '\0' && strncmp(words[k], word, strlen(word)) == 0; /* as if a slip */
        const size_t distance = begun ? 1 : edit_distance(word, words[k]);
        if (distance < best_distance && distance < strlen(words[k])) best = words[k], best_distance = distance;
    }
    return best;
}

bool words_unknown(const char *name, const char *what, const char *word, const char *const *words, size_t count) {
    char list[512] = "";
    size_t used = 0;
    for (size_t k = 0; k < count && used < sizeof list; k++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", words[k]);
    const char *meant = words_closest(word, words, count);
    return meant ? command_refuse(name, "%s '%s' is unknown; did you mean %s? There are %s", what, word, meant, list)
                 : command_refuse(name, "%s '%s' is unknown; there are %s", what, word, list);
}

/* Columns of a terminal that so many bytes of UTF-8 take. */
static size_t columns_of(const char *text, size_t bytes) {
    size_t columns = 0;
    for (size_t k = 0; k < bytes; k++) columns += ((unsigned char)text[k] & 0xc0) != 0x80;
    return columns;
}

/* Prints so many bytes of text from column at on, which is where the cursor is; lines but the first begin at column
 * hang. Line breaks are spaces. Where the cursor is then. */
static size_t fold(const char *text, size_t bytes, size_t at, size_t hang) {
    for (const char *end = text + bytes; text < end;) {
        const size_t spaces = strspn(text, " \n"), length = strcspn(text + spaces, " \n");
        const size_t width = columns_of(text + spaces, length);
        if (at > hang && at + spaces + width > COLUMNS) {
            printf("\n%*s", (int)hang, "");
            at = hang;
        } else {
            printf("%*s", (int)spaces, "");
            at += spaces;
        }
        printf("%.*s", (int)length, text + spaces);
        at += width;
        text += spaces + length;
    }
    return at;
}

/* Where a line of a list goes on when it is wrapped: below the text behind the first gap of two spaces or more. */
static size_t hang_of(const char *line) {
    const size_t length = strcspn(line, "\n"), indent = strspn(line, " ");
    for (size_t k = indent; indent > 0 && k + 1 < length; k++)
        if (line[k] == ' ' && line[k + 1] == ' ') return columns_of(line, k + strspn(line + k, " "));
    return indent;
}

void words_wrap(const char *text, size_t column) {
    size_t at = column;
    while (*text) {
        /* Up to the end of the paragraph, or of the list's line. */
        size_t length = strcspn(text, "\n");
        while (text[length] == '\n' && !strchr("\n ", text[length + 1])) length += 1 + strcspn(text + length + 1, "\n");
        at = fold(text, length, at, column + hang_of(text));
        for (text += length; *text == '\n'; text++) {
            putchar('\n');
            at = 0;
        }
        if (at == 0 && *text) at = (size_t)printf("%*s", (int)column, "");
    }
    if (at > column) putchar('\n');
}
