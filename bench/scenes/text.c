/* SPDX-License-Identifier: Apache-2.0 */
/* The table as Markdown and CSV, from its JSON lines and from nothing else: the same lines give the same text. */

#include "harness/results.h"
#include "harness/run_record.h"
#include "scenes/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const table_coursework courseworks[] = {
    {"hftest", 3.2, 4.3, 4.4, 3.1},        {"landsea-0", 18.3, 36.6, 37.1, 63.0},
    {"landsea-1", 10.3, 18.2, 18.5, 21.3}, {"landsea-2", 8.7, 15.0, 16.2, 24.3},
    {"texture", 6.0, 12.9, 13.2, 15.6},    {"landsea-big", 21.7, 115.8, 117.8, 356.3},
};
enum { COURSEWORK_COUNT = sizeof courseworks / sizeof courseworks[0] };

const table_coursework *table_coursework_of(const char *scene) {
    for (size_t k = 0; k < COURSEWORK_COUNT; k++)
        if (strcmp(courseworks[k].scene, scene) == 0) return &courseworks[k];
    return NULL;
}

static bool is_scene(const json_t *line) { return strcmp(results_text(line, "kind"), "scene") == 0; }

static const json_t *first_scene(const json_t *lines) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_scene(line)) return line;
    }
    return NULL;
}

static void seconds_text(FILE *to, double seconds) {
    fprintf(to, seconds >= 9.995 ? "%.1f" : seconds >= 0.9995 ? "%.2f" : "%.3f", seconds);
}

/* | scene | path | path | …, with a line of dashes under it. */
static void head(FILE *to, const json_t *scene) {
    const json_t *paths = json_object_get(scene, "paths"), *path;
    size_t k;
    fputs("| scene |", to);
    json_array_foreach(paths, k, path) fprintf(to, " %s |", results_text(path, "title"));
    fputs("\n|---|", to);
    json_array_foreach(paths, k, path) fputs("--:|", to);
    fputc('\n', to);
}

static void times(FILE *to, const json_t *lines) {
    size_t index, k;
    const json_t *line, *path;
    head(to, first_scene(lines));
    json_array_foreach(lines, index, line) {
        if (!is_scene(line)) continue;
        fprintf(to, "| %s |", results_text(line, "scene"));
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            fputc(' ', to);
            seconds_text(to, results_number(path, "seconds_median"));
            const double to_default = results_number(path, "time_to_default");
            if (to_default > 0 && strncmp(results_text(path, "path"), "default", 7) != 0)
                fprintf(to, " (%.2f)", to_default);
            fputs(" |", to);
        }
        fputc('\n', to);
    }
}

static void traces(FILE *to, const json_t *lines) {
    size_t index, k;
    const json_t *line, *path;
    head(to, first_scene(lines));
    json_array_foreach(lines, index, line) {
        if (!is_scene(line)) continue;
        fprintf(to, "| %s |", results_text(line, "scene"));
        json_array_foreach(json_object_get(line, "paths"), k, path)
            fprintf(to, " %.3g |", results_number(path, "trace_mrays_per_s"));
        fputc('\n', to);
    }
}

/* Building and sizes: the path that needs longest to build of Embree's and of the library's own. */
static double longest_build(const json_t *scene, bool embree) {
    size_t k;
    const json_t *path;
    double longest = 0;
    json_array_foreach(json_object_get(scene, "paths"), k, path) {
        const double seconds = results_number(path, "build_seconds");
        if ((strncmp(results_text(path, "path"), "default", 7) == 0) == embree && seconds > longest) longest = seconds;
    }
    return longest;
}

static void rays(FILE *to, const json_t *lines) {
    size_t index, k;
    const json_t *line, *field;
    fputs("| scene | picture | fields | camera rays | shadow rays | reflection rays | building: Embree, s | slowest "
          "other, s |\n|---|---|---|--:|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!is_scene(line)) continue;
        fprintf(to, "| %s | %.0f x %.0f |", results_text(line, "scene"), results_number(line, "width"),
                results_number(line, "height"));
        json_array_foreach(json_object_get(line, "fields"), k, field)
            fprintf(to, "%s %.0f x %.0f", k ? "," : "", results_number(field, "nx"), results_number(field, "ny"));
        fprintf(to, " | %.0f | %.0f | %.0f | %.3f | %.3f |\n", results_number(line, "camera_rays"),
                results_number(line, "shadow_rays"), results_number(line, "mirror_rays"), longest_build(line, true),
                longest_build(line, false));
    }
}

static void reasons(FILE *to, const json_t *why) {
    const char *key, *between = "";
    json_t *count;
    json_object_foreach((json_t *)why, key, count) {
        if (json_integer_value(count) == 0) continue;
        fprintf(to, "%s%.0f %s", between, json_number_value(count), key);
        between = ", ";
    }
}

static double differ_of(const json_t *agreed) {
    return results_number(agreed, "only_reference") + results_number(agreed, "only_this") +
           results_number(agreed, "far");
}

static void agreements(FILE *to, const json_t *lines) {
    size_t index, k;
    const json_t *line, *path;
    fputs("| scene | path | rays that differ | why | pixels that differ | visibly |\n|---|---|--:|---|--:|--:|\n", to);
    json_array_foreach(lines, index, line) {
        if (!is_scene(line)) continue;
        size_t alike = 0;
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            const json_t *agreed = json_object_get(path, "agreement");
            const double differ = differ_of(agreed), pixels = results_number(path, "pixels_differ");
            if (differ == 0 && pixels == 0) {
                alike++;
                continue;
            }
            fprintf(to, "| %s | %s | %.0f of %.0f | ", results_text(line, "scene"), results_text(path, "title"), differ,
                    results_number(agreed, "rays"));
            reasons(to, json_object_get(agreed, "why"));
            fprintf(to, " | %.0f of %.0f | %.0f |\n", pixels, results_number(path, "pixels"),
                    results_number(path, "pixels_visibly"));
        }
        if (alike) fprintf(to, "| %s | the other %zu | 0 | | 0 | 0 |\n", results_text(line, "scene"), alike);
    }
}

static void coursework_table(FILE *to) {
    fputs("| scene | Default | grid + 3D-DDA | with Phong | 2D-DDA with Phong |\n|---|--:|--:|--:|--:|\n", to);
    for (size_t k = 0; k < COURSEWORK_COUNT; k++) {
        const table_coursework *c = &courseworks[k];
        fprintf(to, "| %s | %.1f | %.1f (%.2f) | %.1f (%.2f) | %.1f (%.2f) |\n", c->scene, c->plain, c->grid,
                c->grid / c->plain, c->grid_phong, c->grid_phong / c->plain, c->cell_phong, c->cell_phong / c->plain);
    }
}

static void skipped(FILE *to, const json_t *lines) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), "skipped") == 0)
            fprintf(to, "Left out: %s: %s.\n\n", results_text(line, "path"), results_text(line, "why"));
    }
}

static const char *chosen_kernel(const json_t *lines) {
    size_t k;
    const json_t *path;
    json_array_foreach(json_object_get(first_scene(lines), "paths"), k, path) {
        if (strncmp(results_text(path, "path"), "auto", 4) == 0) return results_text(path, "by");
    }
    return NULL;
}

static void brief_page(FILE *to, const json_t *lines) {
    const json_t *record = json_array_get(lines, 0);
    char machine[512];
    run_record_text(record, machine, sizeof machine);
    fprintf(to, "%s.\n\n", machine);
    fputs("Seconds to render, median, CPU time of one thread; building is not in it.", to);
    if (strcmp(results_text(record, "embree"), "") != 0)
        fputs(" In brackets the time over that of Default (Embree's triangle mesh) with the same normals: below 1 is "
              "faster "
              "than Embree.",
              to);
    const char *by = chosen_kernel(lines);
    if (by) fprintf(to, " *cellwalk* is what the library chooses by itself, on the first scene %s.", by);
    fputs("\n\n", to);
    times(to, lines);
    fputs("\nTracing alone, millions of rays a second (a ray counts once for each field that it is asked of):\n\n", to);
    traces(to, lines);
}

static void page(FILE *to, const json_t *lines) {
    brief_page(to, lines);
    fputs("\nWhat was traced and built:\n\n", to);
    rays(to, lines);
    fprintf(
        to,
        "\nAgreement. All paths answered the same rays of one sample a pixel, and were held against %s; their "
        "pictures against that of the same kernel, or else of the first path that is not Default, with the same "
        "normals. Why hits differ: *end*, the "
        "hit is a rounding away from where the ray starts or ends; *edge*, from an edge that two triangles share; "
        "*grazing*, the ray lies too flat to tell; *other*, a defect (grid3d-early has them by design). Pixels differ "
        "by rounding alone where two leaf tests compute the same hit; visibly means by half an 8-bit step.\n\n",
        results_text(first_scene(lines), "reference"));
    agreements(to, lines);
    fputs(
        "\nThe coursework that these scenes come from reported (2.7 GHz Core i7, 8 threads, pbrt-v2, seconds, ratio to "
        "Default; its figures are not comparable in seconds, only in ratios):\n\n",
        to);
    coursework_table(to);
    fputc('\n', to);
    skipped(to, lines);
}

static void csv(FILE *to, const json_t *lines) {
    static const char *const numbers[] = {"samples",         "seconds_median",    "seconds_min", "seconds_mad",
                                          "time_to_default", "trace_mrays_per_s", "traced_rays", "build_seconds",
                                          "pixels_differ",   "pixels_visibly"};
    static const char *const counts[] = {"camera_rays", "shadow_rays", "mirror_rays"};
    enum { NUMBERS = sizeof numbers / sizeof numbers[0], COUNTS = sizeof counts / sizeof counts[0] };
    size_t index, k;
    const json_t *line, *path;
    fputs("scene,path,by", to);
    for (size_t n = 0; n < NUMBERS; n++) fprintf(to, ",%s", numbers[n]);
    for (size_t n = 0; n < COUNTS; n++) fprintf(to, ",%s", counts[n]);
    fputs(",rays_differ\n", to);
    json_array_foreach(lines, index, line) {
        if (!is_scene(line)) continue;
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            fprintf(to, "%s,%s,%s", results_text(line, "scene"), results_text(path, "path"), results_text(path, "by"));
            for (size_t n = 0; n < NUMBERS; n++) {
                fputc(',', to);
                if (json_object_get(path, numbers[n])) fprintf(to, "%.9g", results_number(path, numbers[n]));
            }
            for (size_t n = 0; n < COUNTS; n++) fprintf(to, ",%.0f", results_number(line, counts[n]));
            fprintf(to, ",%.0f\n", differ_of(json_object_get(path, "agreement")));
        }
    }
}

static char *into_memory(const json_t *lines, void (*print)(FILE *, const json_t *)) {
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) return NULL;
    print(file, lines);
    const bool good = !ferror(file);
    if (fclose(file) == 0 && good) return text;
    free(text);
    return NULL;
}

char *table_markdown(const json_t *lines, bool brief) { return into_memory(lines, brief ? brief_page : page); }
char *table_csv(const json_t *lines) { return into_memory(lines, csv); }
