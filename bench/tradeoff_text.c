/* SPDX-License-Identifier: Apache-2.0 */
/* The trade as Markdown, from its JSON lines and from nothing else: the same lines give the same text. */

#include "results.h"
#include "run_record.h"
#include "tradeoff_main.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_MAX = 192 };

static bool is_kind(const json_t *line, const char *kind) { return strcmp(results_text(line, "kind"), kind) == 0; }

static const json_t *first_of(const json_t *lines, const char *kind) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_kind(line, kind)) return line;
    }
    return NULL;
}

/* A cell of a table: the number, or nothing where it was not measured. */
static void put(FILE *to, const json_t *line, const char *key, const char *format) {
    const json_t *value = json_object_get(line, key);
    fputc(' ', to);
    if (value) fprintf(to, format, json_number_value(value)); /* formats are constants below */
    fputs(" |", to);
}

/* A rate: whole from 100 on. */
static void put_rate(FILE *to, const json_t *line, const char *key) {
    put(to, line, key, results_number(line, key) < 100 ? "%.3g" : "%.0f");
}

/* ---- frontier ---- */

static void put_steps(FILE *to, const json_t *lines, const char *frontier) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_kind(line, "step") && strcmp(results_text(line, "frontier"), frontier) == 0)
            fprintf(to, "- %s\n", results_text(line, "text"));
    }
    fputc('\n', to);
}

/* ---- contenders ---- */

static int by_speed(const void *a, const void *b) {
    const json_t *x = *(const json_t *const *)a, *y = *(const json_t *const *)b;
    const double u = results_number(x, "mrays_per_s"), v = results_number(y, "mrays_per_s");
    if (u != v) return u < v ? 1 : -1;
    return strcmp(results_text(x, "contender"), results_text(y, "contender"));
}

static void put_contenders(FILE *to, const json_t *lines) {
    const json_t *all[NAMES_MAX], *line;
    size_t count = 0, index;
    json_array_foreach(lines, index, line) {
        if (is_kind(line, "summary") && count < NAMES_MAX && results_number(line, "groups") > 0) all[count++] = line;
    }
    qsort(all, count, sizeof *all, by_speed);
    fputs("| mode / kernel | Mrays/s | frontier | leaks | phantoms | wrong surface | aimed | beyond claim | t: ULP, "
          "median | "
          "worst | t: cells, median | worst | off surface: median | worst | normal: median | worst |\n"
          "|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
          to);
    for (size_t k = 0; k < count; k++) {
        const bool partial = json_is_true(json_object_get(all[k], "partial"));
        const bool answers = json_is_true(json_object_get(all[k], "frontier_answers"));
        const bool near = json_is_true(json_object_get(all[k], "frontier_place"));
        fprintf(to, "| %s%s |", results_text(all[k], "contender"), partial ? " \\*" : "");
        put(to, all[k], "mrays_per_s", "%.3g");
        fprintf(to, " %s%s%s |", answers ? "answers" : "", answers && near ? ", " : "", near ? "place" : "");
        put_rate(to, all[k], "leaks_per_million");
        put_rate(to, all[k], "phantoms_per_million");
        put_rate(to, all[k], "wrong_per_million");
        put_rate(to, all[k], "aimed_wrong_answers_per_million");
        put_rate(to, all[k], "broken_per_million");
        put(to, all[k], "t_ulp_median", "%.2f");
        put(to, all[k], "t_ulp_worst", "%.3g");
        put(to, all[k], "t_cells_median", "%.2g");
        put(to, all[k], "t_cells_worst", "%.2g");
        put(to, all[k], "off_cells_median", "%.2g");
        put(to, all[k], "off_cells_worst", "%.2g");
        put(to, all[k], "normal_degrees_median", "%.2g");
        put(to, all[k], "normal_degrees_worst", "%.2g");
        fputc('\n', to);
    }
    fputc('\n', to);
}

/* ---- claims ---- */

static const json_t *result_of(const json_t *lines, const char *name, const char *field, const char *rays) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_kind(line, "result") && strcmp(results_text(line, "contender"), name) == 0 &&
            strcmp(results_text(line, "field"), field) == 0 && strcmp(results_text(line, "rays"), rays) == 0)
            return line;
    }
    return NULL;
}

static void put_early(FILE *to, const json_t *lines) {
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    fputs("Wrong answers of grid3d-early in a million, those of grid3d in brackets:\n\n| rays |", to);
    for (size_t f = 0; f < field_count; f++) fprintf(to, " %s |", fields[f]);
    fputs("\n|---|", to);
    for (size_t f = 0; f < field_count; f++) fputs("--:|", to);
    fputc('\n', to);
    for (size_t r = 0; r < ray_count; r++) {
        const json_t *any = result_of(lines, "early/grid3d-early", field_count ? fields[0] : "", rays[r]);
        if (any == NULL || strcmp(results_text(any, "query"), "closest") != 0) continue;
        fprintf(to, "| %s |", rays[r]);
        for (size_t f = 0; f < field_count; f++) {
            static const char *const contenders[] = {"early/grid3d-early", "moller-trumbore/grid3d"};
            for (int k = 0; k < 2; k++) {
                const json_t *of = result_of(lines, contenders[k], fields[f], rays[r]);
                if (of == NULL || !json_object_get(of, "leaks_per_million")) continue;
                const double rate = results_number(of, "leaks_per_million") +
                                    results_number(of, "phantoms_per_million") +
                                    results_number(of, "wrong_per_million");
                fprintf(to, rate < 100 ? "%s%.3g%s" : "%s%.0f%s", k ? " (" : " ", rate, k ? ")" : "");
            }
            fputs(" |", to);
        }
        fputc('\n', to);
    }
    fputc('\n', to);
}

static void put_counts(FILE *to, const json_t *lines) {
    size_t index, astray = 0;
    const json_t *line;
    fputs("A ray, on average; cell triangles are those tested after the comparison of heights:\n\n"
          "| field or scene | rays | voxels | triangles | cells | triangles |\n|---|---|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "count")) continue;
        fprintf(to, "| %s | %s |", results_text(line, "where"), results_text(line, "rays"));
        put(to, line, "voxels", "%.1f");
        put(to, line, "voxel_triangles", "%.1f");
        put(to, line, "cells", "%.1f");
        put(to, line, "cell_triangles", "%.1f");
        fputc('\n', to);
        astray += (size_t)results_number(line, "astray");
    }
    fprintf(to, "\nCounted rays that did not end at the kernels' hits: %zu.\n\n", astray);
}

static void put_normals(FILE *to, const json_t *lines) {
    static const char *const kinds[] = {"facet", "barycentric", "bilinear"};
    size_t index;
    const json_t *line;
    fputs("Root mean square (worst) error in degrees, and nanoseconds a normal:\n\n"
          "| wave: length × height, cells | facet | ns | barycentric | ns | bilinear | ns |\n"
          "|---|--:|--:|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "normal")) continue;
        fprintf(to, "| %g × %g |", results_number(line, "wave_length"), results_number(line, "wave_height"));
        for (int k = 0; k < 3; k++) {
            const json_t *of = json_object_get(line, kinds[k]);
            fprintf(to, " %.3g (%.3g) | %.1f |", results_number(of, "degrees_rms"), results_number(of, "degrees_worst"),
                    results_number(of, "nanoseconds"));
        }
        fputc('\n', to);
    }
    fputc('\n', to);
}

static void put_claims(FILE *to, const json_t *lines) {
    size_t index;
    const json_t *line;
    fputs("### Three claims\n\n", to);
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "hypothesis")) continue;
        const char *name = results_text(line, "name");
        fprintf(to, "**\"%s\": %s.** %s\n\n", results_text(line, "claim"), results_text(line, "verdict"),
                results_text(line, "text"));
        if (strcmp(results_text(line, "verdict"), "not measured") == 0) continue;
        if (strcmp(name, "early") == 0) put_early(to, lines);
        if (strcmp(name, "cells") == 0) put_counts(to, lines);
        if (strcmp(name, "normals") == 0) put_normals(to, lines);
    }
}

/* ---- scenes ---- */

static void put_scenes(FILE *to, const json_t *lines) {
    if (first_of(lines, "picture") == NULL) return;
    size_t index;
    const json_t *line;
    fputs("### The scenes\n\nPictures against strict, values from 0 to 1, Phong normals of the scene's own samples.\n\n"
          "| scene | mode / kernel | Mrays/s | RMSE | worst pixel | pixels that differ | visibly |\n"
          "|---|---|--:|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "picture")) continue;
        fprintf(to, "| %s | %s |", results_text(line, "scene"), results_text(line, "contender"));
        put(to, line, "trace_mrays_per_s", "%.3g");
        put(to, line, "rmse", "%.2g");
        put(to, line, "worst", "%.2g");
        put(to, line, "pixels_differ", "%.0f");
        put(to, line, "pixels_visibly", "%.0f");
        fputc('\n', to);
    }
    fputc('\n', to);
}

static void page(FILE *to, const json_t *lines) {
    const json_t *record = json_array_get(lines, 0);
    char machine[512];
    run_record_text(record, machine, sizeof machine);
    fprintf(to, "%s. %.0f rays a class and field.\n\n", machine, results_number(record, "rays_a_class"));
    fputs("### The frontier\n\nSpeed against wrong answers:\n\n", to);
    put_steps(to, lines, "answers");
    fputs("Speed against the worst height of a hit off the surface:\n\n", to);
    put_steps(to, lines, "place");
    fputs("### All contenders\n\n"
          "Speed: geometric mean over fields and classes of rays. Leaks, phantoms and wrong surfaces: in a million "
          "rays,\n"
          "mean over the same. Aimed: all three, of rays aimed at vertices and edges; the frontier counts them too. "
          "Beyond\n"
          "claim: what the mode's own bound does not explain. Errors of t, heights off the surface in cells and angles "
          "between\n"
          "normals in degrees: median of the groups' medians, and the worst of all.\n\n",
          to);
    put_contenders(to, lines);
    fputs("\\* did not run everywhere, for want of time, memory or means; its figures are of where it did.\n\n", to);
    put_scenes(to, lines);
    put_claims(to, lines);
}

char *tradeoff_markdown(const json_t *lines) {
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) return NULL;
    page(file, lines);
    if (fclose(file) == 0) return text;
    free(text);
    return NULL;
}
