/* SPDX-License-Identifier: Apache-2.0 */
/* The little JSON that the program prints. */
#ifndef CELLWALK_TOOL_JSON_H
#define CELLWALK_TOOL_JSON_H

#include <stdio.h>

/* Prints the format with ' for ". Values: %s a text as a JSON string, %b an int as true or false, %u a size_t, %g a
 * double of nine digits and %G of seventeen. JSON has no word for infinities, NaN and no text: they become null. */
void json_print(FILE *to, const char *format, ...);

#endif
