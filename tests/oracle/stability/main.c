/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-stability MILLIONS [FILE]: aimed rays, the same ones for every kernel and, with a file, for Embree, judged with the exact
 * oracle, on one thread. Counts go to FILE as JSON lines: one of kind "run", and one of kind "result" for each contender, class and
 * start. The test runs it without a file: no leak, no phantom, the same bits, and rays that do pass. CELLWALK_TEST_DIVIDE = n takes
 * an nth of the rays. */

#include "harness/harness_run.h"
#include "harness/results.h"
#include "reference.h"
#include "stability/run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    results_set_counts(run, "batches sample", (size_t[]){batches, s->sample});
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

/* Prints sums; false if too few rays pass, or a kernel took no part, so that they mean little. */
static bool print_sums(const stability *s, size_t batches) {
    bool good = true;
    for (int kind = 0; kind < AIM_COUNT; kind++) {
        const counts sum = stability_sum(s, 0, (aim)kind), *c = &sum;
        printf("%-9s %9zu rays, %9zu known to pass, %zu leaks, %zu phantoms; worst |d| / E %.3f, off the triangle / "
               "delta %.3f, error of t / bound %.3f\n",
               aim_name((aim)kind), c->of[RAYS], c->of[PASS], c->of[LEAKS], c->of[PHANTOMS], c->residual, c->apart,
               c->t_error);
        good &= c->of[PASS] >= (kind == AIM_GRAZING ? c->of[RAYS] / 8 : c->of[RAYS] - c->of[RAYS] / 100);
    }
    for (unsigned n = 1; n < s->contenders; n++) {
        const counts sum = stability_sum(s, n, AIM_COUNT);
        printf("%-26s %9zu rays, %zu leaks, %zu phantoms, %zu other bits\n", s->tested[0][n].contender.name,
               sum.of[RAYS], sum.of[LEAKS], sum.of[PHANTOMS], sum.of[OTHER]);
        good &= sum.of[RAYS] > 0 || batches < s->tested[0][n].every * (size_t)ROUND_BATCHES;
    }
    return good;
}

static void miss(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    (void)self, (void)rays;
    for (size_t k = 0; k < n; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
}

/* True if a kernel that misses all rays is found out. Its counts go. */
static bool misses_are_seen(stability *s) {
    contender kept[AIMED_FIELDS];
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        kept[f] = s->tested[f][0].contender;
        s->tested[f][0].contender.closest = miss;
    }
    for (size_t n = 0; n < AIMED_FIELDS; n++) stability_batch(s, n);
    const bool seen = stability_faults(s) > 0 && stability_sum(s, 0, AIM_COUNT).of[LEAKS] > 0;
    for (size_t f = 0; f < AIMED_FIELDS; f++) s->tested[f][0].contender = kept[f];
    memset(s->count, 0, sizeof s->count);
    s->explained = 0;
    return seen;
}

int main(int argc, char **argv) {
    static stability s;
    const char *file = argc > 2 ? argv[2] : NULL, *by = getenv("CELLWALK_TEST_DIVIDE");
    const double millions = argc > 1 ? (double)strtoul(argv[1], NULL, 10) : 0,
                 divisor = by ? fmax(1, (double)strtol(by, NULL, 10)) : 1;
    const size_t batches = (size_t)(millions * 1e6 / divisor / BATCH_RAYS / ROUND_BATCHES + 1) * ROUND_BATCHES;
    if (millions < 1) {
        fputs("usage: cellwalk-stability MILLIONS [FILE]\n", stderr);
        return EXIT_FAILURE;
    }
    cw_reference_add();
    run_record_begin(argv + 1, argc - 1);
    const stability_shares shares =
        file ? (stability_shares){16, 128, peer_embree.version ? 16 : 0} : (stability_shares){8, 31, 0};
    io_error error = {{0}};
    io_output out = {0};
    bool good =
        (file == NULL || io_output_open(&out, file, &error)) && stability_make(&s, shares, file ? 1024 : 512, &error);
    const bool sees = good && misses_are_seen(&s);
    if (!sees) puts("misses of all rays are not seen");
    for (size_t n = 0; good && n < batches; n++) {
        stability_batch(&s, n);
        if (file && n % 100 == 99)
            fprintf(stderr, "%.0f million rays, %zu faults\n", (double)(n + 1) * BATCH_RAYS * 1e-6,
                    stability_faults(&s));
    }
    const bool means = good && print_sums(&s, batches);
    good = good && (file == NULL || (write_lines(&out, &s, batches, &error) && io_output_commit(&out, &error)));
    io_output_discard(&out);
    if (!good) fprintf(stderr, "cellwalk-stability: %s\n", error.text);
    const size_t faults = stability_faults(&s);
    printf("%zu faults%s\n", faults, means ? "" : "; too few rays for that to mean anything");
    stability_free(&s);
    return good && sees && means && faults == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
