/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-stability: aimed rays by the thousand million, every contender before the same ones; and the
 * tables of papers/stability.md. It is no subcommand of cellwalk-bench because it judges with the exact oracle, which
 * needs GMP, and belongs to the tests.
 *
 * One run is one thread. Several processes with --part 1/N … N/N do what one does without it, and the report adds their
 * files up: batch number n is the same rays wherever it runs. */

#include "options.h"
#include "report.h"
#include "run_record.h"
#include "stability_page.h"
#include "timing.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *const usage =
    "Usage: cellwalk-stability run [OPTIONS]\n"
    "       cellwalk-stability report --json FILE[,FILE…] [--into PAGE]\n"
    "\n"
    "run traces rays that are aimed at vertices, edges and the like, of which it is known that they hit, through all\n"
    "kernels and Embree, and counts leaks, phantoms and wrong surfaces. Ctrl-C ends it early, with all results so "
    "far.\n"
    "report prints the results as Markdown, or puts them into a page between the lines <!-- begin:stability --> and\n"
    "<!-- end:stability -->.\n"
    "\n"
    "Options:\n";

static volatile sig_atomic_t stopped;

static void stop(int signal_number) {
    stopped = 1;
    signal(signal_number, SIG_DFL); /* a second one ends at once */
}

static void show_progress(const stability *s, uint64_t done, uint64_t wanted, double seconds) {
    counts sum = {0};
    for (int kind = 0; kind < AIM_COUNT; kind++) counts_add(&sum, &s->count[0][kind]);
    const double rays = (double)sum.rays, left = done ? seconds * (double)(wanted - done) / (double)done : 0;
    fprintf(stderr, "\r%.0f million rays, %.2f million a second, %llu faults, %.0f s left   ", rays * 1e-6,
            seconds > 0 ? rays * 1e-6 / seconds : 0, (unsigned long long)stability_faults(s), left);
    if (!isatty(STDERR_FILENO)) fputc('\n', stderr);
}

/* "2/3": 1 and 3. */
static bool parse_part(const char *text, unsigned *part, unsigned *parts, io_error *error) {
    char rest;
    if (sscanf(text, "%u/%u%c", part, parts, &rest) == 2 && *part >= 1 && *part <= *parts) return true;
    return io_fail(error, "--part %s: want K/N with 1 <= K <= N", text);
}

static bool run(uint64_t million, unsigned sample, const char *part_text, const char *json, bool no_embree,
                io_error *error) {
    static stability s;
    unsigned part = 1, parts = 1;
    if (part_text && !parse_part(part_text, &part, &parts, error)) return false;
    const uint64_t round_rays = (uint64_t)ROUND_BATCHES * BATCH_RAYS;
    const uint64_t batches = (million * 1000000 + round_rays - 1) / round_rays * ROUND_BATCHES;
    const bool embree = !no_embree && peer_embree_version();
    if (!no_embree && !embree) fputs("cellwalk-stability: built without Embree, which is left out\n", stderr);
    bool good =
        stability_make(&s, (stability_shares){.others = 64, .slow = 128, .peers = embree ? 32 : 0}, sample, error);
    s.explain = true;
    signal(SIGINT, stop);
    signal(SIGTERM, stop);
    const double begin = timing_seconds(), every = isatty(STDERR_FILENO) ? 1 : 60;
    double shown = begin;
    const uint64_t mine = (batches - part) / parts + 1;
    for (uint64_t n = part - 1; good && n < batches && !stopped; n += parts) {
        stability_batch(&s, n);
        const double now = timing_seconds();
        if (now - shown < every) continue;
        shown = now;
        show_progress(&s, s.batches, mine, now - begin);
    }
    if (good) {
        const double seconds = timing_seconds() - begin;
        show_progress(&s, s.batches, s.batches, seconds);
        fputc('\n', stderr);
        good = json == NULL || stability_write(&s, json, seconds, error);
    }
    const uint64_t faults = stability_faults(&s);
    stability_free(&s);
    if (good && stopped) fputs("cellwalk-stability: ended early\n", stderr);
    return good && (faults == 0 || io_fail(error, "%llu faults", (unsigned long long)faults));
}

static bool report(option_list *files, const char *into, io_error *error) {
    char *text = stability_page(files->items, files->count, error);
    if (text == NULL) return false;
    const bool good = into == NULL || report_into(into, "stability", text, error);
    if (into == NULL) fputs(text, stdout);
    free(text);
    return good;
}

int main(int argc, char **argv) {
    uint64_t million = 1000, sample = 1024;
    const char *part = NULL, *into = NULL;
    option_list files = {.count = 0};
    bool no_embree = false, help = false;
    const option options[] = {
        {"--million", "N", "millions of rays in all parts together, 1000 by default", OPTION_COUNT, &million, 1, 1e9},
        {"--sample", "N", "judge one ray in N in full; 1024 by default", OPTION_COUNT, &sample, 1, BATCH_RAYS},
        {"--part", "K/N", "only every Nth batch, from the Kth on", OPTION_TEXT, &part, 0, 0},
        {"--no-embree", NULL, "leave Embree out", OPTION_FLAG, &no_embree, 0, 0},
        {"--json", "FILE", "of run: write results to it; of report: read them, from several if given", OPTION_LIST,
         &files, 0, 0},
        {"--into", "PAGE", "of report: the page to put the tables into", OPTION_TEXT, &into, 0, 0},
        {"--help", NULL, "this text", OPTION_FLAG, &help, 0, 0},
    };
    const size_t option_count = sizeof options / sizeof options[0];
    io_error error = {{0}};
    int count = argc - 1;
    run_record_arguments(argv + 1, count);
    bool good = options_parse(options, option_count, argv + 1, &count, &error);
    const bool runs = good && count == 1 && strcmp(argv[1], "run") == 0;
    const bool reports = good && count == 1 && strcmp(argv[1], "report") == 0;
    if (good && help) {
        fputs(usage, stdout);
        options_print(stdout, options, option_count);
        return EXIT_SUCCESS;
    }
    if (good && !runs && !reports) good = io_fail(&error, "want one of the words run and report");
    if (good && reports && files.count == 0) good = io_fail(&error, "--json: the file of results is missing");
    if (good && runs && files.count > 1) good = io_fail(&error, "--json: run writes one file");
    if (!good) {
        fprintf(stderr, "cellwalk-stability: %s\nTry 'cellwalk-stability --help'.\n", error.text);
        return 2;
    }
    if (runs)
        good = run(million, (unsigned)sample, part, files.count ? files.items[0] : NULL, no_embree, &error);
    else
        good = report(&files, into, &error);
    if (good) return EXIT_SUCCESS;
    fprintf(stderr, "cellwalk-stability: %s\n", error.text);
    return EXIT_FAILURE;
}
