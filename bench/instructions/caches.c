/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-caches: how often rays miss the caches, counted by callgrind's model of them. A model, because
 * counters of the hardware are not to be had on every machine; two levels at a time, least recently used, without
 * prefetches. Its caches are those of Zen 3, whichever machine counts, so that counts repeat. A class of rays finds in
 * them what the class before it left. */
#include "harness/results.h"
#include "harness/run_record.h"
#include "instructions/callgrind.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-caches RESULTS RAYS FIELD,FIELD.. WORKLOAD KERNEL\n"
    "\n"
    "Counts with valgrind the reads of WORKLOAD, a cellwalk-ablation-work, with the KERNEL, and those that miss caches "
    "of\n"
    "32 KiB, 512 KiB and 32 MiB, and writes JSON lines into the file RESULTS.\n";

static char runs_file[] = "caches.runs", answers_file[] = "caches.answers", profile_file[] = "caches.callgrind";

/* Last levels to count with; the first is the same for both. */
static const struct {
    const char *name;
    char option[32];
} levels[] = {{"L2", "--LL=524288,8,64"}, {"L3", "--LL=33554432,16,64"}};
enum { LEVELS = sizeof levels / sizeof levels[0], LINE_MAX_LENGTH = 512 };

/* What callgrind counts of each run, in its order. */
typedef enum event { IR, DR, DW, I1MR, D1MR, D1MW, ILMR, DLMR, DLMW, EVENTS } event;
static const char events_line[] = "events: Ir Dr Dw I1mr D1mr D1mw ILmr DLmr DLmw\n";

static bool take_summary(const char *line, uint64_t counts[EVENTS]) {
    for (size_t e = 0; e < EVENTS; e++) {
        char *end;
        counts[e] = strtoull(line, &end, 10);
        if (end == line && e == 0) return false;
        line = end; /* events that never happened are left out at the end */
    }
    return true;
}

/* The next part of the profile, which is one run of the workload. */
static bool read_part(FILE *profile, uint64_t counts[EVENTS], io_error *error) {
    char line[LINE_MAX_LENGTH];
    bool known = false;
    while (fgets(line, sizeof line, profile)) {
        known = known || strcmp(line, events_line) == 0;
        if (strncmp(line, "summary:", 8) == 0 && take_summary(line + 8, counts) && counts[IR] > 0)
            return known || io_fail(error, "%s: does not count %s", profile_file, events_line);
    }
    return io_fail(error, "%s: ends before the last run", profile_file);
}

static bool write_run(io_output *out, char *run, const char *field, size_t level, const uint64_t counts[EVENTS],
                      io_error *error) {
    char *words[5], *rest;
    size_t n = 0;
    for (char *word = strtok_r(run, ",\n", &rest); word && n < 5; word = strtok_r(NULL, ",\n", &rest))
        words[n++] = word;
    if (n != 5) return io_fail(error, "%s: has a line that is no run", runs_file);
    json_t *line = json_object();
    results_set_text(line, "kind", "caches");
    results_set_text(line, "kernel", words[1]);
    results_set_text(line, "leaf", words[2]);
    results_set_text(line, "field", field);
    results_set_text(line, "rays", words[3]);
    results_set_count(line, "ray_count", strtoul(words[4], NULL, 10));
    results_set_text(line, "level", levels[level].name);
    results_set_count(line, "reads", (size_t)counts[DR]);
    results_set_count(line, "writes", (size_t)counts[DW]);
    results_set_count(line, "first_misses", (size_t)(counts[D1MR] + counts[D1MW]));
    results_set_count(line, "misses", (size_t)(counts[DLMR] + counts[DLMW]));
    return results_write(out, line, error);
}

static bool count(char **workload, const char *field, size_t level, io_output *out, io_error *error) {
    static char simulate[] = "--cache-sim=yes", first[] = "--D1=32768,8,64";
    char last[sizeof levels[0].option];
    memcpy(last, levels[level].option, sizeof last);
    char *const options[] = {simulate, first, last, NULL};
    const int status = guard_callgrind(options, workload, runs_file, answers_file, profile_file);
    if (status != 0)
        return io_fail(error, "field %s: valgrind %s", field,
                       status == 127 ? "is not installed (Debian: valgrind)" : "or the workload failed");
    FILE *runs = fopen(runs_file, "r"), *profile = fopen(profile_file, "r");
    bool good = (runs && profile) || io_fail(error, "%s, %s: cannot be read", runs_file, profile_file);
    char run[LINE_MAX_LENGTH];
    uint64_t counts[EVENTS];
    while (good && fgets(run, sizeof run, runs))
        good = read_part(profile, counts, error) && write_run(out, run, field, level, counts, error);
    if (runs) fclose(runs);
    if (profile) fclose(profile);
    return good;
}

int main(int argc, char **argv) {
    if (argc != 6) {
        fputs(usage, stderr);
        return 2;
    }
    run_record_begin(argv + 2, 2); /* where files are does not matter */
    io_error error = {{0}};
    io_output out = {0};
    bool good = io_output_open(&out, argv[1], &error) && results_write(&out, run_record("caches", 1, -1), &error);
    char *rest;
    for (char *field = strtok_r(argv[3], ",", &rest); good && field; field = strtok_r(NULL, ",", &rest))
        for (size_t level = 0; good && level < LEVELS; level++) {
            char *workload[] = {argv[4], argv[5], field, argv[2], NULL};
            printf("field %s: %s\n", field, levels[level].name);
            fflush(stdout);
            good = count(workload, field, level, &out, &error);
        }
    good = good && io_output_commit(&out, &error);
    io_output_discard(&out);
    if (good) return EXIT_SUCCESS;
    fprintf(stderr, "cellwalk-caches: %s\n", error.text);
    return EXIT_FAILURE;
}
