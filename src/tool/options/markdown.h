/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_OPTIONS_MARKDOWN_H
#define CELLWALK_OPTIONS_MARKDOWN_H

/* Prints Markdown for a terminal of 100 columns: paragraphs are folded, tables have their columns side by side, those that are
 * beyond the 100th column below the others, with the first column again. In the head of a table a comma ends a line. */
void markdown_print(const char *text);

#endif
