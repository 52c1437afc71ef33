/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench measure and table: runs a plan line by line. A result stands in the file with its interval, and with
 * "converged": false where that is too wide or comes from too few passes; then the exit status is 1. */

#include "build_info.h"
#include "clock.h"
#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- a workload ---- */

entrant *measure_enter(workload *w, const char *group, const char *name, io_error *error) {
    if (w->count == ENTRANTS_MAX) {
        io_fail(error, "%s: more than %d contenders", w->name, ENTRANTS_MAX);
        return NULL;
    }
    entrant *e = &w->entrants[w->count++];
    snprintf(e->name, sizeof e->name, "%s", name);
    snprintf(e->group, sizeof e->group, "%s", group);
    e->line = json_object();
    results_set_texts(e->line, "kind workload isa field item unit contender group",
                      (const char *[]){"result", w->name, cw_isa_name((cw_isa)w->options->run.isa), w->field, w->item,
                                       w->kind->unit, name, group});
    return e;
}

static void leave_all(workload *w) {
    for (entrant *e = w->entrants; e < w->entrants + w->count; e++) {
        if (e->own) w->kind->leave(e);
        json_decref(e->line);
    }
    if (w->own && w->kind->close) w->kind->close(w);
    free(w->entrants);
}

static void set_time(workload *w, entrant *e, const entrant *first) {
    const statistics *s = &e->job.seconds;
    const statistics to = interleave_ratio(&e->job, &first->job);
    results_set_numbers(e->line, "items", &w->items);
    results_set_counts(e->line, "samples", &s->n);
    results_set_numbers(
        e->line,
        "seconds_min seconds_median seconds_low seconds_high per_second time_to_first time_to_first_low "
        "time_to_first_high",
        (double[]){s->min, s->median, s->low, s->high, w->items / s->median, to.median, to.low, to.high});
    json_object_set_new(e->line, "converged", json_boolean(e->job.converged));
    json_object_set_new(e->line, "by_clock", json_boolean(e->job.by_clock));
}

/* Those that are not left out; the fastest of a group, as of Embree's widths, is marked. */
static void time_all(workload *w, double seconds) {
    interleave_job *jobs[ENTRANTS_MAX];
    entrant *first = NULL;
    size_t count = 0;
    for (entrant *e = w->entrants; e < w->entrants + w->count; e++) {
        if (e->why[0]) continue;
        if (first == NULL) first = e;
        e->job.group = e->group;
        jobs[count++] = &e->job;
    }
    interleave(jobs, count, &(interleave_limits){w->options->width, seconds, w->options->run.seed});
    for (entrant *e = w->entrants; e < w->entrants + w->count; e++) {
        if (e->why[0]) continue;
        set_time(w, e, first);
        json_object_set_new(e->line, "best_of_group", json_boolean(e->job.best));
    }
}

/* *left: seconds for all timing that is still to come, of which this line may take a share. */
static bool run_line(const plan_line *line, const measure_options *o, double share, double *left, json_t *results,
                     io_error *error) {
    workload w = {.name = line->workload, .field = line->field, .item = line->item, .kind = line->kind, .options = o};
    w.entrants = memory(ENTRANTS_MAX, sizeof *w.entrants);
    bool good = w.kind->open(&w, error);
    for (size_t k = 0; good && w.why[0] == '\0' && k < line->count; k++)
        good = w.kind->enter(&w, line->contenders[k], error);
    for (size_t k = 0; good && k < w.count; k++) {
        entrant *e = &w.entrants[k];
        if (e->why[0])
            json_object_set_new(e->line, "left_out", json_string(e->why));
        else
            good = w.kind->judge(&w, e, line->metrics, error);
    }
    if (good && (line->metrics & METRIC_TIME)) {
        const double start = clock_seconds();
        time_all(&w, *left * share);
        *left = fmax(*left - (clock_seconds() - start), 0);
    }
    if (good) print_workload(&w);
    for (size_t k = 0; good && k < w.count; k++) {
        results_set_counts(w.entrants[k].line, "line", &line->number);
        json_array_append(results, w.entrants[k].line);
    }
    leave_all(&w);
    return good;
}

/* ---- a plan ---- */

/* An answer that rounding does not explain: an error in its place. */
static bool is_right(const json_t *line, io_error *error) {
    const double wrong = results_number(json_object_get(json_object_get(line, "agreement"), "why"), "other");
    return wrong == 0 || io_fail(error, "%s: %.0f answers of %s are wrong", results_text(line, "workload"), wrong,
                                 results_text(line, "contender"));
}

/* After each line, so that an interrupted run leaves what it measured. Of no results: whether FILE can be written. */
static bool save(const char *path, const json_t *results, io_error *error) {
    io_output out = {0};
    if (path == NULL) return true;
    bool good = io_output_open(&out, path, error);
    for (size_t k = 0; good && k < json_array_size(results); k++)
        good = results_write(&out, json_incref(json_array_get(results, k)), error);
    good = good && (results == NULL || io_output_commit(&out, error));
    io_output_discard(&out);
    return good;
}

/* Times that no page may quote. */
static size_t count_wide(const json_t *results) {
    size_t index, wide = 0;
    const json_t *line;
    json_array_foreach((json_t *)results, index, line) wide +=
        json_is_true(json_object_get(line, "best_of_group")) && json_is_false(json_object_get(line, "converged"));
    return wide;
}

static bool run_plan(const plan *p, const char *name, measure_options *o, json_t *results, io_error *error) {
    int cpu;
    size_t timed = 0;
    char text[512];
    const cw_isa most = (cw_isa)o->run.isa;
    for (size_t k = 0; k < p->count; k++) {
        timed += (p->lines[k].metrics & METRIC_TIME) != 0;
        for (size_t c = 0; c < p->lines[k].count; c++) /* threads need more than one CPU */
            o->run.no_pin = o->run.no_pin || strstr(p->lines[k].contenders[c], ":threads=") != NULL;
    }
    bool good = run_options_pin(&o->run, &cpu, error);
    json_t *record = run_record("measure", o->run.seed, cpu);
    json_object_set_new(record, "plan", json_string(name));
    run_record_text(record, text, sizeof text);
    printf("%s\n", text);
    json_array_append_new(results, record);
    good = good && save(o->out, NULL, error);
    if (o->seconds <= 0) o->seconds = 10 * (double)timed;
    /* Making fields and building Embree do not count. What a line that has converged leaves, the later ones get. */
    double left = o->seconds;
    for (size_t k = 0; good && k < p->count; k++) {
        const plan_line *line = &p->lines[k];
        const cw_isa isa = line->isa < 0 ? most : (cw_isa)line->isa;
        o->run.isa = (int)isa;
        if (!cw_isa_includes(most, isa)) {
            printf("\n%s with %s is left out: this machine, or the limit, has no more than %s\n", line->workload,
                   cw_isa_name(isa), cw_isa_name(most));
        } else {
            cw_isa_limit(isa);
            good = run_line(line, o, 1 / (double)(timed ? timed : 1), &left, results, error) &&
                   save(o->out, results, error);
        }
        timed -= (line->metrics & METRIC_TIME) != 0;
    }
    land_end();
    if (good && count_wide(results) > 0)
        fprintf(stderr,
                "%zu results have not converged in %.3g s: no figure of theirs may be quoted; give more --seconds, or "
                "stop other programs\n",
                count_wide(results), o->seconds);
    for (size_t k = 0; good && k < json_array_size(results); k++) good = is_right(json_array_get(results, k), error);
    return good;
}

/* With its parents. */
static bool make_folder(const char *folder, io_error *error) {
    char path[PATH_MAX], *end = path;
    if (snprintf(path, sizeof path, "%s", folder) >= PATH_MAX) errno = ENAMETOOLONG, end = NULL;
    while (end != NULL) {
        end = strchr(end + 1, '/');
        if (end) *end = '\0';
        if (mkdir(path, 0777) != 0 && errno != EEXIST) break;
        if (end == NULL) return true;
        *end = '/';
    }
    return io_fail(error, "folder %s: %s", folder, strerror(errno));
}

/* Runs a plan, writes its results to o->out and, with a folder, the scenes' table there. */
static int measure(const char *as, const char *name, measure_options *o, const char *folder) {
    char file[PATH_MAX], table[PATH_MAX];
    io_output text = {0};
    io_error error = {{0}};
    json_t *results = json_array();
    plan p;
    if (!run_options_check(&o->run, as)) return EXIT_USAGE;
    /* Outputs are opened when all inputs are known. */
    bool good = measure_plan_read(&p, name, o, &error);
    if (good && folder) {
        good = make_folder(folder, &error);
        if (good && snprintf(file, sizeof file, "%s/table.jsonl", folder) >= PATH_MAX)
            good = io_fail(&error, "folder %s: %s", folder, strerror(ENAMETOOLONG));
        snprintf(table, sizeof table, "%s/table.md", folder);
        o->out = file;
    }
    good = good && (folder == NULL || io_output_open(&text, table, &error)) && run_plan(&p, name, o, results, &error);
    if (good && folder) {
        printf("\n");
        print_scenes(stdout, results);
        print_scenes(text.file, results);
        good = io_output_commit(&text, &error);
    }
    /* The scenes' table is the work itself, and says which of its figures have not converged. */
    const bool wide = folder == NULL && count_wide(results) > 0;
    io_output_discard(&text);
    measure_plan_free(&p);
    json_decref(results);
    if (!good) return command_fail(as, "%s", error.text);
    return wide ? EXIT_FAILURE : EXIT_SUCCESS;
}

/* ---- command lines ---- */

#define COMMON_OPTIONS(o, usual_seconds, usual_width)                                                                  \
    option_text("scenes", "FOLDER", &(o).scenes,                                                                       \
                "folder with the scenes' .pbrt files; by default those built with this program"),                      \
        option_range("seconds", "S", &(o).seconds, 0.01, 1e6, NULL,                                                    \
                     "seconds for all timing together (" usual_seconds ")"),                                           \
        option_range("width", "SHARE", &(o).width, 1e-6, 10, NULL,                                                     \
                     "an interval is narrow if it is at most SHARE of its middle wide (" usual_width ")"),             \
        RUN_OPTIONS((o).run)

static const char what[] =
    "Runs a plan: a file, or one that ships (release, speed, first, single, tradeoff, scenes). "
    "Each of its lines is \"FIELD/WORK CONTENDERS METRICS\", with commas in lists and # "
    "before comments; a fourth word names instruction sets:\n\n"
    "  257,1025/primary  default,embree               time\n"
    "  8193/primary      default,coarser:2,coarser:4  time,error\n"
    "  scenes/hftest     default,grid3d,embree        time\n\n"
    "Metrics are time, agree (whether answers are the first contender's), error (against the truth) and instructions "
    "(one pass, for callgrind). "
    "Contenders are compared first, then timed in turns, each round in another order, until the 95 % intervals of "
    "their ratios to the first are narrow. The exit status is 1 if a figure did not get there, which is marked, or if "
    "an answer is wrong.\n\n"
    "A field is a number of samples a side of fractal land, sea-calm, sea-rough, plane, grooves, comb, checkerboard, "
    "jacksboro, or a raster's file. Without a plan, --field times all classes of rays on your raster beside Embree.";

static const char examples[] = "  cellwalk-bench measure --field dem.tif            # your own land\n"
                               "  cellwalk-bench measure speed -o speed.jsonl\n"
                               "  cellwalk-bench measure release -o release.jsonl\n"
                               "  cellwalk-bench measure my.plan --seconds 60 --isa avx2 -o mine.jsonl\n";

static char *help_of_kinds(void) {
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    if (stream == NULL) memory_end();
    fprintf(stream, "%s\n\n", what);
    for (size_t k = 0; measure_kind(k); k++)
        fprintf(stream, "  %-15s %s\n", measure_kind(k)->form, measure_kind(k)->what);
    fprintf(stream, "\n%s.", contenders_help);
    if (fclose(stream) != 0) memory_end();
    return text;
}

static int start_measure(int argc, char **argv) {
    measure_options o = {.run = RUN_DEFAULTS, .scenes = BUILD_INFO_SCENES, .count = 65536, .width = 0.04};
    const option_spec options[] = {
        {"out", "FILE", "write results there after each line of the plan, a JSON object each", OPTION_TEXT,
         .to = &o.out, .letter = 'o'},
        option_text("field", "FILE", &o.field,
                    "stands for FIELD in the plan; without a plan, the raster to measure on"),
        option_range("cellsize", "SIZE", &o.cell_size, 1e-9, 1e9, NULL,
                     "cell size of a raster that does not say, in its unit of heights"),
        option_count("count", "N", &o.count, 16, 1 << 24, "rays of a pass (65536)"),
        COMMON_OPTIONS(o, "10 a line of the plan", "0.04"),
    };
    static const char *const names[] = {"PLAN"};
    char *text = help_of_kinds();
    const options_usage usage = {"measure", "[PLAN] [-o FILE.jsonl] [OPTIONS]", text,  examples,
                                 options,   sizeof options / sizeof *options,   names, 0,
                                 1};
    const char *name;
    const int status = options_parse(&usage, argc, argv, &name);
    free(text);
    if (status != OPTIONS_GO) return status;
    if (name == NULL && o.field == NULL) return command_fail("measure", "give a PLAN, or --field FILE"), EXIT_USAGE;
    return measure("measure", name ? name : "field", &o, NULL);
}

static int start_table(int argc, char **argv) {
    const char *folder = "out/table";
    bool quick = false;
    measure_options o = {.run = RUN_DEFAULTS, .scenes = BUILD_INFO_SCENES, .count = 16, .width = 0.1};
    const option_spec options[] = {
        option_text("out", "FOLDER", &folder, "folder for table.md and table.jsonl, made if missing (out/table)"),
        option_flag("quick", &quick, "the smallest scene alone: a first look"),
        COMMON_OPTIONS(o, "120", "0.1"),
    };
    static const char purpose[] =
        "Renders the six scenes on one thread with the rays of Embree and of the kernels, in turns, and "
        "prints their times: the plan \"scenes\" of cellwalk-bench measure.";
    const options_usage usage = {
        "table", "[OPTIONS]", purpose, "  cellwalk-bench table --quick\n", options, sizeof options / sizeof *options,
        NULL,    0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    if (o.seconds <= 0) o.seconds = quick ? 10 : 120;
    return measure("table", quick ? "scenes-quick" : "scenes", &o, folder);
}

const command command_measure = {"measure", "compare and time contenders by a plan, or on a raster of your own",
                                 start_measure};
const command command_table = {"table", "time six scenes rendered by Embree and the kernels; write the table",
                               start_table};
