/* SPDX-License-Identifier: Apache-2.0 */
/* What the pictures show, as gnuplot's commands with the data among them. */

#include "plot.h"
#include "plot_parts.h"
#include "results.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BARS_MAX = 10, SIDES_MAX = 16 };

const char *const plot_cool[PLOT_COLOURS] = {"#2f7fd1", "#109a8c", "#8468dc", "#5b8c2a", "#3f6f9f", "#b05fc0"};
const char *const plot_warm[PLOT_COLOURS] = {"#a8642a", "#e0892b", "#d9534f", "#9c8a1a", "#c0567f", "#8f6f3f"};

bool plot_is_embree(const char *name) { return strncmp(name, "embree/", 7) == 0; }

void plot_put_label(FILE *to, const char *name, const char *const *all, size_t count) {
    if (plot_is_embree(name)) {
        const char *geometry = name + 7, *width = strchr(geometry, '/');
        fprintf(to, "\"Embree %.*s", (int)strcspn(geometry, "/"), geometry);
        const size_t digits = width ? strspn(width + 2, "0123456789") : 0;
        if (digits) fprintf(to, ", %.*s wide%s", (int)digits, width + 2, width[2 + digits] ? " (split)" : "");
        fputc('"', to);
        return;
    }
    const size_t length = strcspn(name, "/");
    size_t same = 0;
    for (size_t k = 0; k < count; k++) same += strncmp(all[k], name, length) == 0 && all[k][length] == '/';
    if (same > 1)
        fprintf(to, "\"%s\"", name);
    else
        fprintf(to, "\"%.*s\"", (int)length, name);
}

double plot_speed_of(const json_t *lines, const char *field, const char *rays, const char *name) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), "result") == 0 && strcmp(results_text(line, "field"), field) == 0 &&
            strcmp(results_text(line, "rays"), rays) == 0 && strcmp(results_text(line, "contender"), name) == 0)
            return results_number(line, "mrays_per_s");
    }
    return 0;
}

static const json_t *field_line(const json_t *lines, const char *field) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), "field") == 0 && strcmp(results_text(line, "field"), field) == 0)
            return line;
    }
    return NULL;
}

void plot_put_titles(FILE *to, const json_t *lines, const char *what) {
    const json_t *run = json_array_get(lines, 0);
    const char *date = results_text(run, "date"), *embree = results_text(run, "embree");
    fprintf(to, "set label 1 \"%s\" at screen 0.5,0.965 center textcolor '#7a7a7a' font 'sans-serif,15'\n", what);
    fprintf(to, "set label 2 \"%s, %s, %s, Cellwalk %s (%.10s), ", results_text(run, "cpu"), results_text(run, "isa"),
            results_text(run, "compiler"), results_text(run, "cellwalk"), results_text(run, "commit"));
    if (*embree) fprintf(to, "Embree %s, ", embree);
    const char *threads = results_text(run, "threads");
    fprintf(to, "%s%s, load %.1f, %.10s\"", *threads ? threads : "one", *threads ? " threads" : " thread",
            results_number(run, "load"), date);
    fputs(" at screen 0.5,0.915 center textcolor '#7a7a7a' font 'sans-serif,11'\n", to);
}

/* ---- speed ---- */

/* The fastest of the contenders over all classes, in the order of the results; the rest would make hairlines of bars. */
static size_t choose_bars(const json_t *lines, const char *field, const char *const *rays, size_t ray_count,
                          const char **names, size_t count) {
    double sums[PLOT_NAMES_MAX];
    for (size_t k = 0; k < count; k++) {
        sums[k] = 0;
        for (size_t r = 0; r < ray_count; r++) sums[k] += plot_speed_of(lines, field, rays[r], names[k]);
    }
    size_t left = 0;
    for (size_t k = 0; k < count; k++) {
        size_t faster = 0;
        for (size_t n = 0; n < count; n++) faster += sums[n] > sums[k];
        if (sums[k] > 0 && faster < BARS_MAX && left < BARS_MAX) names[left++] = names[k];
    }
    return left;
}

bool plot_speed(FILE *to, const json_t *lines, const char *field) {
    const char *rays[PLOT_NAMES_MAX], *names[PLOT_NAMES_MAX];
    const size_t ray_count = results_distinct(lines, "rays", rays, PLOT_NAMES_MAX);
    size_t count = results_distinct(lines, "contender", names, PLOT_NAMES_MAX);
    count = choose_bars(lines, field, rays, ray_count, names, count);
    const json_t *about = field_line(lines, field);
    if (count == 0 || about == NULL) return false;

    char title[256];
    snprintf(title, sizeof title, "Speed by class of rays: field %s of %.0f × %.0f samples", field,
             results_number(about, "nx"), results_number(about, "ny"));
    plot_put_titles(to, lines, title);
    fputs("$data << END\n", to);
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "%s", rays[r]);
        for (size_t k = 0; k < count; k++) fprintf(to, " %.6g", plot_speed_of(lines, field, rays[r], names[k]));
        fputc('\n', to);
    }
    fputs("END\nset style data histogram\nset style histogram clustered gap 1.5\nset style fill solid 1 noborder\n"
          "set tmargin 5\nset key bottom outside center horizontal samplen 1.5 height 0.5 Left reverse\nset yrange "
          "[0:*]\nset "
          "ylabel 'million rays / s'\n"
          "set xtics scale 0\nplot ",
          to);
    size_t own = 0, other = 0;
    for (size_t k = 0; k < count; k++) {
        fprintf(to, "%s$data using %zu:xtic(1) title ", k ? ", " : "", k + 2);
        plot_put_label(to, names[k], names, count);
        fprintf(to, " linecolor rgb '%s'",
                plot_is_embree(names[k]) ? plot_warm[other++ % PLOT_COLOURS] : plot_cool[own++ % PLOT_COLOURS]);
    }
    fputc('\n', to);
    return true;
}

/* ---- over the side ---- */

typedef struct side {
    const char *field;
    double samples;
} side;

static int by_samples(const void *a, const void *b) {
    const side *left = a, *right = b;
    return (left->samples > right->samples) - (left->samples < right->samples);
}

/* Square land, smallest first: fields of one kind whose name is their side. */
static size_t sides_of(const json_t *lines, side sides[SIDES_MAX]) {
    size_t found = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        const double nx = results_number(line, "nx");
        if (results_is(line, "field", NULL) && found < SIDES_MAX && strtod(results_text(line, "field"), NULL) == nx)
            sides[found++] = (side){results_text(line, "field"), nx};
    }
    qsort(sides, found, sizeof *sides, by_samples);
    return found;
}

static void put_side_axis(FILE *to, const side *sides, size_t count) {
    fputs("set logscale xy\nset xtics (", to);
    for (size_t k = 0; k < count; k++) {
        const bool thousands = sides[k].samples >= 1024; /* 4097 and 8193 would touch in a narrow panel */
        fprintf(to, "%s'%.0f%s' %.0f", k ? ", " : "", thousands ? floor(sides[k].samples / 1024) : sides[k].samples,
                thousands ? "k" : "", sides[k].samples);
    }
    fprintf(to, ")\nset xrange [%g:%g]\n", sides[0].samples / 1.4, sides[count - 1].samples * 1.4);
}

/* Embree's fastest at this place; 0 if there is none. */
static double best_embree(const json_t *lines, const char *field, const char *rays, const char *const *names,
                          size_t count) {
    double best = 0;
    for (size_t k = 0; k < count; k++) {
        const double is = plot_is_embree(names[k]) ? plot_speed_of(lines, field, rays, names[k]) : 0;
        if (is > best) best = is;
    }
    return best;
}

void plot_put_point(FILE *to, double value, plot_span *range) {
    if (!(value > 0)) {
        fputs(" NaN", to);
        return;
    }
    fprintf(to, " %.6g", value);
    if (range->low <= 0 || value < range->low) range->low = value;
    if (value > range->high) range->high = value;
}

void plot_begin_legend(FILE *to) {
    fputs("set margins screen 0.08, screen 0.98, screen 0.01, screen 0.08\n"
          "unset title\nunset xlabel\nunset ylabel\nunset border\nunset tics\nunset grid\n"
          "set key center center horizontal maxrows 2 width -4 samplen 2 Left reverse\nset yrange [1:2]\nplot ",
          to);
}

void plot_begin_panels(FILE *to, size_t count, const plot_span *range) {
    const size_t columns = count < 3 ? count : 3;
    fprintf(to,
            "set multiplot layout %zu,%zu margins 0.08,0.98,0.19,0.83 spacing 0.06,0.13\nunset key\n"
            "set yrange [%g:%g]\nset ytics (0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300)\n",
            (count + columns - 1) / columns, columns, range->low / 1.3, range->high * 1.3);
}

void plot_begin_panel(FILE *to, size_t number, size_t count, const char *title, const char *x_label) {
    const size_t columns = count < 3 ? count : 3, rows = (count + columns - 1) / columns;
    if (number == 1) fputs("unset label 1\nunset label 2\n", to);
    fprintf(to, "set title '%s' offset 0,-0.6\n", title);
    fputs(number % columns == 0 ? "set ylabel 'million rays / s' textcolor '#7a7a7a'\n" : "unset ylabel\n", to);
    if (number / columns == rows - 1)
        fprintf(to, "set xlabel '%s' offset 0,0.7 textcolor '#7a7a7a'\n", x_label);
    else
        fputs("unset xlabel\n", to);
    fputs("plot ", to);
}

bool plot_scaling(FILE *to, const json_t *lines) {
    side sides[SIDES_MAX];
    const char *rays[PLOT_NAMES_MAX], *names[PLOT_NAMES_MAX];
    const size_t side_count = sides_of(lines, sides), ray_count = results_distinct(lines, "rays", rays, PLOT_NAMES_MAX);
    const size_t count = results_distinct(lines, "contender", names, PLOT_NAMES_MAX);
    if (side_count < 2 || ray_count == 0) return false;
    plot_put_titles(to, lines, "Speed over the side of the field, by class of rays");
    plot_span range = {0}; /* one for all panels, so that they can be held against each other */
    bool embree = false;
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "$rays%zu << END\n", r);
        for (size_t s = 0; s < side_count; s++) {
            fprintf(to, "%.0f", sides[s].samples);
            for (size_t k = 0; k < count; k++)
                if (!plot_is_embree(names[k]))
                    plot_put_point(to, plot_speed_of(lines, sides[s].field, rays[r], names[k]), &range);
            const double best = best_embree(lines, sides[s].field, rays[r], names, count);
            embree = embree || best > 0;
            plot_put_point(to, best, &range);
            fputc('\n', to);
        }
        fputs("END\n", to);
    }
    if (range.high <= 0) return false;
    put_side_axis(to, sides, side_count);
    plot_begin_panels(to, ray_count, &range);
    for (size_t r = 0; r < ray_count; r++) {
        plot_begin_panel(to, r, ray_count, rays[r], "samples a side, 1k: 1025");
        size_t own = 0;
        for (size_t k = 0; k < count; k++) {
            if (plot_is_embree(names[k])) continue;
            fprintf(to,
                    "$rays%zu using 1:%zu with linespoints pointtype 7 pointsize 0.5 linewidth 2 linecolor rgb '%s', ",
                    r, own + 2, plot_cool[own % PLOT_COLOURS]);
            own++;
        }
        fprintf(to, "$rays%zu using 1:%zu with linespoints pointtype 5 pointsize 0.5 linewidth 2 linecolor rgb '%s'\n",
                r, own + 2, plot_warm[1]);
    }
    plot_begin_legend(to);
    size_t own = 0;
    for (size_t k = 0; k < count; k++) {
        if (plot_is_embree(names[k])) continue;
        fputs("NaN title ", to);
        plot_put_label(to, names[k], names, count);
        fprintf(to, " with linespoints pointtype 7 pointsize 0.5 linewidth 2 linecolor rgb '%s', ",
                plot_cool[own++ % PLOT_COLOURS]);
    }
    fprintf(
        to,
        "NaN with linespoints pointtype 5 pointsize 0.5 linewidth 2 linecolor rgb '%s' title '%s'\nunset multiplot\n",
        plot_warm[1], embree ? "Embree, its fastest width" : "");
    return true;
}

/* ---- building ---- */

/* A member of a build line, NULL if there is none. */
static const json_t *build_member(const json_t *lines, const char *field, const char *key, const char *name,
                                  const char *member) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, key), name) == 0 && strcmp(results_text(line, "field"), field) == 0 &&
            strcmp(results_text(line, "kind"), strcmp(key, "kernel") == 0 ? "kernel_build" : "peer_build") == 0)
            return json_object_get(line, member);
    }
    return NULL;
}

static double build_number(const json_t *lines, const char *field, const char *key, const char *name,
                           const char *member) {
    return json_number_value(build_member(lines, field, key, name, member));
}

typedef struct builder {
    const char *key, *name;
} builder;

/* Whose builds the results have. Kernels that walk on the same structure have equally many bytes; the first stands for
 * them. */
static size_t builders_of(const json_t *lines, const char *field, builder *builders, size_t most) {
    size_t count = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        const char *kind = results_text(line, "kind");
        const bool kernel = strcmp(kind, "kernel_build") == 0;
        if ((!kernel && strcmp(kind, "peer_build") != 0) || strcmp(results_text(line, "field"), field) != 0) continue;
        const char *key = kernel ? "kernel" : "peer";
        bool known = false;
        for (size_t k = 0; k < count && kernel; k++)
            known =
                known || (strcmp(builders[k].key, key) == 0 &&
                          build_number(lines, field, key, builders[k].name, "bytes") == results_number(line, "bytes"));
        if (!known && count < most) builders[count++] = (builder){key, results_text(line, key)};
    }
    return count;
}

static void put_builder(FILE *to, const json_t *lines, const char *field, const builder *b) {
    if (strcmp(b->key, "kernel") == 0) { /* "pyramid", whose kernels end in their width, "8" or "8x2" */
        size_t length = strlen(b->name);
        const char *pair = strstr(b->name, "x2");
        if (pair && pair[2] == '\0') length -= 2;
        while (length > 1 && b->name[length - 1] >= '0' && b->name[length - 1] <= '9') length--;
        fprintf(to, "'%.*s'", (int)length, b->name);
        return;
    }
    const char *quality = json_string_value(build_member(lines, field, b->key, b->name, "quality"));
    fprintf(to, "'Embree %s", plot_is_embree(b->name) ? b->name + 7 : b->name);
    if (quality) fprintf(to, ", %s build quality", quality);
    fputc('\'', to);
}

bool plot_building(FILE *to, const json_t *lines) {
    side sides[SIDES_MAX];
    builder builders[PLOT_COLOURS];
    const size_t side_count = sides_of(lines, sides);
    const size_t count = side_count ? builders_of(lines, sides[0].field, builders, PLOT_COLOURS) : 0;
    if (side_count < 2 || count == 0) return false;
    plot_span ranges[2] = {{0}};
    plot_put_titles(to, lines, "Memory and building time over the side of the field");
    fputs("$data << END\n", to);
    for (size_t s = 0; s < side_count; s++) {
        const double cells = (sides[s].samples - 1) * (sides[s].samples - 1);
        const double samples = results_number(field_line(lines, sides[s].field), "bytes_samples");
        fprintf(to, "%.0f", sides[s].samples);
        for (size_t k = 0; k < count; k++) {
            const builder *b = &builders[k];
            const bool kernel = strcmp(b->key, "kernel") == 0;
            const double bytes = build_number(lines, sides[s].field, b->key, b->name, "bytes");
            plot_put_point(to, bytes > 0 ? (bytes + (kernel ? samples : 0)) / cells : 0, &ranges[0]);
            plot_put_point(to, build_number(lines, sides[s].field, b->key, b->name, "build_seconds"), &ranges[1]);
        }
        fputc('\n', to);
    }
    fputs("END\n", to);
    put_side_axis(to, sides, side_count);
    fputs("set multiplot layout 1,2 margins 0.09,0.98,0.24,0.80 spacing 0.11,0\nset xlabel 'samples a side, 1k: 1025' "
          "offset "
          "0,0.5\nunset key\n",
          to);
    static const char *const titles[] = {"bytes a cell, samples included", "CPU time to build, one thread"};
    static const char *const tics[] = {
        "1, 2, 5, 10, 20, 50, 100, 200, 500",
        "'1 µs' 1e-6, '10 µs' 1e-5, '100 µs' 1e-4, '1 ms' 1e-3, '10 ms' 1e-2, '100 ms' 0.1, '1 s' 1, '10 s' 10, "
        "'100 s' 100, '1000 s' 1000"};
    for (size_t panel = 0; panel < 2; panel++) {
        fprintf(to, "set title '%s'\nset yrange [%g:%g]\nset ytics (%s)\nplot ", titles[panel],
                panel ? ranges[1].low / 2 : 1, ranges[panel].high * 2, tics[panel]);
        size_t own = 0, other = 0;
        for (size_t k = 0; k < count; k++) {
            const bool kernel = strcmp(builders[k].key, "kernel") == 0;
            fprintf(to,
                    "%s$data using 1:%zu with linespoints pointtype %d pointsize 0.6 linewidth 2 linecolor rgb '%s'",
                    k ? ", " : "", 2 * k + 2 + panel, kernel ? 7 : 5,
                    kernel ? plot_cool[own++] : plot_warm[1 + other++ % (PLOT_COLOURS - 1)]);
        }
        fputs("\nunset label 1\nunset label 2\n", to);
    }
    plot_begin_legend(to);
    size_t own = 0, other = 0;
    for (size_t k = 0; k < count; k++) {
        const bool kernel = strcmp(builders[k].key, "kernel") == 0;
        fprintf(to, "%sNaN title ", k ? ", " : "");
        put_builder(to, lines, sides[0].field, &builders[k]);
        fprintf(to, " with linespoints pointtype %d pointsize 0.6 linewidth 2 linecolor rgb '%s'", kernel ? 7 : 5,
                kernel ? plot_cool[own++] : plot_warm[1 + other++ % (PLOT_COLOURS - 1)]);
    }
    fputs("\nunset multiplot\n", to);
    return true;
}
