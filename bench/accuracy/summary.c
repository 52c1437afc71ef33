/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/summary.h"

#include "accuracy/pareto.h"
#include "harness/results.h"
#include "harness/statistics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CONTENDERS_MAX = 192, GROUPS_MAX = 256 };

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
        if (!results_is(line, "result")) continue;
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
        if (!results_is(line, "result") || strcmp(results_text(line, "contender"), name) != 0) continue;
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
    const char *key, *flag;
} frontier;

static const frontier frontiers[] = {
    {"wrong_answers_per_million", "frontier_answers"},
    {"off_cells_worst", "frontier_place"},
};
enum { FRONTIER_COUNT = sizeof frontiers / sizeof frontiers[0] };

/* Less is noise: what changes from run to run of the same program, as compare takes it. */
static const double step_margin = 0.02;

static void mark(const frontier *f, json_t **summaries, size_t count) {
    tradeoff_point points[CONTENDERS_MAX];
    size_t order[CONTENDERS_MAX];
    for (size_t k = 0; k < count; k++) {
        const bool partial = json_is_true(json_object_get(summaries[k], "partial"));
        const json_t *error = json_object_get(summaries[k], f->key);
        points[k].speed = partial ? 0 : results_number(summaries[k], "mrays_per_s");
        points[k].error = error ? json_number_value(error) : (double)NAN;
    }
    tradeoff_pareto(points, count, step_margin, order);
    for (size_t k = 0; k < count; k++) results_set_bool(summaries[k], f->flag, points[k].frontier);
}

bool tradeoff_summarise(json_t *lines, io_error *error) {
    const char *names[CONTENDERS_MAX];
    json_t *summaries[CONTENDERS_MAX];
    const size_t count = results_distinct(lines, "result", "contender", names, CONTENDERS_MAX);
    const groups g = groups_of(lines);
    bool good = true;
    for (size_t k = 0; k < count; k++) summaries[k] = summary_of(lines, &g, names[k]);
    for (size_t f = 0; f < FRONTIER_COUNT; f++) mark(&frontiers[f], summaries, count);
    for (size_t k = 0; k < count; k++) good = json_array_append_new(lines, summaries[k]) == 0 && good;
    return good || io_fail(error, "out of memory");
}

/* ---- for people ---- */

static int by_speed(const void *a, const void *b) {
    const json_t *x = *(const json_t *const *)a, *y = *(const json_t *const *)b;
    const double u = results_number(x, "mrays_per_s"), v = results_number(y, "mrays_per_s");
    if (u != v) return u < v ? 1 : -1;
    return strcmp(results_text(x, "contender"), results_text(y, "contender"));
}

static void print_number(const json_t *line, const char *key) {
    if (json_object_get(line, key))
        printf(" %9.3g", results_number(line, key));
    else
        printf(" %9s", "");
}

void summary_print(const json_t *lines) {
    static const char *const keys[] = {"mrays_per_s",          "leaks_per_million",  "wrong_per_million",
                                       "phantoms_per_million", "broken_per_million", "aimed_wrong_answers_per_million",
                                       "off_cells_worst"};
    const json_t *all[CONTENDERS_MAX], *line;
    size_t count = 0, index;
    json_array_foreach(lines, index, line) {
        if (results_is(line, "summary") && results_number(line, "groups") > 0) all[count++] = line;
    }
    qsort(all, count, sizeof *all, by_speed);
    printf("In a million rays; a marks the frontier of speed and wrong answers, h that of speed and height off the "
           "surface,\n* who did not run everywhere.\n\n%-28s %9s %9s %9s %9s %9s %9s %9s\n",
           "mode / kernel", "Mrays/s", "leaks", "wrong", "phantoms", "beyond", "aimed", "cells off");
    for (size_t k = 0; k < count; k++) {
        printf("%-28s", results_text(all[k], "contender"));
        for (size_t n = 0; n < sizeof keys / sizeof keys[0]; n++) print_number(all[k], keys[n]);
        printf("  %s%s%s\n", json_is_true(json_object_get(all[k], "frontier_answers")) ? "a" : "",
               json_is_true(json_object_get(all[k], "frontier_place")) ? "h" : "",
               json_is_true(json_object_get(all[k], "partial")) ? "*" : "");
    }
}
