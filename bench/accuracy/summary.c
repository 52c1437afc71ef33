/* SPDX-License-Identifier: Apache-2.0 */
/* What the results of tradeoff come to, from their JSON lines alone. */
#include "accuracy/tradeoff.h"

#include "harness/results.h"
#include "harness/statistics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CONTENDERS_MAX = 192, GROUPS_MAX = 256 };

/* ---- sums over the groups: a field and a class of rays each ---- */

/* How the numbers of a contender become one, and of which rays they are. */
typedef enum reduction { GEOMETRIC_MEAN, MEAN, MEDIAN, WORST } reduction;
typedef enum aims { ALL, AIMED, NOT_AIMED } aims;

static const char wrong_answers[] = "wrong_answers_per_million"; /* of whichever kind */

static const struct {
    const char *key;
    reduction by;
    aims of;
} members[] = {
    {"mrays_per_s", GEOMETRIC_MEAN, ALL},
    {"wrong_answers_per_million", MEAN, ALL},
    {"leaks_per_million", MEAN, NOT_AIMED},
    {"phantoms_per_million", MEAN, NOT_AIMED},
    {"wrong_per_million", MEAN, NOT_AIMED},
    {"broken_per_million", MEAN, ALL},
    {"aimed_wrong_answers_per_million", MEAN, AIMED},
    {"t_ulp_median", MEDIAN, ALL},
    {"t_ulp_worst", WORST, ALL},
    {"t_cells_median", MEDIAN, ALL},
    {"t_cells_worst", WORST, ALL},
    {"off_cells_median", MEDIAN, ALL},
    {"off_cells_worst", WORST, ALL},
    {"normal_degrees_median", MEDIAN, ALL},
    {"normal_degrees_worst", WORST, ALL},
};

static bool is_aimed(const json_t *line) {
    const char *rays = results_text(line, "rays");
    return strcmp(rays, "vertices") == 0 || strcmp(rays, "edges") == 0;
}

/* The contender's numbers under a key; how many groups have them. */
static size_t numbers_of(const json_t *lines, const char *name, const char *key, aims of, double *numbers) {
    size_t n = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        const bool sum = strcmp(key, wrong_answers) == 0;
        if (!results_is(line, "result") || strcmp(results_text(line, "contender"), name) != 0 || n == GROUPS_MAX ||
            (of != ALL && is_aimed(line) != (of == AIMED)) || !json_object_get(line, sum ? "ray_count" : key))
            continue;
        numbers[n++] = sum ? results_number(line, "leaks_per_million") + results_number(line, "phantoms_per_million") +
                                 results_number(line, "wrong_per_million")
                           : results_number(line, key);
    }
    return n;
}

static double reduce(double *numbers, size_t n, reduction by) {
    double sum = 0;
    for (size_t k = 0; k < n; k++) sum += numbers[k];
    if (by == GEOMETRIC_MEAN) return statistics_geometric_mean(numbers, n);
    if (by == MEAN) return sum / (double)n;
    const double median = statistics_of(numbers, n).median; /* sorts them */
    return by == MEDIAN ? median : numbers[n - 1];
}

/* In how many groups somebody has this member. */
static size_t groups_with(const json_t *lines, const char *key) {
    size_t groups = 0, index, other;
    const json_t *line, *before;
    json_array_foreach(lines, index, line) {
        bool first = results_is(line, "result") && json_object_get(line, key);
        json_array_foreach(lines, other, before) {
            if (!first || other == index) break;
            first = !results_is(before, "result") || !json_object_get(before, key) ||
                    !results_same(before, line, "field") || !results_same(before, line, "rays");
        }
        groups += first;
    }
    return groups;
}

static json_t *summary_of(const json_t *lines, const char *name, size_t groups, size_t timed) {
    double numbers[GROUPS_MAX], rays = 0;
    const char *slash = strchr(name, '/');
    char mode[64];
    const size_t ran = numbers_of(lines, name, "ray_count", ALL, numbers);
    for (size_t k = 0; k < ran; k++) rays += numbers[k];
    snprintf(mode, sizeof mode, "%.*s", (int)(slash - name), name);
    json_t *s = json_object();
    results_set_texts(s, "kind contender mode kernel", (const char *[]){"summary", name, mode, slash + 1});
    results_set_counts(s, "groups ray_count", (size_t[]){ran, (size_t)rays});
    results_set_bool(s, "partial", ran < groups || numbers_of(lines, name, "mrays_per_s", ALL, numbers) < timed);
    for (size_t m = 0; m < sizeof members / sizeof members[0]; m++) {
        const char *key = members[m].key + (members[m].of == AIMED ? strlen("aimed_") : 0);
        const size_t n = numbers_of(lines, name, key, members[m].of, numbers);
        if (n) results_set_number(s, members[m].key, reduce(numbers, n, members[m].by));
    }
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

void summary_add(json_t *lines) {
    const char *names[CONTENDERS_MAX];
    json_t *summaries[CONTENDERS_MAX];
    const size_t count = results_distinct(lines, "contender", names, CONTENDERS_MAX);
    const size_t groups = groups_with(lines, "contender"), timed = groups_with(lines, "mrays_per_s");
    for (size_t k = 0; k < count; k++) summaries[k] = summary_of(lines, names[k], groups, timed);
    mark(summaries, count, wrong_answers, "frontier_answers");
    mark(summaries, count, "off_cells_worst", "frontier_place");
    for (size_t k = 0; k < count; k++) results_append(lines, summaries[k]);
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
