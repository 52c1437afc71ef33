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

/* Appends a line to the array, for which memory is taken; line may be NULL. */
void results_append(json_t *lines, json_t *line);

/* Writes all lines of the array, to which the references stay the caller's. */
bool results_write_all(io_output *out, const json_t *lines, io_error *error);

/* Add members, whose names stand in keys with a space between. */
void results_set_texts(json_t *object, const char *keys, const char *const *texts);
void results_set_numbers(json_t *object, const char *keys, const double *values);
void results_set_counts(json_t *object, const char *keys, const size_t *values);

/* Members samples, seconds_min, _median, _low, _high, and interval_sure. */
struct statistics; /* interleave.h */
void results_set_seconds(json_t *object, const struct statistics *seconds);

/* agree.h as an object. */
json_t *results_agreement(const agreement *a);

/* Members of an object; "" and 0 where there is none. */
const char *results_text(const json_t *object, const char *key);
double results_number(const json_t *object, const char *key);

/* True if the line is of that kind. */
bool results_is(const json_t *line, const char *kind);
/* The texts that a member has in lines of kind "result", in order of first appearance; at most most of them. */
size_t results_distinct(const json_t *lines, const char *key, const char **texts, size_t most);

#endif
