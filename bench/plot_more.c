/* SPDX-License-Identifier: Apache-2.0 */
/* Further pictures: threads, packet widths, and the table of scenes beside the coursework's. */

#include "plot.h"
#include "plot_parts.h"
#include "results.h"
#include "table.h"

#include <stdlib.h>
#include <string.h>

/* ---- threads ---- */

/* Of a contender NAME/tN, N; else 1. */
static unsigned threads_of(const char *name) {
    const char *last = strrchr(name, '/');
    return last && last[1] == 't' && last[2] >= '1' && last[2] <= '9' ? (unsigned)strtoul(last + 2, NULL, 10) : 1;
}

/* Speed over that of the same kernel with one thread. */
static double speed_up(const json_t *lines, const char *field, const char *rays, const char *name) {
    char one[128];
    snprintf(one, sizeof one, "%.*s", (int)(strrchr(name, '/') - name), name);
    const double base = plot_speed_of(lines, field, rays, one);
    return base > 0 ? plot_speed_of(lines, field, rays, name) / base : 0;
}

bool plot_threads(FILE *to, const json_t *lines) {
    const char *rays[PLOT_NAMES_MAX], *names[PLOT_NAMES_MAX], *fields[PLOT_NAMES_MAX];
    const size_t ray_count = results_distinct(lines, "rays", rays, PLOT_NAMES_MAX);
    const size_t field_count = results_distinct(lines, "field", fields, PLOT_NAMES_MAX);
    const size_t all = results_distinct(lines, "contender", names, PLOT_NAMES_MAX);
    size_t count = 0;
    unsigned most = 1;
    for (size_t k = 0; k < all; k++)
        if (threads_of(names[k]) > 1) names[count++] = names[k];
    for (size_t k = 0; k < count; k++) most = threads_of(names[k]) > most ? threads_of(names[k]) : most;
    if (count == 0 || count * field_count > 2 * PLOT_COLOURS) return false;
    plot_put_titles(to, lines, "Speed of several threads over that of one, by class of rays and side of the field");
    fputs("$data << END\n", to);
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "%s", rays[r]);
        for (size_t k = 0; k < count; k++)
            for (size_t f = 0; f < field_count; f++)
                fprintf(to, " %.6g", speed_up(lines, fields[f], rays[r], names[k]));
        fputc('\n', to);
    }
    fprintf(to,
            "END\nset style data histogram\nset style histogram clustered gap 1.5\nset style fill solid 1 noborder\n"
            "set tmargin 5\nset key bottom outside center horizontal samplen 1.5 height 0.5 Left reverse\n"
            "set yrange [0:%u.3]\nset ytics 0.5\nset ylabel 'speed over one thread'\nset xtics scale 0\nplot ",
            most);
    for (size_t k = 0; k < count * field_count; k++) {
        const size_t name = k / field_count;
        fprintf(to, "%s$data using %zu:xtic(1) title '%.*s, %u threads, %s' linecolor rgb '%s'", k ? ", " : "", k + 2,
                (int)strcspn(names[name], "/"), names[name], threads_of(names[name]), fields[k % field_count],
                k < PLOT_COLOURS ? plot_cool[k] : plot_warm[k - PLOT_COLOURS]);
    }
    fputc('\n', to);
    return true;
}

/* ---- packet widths ---- */

static const struct {
    const char *label, *start, *end; /* of contenders' names, around the width */
    bool embree;
} families[] = {
    {"pyramid", "pyramid", "/", false},
    {"pyramid, two vectors", "pyramid", "x2/", false},
    {"packet", "packet", "/", false},
    {"Embree triangles", "embree/triangles/w", "", true},
};
enum { FAMILIES = sizeof families / sizeof families[0], WIDTHS = 4 };
static const unsigned widths[WIDTHS] = {1, 4, 8, 16};

/* The fastest of the family with this width: packets that Embree splits have another end. 0 if there is none. */
static double family_speed(const json_t *lines, const char *field, const char *rays, size_t family, unsigned width) {
    char start[64];
    const json_t *line;
    size_t index;
    double best = 0;
    const int length = snprintf(start, sizeof start, "%s%u%s", families[family].start, width, families[family].end);
    json_array_foreach(lines, index, line) {
        const char *name = results_text(line, "contender");
        const double is = results_number(line, "mrays_per_s");
        if (results_is(line, "result", "field", field, "rays", rays, NULL) &&
            strncmp(name, start, (size_t)length) == 0 && (name[length] < '0' || name[length] > '9') &&
            threads_of(name) == 1 && is > best)
            best = is;
    }
    return best;
}

/* The field with the most samples that has results. */
static const char *largest_field(const json_t *lines) {
    const char *fields[PLOT_NAMES_MAX];
    const size_t count = results_distinct(lines, "field", fields, PLOT_NAMES_MAX);
    const char *best = NULL;
    double most = 0;
    for (size_t k = 0; k < count; k++) {
        const json_t *about = results_find(lines, "field", "field", fields[k], NULL);
        const double samples = about ? results_number(about, "nx") * results_number(about, "ny") : 0;
        if (samples > most) {
            most = samples;
            best = fields[k];
        }
    }
    return best;
}

bool plot_widths(FILE *to, const json_t *lines) {
    const char *rays[PLOT_NAMES_MAX], *field = largest_field(lines);
    const size_t ray_count = results_distinct(lines, "rays", rays, PLOT_NAMES_MAX);
    plot_span range = {0, 0};
    size_t own = 0;
    if (field == NULL || ray_count == 0) return false;
    for (size_t w = 0; w < WIDTHS; w++) own += family_speed(lines, field, rays[0], 0, widths[w]) > 0;
    if (own < 2) return false;
    char title[128];
    snprintf(title, sizeof title, "Speed over the width of packets: field %s", field);
    plot_put_titles(to, lines, title);
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "$rays%zu << END\n", r);
        for (size_t w = 0; w < WIDTHS; w++) {
            fprintf(to, "%u", widths[w]);
            for (size_t f = 0; f < FAMILIES; f++)
                plot_put_point(to, family_speed(lines, field, rays[r], f, widths[w]), &range);
            fputc('\n', to);
        }
        fputs("END\n", to);
    }
    fputs("set logscale xy\nset xtics (1, 4, 8, 16)\nset xrange [0.8:20]\n", to);
    plot_begin_panels(to, ray_count, &range);
    for (size_t r = 0; r < ray_count; r++) {
        plot_begin_panel(to, r, ray_count, rays[r], "rays at a time");
        for (size_t f = 0; f < FAMILIES; f++)
            fprintf(
                to, "%s$rays%zu using 1:%zu with linespoints pointtype %d pointsize 0.6 linewidth 2 linecolor rgb '%s'",
                f ? ", " : "", r, f + 2, families[f].embree ? 5 : 7, families[f].embree ? plot_warm[1] : plot_cool[f]);
        fputc('\n', to);
    }
    plot_begin_legend(to);
    for (size_t f = 0; f < FAMILIES; f++)
        fprintf(to, "%sNaN title '%s' with linespoints pointtype %d pointsize 0.6 linewidth 2 linecolor rgb '%s'",
                f ? ", " : "", families[f].label, families[f].embree ? 5 : 7,
                families[f].embree ? plot_warm[1] : plot_cool[f]);
    fputs("\nunset multiplot\n", to);
    return true;
}

/* ---- the coursework ---- */

static const struct {
    const char *label, *path; /* NULL: the coursework's own */
    int point;
    const char *const *colour;
} ways[] = {
    {"coursework: 3D grid", NULL, 4, &plot_warm[1]},
    {"coursework: cell walk", NULL, 6, &plot_warm[2]},
    {"here: 3D grid", "grid3d-phong", 5, &plot_warm[1]},
    {"here: cell walk", "cell-phong", 7, &plot_warm[2]},
    {"here: what the library chooses", "auto-phong", 9, &plot_cool[0]},
};
enum { WAYS = sizeof ways / sizeof ways[0] };

/* Time over that of the triangle mesh; 0 where it is not known. */
static double time_ratio(const json_t *scene, size_t way) {
    if (ways[way].path == NULL) {
        const table_coursework *c = table_coursework_of(results_text(scene, "scene"));
        return c == NULL ? 0 : (way == 0 ? c->grid_phong : c->cell_phong) / c->plain;
    }
    const json_t *path;
    size_t k;
    json_array_foreach(json_object_get(scene, "paths"), k, path) {
        if (strcmp(results_text(path, "path"), ways[way].path) == 0) return results_number(path, "time_to_default");
    }
    return 0;
}

static void put_scene_tics(FILE *to, const json_t *lines) {
    size_t scenes = 0, index;
    const json_t *line;
    fputs("set xtics scale 0 (", to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene", NULL)) continue;
        fprintf(to, "%s'%s' %zu", scenes ? ", " : "", results_text(line, "scene"), scenes);
        scenes++;
    }
    fputs(")\n", to);
}

bool plot_coursework(FILE *to, const json_t *lines) {
    plot_span range = {0, 0};
    size_t scenes = 0, index;
    const json_t *line;
    bool ours = false;
    plot_put_titles(to, lines, "Time to render, over that of a triangle mesh: the coursework's paths and ours");
    fputs("$data << END\n", to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene", NULL)) continue;
        fprintf(to, "%s %zu", results_text(line, "scene"), scenes++);
        for (size_t w = 0; w < WAYS; w++) {
            const double times = time_ratio(line, w);
            ours = ours || (ways[w].path && times > 0);
            plot_put_point(to, times, &range);
        }
        fputc('\n', to);
    }
    if (!ours) return false;
    fprintf(to,
            "END\nset logscale y\nset xrange [-0.5:%zu.5]\nset yrange [%g:%g]\nset tmargin 5\n"
            "set ylabel 'time over the triangle mesh, Phong normals'\n"
            "set key bottom outside center horizontal samplen 1 height 0.5 Left reverse\n"
            "set ytics (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50)\n",
            scenes - 1, range.low < 1 ? range.low / 1.3 : 0.8, range.high * 1.3);
    put_scene_tics(to, lines);
    fputs("plot ", to);
    for (size_t w = 0; w < WAYS; w++)
        fprintf(to,
                "%s$data using ($2 + %.2f):%zu title '%s' with points pointtype %d pointsize 1.2 linewidth 2 "
                "linecolor rgb '%s'",
                w ? ", " : "", 0.1 * ((double)w - (WAYS - 1) / 2.0), w + 3, ways[w].label, ways[w].point,
                *ways[w].colour);
    fputs(", 1 with lines linewidth 1 linecolor rgb '#7a7a7a' title 'triangle mesh: pbrt-v2, Embree'\n", to);
    return true;
}
