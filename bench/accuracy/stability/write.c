/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/stability/run.h"

#include "harness/results.h"
#include "harness/run_record.h"

/* What a contender is before the reference: "reference", "same-bits", "own-rules". */
static const char *const roles[] = {"reference", "same-bits", "own-rules"};

static json_t *result_line(const tested *t, aim kind, const counts *c) {
    json_t *line = json_object(), *verdicts = json_object();
    results_set_texts(line, "kind contender role rays",
                      (const char *[]){"result", t->contender.name, roles[t->role], aim_name(kind)});
    results_set_counts(line, "traced hits other_bits", (size_t[]){c->rays, c->hits, c->other});
    if (t->role == ROLE_SAME_BITS) {
        json_decref(verdicts);
        return line;
    }
    results_set_counts(line, "pass leaks phantoms decided_exactly sampled",
                       (size_t[]){c->pass, c->leaks, c->phantoms, c->doubts, c->sampled});
    results_set_numbers(line, "residual apart t_error", (double[]){c->residual, c->apart, c->t_error});
    results_set_counts(verdicts, "right tie leak phantom wrong_surface", c->verdict);
    json_object_set_new(line, "verdicts", verdicts);
    json_t *ulp = json_array();
    for (int k = 0; k < ULP_BINS; k++) json_array_append_new(ulp, json_integer((json_int_t)c->ulp[k]));
    json_object_set_new(line, "t_error_ulp", ulp);
    return line;
}

static bool write_lines(io_output *out, const stability *s, double seconds, io_error *error) {
    json_t *run = run_record("stability", 0, -1);
    results_set_counts(run, "part parts first end batches sample",
                       (size_t[]){s->range.part, s->range.parts, s->range.first, s->range.end, s->batches, s->sample});
    results_set_number(run, "seconds", seconds);
    if (!results_write(out, run, error)) return false;
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        json_t *line = json_object();
        results_set_texts(line, "kind field text",
                          (const char *[]){"field", s->field[f].aimed.samples.name, s->field[f].aimed.text});
        if (!results_write(out, line, error)) return false;
    }
    for (unsigned n = 0; n < s->contenders; n++)
        for (int kind = 0; kind < AIM_COUNT; kind++) {
            const counts *c = &s->count[n][kind];
            if (c->rays && !results_write(out, result_line(&s->tested[0][n], (aim)kind, c), error)) return false;
        }
    return true;
}

bool stability_write(const stability *s, const char *path, double seconds, io_error *error) {
    io_output out = {0};
    const bool good =
        io_output_open(&out, path, error) && write_lines(&out, s, seconds, error) && io_output_commit(&out, error);
    io_output_discard(&out);
    return good;
}
