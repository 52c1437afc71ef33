/* SPDX-License-Identifier: Apache-2.0 */
/* Results as JSON lines: one object a line, the first of kind "run" (harness_run.h). */
#ifndef CELLWALK_BENCH_HARNESS_RESULTS_H
#define CELLWALK_BENCH_HARNESS_RESULTS_H

#include "harness/agree.h"
#include "io_error.h"
#include "output.h"

#include <jansson.h>

/* Appends a line and takes over the reference to it; only that if out is not open. */
bool results_write(io_output *out, json_t *line, io_error *error);

/* Add members, whose names stand in keys with a space between. */
void results_set_texts(json_t *object, const char *keys, const char *const *texts);
void results_set_numbers(json_t *object, const char *keys, const double *values);
void results_set_counts(json_t *object, const char *keys, const size_t *values);

/* agree.h as an object. */
json_t *results_agreement(const agreement *a);

/* Members of an object; "" and 0 where there is none. */
const char *results_text(const json_t *object, const char *key);
double results_number(const json_t *object, const char *key);

#endif
