/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-stability MILLIONS FILE: aimed rays, the same ones for every kernel and for Embree, judged with the exact oracle, on one
 * thread. Counts go to FILE as JSON lines: one of kind "run", and one of kind "result" for each contender, class and start. */

#include "harness/harness_run.h"
#include "harness/results.h"
#include "reference.h"
#include "stability/run.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { SAMPLE = 1024 };

static json_t *result_line(const tested *t, aim kind, aim_start start, const counts *c) {
    static const char *const roles[] = {"reference", "same-bits", "own-rules"};
    json_t *line = json_object(), *verdicts = json_object();
    results_set_texts(
        line, "kind contender role rays start",
        (const char *[]){"result", t->contender.name, roles[t->role], aim_name(kind), aim_start_name(start)});
    results_set_counts(line, "traced hits other_bits pass leaks phantoms sampled", c->of);
    results_set_numbers(line, "residual apart t_error", (double[]){c->residual, c->apart, c->t_error});
    results_set_counts(verdicts, "right tie leak phantom wrong_surface", c->of + RIGHT);
    json_object_set_new(line, "verdicts", verdicts);
    return line;
}

static bool write_lines(io_output *out, const stability *s, size_t batches, io_error *error) {
    json_t *run = run_record("stability", 0, -1);
    results_set_counts(run, "batches sample", (size_t[]){batches, SAMPLE});
    bool good = results_write(out, run, error);
    for (unsigned n = 0; n < s->contenders; n++)
        for (int k = 0; good && k < AIM_COUNT * START_COUNT; k++) {
            const aim kind = (aim)(k / START_COUNT);
            const aim_start start = (aim_start)(k % START_COUNT);
            const counts *c = &s->count[n][kind][start];
            if (c->of[RAYS]) good = results_write(out, result_line(&s->tested[0][n], kind, start, c), error);
        }
    return good;
}

int main(int argc, char **argv) {
    static stability s;
    const double millions = argc == 3 ? (double)strtoul(argv[1], NULL, 10) : 0;
    const size_t batches = (size_t)(millions * 1e6 / BATCH_RAYS / ROUND_BATCHES + 1) * ROUND_BATCHES;
    if (millions < 1) {
        fputs("usage: cellwalk-stability MILLIONS FILE\n", stderr);
        return EXIT_FAILURE;
    }
    cw_reference_add();
    run_record_begin(argv + 1, argc - 1);
    io_error error = {{0}};
    io_output out = {0};
    bool good = io_output_open(&out, argv[2], &error) &&
                stability_make(&s, (stability_shares){16, 128, peer_embree.version ? 16 : 0}, SAMPLE, &error);
    for (size_t n = 0; good && n < batches; n++) {
        stability_batch(&s, n);
        if (n % 100 == 99 || n + 1 == batches)
            fprintf(stderr, "%c%.0f million rays, %zu faults", isatty(STDERR_FILENO) ? '\r' : '\n',
                    (double)(n + 1) * BATCH_RAYS * 1e-6, stability_faults(&s));
    }
    fputc('\n', stderr);
    good = good && write_lines(&out, &s, batches, &error) && io_output_commit(&out, &error);
    io_output_discard(&out);
    if (!good) fprintf(stderr, "cellwalk-stability: %s\n", error.text);
    good = good && stability_faults(&s) == 0;
    stability_free(&s);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
