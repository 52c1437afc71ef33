/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of the papers that are about time: from where the figures are, in short, threads, widths, Embree's geometries, the
 * coursework's table beside ours, and the frontier of speed and error. */

#include "papers.h"
#include "results.h"
#include "statistics.h"
#include "table.h"
#include "targets.h"

#include <math.h>
#include <string.h>

enum { NAMES_MAX = 96 };

static bool starts_with(const char *text, const char *start) { return strncmp(text, start, strlen(start)) == 0; }

/* ---- sources ---- */

bool papers_sources(FILE *to, papers_data *d, io_error *error) {
    static const char *const files[] = {
        "speed-avx512.json", "speed-avx2.json", "speed-sse42.json", "peers.json",        "widths.json",
        "threads.json",      "building.json",   "parts.json",       "counters.json",     "ablation.json",
        "caches.json",       "pages-huge.json", "pages-small.json", "scenes/table.json", "tradeoff/tradeoff.json"};
    const char *cpu = NULL;
    fputs("| file | made by | commit | load | date |\n|---|---|---|--:|---|\n", to);
    const json_t *first = NULL;
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) {
        const json_t *lines;
        if (!papers_lines_if_there(d, files[k], &lines, error)) return false;
        if (lines == NULL) continue;
        const json_t *run = json_array_get(lines, 0);
        if (first == NULL) first = run;
        const char *command = results_text(run, "command");
        const bool build_target = strcmp(command, "ablation") == 0 || strcmp(command, "caches") == 0;
        const bool same = cpu == NULL || strcmp(cpu, results_text(run, "cpu")) == 0;
        cpu = results_text(first, "cpu");
        fprintf(to, "| [%s](data/%s)%s%s | `%s%s%s` | %s | %.2f | %.10s |\n", files[k], files[k], same ? "" : ", on ",
                same ? "" : results_text(run, "cpu"),
                build_target ? "cmake --build --preset release --target " : "cellwalk-bench ",
                build_target ? command : "", build_target ? "" : results_text(run, "arguments"),
                results_text(run, "commit"), results_number(run, "load"), results_text(run, "date"));
    }
    if (first == NULL) return io_fail(error, "%s: has no files of results", d->folder);
    fprintf(to, "\n%s, %s cache, %.0f CPUs, %s; %s, `%s`", cpu, results_text(first, "cache"),
            results_number(first, "cpus"), results_text(first, "isa"), results_text(first, "compiler"),
            results_text(first, "flags"));
    if (*results_text(first, "embree"))
        fprintf(to, "; Embree %s%s", results_text(first, "embree"),
                json_is_true(json_object_get(first, "embree_assertions")) ? ", compiled with assertions" : "");
    fprintf(to, ". The time stamp counter runs at %.2f GHz.\n", results_number(first, "tsc_hz") * 1e-9);
    return true;
}

/* ---- in short ---- */

static const char *const classes[] = {"primary", "shadow", "ao", "bounce", "random", "grazing"};
static const char *const land[] = {"257", "1025", "4097"};
enum { CLASSES = sizeof classes / sizeof classes[0], LAND = sizeof land / sizeof land[0] };

static void put_speed(FILE *to, const json_t *lines, const char *isa) {
    double ratios[CLASSES * LAND], low = INFINITY, high = 0;
    const char *low_at[2] = {"", ""}, *high_at[2] = {"", ""};
    size_t n = 0;
    for (size_t c = 0; c < CLASSES; c++)
        for (size_t f = 0; f < LAND; f++) {
            const json_t *own = targets_own(lines, land[f], classes[c]);
            const json_t *embree = targets_embree(lines, land[f], classes[c]);
            if (own == NULL || embree == NULL) continue;
            const double is = results_number(own, "mrays_per_s") / results_number(embree, "mrays_per_s");
            if (is < low) low = is, low_at[0] = classes[c], low_at[1] = land[f];
            if (is > high) high = is, high_at[0] = classes[c], high_at[1] = land[f];
            ratios[n++] = is;
        }
    if (n == 0) return;
    fprintf(
        to,
        "- %s: %.2f times the speed of Embree's fastest width, geometric mean over %zu pairs of a class of rays and "
        "a size of field; from %.2f (%s, %s) to %.2f (%s, %s).\n",
        isa, statistics_geometric_mean(ratios, n), n, low, low_at[0], low_at[1], high, high_at[0], high_at[1]);
}

static double bytes_a_cell(const json_t *about, const json_t *build, bool own) {
    const double cells = (results_number(about, "nx") - 1) * (results_number(about, "ny") - 1);
    return (results_number(build, "bytes") + (own ? results_number(about, "bytes_samples") : 0)) / cells;
}

/* On the largest field of which both builds are there. */
static void put_building(FILE *to, const json_t *lines) {
    const json_t *line, *about = NULL, *own = NULL, *mesh = NULL, *grid = NULL;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "field", NULL)) continue;
        const char *field = results_text(line, "field");
        const json_t *ours =
            results_find(lines, "kernel_build", "field", field, "kernel", results_text(line, "default_kernel"), NULL);
        const json_t *theirs = results_find(lines, "peer_build", "field", field, "peer", "embree/triangles", NULL);
        if (!ours || !theirs || (about && results_number(line, "nx") < results_number(about, "nx"))) continue;
        about = line, own = ours, mesh = theirs;
        grid = results_find(lines, "peer_build", "field", field, "peer", "embree/grid", NULL);
    }
    if (about == NULL) return;
    const double seconds = results_number(own, "build_seconds");
    fprintf(to, "- Memory at %s samples a side: %.2f bytes a cell with the samples; Embree's triangles take %.0f",
            results_text(about, "field"), bytes_a_cell(about, own, true), bytes_a_cell(about, mesh, false));
    if (grid) fprintf(to, ", its grid %.0f", bytes_a_cell(about, grid, false));
    fprintf(to, ".\n- Building it takes %.3g s; Embree's triangles at default quality take %.0f times as long", seconds,
            results_number(mesh, "build_seconds") / seconds);
    if (grid) fprintf(to, ", its grid %.1f times", results_number(grid, "build_seconds") / seconds);
    fputs(".\n", to);
}

/* The fastest contender of a mode that ran everywhere; NULL if there is none. */
static const json_t *fastest_of(const json_t *lines, const char *mode) {
    const json_t *best = NULL, *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (results_is(line, "summary", "mode", mode, NULL) && !json_is_true(json_object_get(line, "partial")) &&
            results_number(line, "mrays_per_s") > (best ? results_number(best, "mrays_per_s") : 0))
            best = line;
    }
    return best;
}

static void put_accuracy(FILE *to, const json_t *lines) {
    static const char *const modes[][2] = {{"strict", "the default"},
                                           {"moller-trumbore", "with Möller and Trumbore's test instead"},
                                           {"embree", "Embree"},
                                           {"embree-robust", "Embree's robust mode"}};
    const char *between = "- Wrong answers in a million rays aimed at vertices and edges: ";
    for (size_t k = 0; k < sizeof modes / sizeof modes[0]; k++) {
        const json_t *of = fastest_of(lines, modes[k][0]);
        if (of == NULL) continue;
        fprintf(to, "%s%.0f (%s)", between, results_number(of, "aimed_wrong_answers_per_million"), modes[k][1]);
        between = ", ";
    }
    fputs(".\n", to);
}

bool papers_summary(FILE *to, papers_data *d, io_error *error) {
    targets_data data;
    bool good = targets_open(&data, d->folder, error);
    for (size_t k = 0; good && k < TARGETS_ISAS; k++)
        if (data.speed[k]) put_speed(to, data.speed[k], targets_isa(k));
    if (good && data.building) put_building(to, data.building);
    const json_t *tradeoff = good ? papers_lines(d, "tradeoff/tradeoff.json", error) : NULL;
    if (tradeoff) put_accuracy(to, tradeoff);
    targets_close(&data);
    return tradeoff != NULL;
}

/* ---- contenders in a table of speeds ---- */

/* Whether the name is that one, or begins with it up to a slash. */
static bool is_named(const char *name, const char *start) {
    const size_t length = strlen(start);
    return strncmp(name, start, length) == 0 &&
           (length == 0 || start[length - 1] == '/' || name[length] == '/' || name[length] == '\0');
}

/* In millions of rays a second; 0 if there is none. */
static double speed_of(const json_t *lines, const char *field, const char *rays, const char *start, double threads) {
    const json_t *line;
    size_t index;
    double best = 0;
    json_array_foreach(lines, index, line) {
        if (results_is(line, "result", "field", field, "rays", rays, NULL) &&
            is_named(results_text(line, "contender"), start) && results_number(line, "threads") == threads &&
            results_number(line, "mrays_per_s") > best)
            best = results_number(line, "mrays_per_s");
    }
    return best;
}

bool papers_threads(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "threads.json", error), *line;
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    double most = 1;
    size_t index;
    json_array_foreach(lines, index, line) most = fmax(most, results_number(line, "threads"));
    fprintf(to, "Speed of several threads over that of one, by the clock, of %.0f CPUs.\n\n",
            results_number(json_array_get(lines, 0), "cpus"));
    fputs("| threads | rays |", to);
    for (size_t f = 0; f < field_count; f++) fprintf(to, " %s |", fields[f]);
    fputs("\n|--:|---|", to);
    for (size_t f = 0; f < field_count; f++) fputs("--:|", to);
    fputc('\n', to);
    for (double threads = 2; threads <= most; threads++) {
        if (field_count && ray_count && !(speed_of(lines, fields[0], rays[0], "", threads) > 0)) continue;
        for (size_t r = 0; r < ray_count; r++) {
            fprintf(to, "| %.0f | %s |", threads, rays[r]);
            for (size_t f = 0; f < field_count; f++)
                papers_put_ratio(to, speed_of(lines, fields[f], rays[r], "", threads),
                                 speed_of(lines, fields[f], rays[r], "", 1));
            fputc('\n', to);
        }
    }
    return true;
}

bool papers_widths(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "widths.json", error);
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX], *names[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    const size_t count = results_distinct(lines, "contender", names, NAMES_MAX);
    fputs("Millions of rays a second.\n", to);
    for (size_t f = 0; f < field_count; f++) {
        fprintf(to, "\n**%s**\n\n", fields[f]);
        papers_put_head(to, "", rays, ray_count);
        for (size_t k = 0; k < count; k++) {
            const bool embree = starts_with(names[k], "embree/");
            fprintf(to, "| %.*s |", embree ? (int)strlen(names[k]) : (int)strcspn(names[k], "/"), names[k]);
            for (size_t r = 0; r < ray_count; r++) {
                const double speed = speed_of(lines, fields[f], rays[r], names[k], 1);
                fprintf(to, speed > 0 ? " %.3g |" : " |", speed);
            }
            fputc('\n', to);
        }
    }
    return true;
}

bool papers_peers(FILE *to, papers_data *d, io_error *error) {
    static const char *const geometries[][2] = {{"embree/triangles/", "triangles"},
                                                {"embree/triangles-robust/", "triangles, robust"},
                                                {"embree/grid/", "grid"},
                                                {"embree/grid-robust/", "grid, robust"}};
    const json_t *lines = papers_lines(d, "peers.json", error);
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    fputs("The library's speed over that of Embree's fastest width.\n", to);
    for (size_t f = 0; f < field_count; f++) {
        fprintf(to, "\n**%s**\n\n", fields[f]);
        papers_put_head(to, "Embree's", rays, ray_count);
        for (size_t g = 0; g < sizeof geometries / sizeof geometries[0]; g++) {
            fprintf(to, "| %s |", geometries[g][1]);
            for (size_t r = 0; r < ray_count; r++) {
                const json_t *own = targets_own(lines, fields[f], rays[r]);
                papers_put_ratio(to, own ? results_number(own, "mrays_per_s") : 0,
                                 speed_of(lines, fields[f], rays[r], geometries[g][0], 1));
            }
            fputc('\n', to);
        }
    }
    return true;
}

/* ---- the coursework ---- */

static double time_of(const json_t *scene, const char *name) {
    const json_t *path;
    size_t k;
    json_array_foreach(json_object_get(scene, "paths"), k, path) {
        if (strcmp(results_text(path, "path"), name) == 0) return results_number(path, "time_to_default");
    }
    return 0;
}

bool papers_coursework(FILE *to, papers_data *d, io_error *error) {
    static const char *const ours[] = {"grid3d-phong", "cell-phong", "auto-phong"};
    const json_t *lines = papers_lines(d, "scenes/table.json", error), *line;
    if (lines == NULL) return false;
    size_t index;
    fputs("Time to render with Phong normals over that of a triangle mesh: in the coursework pbrt-v2's, here "
          "Embree's.\n\n"
          "| scene | coursework: 3D grid | coursework: cell walk | `grid3d` | `cell` | what the library chooses |\n"
          "|---|--:|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "scene", NULL)) continue;
        const table_coursework *c = table_coursework_of(results_text(line, "scene"));
        fprintf(to, "| %s |", results_text(line, "scene"));
        papers_put_ratio(to, c ? c->grid_phong : 0, c ? c->plain : 0);
        papers_put_ratio(to, c ? c->cell_phong : 0, c ? c->plain : 0);
        for (size_t k = 0; k < sizeof ours / sizeof ours[0]; k++) papers_put_ratio(to, time_of(line, ours[k]), 1);
        fputc('\n', to);
    }
    return true;
}

/* ---- the frontier ---- */

static void put_steps(FILE *to, const json_t *lines, const char *frontier) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (results_is(line, "step", "frontier", frontier, NULL)) fprintf(to, "- %s\n", results_text(line, "text"));
    }
}

bool papers_frontier(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "tradeoff/tradeoff.json", error), *line;
    if (lines == NULL) return false;
    size_t index;
    fputs("The fastest contender of each mode; wrong answers in a million rays, those aimed at vertices and edges by\n"
          "themselves, and the worst height of a hit off the surface in cells.\n\n"
          "| mode / kernel | Mrays/s | wrong answers | of aimed rays | off the surface |\n|---|--:|--:|--:|--:|\n",
          to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "summary", NULL) || fastest_of(lines, results_text(line, "mode")) != line) continue;
        fprintf(to, "| %s | %.3g | %.3g | %.0f | %.2g |\n", results_text(line, "contender"),
                results_number(line, "mrays_per_s"), results_number(line, "wrong_answers_per_million"),
                results_number(line, "aimed_wrong_answers_per_million"), results_number(line, "off_cells_worst"));
    }
    fputs("\nSpeed against wrong answers:\n\n", to);
    put_steps(to, lines, "answers");
    fputs("\nSpeed against the worst height off the surface:\n\n", to);
    put_steps(to, lines, "place");
    return true;
}
