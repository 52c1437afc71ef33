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

/* Prints text from column on, which is where the cursor is, on lines of at most 80 columns, all of them indented by column.
 * An empty line ends a paragraph. A line that begins with a space is one of a list: it begins on a new line, and goes
 * on, if it is too long, below the text behind its first gap of two spaces. All other line breaks are spaces. Ends with a
 * line break. */
void words_wrap(const char *text, size_t column);

#endif
