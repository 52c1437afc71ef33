/* SPDX-License-Identifier: Apache-2.0 */
/* Parameter lists of a .pbrt directive: pairs of "type name" and values. */
#ifndef CELLWALK_SCENE_PBRT_PARAMS_H
#define CELLWALK_SCENE_PBRT_PARAMS_H

#include "pbrt_lex.h"

/* The directive being read: what messages name. */
typedef struct pbrt_site {
    pbrt_source *source;
    size_t offset;
    const char *name; /* Shape "cylinder" */
} pbrt_site;

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
    pbrt_site site;
    char *class; /* the string before them, if there was one */
    pbrt_param list[PBRT_PARAMS_MAX];
    int count;
} pbrt_params;

/* "file:line: directive: …", at the directive or at another place; returns false. */
__attribute__((format(printf, 4, 5))) bool pbrt_fail_at(const pbrt_site *site, size_t offset, io_error *error,
                                                        const char *format, ...);
#define pbrt_fail(site, ...) pbrt_fail_at(site, (site)->offset, __VA_ARGS__)

/* Reads the string that follows a directive. The caller frees it; NULL on failure. */
char *pbrt_read_string(const pbrt_site *site, io_error *error);
/* Reads until something else than a parameter follows. On failure, too, pbrt_params_free is due. */
bool pbrt_params_read(pbrt_params *params, const pbrt_site *site, io_error *error);
/* The same, after a class, which must be the one given unless that is NULL. */
bool pbrt_class_read(pbrt_params *params, const pbrt_site *site, const char *class, io_error *error);
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
