/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-stability: thousands of millions of aimed rays, the same ones for every contender. It is not
 * a subcommand of cellwalk-bench because it judges with the exact oracle, which needs GMP and belongs to the tests.
 *
 * A run uses one thread. Several processes with --part 1/N … N/N together trace the rays of one without it, and a
 * run that was ended early goes on with --first. Their files add up, since batch number n has the same rays in every
 * run. */

#include "clock.h"
#include "command.h"
#include "harness/harness_run.h"
#include "harness/results.h"
#include "reference.h"
#include "stability/run.h"

#include <inttypes.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static volatile sig_atomic_t stopped;

static void stop(int signal_number) {
    stopped = 1;
    signal(signal_number, SIG_DFL); /* a second one ends at once */
}

static void show_progress(const stability *s, uint64_t done, uint64_t wanted, double seconds) {
    const double rays = (double)(s->batches * BATCH_RAYS),
                 left = done ? seconds * (double)(wanted - done) / (double)done : 0;
    fprintf(stderr, "\r%.0f million rays, %.2f million a second, %" PRIu64 " faults, %.0f s left   ", rays * 1e-6,
            seconds > 0 ? rays * 1e-6 / seconds : 0, stability_faults(s), left);
    if (!isatty(STDERR_FILENO)) fputc('\n', stderr);
}

/* Batches first, first + 1 … end - 1 that fall to part of parts: those with number % parts == part - 1. */
typedef struct batch_range {
    unsigned part, parts;
    uint64_t first, end;
} batch_range;

typedef struct settings {
    unsigned million, sample, first;
    const char *part, *json;
    bool no_embree;
} settings;

static bool plan_range(const settings *o, batch_range *r, io_error *error) {
    const uint64_t round_rays = (uint64_t)ROUND_BATCHES * BATCH_RAYS;
    char rest;
    *r = (batch_range){.part = 1, .parts = 1, .first = o->first};
    r->end = ((uint64_t)o->million * 1000000 + round_rays - 1) / round_rays * ROUND_BATCHES;
    if (o->part && (sscanf(o->part, "%u/%u%c", &r->part, &r->parts, &rest) != 2 || r->part < 1 || r->part > r->parts))
        return io_fail(error, "--part %s: not K/N with 1 <= K <= N", o->part);
    return r->first < r->end ||
           io_fail(error, "--first %" PRIu64 ": there are only %" PRIu64 " batches", r->first, r->end);
}

/* r->end becomes where it ended; the CPU time that it took. */
static double run_batches(stability *s, batch_range *r) {
    const double begin = clock_seconds(), begin_cpu = clock_cpu_seconds(), every = isatty(STDERR_FILENO) ? 1 : 60;
    double shown = begin;
    const uint64_t wanted = (r->end - r->first + r->parts - 1) / r->parts;
    uint64_t n = r->first;
    for (; n < r->end && !stopped; n++) {
        if (n % r->parts != r->part - 1) continue;
        stability_batch(s, n);
        const double now = clock_seconds();
        if (now - shown < every) continue;
        shown = now;
        show_progress(s, s->batches, wanted, now - begin);
    }
    r->end = n;
    show_progress(s, s->batches, s->batches, clock_seconds() - begin);
    fputc('\n', stderr);
    return clock_cpu_seconds() - begin_cpu;
}

/* ---- results ---- */

/* A contender's role beside the reference: "reference", "same-bits", "own-rules". */
static const char *const roles[] = {"reference", "same-bits", "own-rules"};

static json_t *result_line(const tested *t, aim kind, aim_start start, const counts *c) {
    json_t *line = json_object();
    results_set_texts(
        line, "kind contender role rays start",
        (const char *[]){"result", t->contender.name, roles[t->role], aim_name(kind), aim_start_name(start)});
    results_set_counts(line, "traced hits other_bits", (size_t[]){c->rays, c->hits, c->other});
    if (t->role == ROLE_SAME_BITS) return line;
    results_set_counts(line, "pass leaks phantoms decided_exactly sampled",
                       (size_t[]){c->pass, c->leaks, c->phantoms, c->exact, c->sampled});
    results_set_numbers(line, "residual apart t_error", (double[]){c->residual, c->apart, c->t_error});
    json_t *verdicts = json_object(), *ulp = json_array();
    results_set_counts(verdicts, "right tie leak phantom wrong_surface", c->verdict);
    json_object_set_new(line, "verdicts", verdicts);
    for (int k = 0; k < ULP_BINS; k++) json_array_append_new(ulp, json_integer((json_int_t)c->ulp[k]));
    json_object_set_new(line, "t_error_ulp", ulp);
    return line;
}

/* A line of kind "run", one of kind "field" for each field, one of kind "result" for each contender, class and
 * start. */
static bool write_lines(io_output *out, const stability *s, const batch_range *r, double seconds, io_error *error) {
    json_t *run = run_record("stability", 0, -1);
    results_set_counts(run, "part parts first end batches sample",
                       (size_t[]){r->part, r->parts, r->first, r->end, s->batches, s->sample});
    results_set_numbers(run, "seconds", &seconds);
    if (!results_write(out, run, error)) return false;
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        json_t *line = json_object();
        results_set_texts(line, "kind field text",
                          (const char *[]){"field", s->field[f].samples.name, s->field[f].samples.text});
        if (!results_write(out, line, error)) return false;
    }
    for (unsigned n = 0; n < s->contenders; n++)
        for (int k = 0; k < AIM_COUNT * START_COUNT; k++) {
            const aim kind = (aim)(k / START_COUNT);
            const aim_start start = (aim_start)(k % START_COUNT);
            const counts *c = &s->count[n][kind][start];
            if (c->rays && !results_write(out, result_line(&s->tested[0][n], kind, start, c), error)) return false;
        }
    return true;
}

/* A line a contender, all classes together. */
static void print_counts(const stability *s) {
    printf("%-28s %14s %14s %10s %10s %10s\n", "contender", "rays", "known to pass", "leaks", "phantoms", "other bits");
    for (unsigned n = 0; n < s->contenders; n++) {
        const counts sum = stability_sum(s, n, AIM_COUNT);
        printf("%-28s %14" PRIu64 " %14" PRIu64 " %10" PRIu64 " %10" PRIu64 " %10" PRIu64 "\n",
               s->tested[0][n].contender.name, sum.rays, sum.pass, sum.leaks, sum.phantoms, sum.other);
    }
}

static bool run(const settings *o, batch_range range, io_error *error) {
    static stability s;
    const uint64_t all = range.end;
    const bool embree = !o->no_embree && peer_embree.version;
    if (!o->no_embree && !embree) fputs("cellwalk-stability: built without Embree, which is left out\n", stderr);
    const stability_shares shares = {.others = 16, .slow = 128, .peers = embree ? 16 : 0};
    bool good = stability_make(&s, shares, o->sample, error);
    s.explain = true;
    signal(SIGINT, stop);
    signal(SIGTERM, stop);
    if (good) {
        const double seconds = run_batches(&s, &range);
        print_counts(&s);
        io_output out = {0};
        good = o->json == NULL || (io_output_open(&out, o->json, error) &&
                                   write_lines(&out, &s, &range, seconds, error) && io_output_commit(&out, error));
        io_output_discard(&out);
    }
    const uint64_t faults = stability_faults(&s);
    stability_free(&s);
    if (good && range.end < all)
        fprintf(stderr, "cellwalk-stability: ended early; go on with --first %" PRIu64 " and another file\n",
                range.end);
    return good && (faults == 0 || io_fail(error, "%" PRIu64 " faults", faults));
}

static const char what[] = "Traces rays that are aimed at vertices, edges and the like, and known to hit, with all "
                           "kernels and Embree, and prints counts of leaks, phantoms and wrong surfaces; --json also "
                           "writes them to a file. Ctrl-C ends it early, with all results so far, and prints the "
                           "command that continues.";

static int start(int argc, char **argv) {
    settings o = {.million = 1000, .sample = 1024};
    const option_spec options[] = {
        {"million", "N", "millions of rays in all parts together (1000)", OPTION_COUNT, .to = &o.million, .low = 1,
         .high = 1e6},
        {"sample", "N", "judge one ray in N in full (1024)", OPTION_COUNT, .to = &o.sample, .low = 1,
         .high = BATCH_RAYS},
        {"part", "K/N", "only every Nth batch, from the Kth on", OPTION_TEXT, .to = &o.part},
        {"first", "N", "begin with batch N, as a run that was ended early prints", OPTION_COUNT, .to = &o.first,
         .high = UINT_MAX},
        {"no-embree", NULL, "trace without Embree", OPTION_FLAG, .to = &o.no_embree},
        {"json", "FILE", "also write the results to FILE as JSON lines", OPTION_TEXT, .to = &o.json},
    };
    const options_usage usage = {"run", "[OPTIONS]", what, NULL, options, sizeof options / sizeof *options, NULL, 0, 0};
    const int status = options_parse(&usage, argc, argv, NULL);
    io_error error = {{0}};
    batch_range range;
    if (status != OPTIONS_GO) return status;
    if (!plan_range(&o, &range, &error)) return command_fail("run", "%s", error.text), EXIT_USAGE;
    return run(&o, range, &error) ? EXIT_SUCCESS : command_fail("run", "%s", error.text);
}

int main(int argc, char **argv) {
    static const command run_command = {"run", "trace aimed rays and count wrong answers", start};
    static const command *const commands[] = {&run_command};
    static const program stability_program = {.name = "cellwalk-stability",
                                              .what = "Counts wrong answers of the kernels and Embree on aimed rays.",
                                              .commands = commands,
                                              .command_count = 1};
    cw_reference_add();
    run_record_begin(argv + 1, argc - 1);
    return program_main(&stability_program, argc, argv);
}
