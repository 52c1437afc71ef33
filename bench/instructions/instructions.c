/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-instructions: what callgrind counts of the kernels, as JSON lines.
 *
 * ablation: the instructions of several builds of cellwalk-counted-work, in each of which one lever of the kernels is off;
 * ablation.cmake makes the builds and calls this. Instructions, because they repeat to the last digit; what they cannot show is
 * said in guard.c.
 *
 * caches: how often rays miss the caches, by callgrind's model of them. A model, because counters of the hardware are not to be
 * had on every machine; two levels at a time, least recently used, without prefetches. Its caches are those of Zen 3, whichever
 * machine counts, so that counts repeat. A class of rays finds in them what the class before it left. */
#include "command.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "instructions/callgrind.h"
#include "options.h"

#include <stdlib.h>
#include <string.h>

/* Calls count for each field of the list, between opening and closing the file of results. */
typedef bool count_field(const char **operands, char *field, io_output *out, io_error *error);
static int for_each_field(const char *name, const char **operands, count_field *count) {
    io_error error = {{0}};
    io_output out = {0};
    char *fields = strdup(operands[2]), *rest;
    bool good = io_output_open(&out, operands[0], &error) && results_write(&out, run_record(name, 1, -1), &error);
    for (char *field = strtok_r(fields, ",", &rest); good && field; field = strtok_r(NULL, ",", &rest))
        good = count(operands, field, &out, &error);
    good = good && io_output_commit(&out, &error);
    io_output_discard(&out);
    free(fields);
    return good ? EXIT_SUCCESS : command_fail(name, "%s", error.text);
}

static bool count_work(counted *all, const char *name, const char *const *work, const char *const *options,
                       io_error *error) {
    bool missing;
    io_error why;
    return callgrind_run(all, name, work, options, &missing, &why) ||
           io_fail(error, "%s on field %s: %.400s", work[1], work[2], why.text);
}

static json_t *line_of(const char *kind, const counted_run *r, const char *field) {
    json_t *line = json_object();
    results_set_texts(line, "kind kernel leaf field rays", (const char *[]){kind, r->kernel, r->leaf, field, r->rays});
    results_set_count(line, "ray_count", r->count);
    return line;
}

/* ---- ablation ---- */

/* The work's hash of its answers. */
static bool read_answers(char answers[32], io_error *error) {
    FILE *file = fopen("ablation.errors", "r");
    const bool good = file && fgets(answers, 32, file);
    if (file) fclose(file);
    answers[strcspn(answers, "\n")] = '\0';
    return (good && strlen(answers) == 16) || io_fail(error, "ablation.errors: is not a hash of answers");
}

static bool count_variants(const char **operands, char *field, io_output *out, io_error *error) {
    static counted all;
    char first[32] = "", answers[32] = "";
    for (const char **variant = operands + 3; *variant; variant += 3) {
        const char *const work[] = {variant[1], variant[2], field, operands[1], NULL};
        printf("field %s: %s\n", field, variant[0]);
        if (!count_work(&all, "ablation", work, NULL, error) || !read_answers(answers, error)) return false;
        if (*first == '\0') memcpy(first, answers, sizeof first);
        if (strcmp(first, answers) != 0) return io_fail(error, "%s, field %s: gives other answers", variant[0], field);
        for (size_t k = 0; k < all.count; k++) {
            json_t *line = line_of("ablation", &all.runs[k], field);
            results_set_text(line, "variant", variant[0]);
            results_set_count(line, "instructions", (size_t)all.runs[k].events[IR]);
            results_set_text(line, "answers", answers);
            if (!results_write(out, line, error)) return false;
        }
    }
    return true;
}

static int ablation(int argc, char **argv) {
    enum { MOST = 255 };
    static const char *operands[MOST + 1],
        *names[MOST] = {"RESULTS", "RAYS", "FIELD,..", "LABEL", "WORK", "KERNEL", "LABEL.."};
    const options_usage usage = {.name = "ablation",
                                 .synopsis = "RESULTS RAYS FIELD,.. LABEL WORK KERNEL [LABEL WORK KERNEL]..",
                                 .what =
                                     "Counts the instructions of each WORK, a cellwalk-counted-work, with the KERNEL, "
                                     "and writes them to the file RESULTS. All have to give the same answers.",
                                 .operands = names,
                                 .operand_least = 6,
                                 .operand_most = MOST};
    const int status = options_parse(&usage, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    if (argc % 3 != 1) return command_fail("ablation", "a variant is a LABEL, a WORK and a KERNEL"), EXIT_USAGE;
    run_record_begin(argv + 1, argc - 1);
    return for_each_field("ablation", operands, count_variants);
}

/* ---- caches ---- */

static bool count_misses(const char **operands, char *field, io_output *out, io_error *error) {
    static const char *const levels[] = {"L2", "L3"}, *const last[] = {"--LL=524288,8,64", "--LL=33554432,16,64"};
    const char *const work[] = {operands[3], operands[4], field, operands[1], NULL};
    static counted all;
    for (int level = 0; level < 2; level++) {
        const char *const options[] = {"--cache-sim=yes", "--D1=32768,8,64", last[level], NULL};
        printf("field %s: %s\n", field, levels[level]);
        if (!count_work(&all, "caches", work, options, error)) return false;
        for (size_t k = 0; k < all.count; k++) {
            const uint64_t *e = all.runs[k].events;
            json_t *line = line_of("caches", &all.runs[k], field);
            results_set_text(line, "level", levels[level]);
            results_set_counts(line, "reads writes first_misses misses",
                               (size_t[]){e[DR], e[DW], e[D1MR] + e[D1MW], e[DLMR] + e[DLMW]});
            if (!results_write(out, line, error)) return false;
        }
    }
    return true;
}

static int caches(int argc, char **argv) {
    static const char *const names[] = {"RESULTS", "RAYS", "FIELD,..", "WORK", "KERNEL"};
    const options_usage usage = {
        .name = "caches",
        .synopsis = "RESULTS RAYS FIELD,.. WORK KERNEL",
        .what = "Counts the reads of WORK, a cellwalk-counted-work, with the KERNEL, and those that miss caches of 32 "
                "KiB, 512 KiB and 32 MiB, and writes them to the file RESULTS.",
        .operands = names,
        .operand_least = 5,
        .operand_most = 5};
    const char *operands[5];
    const int status = options_parse(&usage, argc, argv, operands);
    if (status != OPTIONS_GO) return status;
    run_record_begin(argv + 2, 2); /* where files are does not matter */
    return for_each_field("caches", operands, count_misses);
}

int main(int argc, char **argv) {
    static const command of_ablation = {"ablation", "count the instructions of builds without a lever each", ablation},
                         of_caches = {"caches", "count what misses the caches", caches};
    static const command *const commands[] = {&of_ablation, &of_caches};
    static const program instructions_program = {.name = "cellwalk-instructions",
                                                 .what = "What does callgrind count of the kernels?",
                                                 .commands = commands,
                                                 .command_count = 2};
    return program_main(&instructions_program, argc, argv);
}
