/* SPDX-License-Identifier: Apache-2.0 */
/* Words on the command line and in the help. */
#ifndef CELLWALK_OPTIONS_WORDS_H
#define CELLWALK_OPTIONS_WORDS_H

#include <stdbool.h>
#include <stddef.h>

/* The one of count words that is closest to word, by edit distance, if it is close enough to be meant; else
 * NULL. Words may be NULL and are then passed over. */
const char *words_closest(const char *word, const char *const *words, size_t count);

/* Prints "PROGRAM NAME: WHAT 'word' is unknown; there are a, b, c" with the closest one before the list. Returns false. */
bool words_unknown(const char *name, const char *what, const char *word, const char *const *words, size_t count);

/* Columns of a terminal that so many bytes of UTF-8 take. */
size_t words_columns(const char *text, size_t bytes);

/* Prints so many bytes of text from column at on, which is where the cursor is, on lines of at most most columns; all but the
 * first begin at column hang. Line breaks are spaces. Where the cursor is then. */
size_t words_fold(const char *text, size_t bytes, size_t at, size_t hang, size_t most);

/* Prints text from column on, which is where the cursor is, on lines of at most 80 columns, all of them indented by column.
 * An empty line ends a paragraph. A line that begins with a space is one of a list: it begins on a new line, and goes
 * on, if it is too long, below the text behind its first gap of two spaces. All other line breaks are spaces. Ends with a
 * line break. */
void words_wrap(const char *text, size_t column);

#endif
