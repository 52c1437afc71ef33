/* SPDX-License-Identifier: Apache-2.0 */
/* The table as text, Markdown and CSV, from its JSON lines and from nothing else: the same lines give the same text. */

#include "harness/cells.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "scenes/table.h"

#include <string.h>

static bool is_default(const json_t *path) { return strncmp(results_text(path, "path"), "default", 7) == 0; }

/* A paragraph, which a table or another one follows. In a terminal it is folded, as wide as tables are. */
static void say(FILE *to, table_format format, const char *text) {
    enum { WIDTH = 100 };
    size_t at = 0;
    while (*text) {
        const size_t length = strcspn(text, " ");
        if (at > 0 && format == TABLE_TEXT && at + 1 + length > WIDTH) {
            fputc('\n', to);
            at = 0;
        }
        at += (size_t)fprintf(to, "%s%.*s", at ? " " : "", (int)length, text);
        text += length + strspn(text + length, " ");
    }
    fputs(format == TABLE_TEXT ? "\n" : "\n\n", to);
}

/* ---- a row a scene, a column a path ---- */

typedef void put_cell(cells *t, const json_t *path);

static void put_seconds(cells *t, const json_t *path) {
    const double seconds = results_number(path, "seconds_median");
    cells_add(t, seconds >= 9.995 ? "%.1f" : seconds >= 0.9995 ? "%.2f" : "%.3f", seconds);
}

static void put_ratio(cells *t, const json_t *path) {
    const double to_default = results_number(path, "time_to_default");
    if (to_default > 0)
        cells_add(t, "%.2f", to_default);
    else
        cells_add(t, " ");
}

/* Both in one: the page is wide enough. */
static void put_both(cells *t, const json_t *path) {
    const double seconds = results_number(path, "seconds_median"), to_default = results_number(path, "time_to_default");
    if (to_default > 0 && !is_default(path))
        cells_add(t,
                  seconds >= 9.995    ? "%.1f (%.2f)"
                  : seconds >= 0.9995 ? "%.2f (%.2f)"
                                      : "%.3f (%.2f)",
                  seconds, to_default);
    else
        put_seconds(t, path);
}

static void put_speed(cells *t, const json_t *path) { cells_add(t, "%.3g", results_number(path, "trace_mrays_per_s")); }

static void put_paths(FILE *to, const json_t *lines, table_format format, put_cell *put) {
    static cells t;
    size_t index, k;
    const json_t *line, *path;
    cells_add(&t, "scene");
    json_array_foreach(json_object_get(results_first(lines, "scene"), "paths"), k, path)
        cells_add(&t, "%s", results_text(path, "title"));
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene")) continue;
        cells_end_row(&t);
        cells_add(&t, "%s", results_text(line, "scene"));
        json_array_foreach(json_object_get(line, "paths"), k, path) put(&t, path);
    }
    cells_print(&t, to, (cells_format)format);
    fputc('\n', to);
}

/* ---- rays and building ---- */

/* The path that needs longest to build, of Embree's or of the library's own. */
static double longest_build(const json_t *scene, bool embree) {
    size_t k;
    const json_t *path;
    double longest = 0;
    json_array_foreach(json_object_get(scene, "paths"), k, path) {
        const double seconds = results_number(path, "build_seconds");
        if (is_default(path) == embree && seconds > longest) longest = seconds;
    }
    return longest;
}

static void put_rays(FILE *to, const json_t *lines, table_format format) {
    static const char *const heads[] = {"scene",        "picture ",         "fields ",         "camera, rays",
                                        "shadow, rays", "reflection, rays", "build s, Embree", "build s, other"};
    static cells t;
    size_t index, k;
    const json_t *line, *field;
    for (k = 0; k < sizeof heads / sizeof heads[0]; k++) cells_add(&t, "%s", heads[k]);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene")) continue;
        char fields[256] = "";
        json_array_foreach(json_object_get(line, "fields"), k, field) {
            const size_t used = strlen(fields);
            snprintf(fields + used, sizeof fields - used, "%s%.0f x %.0f", k ? "; " : "", results_number(field, "nx"),
                     results_number(field, "ny"));
        }
        cells_end_row(&t);
        cells_add(&t, "%s", results_text(line, "scene"));
        cells_add(&t, "%.0f x %.0f", results_number(line, "width"), results_number(line, "height"));
        cells_add(&t, "%s", fields);
        cells_add(&t, "%.0f", results_number(line, "camera_rays"));
        cells_add(&t, "%.0f", results_number(line, "shadow_rays"));
        cells_add(&t, "%.0f", results_number(line, "mirror_rays"));
        cells_add(&t, "%.3f", longest_build(line, true));
        cells_add(&t, "%.3f", longest_build(line, false));
    }
    cells_print(&t, to, (cells_format)format);
    fputc('\n', to);
}

/* ---- agreement ---- */

static double differ_of(const json_t *agreed) {
    return results_number(agreed, "only_reference") + results_number(agreed, "only_this") +
           results_number(agreed, "far");
}

static void add_reasons(cells *t, const json_t *why) {
    char text[256] = "";
    const char *key;
    json_t *count;
    json_object_foreach((json_t *)why, key, count) {
        const size_t used = strlen(text);
        if (json_integer_value(count) == 0) continue;
        snprintf(text + used, sizeof text - used, "%s%.0f %s", used ? ", " : "", json_number_value(count), key);
    }
    cells_add(t, "%s", text);
}

static void put_agreement(FILE *to, const json_t *lines, table_format format) {
    static const char *const heads[] = {"scene",  "path ", "rays that, differ", "why ", "pixels that, differ",
                                        "visibly"};
    static cells t;
    size_t index, k;
    const json_t *line, *path;
    for (k = 0; k < sizeof heads / sizeof heads[0]; k++) cells_add(&t, "%s", heads[k]);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene")) continue;
        size_t alike = 0;
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            const json_t *agreed = json_object_get(path, "agreement");
            const double differ = differ_of(agreed), pixels = results_number(path, "pixels_differ");
            alike += differ == 0 && pixels == 0;
            if (differ == 0 && pixels == 0) continue;
            cells_end_row(&t);
            cells_add(&t, "%s", results_text(line, "scene"));
            cells_add(&t, "%s", results_text(path, "title"));
            cells_add(&t, "%.0f of %.0f", differ, results_number(agreed, "rays"));
            add_reasons(&t, json_object_get(agreed, "why"));
            cells_add(&t, "%.0f of %.0f", pixels, results_number(path, "pixels"));
            cells_add(&t, "%.0f", results_number(path, "pixels_visibly"));
        }
        if (alike == 0) continue;
        cells_end_row(&t);
        cells_add(&t, "%s", results_text(line, "scene"));
        cells_add(&t, "the other %zu", alike);
        cells_add(&t, "0");
        cells_add(&t, " ");
        cells_add(&t, "0");
        cells_add(&t, "0");
    }
    cells_print(&t, to, (cells_format)format);
    fputc('\n', to);
}

/* ---- all of it ---- */

static const char *chosen_kernel(const json_t *lines) {
    size_t k;
    const json_t *path;
    json_array_foreach(json_object_get(results_first(lines, "scene"), "paths"), k, path) {
        if (strncmp(results_text(path, "path"), "auto", 4) == 0) return results_text(path, "by");
    }
    return "";
}

void table_write(FILE *to, const json_t *lines, table_format format) {
    const json_t *record = json_array_get(lines, 0);
    const bool markdown = format == TABLE_MARKDOWN, embree = *results_text(record, "embree") != '\0';
    const char *by = chosen_kernel(lines);
    char text[1024];
    run_record_text(record, text, sizeof text);
    say(to, format, text);
    if (!markdown) fputc('\n', to);
    snprintf(text, sizeof text,
             "Seconds to render: median of the CPU time of one thread, building not included.%s%s%s%s",
             markdown && embree
                 ? " In brackets the time over that of Default (Embree's triangle mesh) with the same normals: "
                   "below 1 is faster than Embree."
                 : "",
             *by ? " cellwalk is what the library chooses by itself, on the first scene " : "", by, *by ? "." : "");
    say(to, format, text);
    put_paths(to, lines, format, markdown ? put_both : put_seconds);
    if (!markdown && embree) {
        say(to, format,
            "Time over that of Default (Embree's triangle mesh) with the same normals; below 1 is faster than Embree:");
        put_paths(to, lines, format, put_ratio);
    }
    say(to, format, "Tracing alone, millions of rays a second (a ray counts once for each field that it is asked of):");
    put_paths(to, lines, format, put_speed);
    say(to, format, "What was traced and built:");
    put_rays(to, lines, format);
    snprintf(
        text, sizeof text,
        "Agreement: all paths answered the same rays of one sample a pixel, which were held against the answers of %s, "
        "and "
        "their pictures against that of the same kernel, or else of the first path that is not Default, with the same "
        "normals. Why hits differ: end, the hit is a rounding away from where the ray starts or ends; edge, from an "
        "edge "
        "that two triangles share; grazing, the ray lies too flat to tell; other, a defect (grid3d-early has them by "
        "design). Pixels differ by rounding alone where two leaf tests compute the same hit; visibly means by half an "
        "8-bit step.",
        results_text(results_first(lines, "scene"), "reference"));
    say(to, format, text);
    put_agreement(to, lines, format);
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "skipped")) continue;
        snprintf(text, sizeof text, "Left out: %s: %s.", results_text(line, "path"), results_text(line, "why"));
        say(to, format, text);
    }
}

void table_write_csv(FILE *to, const json_t *lines) {
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
