/* SPDX-License-Identifier: Apache-2.0 */
/* The table as Markdown and CSV, from its JSON lines and from nothing else: the same lines give the same text. */

#include "harness/results.h"
#include "scenes/table.h"

#include <math.h>
#include <string.h>

static bool is_default(const json_t *path) { return strncmp(results_text(path, "path"), "default", 7) == 0; }

/* ---- a row a scene, a column a path ---- */

static void put_time(FILE *to, const json_t *path) {
    const double seconds = results_number(path, "seconds_median"), to_default = results_number(path, "time_to_default");
    fprintf(to, seconds >= 9.995 ? " %.1f" : seconds >= 0.9995 ? " %.2f" : " %.3f", seconds);
    if (to_default > 0 && !is_default(path)) fprintf(to, " (%.2f)", to_default);
}

static void put_speed(FILE *to, const json_t *path) { fprintf(to, " %.3g", results_number(path, "trace_mrays_per_s")); }

static void put_paths(FILE *to, const json_t *lines, bool pbrt, void (*put)(FILE *, const json_t *)) {
    const json_t *paths = json_object_get(results_first(lines, "scene"), "paths"), *line, *path;
    size_t index, k;
    fputs(pbrt ? "| scene | pbrt-v2 |" : "| scene |", to);
    json_array_foreach(paths, k, path) fprintf(to, " %s |", results_text(path, "title"));
    fputs(pbrt ? "\n|---|--:|" : "\n|---|", to);
    json_array_foreach(paths, k, path) fputs("--:|", to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene")) continue;
        fprintf(to, "\n| %s |", results_text(line, "scene"));
        const double ratio = results_number(line, "pbrt_ratio");
        if (pbrt && ratio > 0) fprintf(to, " %.1f x", ratio);
        if (pbrt) fputs(" |", to);
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            put(to, path);
            fputs(" |", to);
        }
    }
    fputc('\n', to);
}

/* ---- rays, building, agreement ---- */

/* The path that needs longest to build, of Embree's or of the library's own. */
static double longest_build(const json_t *of, bool embree) {
    size_t k;
    const json_t *path;
    double longest = 0;
    json_array_foreach(json_object_get(of, "paths"), k, path) {
        if (is_default(path) == embree) longest = fmax(longest, results_number(path, "build_seconds"));
    }
    return longest;
}

static void put_rays(FILE *to, const json_t *of) {
    size_t k;
    const json_t *field;
    fprintf(to, "| %s | %.0f x %.0f |", results_text(of, "scene"), results_number(of, "width"),
            results_number(of, "height"));
    json_array_foreach(json_object_get(of, "fields"), k, field)
        fprintf(to, "%s %.0f x %.0f", k ? "," : "", results_number(field, "nx"), results_number(field, "ny"));
    fprintf(to, " | %.0f | %.0f | %.0f | %.3f | %.3f |\n", results_number(of, "camera_rays"),
            results_number(of, "shadow_rays"), results_number(of, "mirror_rays"), longest_build(of, true),
            longest_build(of, false));
}

static double differ_of(const json_t *agreed) {
    return results_number(agreed, "only_reference") + results_number(agreed, "only_this") +
           results_number(agreed, "far");
}

static void put_agreement(FILE *to, const json_t *of) {
    size_t k, alike = 0;
    const json_t *path;
    json_array_foreach(json_object_get(of, "paths"), k, path) {
        const json_t *agreed = json_object_get(path, "agreement");
        const double differ = differ_of(agreed), pixels = results_number(path, "pixels_differ");
        const char *reason, *between = "";
        json_t *count;
        alike += differ == 0 && pixels == 0;
        if (differ == 0 && pixels == 0) continue;
        fprintf(to, "| %s | %s | %.0f of %.0f | ", results_text(of, "scene"), results_text(path, "title"), differ,
                results_number(agreed, "rays"));
        json_object_foreach(json_object_get(agreed, "why"), reason, count) {
            if (json_integer_value(count) == 0) continue;
            fprintf(to, "%s%.0f %s", between, json_number_value(count), reason);
            between = ", ";
        }
        fprintf(to, " | %.0f of %.0f | %.0f |\n", pixels, results_number(path, "pixels"),
                results_number(path, "pixels_visibly"));
    }
    if (alike) fprintf(to, "| %s | the other %zu | 0 | | 0 | 0 |\n", results_text(of, "scene"), alike);
}

static void put_scenes(FILE *to, const json_t *lines, const char *head, void (*put)(FILE *, const json_t *)) {
    size_t index;
    const json_t *line;
    fputs(head, to);
    json_array_foreach(lines, index, line) {
        if (results_is(line, "scene")) put(to, line);
    }
}

/* ---- all of it ---- */

void table_write_markdown(FILE *to, const json_t *lines) {
    const json_t *record = json_array_get(lines, 0), *of = results_first(lines, "scene"), *path, *line;
    const json_t *pbrt = results_first(lines, "pbrt");
    char machine[512];
    const char *by = NULL;
    size_t k;
    run_record_text(record, machine, sizeof machine);
    json_array_foreach(json_object_get(of, "paths"), k, path) {
        if (by == NULL && strncmp(results_text(path, "path"), "auto", 4) == 0) by = results_text(path, "by");
    }
    fprintf(to, "%s.\n\nSeconds to render: median CPU time of one thread, building excluded.", machine);
    if (*results_text(record, "embree"))
        fputs(" In brackets: time relative to Default, Embree's triangle mesh, with the same normals; below 1 is "
              "faster than Embree.",
              to);
    if (by)
        fprintf(to, " *cellwalk* is the kernel that the library chooses, in the first scene `%.*s`.",
                (int)strcspn(by, "/"), by);
    if (pbrt)
        fprintf(
            to,
            " *pbrt-v2*: how many times as long as cellwalk its whole process takes, with flat triangles; not measured "
            "in this run, but both on %s, %s, commit %s, %s, with pbrt-v2 of %s.",
            results_text(pbrt, "cpu"), results_text(pbrt, "isa"), results_text(pbrt, "commit"),
            results_text(pbrt, "date"), results_text(pbrt, "pbrt"));
    fputs("\n\n", to);
    put_paths(to, lines, pbrt != NULL, put_time);
    fputs("\nTracing alone, in millions of rays a second (a ray counts once for each field that it is tested "
          "against):\n\n",
          to);
    put_paths(to, lines, false, put_speed);
    fputs("\nWhat was traced and built:\n\n", to);
    put_scenes(to, lines,
               "| scene | picture | fields | camera, rays | shadow, rays | reflection, rays | build s, Embree | build "
               "s, slowest other |\n|---|---|---|--:|--:|--:|--:|--:|\n",
               put_rays);
    fprintf(to,
            "\nAgreement. All paths answered the same rays of one sample a pixel and were compared with %s, their "
            "pictures with that of the same kernel, or else of the first path that is not Default, with the same "
            "normals. Why hits differ: *end*, the hit is a rounding away from where the ray starts or ends; *edge*, "
            "from an edge that two triangles share; *grazing*, the ray lies too flat to tell; *other*, a defect. "
            "Pixels differ by rounding alone where two leaf tests compute the same "
            "hit; visibly means by more than half an 8-bit step.\n\n",
            results_text(of, "reference"));
    put_scenes(
        to, lines,
        "| scene | path | rays, that differ | why | pixels, that differ | visibly |\n|---|---|--:|---|--:|--:|\n",
        put_agreement);
    json_array_foreach(lines, k, line) {
        if (results_is(line, "skipped"))
            fprintf(to, "\nLeft out: %s: %s.\n", results_text(line, "path"), results_text(line, "why"));
    }
}

void table_write_csv(FILE *to, const json_t *lines) {
    static const char *const numbers[] = {"samples",         "seconds_median",    "seconds_min", "seconds_mad",
                                          "time_to_default", "trace_mrays_per_s", "traced_rays", "build_seconds",
                                          "pixels_differ",   "pixels_visibly"};
    size_t index, k, n;
    const json_t *line, *path;
    fputs("scene,path,by", to);
    for (n = 0; n < sizeof numbers / sizeof numbers[0]; n++) fprintf(to, ",%s", numbers[n]);
    fputs(",camera_rays,shadow_rays,mirror_rays,rays_differ\n", to);
    json_array_foreach(lines, index, line) {
        json_array_foreach(json_object_get(line, "paths"), k, path) {
            fprintf(to, "%s,%s,%s", results_text(line, "scene"), results_text(path, "path"), results_text(path, "by"));
            for (n = 0; n < sizeof numbers / sizeof numbers[0]; n++) {
                fputc(',', to);
                if (json_object_get(path, numbers[n])) fprintf(to, "%.9g", results_number(path, numbers[n]));
            }
            fprintf(to, ",%.0f,%.0f,%.0f,%.0f\n", results_number(line, "camera_rays"),
                    results_number(line, "shadow_rays"), results_number(line, "mirror_rays"),
                    differ_of(json_object_get(path, "agreement")));
        }
    }
}
