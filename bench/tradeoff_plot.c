/* SPDX-License-Identifier: Apache-2.0 */
/* Speed against error as a picture: two panels, a point a contender, a colour a mode, and the frontier as a line. */

#include "plot.h"
#include "plot_parts.h"
#include "results.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_MAX = 192, FIRST_LABEL = 10 };

typedef struct panel {
    const char *key, *flag, *title;
} panel;

static const panel panels[] = {
    {"wrong_answers_per_million", "frontier_answers", "wrong answers in a million rays"},
    {"off_cells_worst", "frontier_place", "worst height of a hit off the surface, in cells"},
};
enum { PANEL_COUNT = sizeof panels / sizeof panels[0] };

static bool is_summary(const json_t *line) { return strcmp(results_text(line, "kind"), "summary") == 0; }

static bool is_drawn(const json_t *line, const panel *p) {
    return is_summary(line) && !json_is_true(json_object_get(line, "partial")) && json_object_get(line, p->key) &&
           results_number(line, "mrays_per_s") > 0;
}

typedef struct axis {
    double low, high;  /* of the errors above 0 */
    double slow, fast; /* speeds */
    bool none;         /* some have none: they stand at the zero line, a decade below */
} axis;

static axis axis_of(const json_t *lines, const panel *p) {
    axis a = {0};
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_drawn(line, p)) continue;
        const double error = results_number(line, p->key);
        const double speed = results_number(line, "mrays_per_s");
        if (a.slow <= 0 || speed < a.slow) a.slow = speed;
        if (speed > a.fast) a.fast = speed;
        if (error <= 0) {
            a.none = true;
            continue;
        }
        if (a.low <= 0 || error < a.low) a.low = error;
        if (error > a.high) a.high = error;
    }
    if (a.high <= 0) a.low = a.high = 1;
    a.low = pow(10, floor(log10(a.low)));
    a.high = pow(10, ceil(log10(a.high * 1.01)));
    return a;
}

static double place(const axis *a, double error) { return error > 0 ? error : a->low / 10; }

static void put_data(FILE *to, const json_t *lines, const panel *p, const axis *a, const char *mode) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_drawn(line, p) && strcmp(results_text(line, "mode"), mode) == 0)
            fprintf(to, "%.6g %.6g\n", results_number(line, "mrays_per_s"), place(a, results_number(line, p->key)));
    }
}

static int by_speed(const void *a, const void *b) {
    const json_t *x = *(const json_t *const *)a, *y = *(const json_t *const *)b;
    const double u = results_number(x, "mrays_per_s"), v = results_number(y, "mrays_per_s");
    return (u > v) - (u < v);
}

/* From the slowest on the frontier to the fastest. */
static size_t frontier_of(const json_t *lines, const panel *p, const json_t **on) {
    const json_t *line;
    size_t count = 0, index;
    json_array_foreach(lines, index, line) {
        if (is_drawn(line, p) && json_is_true(json_object_get(line, p->flag)) && count < NAMES_MAX) on[count++] = line;
    }
    qsort(on, count, sizeof *on, by_speed);
    return count;
}

static void put_frontier(FILE *to, const json_t *lines, const panel *p, const axis *a) {
    const json_t *on[NAMES_MAX];
    const size_t count = frontier_of(lines, p, on);
    for (size_t k = 0; k < count; k++)
        fprintf(to, "%.6g %.6g\n", results_number(on[k], "mrays_per_s"), place(a, results_number(on[k], p->key)));
}

/* Names, to the right of their points: nothing on the frontier has a faster contender beside it at its error. */
static void put_names(FILE *to, const json_t *lines, const panel *p, const axis *a) {
    const json_t *on[NAMES_MAX];
    const size_t count = frontier_of(lines, p, on);
    for (size_t k = 0; k < count; k++)
        fprintf(to, "set label %zu \"%s\" at %.6g,%.6g left offset 1.6,0 textcolor '#7a7a7a' font 'sans-serif,11'\n",
                FIRST_LABEL + k, results_text(on[k], "contender"), results_number(on[k], "mrays_per_s"),
                place(a, results_number(on[k], p->key)));
}

static void drop_names(FILE *to, const json_t *lines, const panel *p) {
    const json_t *on[NAMES_MAX];
    const size_t count = frontier_of(lines, p, on);
    for (size_t k = 0; k < count; k++) fprintf(to, "unset label %zu\n", FIRST_LABEL + k);
}

/* Distinct modes that have a point, in order. */
static size_t modes_of(const json_t *lines, const char **modes) {
    size_t count = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_drawn(line, &panels[0])) continue;
        const char *mode = results_text(line, "mode");
        size_t k = 0;
        while (k < count && strcmp(modes[k], mode) != 0) k++;
        if (k == count && count < NAMES_MAX) modes[count++] = mode;
    }
    return count;
}

static void put_style_of(FILE *to, const char *mode, size_t *own, size_t *other) {
    const bool embree = strncmp(mode, "embree", 6) == 0;
    const size_t k = embree ? (*other)++ : (*own)++;
    fprintf(to, "pointtype %d pointsize 0.8 linecolor rgb '%s'",
            embree             ? 5
            : k < PLOT_COLOURS ? 7
                               : 9,
            embree ? plot_warm[k % PLOT_COLOURS] : plot_cool[k % PLOT_COLOURS]);
}

static void put_axis(FILE *to, const axis *a) {
    fprintf(to, "set xrange [%g:%g]\n", a->slow / 1.4, a->fast * 20); /* with room for names */
    fprintf(to, "set yrange [%g:%g]\nset format y '10^{%%T}'\nset ytics nomirror (", a->none ? a->low / 80 : a->low / 2,
            a->high * 6);
    if (a->none) fprintf(to, "'0' %g, ", a->low / 10);
    const int first = (int)lround(log10(a->low)), last = (int)lround(log10(a->high));
    const int every = last - first > 8 ? 2 : 1;
    for (int k = first; k <= last; k += every) fprintf(to, "%s'%g' 1e%d", k > first ? ", " : "", pow(10, k), k);
    fputs(") textcolor '#7a7a7a'\n", to);
}

bool plot_tradeoff(FILE *to, const json_t *lines) {
    const char *modes[NAMES_MAX];
    const size_t count = modes_of(lines, modes);
    if (count == 0) return false;
    const json_t *run = json_array_get(lines, 0);
    fprintf(to,
            "set label 1 \"Speed against error\" at screen 0.5,0.965 center textcolor '#7a7a7a' font 'sans-serif,15'\n"
            "set label 2 \"%s, %s, %s, Cellwalk %s (%.10s), ",
            results_text(run, "cpu"), results_text(run, "isa"), results_text(run, "compiler"),
            results_text(run, "cellwalk"), results_text(run, "commit"));
    if (*results_text(run, "embree")) fprintf(to, "Embree %s, ", results_text(run, "embree"));
    fprintf(to, "one thread, load %.1f, %.10s\" at screen 0.5,0.915 center textcolor '#7a7a7a' font 'sans-serif,11'\n",
            results_number(run, "load"), results_text(run, "date"));
    axis axes[PANEL_COUNT];
    for (size_t p = 0; p < PANEL_COUNT; p++) {
        axes[p] = axis_of(lines, &panels[p]);
        for (size_t m = 0; m < count; m++) {
            fprintf(to, "$points%zu_%zu << END\n", p, m);
            put_data(to, lines, &panels[p], &axes[p], modes[m]);
            fputs("END\n", to);
        }
        fprintf(to, "$frontier%zu << END\n", p);
        put_frontier(to, lines, &panels[p], &axes[p]);
        fputs("END\n", to);
    }
    fputs("set logscale xy\nset grid xtics ytics linecolor '#7a7a7a' linewidth 0.4 dashtype 3\nunset key\n"
          "set multiplot layout 1,2 margins 0.08,0.97,0.26,0.80 spacing 0.11,0\n"
          "set xlabel 'million rays / s' offset 0,0.5\n",
          to);
    for (size_t p = 0; p < PANEL_COUNT; p++) {
        fprintf(to, "set title '%s'\n", panels[p].title);
        put_axis(to, &axes[p]);
        put_names(to, lines, &panels[p], &axes[p]);
        fprintf(to, "plot $frontier%zu using 1:2 with lines linewidth 1.5 linecolor rgb '#7a7a7a'", p);
        size_t own = 0, other = 0;
        for (size_t m = 0; m < count; m++) {
            fprintf(to, ", $points%zu_%zu using 1:2 with points ", p, m);
            put_style_of(to, modes[m], &own, &other);
        }
        fprintf(to,
                ", $frontier%zu using 1:2 with points pointtype 6 pointsize 1.6 linewidth 1.5 linecolor rgb '#7a7a7a'\n"
                "unset label 1\nunset label 2\n",
                p);
        drop_names(to, lines, &panels[p]);
    }
    /* One legend for both: a plot without axes, of nothing. */
    fputs("set margins screen 0.04, screen 0.98, screen 0.01, screen 0.14\nunset logscale\n"
          "unset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset grid\n"
          "set key center center horizontal samplen 1 Left reverse\nset xrange [0:1]\nset yrange [1:2]\nplot ",
          to);
    size_t own = 0, other = 0;
    for (size_t m = 0; m < count; m++) {
        fprintf(to, "NaN title '%s' with points ", modes[m]);
        put_style_of(to, modes[m], &own, &other);
        fputs(", ", to);
    }
    fputs("NaN title 'frontier' with linespoints pointtype 6 pointsize 1.6 linewidth 1.5 linecolor rgb '#7a7a7a'\n"
          "unset multiplot\n",
          to);
    return true;
}
