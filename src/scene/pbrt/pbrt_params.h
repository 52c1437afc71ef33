/* SPDX-License-Identifier: Apache-2.0 */
/* Parameter lists of a .pbrt directive: pairs of "type name" and values. */
#ifndef CELLWALK_SCENE_PBRT_PARAMS_H
#define CELLWALK_SCENE_PBRT_PARAMS_H

#include "pbrt_lex.h"

typedef struct pbrt_param {
    char type[16], name[32];
    size_t offset;
    size_t count;  /* values */
    float *floats; /* NULL where the values are strings */
    double first;  /* floats[0] before it was rounded */
    char *text;    /* the first string */
    bool used;
} pbrt_param;

enum { PBRT_PARAMS_MAX = 32 };

typedef struct pbrt_params {
    pbrt_source *source;
    const char *directive; /* for messages: Shape "cylinder" */
    pbrt_param list[PBRT_PARAMS_MAX];
    int count;
} pbrt_params;

/* "file:line: directive: …"; returns false. */
__attribute__((format(printf, 5, 6))) bool pbrt_fail(pbrt_source *s, size_t offset, const char *directive,
                                                     io_error *error, const char *format, ...);

/* Reads until something else than a parameter follows. On failure, too, pbrt_params_free is due. */
bool pbrt_params_read(pbrt_params *params, pbrt_source *s, const char *directive, io_error *error);
void pbrt_params_free(pbrt_params *params);

/* NULL if absent; else it counts as used. */
pbrt_param *pbrt_param_find(pbrt_params *params, const char *type, const char *name);

/* Each leaves *value alone if the parameter is absent, and fails if it has the wrong number of values or kind. */
bool pbrt_param_integer(pbrt_params *params, const char *name, long low, long high, long *value, io_error *error);
bool pbrt_param_float(pbrt_params *params, const char *name, double *value, io_error *error);
bool pbrt_param_colour(pbrt_params *params, const char *name, float value[3], io_error *error);
bool pbrt_param_string(pbrt_params *params, const char *type, const char *name, const char **value, io_error *error);

/* Fails if a parameter was not read, since its effect is not modelled. */
bool pbrt_params_all_used(const pbrt_params *params, io_error *error);

#endif
