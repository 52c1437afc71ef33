/* SPDX-License-Identifier: Apache-2.0 */
/* Words, strings, numbers and brackets of a .pbrt file. */
#ifndef CELLWALK_SCENE_PBRT_LEX_H
#define CELLWALK_SCENE_PBRT_LEX_H

#include "io_error.h"

#include <stddef.h>

/* A file in memory. Lines are counted only when a message names one, from the last one named on. */
typedef struct pbrt_source {
    char *path;
    char *text; /* size bytes and a NUL */
    size_t size;
    size_t at;            /* where the next token is looked for */
    size_t counted, line; /* line breaks before offset counted */
} pbrt_source;

typedef enum pbrt_kind { PBRT_END, PBRT_WORD, PBRT_STRING, PBRT_NUMBER, PBRT_OPEN, PBRT_CLOSE, PBRT_BAD } pbrt_kind;

typedef struct pbrt_token {
    pbrt_kind kind;
    size_t offset;     /* in the file */
    const char *start; /* a string's without the quotes */
    size_t length;
    double number;
    const char *problem; /* of PBRT_BAD */
} pbrt_token;

bool pbrt_source_open(pbrt_source *s, const char *path, io_error *error);
void pbrt_source_close(pbrt_source *s);
size_t pbrt_line(pbrt_source *s, size_t offset);

pbrt_token pbrt_next(pbrt_source *s);

/* A number's value as a float, rounded once from the file's digits. */
float pbrt_float(const pbrt_token *token);

/* Reads plain numbers such as -0.25, rounded likewise, until most have been read or something else follows: a bracket,
 * or a number that only pbrt_next understands. Returns how many. */
size_t pbrt_plain_floats(pbrt_source *s, float *values, size_t most);

#endif
