/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-instructions: how often rays miss the caches, by callgrind's model of them, as not every machine
 * has hardware counters: two levels at a time, least recently used, without prefetches. Its caches are those of Zen 3 on
 * every machine, so that counts repeat. Each class of rays starts with the caches as the class before left them. */
#include "command.h"
#include "harness/results.h"
#include "harness/run.h"
#include "instructions/callgrind.h"

#include <stdlib.h>
#include <string.h>

/* A cache whose misses are counted, and callgrind's option for it. */
typedef struct level {
    const char *name, *option;
} level;
static const level caches[] = {{"L2", "--LL=524288,8,64"}, {"L3", "--LL=33554432,16,64"}};
enum { LEVELS = sizeof caches / sizeof caches[0] };

static json_t *line_of(const counted_run *r, const char *field, const char *cache) {
    const uint64_t *e = r->events;
    json_t *line = json_object();
    results_set_texts(line, "kind kernel leaf field rays level",
                      (const char *[]){"caches", r->kernel, r->leaf, field, r->rays, cache});
    results_set_count(line, "ray_count", r->count);
    results_set_counts(line, "reads writes first_misses misses",
                       (size_t[]){e[DR], e[DW], e[D1MR] + e[D1MW], e[DLMR] + e[DLMW]});
    return line;
}

static bool count_misses(const level *at, const char *work, const char *kernel, const char *field, const char *rays,
                         io_output *out, io_error *error) {
    static counted all;
    const char *const words[] = {work, kernel, field, rays, NULL};
    const char *const options[] = {"--cache-sim=yes", "--D1=32768,8,64", at->option, NULL};
    bool missing;
    io_error why;
    printf("field %s: %s\n", field, at->name);
    if (!callgrind_run(&all, "caches", words, options, &missing, &why))
        return io_fail(error, "field %s: %.400s", field, why.text);
    for (size_t k = 0; k < all.count; k++)
        if (!results_write(out, line_of(&all.runs[k], field, at->name), error)) return false;
    return true;
}

static const char what[] = "Runs WORK, a cellwalk-counted-work, with a KERNEL on the fields, counts reads and those "
                           "that miss caches of 32 KiB, "
                           "512 KiB and 32 MiB with callgrind, and writes lines of results to the file RESULTS.";

static int start(int argc, char **argv) {
    enum { RESULTS, RAYS, FIELDS, WORK, KERNEL, OPERANDS };
    static const char *const names[OPERANDS] = {"RESULTS", "RAYS", "FIELD,..", "WORK", "KERNEL"};
    const char *operands[OPERANDS + 1] = {0};
    const options_usage usage = {argv[0], "RESULTS RAYS FIELD,.. WORK KERNEL", what, NULL, NULL, 0, names, OPERANDS,
                                 OPERANDS};
    const int status = options_parse(&usage, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    run_record_begin(argv + 2, 2); /* where files are does not matter */

    io_error error = {{0}};
    io_output out = {0};
    char *fields = strdup(operands[FIELDS]), *rest;
    bool good =
        io_output_open(&out, operands[RESULTS], &error) && results_write(&out, run_record("caches", 1, -1), &error);
    for (char *field = strtok_r(fields, ",", &rest); good && field; field = strtok_r(NULL, ",", &rest))
        for (size_t l = 0; good && l < LEVELS; l++)
            good = count_misses(&caches[l], operands[WORK], operands[KERNEL], field, operands[RAYS], &out, &error);
    good = good && io_output_commit(&out, &error);
    io_output_discard(&out);
    free(fields);
    return good ? EXIT_SUCCESS : command_fail(argv[0], "%s", error.text);
}

static const command command_caches = {"caches",
                                       "count reads, and those that miss caches of 32 KiB, 512 KiB and 32 MiB", start};

int main(int argc, char **argv) {
    static const command *const commands[] = {&command_caches};
    static const program counting = {.name = "cellwalk-instructions",
                                     .what = "Counts the kernels' cache misses with callgrind.",
                                     .commands = commands,
                                     .command_count = 1};
    return program_main(&counting, argc, argv);
}
