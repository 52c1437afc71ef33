/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/stability/run.h"

#include "harness/results.h"
#include "harness/run_record.h"

static const char *const verdict_keys[VERDICTS] = {"right", "tie", "leak", "phantom", "wrong_surface"};

/* What a contender is before the reference: "reference", "same-bits", "own-rules". */
static const char *const roles[] = {"reference", "same-bits", "own-rules"};

static json_t *result_line(const tested *t, aim kind, const counts *c) {
    json_t *line = json_object();
    results_set_text(line, "kind", "result");
    results_set_text(line, "contender", t->contender.name);
    results_set_text(line, "role", roles[t->role]);
    results_set_text(line, "rays", aim_name(kind));
    results_set_count(line, "traced", c->rays);
    results_set_count(line, "hits", c->hits);
    results_set_count(line, "other_bits", c->other);
    if (t->role == ROLE_SAME_BITS) return line;
    results_set_count(line, "pass", c->pass);
    results_set_count(line, "leaks", c->leaks);
    results_set_count(line, "phantoms", c->phantoms);
    results_set_count(line, "decided_exactly", c->doubts);
    results_set_number(line, "residual", c->residual);
    results_set_number(line, "apart", c->apart);
    results_set_count(line, "sampled", c->sampled);
    json_t *verdicts = json_object();
    for (int v = 0; v < VERDICTS; v++) results_set_count(verdicts, verdict_keys[v], c->verdict[v]);
    json_object_set_new(line, "verdicts", verdicts);
    results_set_number(line, "t_error", c->t_error);
    json_t *ulp = json_array();
    for (int k = 0; k < ULP_BINS; k++) json_array_append_new(ulp, json_integer((json_int_t)c->ulp[k]));
    json_object_set_new(line, "t_error_ulp", ulp);
    return line;
}

static bool write_lines(io_output *out, const stability *s, double seconds, io_error *error) {
    json_t *run = run_record("stability", 0, -1);
    results_set_count(run, "part", s->range.part);
    results_set_count(run, "parts", s->range.parts);
    results_set_count(run, "first", s->range.first);
    results_set_count(run, "end", s->range.end);
    results_set_count(run, "batches", s->batches);
    results_set_count(run, "sample", s->sample);
    results_set_number(run, "seconds", seconds);
    if (!results_write(out, run, error)) return false;
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        json_t *line = json_object();
        results_set_text(line, "kind", "field");
        results_set_text(line, "field", s->field[f].aimed.samples.name);
        results_set_text(line, "text", s->field[f].aimed.text);
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
