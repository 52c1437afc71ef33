/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/summary.h"

#include "harness/results.h"
#include "harness/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CONTENDERS_MAX = 192, GROUPS_MAX = 256 };

/* ---- sums ---- */

/* Numbers of one contender, over the groups (a field, a class of rays) in which it ran. */
typedef struct series {
    double values[GROUPS_MAX];
    size_t n;
} series;

static void add(series *s, double value) {
    if (s->n < GROUPS_MAX) s->values[s->n++] = value;
}

static void add_member(series *s, const json_t *line, const char *key) {
    const json_t *value = json_object_get(line, key);
    if (value) add(s, json_number_value(value));
}

static void set_mean(json_t *line, const char *key, const series *s) {
    double sum = 0;
    for (size_t k = 0; k < s->n; k++) sum += s->values[k];
    if (s->n) results_set_number(line, key, sum / (double)s->n);
}

static void set_spread(json_t *line, const char *of, series *medians, series *worsts) {
    char key[64];
    if (worsts->n == 0) return;
    snprintf(key, sizeof key, "%s_median", of);
    results_set_number(line, key, statistics_of(medians->values, medians->n).median);
    snprintf(key, sizeof key, "%s_worst", of);
    statistics_of(worsts->values, worsts->n); /* sorts them */
    results_set_number(line, key, worsts->values[worsts->n - 1]);
}

enum { KINDS = 4 };
static const char *const rates[KINDS] = {"leaks", "phantoms", "wrong", "broken"};
static const char *const errors[KINDS] = {"t_ulp", "t_cells", "off_cells", "normal_degrees"};

static bool is_result_of(const json_t *line, const char *name) {
    return results_is(line, "result") && strcmp(results_text(line, "contender"), name) == 0;
}

/* groups, timed: how many there are, and how many of them are timed. */
static json_t *summary_of(const json_t *lines, const char *name, size_t groups, size_t timed) {
    series *const all = calloc(3 + 3 * KINDS, sizeof *all), *const speeds = all, *const sums = all + 1,
                  *const aimed = all + 2;
    series *const own = all + 3, *const medians = own + KINDS, *const worsts = medians + KINDS;
    size_t ran = 0, rays = 0, index;
    const json_t *line, *any = NULL;
    if (all == NULL) return NULL;
    json_array_foreach(lines, index, line) {
        if (!is_result_of(line, name)) continue;
        any = line;
        if (json_object_get(line, "left_out_seconds")) continue;
        const char *class = results_text(line, "rays");
        const bool is_aimed = strcmp(class, "vertices") == 0 || strcmp(class, "edges") == 0;
        double sum = 0;
        ran++;
        rays += (size_t)results_number(line, "ray_count");
        add_member(speeds, line, "mrays_per_s");
        for (int k = 0; k < KINDS; k++) {
            char key[64];
            snprintf(key, sizeof key, "%s_per_million", rates[k]);
            if (k < 3) sum += results_number(line, key);
            if (k == 3 || !is_aimed) add_member(&own[k], line, key);
            snprintf(key, sizeof key, "%s_median", errors[k]);
            add_member(&medians[k], line, key);
            snprintf(key, sizeof key, "%s_worst", errors[k]);
            add_member(&worsts[k], line, key);
        }
        add(sums, sum);
        if (is_aimed) add(aimed, sum);
    }
    json_t *s = json_object();
    results_set_texts(s, "kind contender mode kernel",
                      (const char *[]){"summary", name, results_text(any, "mode"), results_text(any, "kernel")});
    results_set_counts(s, "groups ray_count", (size_t[]){ran, rays});
    results_set_bool(s, "partial", ran < groups || speeds->n < timed);
    if (speeds->n) results_set_number(s, "mrays_per_s", statistics_geometric_mean(speeds->values, speeds->n));
    set_mean(s, "wrong_answers_per_million", sums);
    for (int k = 0; k < KINDS; k++) {
        char key[64];
        snprintf(key, sizeof key, "%s_per_million", rates[k]);
        set_mean(s, key, &own[k]);
        set_spread(s, errors[k], &medians[k], &worsts[k]);
    }
    set_mean(s, "aimed_wrong_answers_per_million", aimed);
    free(all);
    return s;
}

/* ---- frontiers ---- */

size_t summary_pareto(pareto_point *points, size_t count, double margin, size_t *order) {
    for (size_t k = 0; k < count; k++) points[k].frontier = false;
    double slowest = 0;
    for (size_t found = 0;; found++) {
        size_t best = count;
        for (size_t k = 0; k < count; k++) {
            const pareto_point *p = &points[k];
            if (!(p->speed > slowest && p->error >= 0)) continue;
            if (best == count || p->error < points[best].error ||
                (p->error == points[best].error && p->speed > points[best].speed))
                best = k;
        }
        if (best == count) return found;
        points[best].frontier = true;
        order[found] = best;
        slowest = points[best].speed * (1 + margin);
    }
}

/* Less is noise: what changes from run to run of the same program, as compare takes it. */
static const double step_margin = 0.02;

static void mark(json_t **summaries, size_t count, const char *key, const char *flag) {
    pareto_point points[CONTENDERS_MAX];
    size_t order[CONTENDERS_MAX];
    for (size_t k = 0; k < count; k++) {
        const json_t *error = json_object_get(summaries[k], key);
        const bool partial = json_is_true(json_object_get(summaries[k], "partial"));
        points[k].speed = partial ? 0 : results_number(summaries[k], "mrays_per_s");
        points[k].error = error ? json_number_value(error) : (double)NAN;
    }
    summary_pareto(points, count, step_margin, order);
    for (size_t k = 0; k < count; k++) results_set_bool(summaries[k], flag, points[k].frontier);
}

bool summary_add(json_t *lines, io_error *error) {
    const char *names[CONTENDERS_MAX];
    json_t *summaries[CONTENDERS_MAX];
    const size_t count = results_distinct(lines, "contender", names, CONTENDERS_MAX);
    size_t groups = 0, timed = 0, index, other;
    const json_t *line, *before;
    /* A group is counted at its first line, and as timed if any of its lines has a speed. */
    json_array_foreach(lines, index, line) {
        bool first = results_is(line, "result"), speed = false;
        json_array_foreach(lines, other, before) {
            if (!first || !results_is(before, "result") || !results_same(before, line, "field") ||
                !results_same(before, line, "rays"))
                continue;
            first = other >= index;
            speed = speed || json_object_get(before, "mrays_per_s");
        }
        groups += first;
        timed += first && speed;
    }
    for (size_t k = 0; k < count; k++) summaries[k] = summary_of(lines, names[k], groups, timed);
    mark(summaries, count, "wrong_answers_per_million", "frontier_answers");
    mark(summaries, count, "off_cells_worst", "frontier_place");
    bool good = true;
    for (size_t k = 0; k < count; k++) good = json_array_append_new(lines, summaries[k]) == 0 && good;
    return good || io_fail(error, "out of memory");
}

/* ---- for people ---- */

static int by_speed(const void *a, const void *b) {
    const json_t *x = *(const json_t *const *)a, *y = *(const json_t *const *)b;
    const double u = results_number(x, "mrays_per_s"), v = results_number(y, "mrays_per_s");
    return u != v ? (u < v ? 1 : -1) : strcmp(results_text(x, "contender"), results_text(y, "contender"));
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
    printf("\nIn a million rays; a: on the frontier of speed and wrong answers, h: of speed and height off "
           "the\nsurface, *: did not run everywhere.\n%-27s %8s %8s %8s %8s %8s %8s %9s\n",
           "mode / kernel", "Mrays/s", "leaks", "wrong", "phantoms", "beyond", "aimed", "cells off");
    for (size_t k = 0; k < count; k++) {
        printf("%-27s", results_text(all[k], "contender"));
        for (size_t n = 0; n < sizeof keys / sizeof keys[0]; n++) {
            char text[32] = "";
            if (json_object_get(all[k], keys[n])) snprintf(text, sizeof text, "%.3g", results_number(all[k], keys[n]));
            printf(" %*s", n == 6 ? 9 : 8, text);
        }
        printf(" %s%s%s\n", json_is_true(json_object_get(all[k], "frontier_answers")) ? "a" : "",
               json_is_true(json_object_get(all[k], "frontier_place")) ? "h" : "",
               json_is_true(json_object_get(all[k], "partial")) ? "*" : "");
    }
}
