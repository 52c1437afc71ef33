/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-ablation: counts the instructions of several builds of cellwalk-ablation-work, in each of which one
 * lever of the kernels is off. ablation.cmake makes the builds and calls this. Instructions, because they repeat to the
 * last digit; what they cannot show is said in guard.c. */
#include "harness/results.h"
#include "harness/run_record.h"
#include "instructions/callgrind.h"
#include "instructions/figures.h"

#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-ablation RESULTS RAYS FIELD,FIELD.. LABEL WORKLOAD KERNEL [LABEL WORKLOAD KERNEL]..\n"
    "\n"
    "Counts with valgrind what each WORKLOAD, a cellwalk-ablation-work, takes for the KERNEL, and writes JSON lines "
    "into\n"
    "the file RESULTS. All have to give the same answers.\n";

static char runs_file[] = "ablation.runs", answers_file[] = "ablation.answers", profile_file[] = "ablation.callgrind";

/* The workload's hash of its answers. */
static bool read_answers(char answers[32], io_error *error) {
    FILE *file = fopen(answers_file, "r");
    const bool good = file && fgets(answers, 32, file);
    if (file) fclose(file);
    answers[strcspn(answers, "\n")] = '\0';
    return (good && strlen(answers) == 16) || io_fail(error, "%s: is not a hash of answers", answers_file);
}

/* A variant on a field; first: the answers of the first one on this field, "" if this is the first. */
static bool count_variant(char **variant, char *field, char *rays, char first[32], io_output *out, io_error *error) {
    static guard_figures counted;
    char *const workload[] = {variant[1], variant[2], field, rays, NULL};
    const char *slash = strrchr(variant[1], '/');
    char answers[32] = "";
    const int status = guard_callgrind(NULL, workload, runs_file, answers_file, profile_file);
    if (status != 0)
        return io_fail(error, "%s: valgrind %s", variant[0],
                       status == 127 ? "is not installed (Debian: valgrind)" : "or the workload failed");
    if (!read_answers(answers, error) ||
        !guard_read_counts(&counted, runs_file, profile_file, slash ? slash + 1 : variant[1], error))
        return false;
    if (*first == '\0') memcpy(first, answers, sizeof answers);
    if (strcmp(first, answers) != 0) return io_fail(error, "%s, field %s: gives other answers", variant[0], field);
    for (size_t k = 0; k < counted.count; k++) {
        const guard_figure *f = &counted.items[k];
        json_t *line = json_object();
        results_set_text(line, "kind", "ablation");
        results_set_text(line, "variant", variant[0]);
        results_set_text(line, "kernel", variant[2]);
        results_set_text(line, "leaf", f->leaf);
        results_set_text(line, "field", field);
        results_set_text(line, "rays", f->rays);
        results_set_count(line, "ray_count", (size_t)f->count);
        results_set_count(line, "instructions", (size_t)f->instructions);
        results_set_text(line, "answers", answers);
        if (!results_write(out, line, error)) return false;
    }
    return true;
}

int main(int argc, char **argv) {
    if (argc < 7 || (argc - 4) % 3 != 0) {
        fputs(usage, stderr);
        return 2;
    }
    run_record_begin(argv + 1, argc - 1);
    io_error error = {{0}};
    io_output out = {0};
    bool good = io_output_open(&out, argv[1], &error) && results_write(&out, run_record("ablation", 1, -1), &error);
    for (char *field = strtok(argv[3], ","); good && field; field = strtok(NULL, ",")) {
        char first[32] = "";
        for (int k = 4; good && k < argc; k += 3) {
            printf("field %s: %s\n", field, argv[k]);
            fflush(stdout);
            good = count_variant(argv + k, field, argv[2], first, &out, &error);
        }
    }
    good = good && io_output_commit(&out, &error);
    io_output_discard(&out);
    if (good) return EXIT_SUCCESS;
    fprintf(stderr, "cellwalk-ablation: %s\n", error.text);
    return EXIT_FAILURE;
}
