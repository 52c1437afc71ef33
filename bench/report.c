/* SPDX-License-Identifier: Apache-2.0 */
#include "report.h"

#include "options.h"
#include "output.h"
#include "results.h"
#include "run_record.h"
#include "table.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-bench report [OPTIONS] --json FILE\n"
    "\n"
    "Prints results of 'table' or 'micro --json' as Markdown, or puts them into a page between the two lines\n"
    "<!-- begin:NAME --> and <!-- end:NAME -->. The same file gives the same text.\n"
    "\n"
    "Options:\n";

/* ---- into a page ---- */

static char *read_whole(const char *path, io_error *error) {
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

bool report_into(const char *path, const char *mark, const char *text, io_error *error) {
    char begin[128], end[128];
    if (snprintf(begin, sizeof begin, "<!-- begin:%s -->", mark) >= (int)sizeof begin)
        return io_fail(error, "--mark %s: too long", mark);
    snprintf(end, sizeof end, "<!-- end:%s -->", mark);
    char *page = read_whole(path, error);
    if (page == NULL) return false;
    char *first = find_marker(page, path, begin, error), *last = first ? find_marker(page, path, end, error) : NULL;
    bool good = first && last;
    if (good && last < first) good = io_fail(error, "%s: %s stands before %s", path, end, begin);
    io_output out = {0};
    good = good && io_output_open(&out, path, error);
    if (good) {
        first += strlen(begin);
        good = io_output_write(&out, page, (size_t)(first - page), error) && io_output_write(&out, "\n", 1, error) &&
               io_output_write(&out, text, strlen(text), error) && io_output_write(&out, last, strlen(last), error) &&
               io_output_commit(&out, error);
    }
    io_output_discard(&out);
    free(page);
    return good;
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

static bool run(const char *json, const char *into, const char *mark, bool brief, io_error *error) {
    json_t *lines = results_read(json, error);
    if (lines == NULL) return false;
    const char *command = results_text(json_array_get(lines, 0), "command");
    const bool table = strcmp(command, "table") == 0;
    bool good = table || strcmp(command, "micro") == 0 ||
                io_fail(error, "%s:1: results of '%s': only those of table and micro can be reported", json, command);
    char *text = NULL;
    if (good) {
        text = table ? table_markdown(lines, brief) : report_micro(lines);
        good = text || io_fail(error, "out of memory");
    }
    if (good && into) good = report_into(into, mark ? mark : command, text, error);
    if (good && !into) fputs(text, stdout);
    free(text);
    json_decref(lines);
    return good;
}

int report_main(char **arguments, int count) {
    const char *json = NULL, *into = NULL, *mark = NULL;
    bool brief = false;
    const option options[] = {
        {"--json", "FILE", "the results: table.json, or what micro --json wrote", OPTION_TEXT, &json, 0, 0},
        {"--into", "FILE", "the page to put them into; without it they are printed", OPTION_TEXT, &into, 0, 0},
        {"--mark", "NAME", "the markers' name; by default table or micro", OPTION_TEXT, &mark, 0, 0},
        {"--brief", NULL, "of a table: only times and tracing speed", OPTION_FLAG, &brief, 0, 0},
    };
    const option_frame frame = {
        .command = "report", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    bool good = true;
    if (good && json == NULL) good = io_fail(&error, "--json: the file of results is missing");
    if (!good) return options_misused("report", &error);
    if (run(json, into, mark, brief, &error)) return EXIT_SUCCESS;
    return options_failed("report", &error);
}
