/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-instructions: callgrind's counts of the kernels, as JSON lines.
 *
 * ablation: the instructions of several builds of cellwalk-counted-work, each without one technique of the kernels.
 * ablation.cmake makes the builds and calls this. guard.c explains why instructions are counted, and their limits.
 *
 * caches: how often rays miss the caches, by callgrind's model of them, as not every machine has hardware counters:
 * two levels at a time, least recently used, without prefetches. Its caches are those of Zen 3 on every machine, so
 * that counts repeat. Each class of rays starts with the caches as the class before left them. */
#include "command.h"
#include "harness/results.h"
#include "harness/run.h"
#include "instructions/callgrind.h"

#include <stdlib.h>
#include <string.h>

/* A cache whose misses are counted, and callgrind's option for it; NULL where only instructions are counted. */
typedef struct level {
    const char *name, *option;
} level;
static const level nothing = {NULL, NULL}, caches[] = {{"L2", "--LL=524288,8,64"}, {"L3", "--LL=33554432,16,64"}};
enum { LEVELS = sizeof caches / sizeof caches[0] };

/* The hash of its answers that the work wrote. */
static bool read_answers(const char *path, char answers[32], io_error *error) {
    FILE *file = fopen(path, "r");
    const bool good = file && fgets(answers, 32, file);
    if (file) fclose(file);
    answers[strcspn(answers, "\n")] = '\0';
    return (good && strlen(answers) == 16) || io_fail(error, "%s: is not a hash of answers", path);
}

static json_t *line_of(const char *kind, const counted_run *r, const char *field) {
    const uint64_t *e = r->events;
    json_t *line = json_object();
    results_set_texts(line, "kind kernel leaf field rays", (const char *[]){kind, r->kernel, r->leaf, field, r->rays});
    results_set_count(line, "ray_count", r->count);
    if (strcmp(kind, "ablation") == 0)
        results_set_count(line, "instructions", (size_t)e[IR]);
    else
        results_set_counts(line, "reads writes first_misses misses",
                           (size_t[]){e[DR], e[DW], e[D1MR] + e[D1MW], e[DLMR] + e[DLMW]});
    return line;
}

/* variant: a label, the work, its kernel. first: the answers of the first variant on this field, or empty. */
static bool count_variant(const char *kind, const level *at, const char **variant, const char *field, const char *rays,
                          char first[32], io_output *out, io_error *error) {
    static counted all;
    const char *const work[] = {variant[1], variant[2], field, rays, NULL};
    const char *const options[] = {"--cache-sim=yes", "--D1=32768,8,64", at->option, NULL};
    char answers[32] = "", errors[32];
    bool missing;
    io_error why;
    printf("field %s: %s%s%s\n", field, variant[0], at->name ? ", " : "", at->name ? at->name : "");
    if (!callgrind_run(&all, kind, work, at->name ? options : NULL, &missing, &why))
        return io_fail(error, "%s on field %s: %.400s", variant[0], field, why.text);
    snprintf(errors, sizeof errors, "%s.errors", kind);
    if (at->name == NULL && !read_answers(errors, answers, error)) return false;
    if (*first == '\0') memcpy(first, answers, sizeof answers);
    if (strcmp(first, answers) != 0) return io_fail(error, "%s, field %s: gives other answers", variant[0], field);
    for (size_t k = 0; k < all.count; k++) {
        json_t *line = line_of(kind, &all.runs[k], field);
        results_set_text(line, at->name ? "level" : "variant", at->name ? at->name : variant[0]);
        if (at->name == NULL) results_set_text(line, "answers", answers);
        if (!results_write(out, line, error)) return false;
    }
    return true;
}

static const char what[] =
    "Runs each WORK, a cellwalk-counted-work, with its KERNEL on the fields, counts with callgrind and writes lines of "
    "results to the file RESULTS. All have to give the same answers.";

static int start(int argc, char **argv) {
    enum { MOST = 255 };
    static const char *const names[MOST] = {"RESULTS", "RAYS", "FIELD,..", "LABEL", "WORK", "KERNEL", "LABEL.."};
    const char *operands[MOST + 1] = {0}, *const kind = argv[0];
    const options_usage usage = {
        kind, "RESULTS RAYS FIELD,.. LABEL WORK KERNEL [LABEL WORK KERNEL]..", what, NULL, NULL, 0, names, 6, MOST};
    const int status = options_parse(&usage, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    if (argc % 3 != 1) return command_fail(kind, "a variant is a LABEL, a WORK and a KERNEL"), EXIT_USAGE;
    run_record_begin(argv + 2, 2); /* where files are does not matter */

    io_error error = {{0}};
    io_output out = {0};
    char *fields = strdup(operands[2]), *rest;
    bool good = io_output_open(&out, operands[0], &error) && results_write(&out, run_record(kind, 1, -1), &error);
    for (char *field = strtok_r(fields, ",", &rest); good && field; field = strtok_r(NULL, ",", &rest)) {
        char first[32] = "";
        const bool misses = strcmp(kind, "caches") == 0;
        for (size_t l = 0; l < (misses ? LEVELS : 1); l++)
            for (const char **variant = operands + 3; good && *variant; variant += 3)
                good = count_variant(kind, misses ? &caches[l] : &nothing, variant, field, operands[1], first, &out,
                                     &error);
    }
    good = good && io_output_commit(&out, &error);
    io_output_discard(&out);
    free(fields);
    return good ? EXIT_SUCCESS : command_fail(kind, "%s", error.text);
}

static const command by_name[] = {
    {"ablation", "count the instructions of builds without one technique each", start},
    {"caches", "count reads, and those that miss caches of 32 KiB, 512 KiB and 32 MiB", start},
};

int main(int argc, char **argv) {
    static const command *const commands[] = {&by_name[0], &by_name[1]};
    static const program counting = {.name = "cellwalk-instructions",
                                     .what = "Counts the kernels' instructions and cache misses with callgrind.",
                                     .commands = commands,
                                     .command_count = 2};
    return program_main(&counting, argc, argv);
}
