/* SPDX-License-Identifier: Apache-2.0 */
#include "tradeoff_summary.h"

#include "results.h"
#include "statistics.h"
#include "tradeoff_pareto.h"

#include <math.h>
#include <string.h>

enum { CONTENDERS_MAX = 192, GROUPS_MAX = 256 };

static bool is_result(const json_t *line) { return strcmp(results_text(line, "kind"), "result") == 0; }

/* Groups that the results have, and those of them that are timed. */
typedef struct groups {
    const json_t *first[GROUPS_MAX]; /* a line of each */
    size_t count, timed;
} groups;

static bool is_group(const json_t *a, const json_t *b) {
    return strcmp(results_text(a, "field"), results_text(b, "field")) == 0 &&
           strcmp(results_text(a, "rays"), results_text(b, "rays")) == 0;
}

static groups groups_of(const json_t *lines) {
    groups g = {0};
    bool timed[GROUPS_MAX] = {false};
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_result(line)) continue;
        size_t k = 0;
        while (k < g.count && !is_group(g.first[k], line)) k++;
        if (k == GROUPS_MAX) continue;
        if (k == g.count) g.first[g.count++] = line;
        timed[k] = timed[k] || json_object_get(line, "mrays_per_s");
    }
    for (size_t k = 0; k < g.count; k++) g.timed += timed[k];
    return g;
}

/* ---- summaries ---- */

/* Numbers of one contender, over the groups in which it ran. */
typedef struct series {
    double values[GROUPS_MAX];
    size_t n;
} series;

static void add(series *s, const json_t *line, const char *key) {
    const json_t *value = json_object_get(line, key);
    if (value && s->n < GROUPS_MAX) s->values[s->n++] = json_number_value(value);
}

static double mean(const series *s) {
    double sum = 0;
    for (size_t k = 0; k < s->n; k++) sum += s->values[k];
    return s->n ? sum / (double)s->n : 0;
}

static void set_spread(json_t *line, const char *median, const char *worst, series *medians, const series *worsts) {
    if (worsts->n == 0) return;
    double most = 0;
    for (size_t k = 0; k < worsts->n; k++) most = fmax(most, worsts->values[k]);
    results_set_number(line, median, statistics_of(medians->values, medians->n).median);
    results_set_number(line, worst, most);
}

static bool is_aimed(const json_t *line) {
    const char *rays = results_text(line, "rays");
    return strcmp(rays, "vertices") == 0 || strcmp(rays, "edges") == 0;
}

enum { KINDS = 4 }; /* of rates, and of errors */

static json_t *summary_of(const json_t *lines, const groups *g, const char *name) {
    static const char *const rates[] = {"leaks", "phantoms", "wrong", "broken"};
    static const char *const errors[] = {"t_ulp", "t_cells", "off_cells", "normal_degrees"};
    series speeds = {.n = 0}, all = {.n = 0}, own[KINDS], aimed = {.n = 0}, medians[KINDS], worsts[KINDS];
    for (int k = 0; k < KINDS; k++) own[k].n = medians[k].n = worsts[k].n = 0;
    size_t ran = 0, rays = 0, index;
    const json_t *line, *any = NULL;
    json_array_foreach(lines, index, line) {
        if (!is_result(line) || strcmp(results_text(line, "contender"), name) != 0) continue;
        any = line;
        if (json_object_get(line, "left_out_seconds")) continue;
        ran++;
        rays += (size_t)results_number(line, "ray_count");
        add(&speeds, line, "mrays_per_s");
        double sum = 0;
        char key[64];
        for (int k = 0; k < KINDS; k++) {
            snprintf(key, sizeof key, "%s_per_million", rates[k]);
            if (k < 3) sum += results_number(line, key);
            if (k == 3 || !is_aimed(line)) add(&own[k], line, key);
            snprintf(key, sizeof key, "%s_median", errors[k]);
            add(&medians[k], line, key);
            snprintf(key, sizeof key, "%s_worst", errors[k]);
            add(&worsts[k], line, key);
        }
        if (all.n < GROUPS_MAX) all.values[all.n++] = sum;
        if (is_aimed(line) && aimed.n < GROUPS_MAX) aimed.values[aimed.n++] = sum;
    }
    json_t *s = json_object();
    results_set_text(s, "kind", "summary");
    results_set_text(s, "contender", name);
    results_set_text(s, "mode", results_text(any, "mode"));
    results_set_text(s, "kernel", results_text(any, "kernel"));
    results_set_count(s, "groups", ran);
    results_set_count(s, "ray_count", rays);
    results_set_bool(s, "partial", ran < g->count || speeds.n < g->timed);
    if (ran == 0) return s;
    if (speeds.n) results_set_number(s, "mrays_per_s", statistics_geometric_mean(speeds.values, speeds.n));
    results_set_number(s, "wrong_answers_per_million", mean(&all));
    for (int k = 0; k < KINDS; k++) {
        char key[64], worst[64];
        snprintf(key, sizeof key, "%s_per_million", rates[k]);
        if (own[k].n) results_set_number(s, key, mean(&own[k]));
        snprintf(key, sizeof key, "%s_median", errors[k]);
        snprintf(worst, sizeof worst, "%s_worst", errors[k]);
        set_spread(s, key, worst, &medians[k], &worsts[k]);
    }
    if (aimed.n) results_set_number(s, "aimed_wrong_answers_per_million", mean(&aimed));
    return s;
}

/* ---- frontiers ---- */

typedef struct frontier {
    const char *name, *key, *flag, *unit;
} frontier;

static const frontier frontiers[] = {
    {"answers", "wrong_answers_per_million", "frontier_answers", "wrong answers in a million rays"},
    {"place", "off_cells_worst", "frontier_place", "cells above or below the surface at worst"},
};
enum { FRONTIER_COUNT = sizeof frontiers / sizeof frontiers[0] };

/* With three digits, or whole from 1000 on. */
static void price(const frontier *f, const json_t *of, char *text, size_t size) {
    const double error = results_number(of, f->key);
    snprintf(text, size, error < 1000 ? "%.3g" : "%.0f", error);
}

static json_t *step_line(const frontier *f, const json_t *from, const json_t *to) {
    char text[512], before[32], after[32];
    const char *name = results_text(to, "contender");
    const double speed = results_number(to, "mrays_per_s");
    price(f, to, after, sizeof after);
    if (from == NULL) {
        snprintf(text, sizeof text, "%s is the fastest of those with the least error: %.3g Mrays/s, %s %s.", name,
                 speed, after, f->unit);
    } else {
        price(f, from, before, sizeof before);
        snprintf(text, sizeof text, "From %s to %s: %.1f %% faster, but %s instead of %s %s.",
                 results_text(from, "contender"), name, 100 * (speed / results_number(from, "mrays_per_s") - 1), after,
                 before, f->unit);
    }
    json_t *line = json_object();
    results_set_text(line, "kind", "step");
    results_set_text(line, "frontier", f->name);
    results_set_text(line, "from", from ? results_text(from, "contender") : NULL);
    results_set_text(line, "to", name);
    results_set_text(line, "text", text);
    return line;
}

/* Less is noise: what changes from run to run of the same program, as compare takes it. */
static const double step_margin = 0.02;

static bool mark(const frontier *f, json_t **summaries, size_t count, json_t *lines) {
    tradeoff_point points[CONTENDERS_MAX];
    size_t order[CONTENDERS_MAX];
    for (size_t k = 0; k < count; k++) {
        const bool partial = json_is_true(json_object_get(summaries[k], "partial"));
        const json_t *error = json_object_get(summaries[k], f->key);
        points[k].speed = partial ? 0 : results_number(summaries[k], "mrays_per_s");
        points[k].error = error ? json_number_value(error) : (double)NAN;
    }
    const size_t found = tradeoff_pareto(points, count, step_margin, order);
    for (size_t k = 0; k < count; k++) results_set_bool(summaries[k], f->flag, points[k].frontier);
    bool good = true;
    for (size_t k = 0; good && k < found; k++)
        good = json_array_append_new(lines,
                                     step_line(f, k > 0 ? summaries[order[k - 1]] : NULL, summaries[order[k]])) == 0;
    return good;
}

bool tradeoff_summarise(json_t *lines, io_error *error) {
    const char *names[CONTENDERS_MAX];
    json_t *summaries[CONTENDERS_MAX];
    const size_t count = results_distinct(lines, "contender", names, CONTENDERS_MAX);
    const groups g = groups_of(lines);
    bool good = true;
    for (size_t k = 0; k < count; k++) summaries[k] = summary_of(lines, &g, names[k]);
    for (size_t k = 0; k < count; k++) good = json_array_append_new(lines, summaries[k]) == 0 && good;
    for (size_t f = 0; good && f < FRONTIER_COUNT; f++) good = mark(&frontiers[f], summaries, count, lines);
    good = good && tradeoff_answer_claims(lines);
    return good || io_fail(error, "out of memory");
}
