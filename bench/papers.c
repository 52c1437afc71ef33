/* SPDX-License-Identifier: Apache-2.0 */
#include "papers.h"

#include "options.h"
#include "output.h"
#include "plot.h"
#include "report.h"
#include "results.h"
#include "table.h"
#include "targets.h"
#include "tradeoff_main.h"

#include <errno.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *const usage =
    "Usage: cellwalk-bench papers [OPTIONS]\n"
    "\n"
    "Puts every table into README.md and papers/*.md, between <!-- begin:NAME --> and <!-- end:NAME -->, and draws "
    "every\n"
    "picture, from the files of results in papers/data. The same files give the same pages and pictures. Nothing is\n"
    "written unless all tables can be made.\n"
    "\n"
    "Options:\n";

/* ---- the files ---- */

static bool path_of(const papers_data *d, const char *name, char path[4096], io_error *error) {
    return snprintf(path, 4096, "%s/%s", d->folder, name) < 4096 ||
           io_fail(error, "%s: the name is too long", d->folder);
}

bool papers_lines_if_there(papers_data *d, const char *name, const json_t **lines, io_error *error) {
    char path[4096];
    *lines = NULL;
    for (size_t k = 0; k < d->count; k++)
        if (strcmp(d->names[k], name) == 0) *lines = d->lines[k];
    if (*lines) return true;
    if (!path_of(d, name, path, error)) return false;
    if (access(path, F_OK) != 0) return true;
    if (d->count == PAPERS_FILES) return io_fail(error, "%s: one file too many", path);
    json_t *read = results_read(path, error);
    if (read == NULL) return false;
    d->names[d->count] = name;
    *lines = d->lines[d->count++] = read;
    return true;
}

const json_t *papers_lines(papers_data *d, const char *name, io_error *error) {
    const json_t *lines;
    if (papers_lines_if_there(d, name, &lines, error) && lines == NULL)
        io_fail(error, "%s/%s: is not there; the build target papers-data makes it", d->folder, name);
    return lines;
}

const json_t *papers_speeds(papers_data *d, const char **isa, io_error *error) {
    static const char *const files[][2] = {
        {"speed-avx512.json", "avx512"}, {"speed-avx2.json", "avx2"}, {"speed-sse42.json", "sse4.2"}};
    const json_t *lines = NULL;
    for (size_t k = 0; k < sizeof files / sizeof files[0] && lines == NULL; k++) {
        *isa = files[k][1];
        if (!papers_lines_if_there(d, files[k][0], &lines, error)) return NULL;
    }
    if (lines == NULL)
        io_fail(error, "%s: has no file speed-….json; the build target papers-data makes them", d->folder);
    return lines;
}

/* ---- what tables share ---- */

void papers_put_head(FILE *to, const char *first, const char *const *names, size_t count) {
    fprintf(to, "| %s |", first);
    for (size_t k = 0; k < count; k++) fprintf(to, " %s |", names[k]);
    fputs("\n|---|", to);
    for (size_t k = 0; k < count; k++) fputs("--:|", to);
    fputc('\n', to);
}

void papers_put_ratio(FILE *to, double above, double below) {
    if (above > 0 && below > 0)
        fprintf(to, " %.2f |", above / below);
    else
        fputs(" |", to);
}

/* ---- blocks that other commands have as well ---- */

static bool put_text(FILE *to, char *text, io_error *error) {
    if (text) fputs(text, to);
    free(text);
    return text || io_fail(error, "out of memory");
}

static bool block_table(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "scenes/table.json", error);
    return lines && put_text(to, table_markdown(lines, true), error);
}

static bool block_tradeoff(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "tradeoff/tradeoff.json", error);
    return lines && put_text(to, tradeoff_markdown(lines), error);
}

typedef void put_targets(FILE *to, const targets_data *d);
static bool with_targets(FILE *to, const papers_data *d, put_targets *put, io_error *error) {
    targets_data data;
    const bool good = targets_open(&data, d->folder, error);
    if (good) put(to, &data);
    targets_close(&data);
    return good;
}

static bool block_targets(FILE *to, papers_data *d, io_error *error) {
    return with_targets(to, d, targets_put_table, error);
}
static bool block_speeds(FILE *to, papers_data *d, io_error *error) {
    return with_targets(to, d, targets_put_speeds, error);
}
static bool block_building(FILE *to, papers_data *d, io_error *error) {
    return with_targets(to, d, targets_put_building, error);
}

static const struct {
    const char *name;
    papers_block *put;
} blocks[] = {
    {"table", block_table},        {"tradeoff", block_tradeoff},      {"targets", block_targets},
    {"speeds", block_speeds},      {"building", block_building},      {"sources", papers_sources},
    {"summary", papers_summary},   {"threads", papers_threads},       {"widths", papers_widths},
    {"peers", papers_peers},       {"coursework", papers_coursework}, {"frontier", papers_frontier},
    {"walks", papers_walks},       {"limits", papers_limits},         {"pieces", papers_pieces},
    {"ablation", papers_ablation}, {"caches", papers_caches},         {"pages", papers_pages},
};
enum { BLOCKS = sizeof blocks / sizeof blocks[0] };

/* ---- pages ---- */

/* One block of one page, ready to be put in. */
typedef struct fill {
    const char *page, *name;
    char *text;
} fill;

typedef struct fills {
    fill items[128];
    size_t count;
} fills;

static bool make_text(const char *page, size_t block, papers_data *d, fills *all, io_error *error) {
    char *text = NULL;
    size_t size = 0;
    if (all->count == sizeof all->items / sizeof all->items[0]) return io_fail(error, "%s: one block too many", page);
    FILE *to = open_memstream(&text, &size);
    if (to == NULL) return io_fail(error, "out of memory");
    bool good = blocks[block].put(to, d, error);
    good = (fclose(to) == 0 || io_fail(error, "out of memory")) && good;
    if (good)
        all->items[all->count++] = (fill){page, blocks[block].name, text};
    else
        free(text);
    return good;
}

static bool take_page(const char *page, papers_data *d, fills *all, io_error *error) {
    char *text = report_read_page(page, error);
    bool good = text != NULL;
    for (size_t k = 0; good && k < BLOCKS; k++) {
        char begin[64];
        snprintf(begin, sizeof begin, "<!-- begin:%s -->", blocks[k].name);
        if (strstr(text, begin)) good = make_text(page, k, d, all, error);
    }
    free(text);
    return good;
}

/* Writes, or says which blocks are not what the files give. */
static bool put_all(const fills *all, bool check, io_error *error) {
    size_t stale = 0;
    for (size_t k = 0; k < all->count; k++) {
        const fill *f = &all->items[k];
        bool same = false;
        if (check ? !report_is_in(f->page, f->name, f->text, &same, error)
                  : !report_into(f->page, f->name, f->text, error))
            return false;
        if (!check) printf("%s: %s\n", f->page, f->name);
        if (check && !same) printf("%s: %s is not what the files give\n", f->page, f->name);
        stale += check && !same;
    }
    return stale == 0 ||
           io_fail(error, "%zu tables are not up to date; 'cellwalk-bench papers' makes them again", stale);
}

typedef struct papers_options {
    const char *root, *data, *pictures;
    bool check;
} papers_options;

static bool run(const papers_options *o, io_error *error) {
    papers_data data = {.folder = o->data};
    fills *all = calloc(1, sizeof *all);
    glob_t pages = {0};
    char pattern[4096];
    bool good = all || io_fail(error, "out of memory");
    snprintf(pattern, sizeof pattern, "%s/README.md", o->root);
    good = good && (glob(pattern, 0, NULL, &pages) == 0 || io_fail(error, "%s: is not there", pattern));
    snprintf(pattern, sizeof pattern, "%s/papers/*.md", o->root);
    good = good && (glob(pattern, GLOB_APPEND, NULL, &pages) == 0 || io_fail(error, "%s: no page is there", pattern));
    for (size_t k = 0; good && k < pages.gl_pathc; k++) good = take_page(pages.gl_pathv[k], &data, all, error);
    good = good && put_all(all, o->check, error) && (o->check || plot_folder(o->data, o->pictures, error));
    for (size_t k = 0; all && k < all->count; k++) free(all->items[k].text);
    for (size_t k = 0; k < data.count; k++) json_decref(data.lines[k]);
    globfree(&pages);
    free(all);
    return good;
}

int papers_main(char **arguments, int count) {
    papers_options o = {.root = ".", .data = "papers/data", .pictures = "papers/pictures"};
    const option options[] = {
        {"--root", "FOLDER", "where README.md and papers/ are (.)", OPTION_TEXT, &o.root, 0, 0},
        {"--data", "FOLDER", "the files of results (papers/data)", OPTION_TEXT, &o.data, 0, 0},
        {"--pictures", "FOLDER", "where to put the pictures (papers/pictures)", OPTION_TEXT, &o.pictures, 0, 0},
        {"--check", NULL, "write nothing; fail if a page has other figures than the files give", OPTION_FLAG, &o.check,
         0, 0},
    };
    const option_frame frame = {
        .command = "papers", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    if (run(&o, &error)) return EXIT_SUCCESS;
    return options_failed("papers", &error);
}
