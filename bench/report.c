/* SPDX-License-Identifier: Apache-2.0 */
#include "report.h"

#include "options.h"
#include "output.h"
#include "results.h"
#include "run_record.h"
#include "table.h"
#include "targets.h"
#include "tradeoff_main.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-bench report [OPTIONS] --json FILE\n"
    "       cellwalk-bench report [OPTIONS] --targets FOLDER\n"
    "\n"
    "Prints results of 'table', 'tradeoff', 'micro --json' or 'parts --json' as Markdown, or puts "
    "them into a page between the two lines\n"
    "<!-- begin:NAME --> and <!-- end:NAME -->. The same file gives the same text.\n"
    "\n"
    "Options:\n";

/* ---- into a page ---- */

char *report_read_page(const char *path, io_error *error) {
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    size_t size = 0;
    ssize_t length = -1;
    if (file) length = getdelim(&text, &size, '\0', file);
    const bool failed = file == NULL || ferror(file);
    if (failed) io_fail(error, "%s: %s", path, strerror(errno));
    if (file) fclose(file);
    if (!failed && length < 0) io_fail(error, "%s: is empty", path);
    if (!failed && length >= 0) return text;
    free(text);
    return NULL;
}

/* The only place of a marker; NULL, with an error, if there is none or a second one. */
static char *find_marker(char *page, const char *path, const char *marker, io_error *error) {
    char *found = strstr(page, marker);
    if (found == NULL) {
        io_fail(error, "%s: has no line %s", path, marker);
        return NULL;
    }
    if (strstr(found + 1, marker)) {
        io_fail(error, "%s: has more than one line %s", path, marker);
        return NULL;
    }
    return found;
}

/* A page between whose markers something stands. */
typedef struct marked {
    char *page, *first, *last; /* first: after the beginning marker; last: the ending one */
} marked;

static bool open_marked(marked *m, const char *path, const char *mark, io_error *error) {
    char begin[128], end[128];
    *m = (marked){NULL, NULL, NULL};
    if (snprintf(begin, sizeof begin, "<!-- begin:%s -->", mark) >= (int)sizeof begin)
        return io_fail(error, "--mark %s: too long", mark);
    snprintf(end, sizeof end, "<!-- end:%s -->", mark);
    m->page = report_read_page(path, error);
    if (m->page) m->first = find_marker(m->page, path, begin, error);
    if (m->first) m->last = find_marker(m->page, path, end, error);
    if (m->last && m->last < m->first) io_fail(error, "%s: %s stands before %s", path, end, begin);
    if (m->last && m->last > m->first) {
        m->first += strlen(begin);
        return true;
    }
    free(m->page);
    return false;
}

bool report_into(const char *path, const char *mark, const char *text, io_error *error) {
    marked m;
    if (!open_marked(&m, path, mark, error)) return false;
    io_output out = {0};
    const bool good = io_output_open(&out, path, error) &&
                      io_output_write(&out, m.page, (size_t)(m.first - m.page), error) &&
                      io_output_write(&out, "\n", 1, error) && io_output_write(&out, text, strlen(text), error) &&
                      io_output_write(&out, m.last, strlen(m.last), error) && io_output_commit(&out, error);
    io_output_discard(&out);
    free(m.page);
    return good;
}

bool report_is_in(const char *path, const char *mark, const char *text, bool *same, io_error *error) {
    marked m;
    if (!open_marked(&m, path, mark, error)) return false;
    const size_t length = strlen(text);
    *same = *m.first == '\n' && (size_t)(m.last - m.first) == length + 1 && memcmp(m.first + 1, text, length) == 0;
    free(m.page);
    return true;
}

/* ---- micro ---- */

enum { NAMES_MAX = 32 };

static const json_t *fastest_own(const json_t *lines, const char *field, const char *rays) {
    const json_t *best = NULL, *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), "result") != 0 || strcmp(results_text(line, "field"), field) != 0 ||
            strcmp(results_text(line, "rays"), rays) != 0 ||
            strncmp(results_text(line, "contender"), "embree/", 7) == 0)
            continue;
        if (results_number(line, "mrays_per_s") > (best ? results_number(best, "mrays_per_s") : 0)) best = line;
    }
    return best;
}

static void micro_page(FILE *to, const json_t *lines) {
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    char machine[512];
    run_record_text(json_array_get(lines, 0), machine, sizeof machine);
    fprintf(
        to,
        "%s.\n\nThe fastest kernel in millions of rays a second, median, and its speed over that of Embree's fastest "
        "width on the same rays.\n\n| rays |",
        machine);
    for (size_t f = 0; f < field_count; f++) fprintf(to, " %s |", fields[f]);
    fputs("\n|---|", to);
    for (size_t f = 0; f < field_count; f++) fputs("---|", to);
    fputc('\n', to);
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "| %s |", rays[r]);
        for (size_t f = 0; f < field_count; f++) {
            const json_t *best = fastest_own(lines, fields[f], rays[r]);
            const double to_embree = best ? results_number(best, "speed_to_embree_best") : 0;
            if (best == NULL) {
                fputs(" |", to);
                continue;
            }
            fprintf(to, " %.3g", results_number(best, "mrays_per_s"));
            if (to_embree > 0) fprintf(to, " (%.2f)", to_embree);
            const char *name = results_text(best, "contender");
            fprintf(to, " %.*s |", (int)strcspn(name, "/"), name);
        }
        fputc('\n', to);
    }
}

char *report_micro(const json_t *lines) {
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) return NULL;
    micro_page(file, lines);
    if (fclose(file) == 0) return text;
    free(text);
    return NULL;
}

/* ---- counts and pieces ---- */

static void put_machine(FILE *to, const json_t *lines, const char *what) {
    char machine[512];
    run_record_text(json_array_get(lines, 0), machine, sizeof machine);
    fprintf(to, "%s.\n\n%s\n", machine, what);
}

static double count_of(const json_t *line, const char *name, const char *member) {
    return results_number(json_object_get(json_object_get(line, "counts"), name), member);
}

static void put_per_ray(FILE *to, double count, double rays) {
    if (count > 0)
        fprintf(to, " %.2f |", count / rays);
    else
        fputs(" |", to);
}

static void put_with_busy(FILE *to, const json_t *line, const char *name, double rays) {
    const double events = count_of(line, name, "events"), lanes = count_of(line, name, "lanes");
    if (events > 0)
        fprintf(to, " %.2f (%.0f %%) |", lanes / rays, 100 * lanes / (events * results_number(line, "width")));
    else
        fputs(" |", to);
}

static void counts_page(FILE *to, const json_t *lines) {
    put_machine(
        to, lines,
        "Counts a ray, in brackets the share of the vector's lanes that took part. A leaf test is a ray against a "
        "cell of two triangles; grids test single triangles.");
    const char *field = "", *rays = "";
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "counts", NULL)) continue;
        if (strcmp(field, results_text(line, "field")) != 0 || strcmp(rays, results_text(line, "rays")) != 0) {
            field = results_text(line, "field");
            rays = results_text(line, "rays");
            fprintf(
                to,
                "\n**%s, %s**, %.0f %% hit\n\n| | cells | node steps | leaf tests | refills | shared nodes | voxels "
                "| triangles |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
                field, rays, 100 * results_number(line, "hit_share"));
        }
        const double count = results_number(line, "ray_count"), leaves = count_of(line, "leaf", "lanes");
        fprintf(to, "| %s |", results_text(line, "contender"));
        put_with_busy(to, line, "flat", count);
        put_with_busy(to, line, "node", count);
        put_with_busy(to, line, "leaf", count);
        put_per_ray(to, count_of(line, "refill", "events"), count);
        put_per_ray(to, count_of(line, "shared_node", "events"), count);
        put_per_ray(to, count_of(line, "voxel", "events"), count);
        put_per_ray(to, count_of(line, "triangle", "events") + 2 * leaves, count);
        fputc('\n', to);
    }
}

static void parts_page(FILE *to, const json_t *lines) {
    put_machine(to, lines,
                "Each piece by itself, millions a second, median.\n\n| piece | of | lanes | millions / s | MAD |"
                "\n|---|---|--:|--:|--:|");
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "part", NULL)) continue;
        const char *memory = results_text(line, "memory"), *field = results_text(line, "field");
        fprintf(to, "| %s%s%s%s%s | %s | ", results_text(line, "part"), *memory ? ", " : "", memory, *field ? ", " : "",
                field, results_text(line, "unit"));
        if (results_number(line, "width") > 0) fprintf(to, "%.0f", results_number(line, "width"));
        fprintf(to, " | %.4g | %.1f %% |\n", results_number(line, "per_second") * 1e-6,
                100 * results_number(line, "seconds_mad") / results_number(line, "seconds_median"));
    }
}

/* ---- choosing the page ---- */

typedef struct report_options {
    const char *json, *targets, *into, *mark, *csv;
    bool brief;
} report_options;

/* What there is in the results; *name is the mark by default. */
static char *page_of(const json_t *lines, bool brief, const char **name) {
    if (strcmp(*name = results_text(json_array_get(lines, 0), "command"), "table") == 0)
        return table_markdown(lines, brief);
    if (strcmp(*name, "tradeoff") == 0) return tradeoff_markdown(lines);
    const bool parts = results_find(lines, "part", NULL) != NULL, counts = results_find(lines, "counts", NULL) != NULL;
    if (!parts && !counts) return report_micro(lines);
    *name = parts ? "parts" : "counters";
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (file == NULL) return NULL;
    parts ? parts_page(file, lines) : counts_page(file, lines);
    return fclose(file) == 0 ? text : NULL;
}

static bool put_page(const report_options *o, const char *name, const char *text, io_error *error) {
    if (text == NULL) return io_fail(error, "out of memory");
    if (o->into) return report_into(o->into, o->mark ? o->mark : name, text, error);
    fputs(text, stdout);
    return true;
}

static bool report_results(const report_options *o, io_error *error) {
    json_t *lines = results_read(o->json, error);
    if (lines == NULL) return false;
    const char *name = results_text(json_array_get(lines, 0), "command");
    bool good = strcmp(name, "table") == 0 || strcmp(name, "micro") == 0 || strcmp(name, "parts") == 0 ||
                strcmp(name, "tradeoff") == 0 ||
                io_fail(error, "%s:1: results of '%s': only those of table, micro, parts and tradeoff can be reported",
                        o->json, name);
    if (good) {
        char *text = page_of(lines, o->brief, &name);
        good = put_page(o, name, text, error);
        free(text);
    }
    json_decref(lines);
    return good;
}

static bool report_targets(const report_options *o, io_error *error) {
    targets_data data;
    bool good = targets_open(&data, o->targets, error);
    char *text = NULL;
    size_t size = 0;
    FILE *file = good ? open_memstream(&text, &size) : NULL;
    if (file) {
        targets_markdown(file, &data);
        if (fclose(file) != 0) text = NULL;
    }
    io_output csv = {0};
    good = good && (o->csv == NULL || io_output_open(&csv, o->csv, error));
    if (good && csv.file) {
        targets_csv(csv.file, &data);
        good = io_output_commit(&csv, error);
    }
    io_output_discard(&csv);
    good = good && put_page(o, "targets", text, error);
    free(text);
    targets_close(&data);
    return good;
}

int report_main(char **arguments, int count) {
    report_options o = {.brief = false};
    const option options[] = {
        {"--json", "FILE", "the results: table.json, tradeoff.json, or what micro --json or parts --json wrote",
         OPTION_TEXT, &o.json, 0, 0},
        {"--targets", "FOLDER", "instead: what is aimed at, from the files that measure made there", OPTION_TEXT,
         &o.targets, 0, 0},
        {"--into", "FILE", "the page to put them into; without it they are printed", OPTION_TEXT, &o.into, 0, 0},
        {"--mark", "NAME", "the markers' name; by default table, micro, counters, parts or targets", OPTION_TEXT,
         &o.mark, 0, 0},
        {"--csv", "FILE", "of targets: write the same figures there", OPTION_TEXT, &o.csv, 0, 0},
        {"--brief", NULL, "of a table: only times and tracing speed", OPTION_FLAG, &o.brief, 0, 0},
    };
    const option_frame frame = {
        .command = "report", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    bool good = true;
    if ((o.json == NULL) == (o.targets == NULL))
        good = io_fail(&error, "either --json with a file of results or --targets with a folder of them is needed");
    if (good && o.csv && !o.targets) good = io_fail(&error, "--csv: goes with --targets");
    if (!good) return options_misused("report", &error);
    if (o.json ? report_results(&o, &error) : report_targets(&o, &error)) return EXIT_SUCCESS;
    return options_failed("report", &error);
}
