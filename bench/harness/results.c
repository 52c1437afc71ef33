/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/results.h"

#include "harness/harness_memory.h"

#include <stdlib.h>
#include <string.h>

bool results_write(io_output *out, json_t *line, io_error *error) {
    char *text = out->file ? json_dumps(line, JSON_COMPACT | JSON_PRESERVE_ORDER) : NULL;
    if (out->file && text == NULL) memory_end();
    const bool good =
        text == NULL || (io_output_write(out, text, strlen(text), error) && io_output_write(out, "\n", 1, error));
    free(text);
    json_decref(line);
    return good;
}

/* The next of the names in keys; false if there is none. */
static bool next_key(const char **keys, char key[64]) {
    const size_t length = strcspn(*keys, " ");
    snprintf(key, 64, "%.*s", (int)length, *keys);
    *keys += length + strspn(*keys + length, " ");
    return length > 0;
}

void results_set_texts(json_t *object, const char *keys, const char *const *texts) {
    char key[64];
    for (; next_key(&keys, key); texts++) json_object_set_new(object, key, *texts ? json_string(*texts) : json_null());
}

void results_set_numbers(json_t *object, const char *keys, const double *values) {
    char key[64];
    while (next_key(&keys, key)) json_object_set_new(object, key, json_real(*values++));
}

void results_set_counts(json_t *object, const char *keys, const size_t *values) {
    char key[64];
    while (next_key(&keys, key)) json_object_set_new(object, key, json_integer((json_int_t)*values++));
}

json_t *results_agreement(const agreement *a) {
    json_t *object = json_object(), *why = json_object();
    for (int r = 0; r < AGREE_REASON_COUNT; r++)
        results_set_counts(why, agree_reason_name((agree_reason)r), &a->why[r]);
    results_set_counts(
        object, "rays hits_reference hits only_reference only_this far other_triangle same_bits",
        (size_t[]){a->rays, a->hits_a, a->hits_b, a->only_a, a->only_b, a->far, a->other_triangle, a->same_bits});
    json_object_set_new(object, "why", why);
    return object;
}

const char *results_text(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

double results_number(const json_t *object, const char *key) { return json_number_value(json_object_get(object, key)); }
