/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/measure.h"

#include "accuracy/judge.h"
#include "harness/memory.h"
#include "harness/results.h"

#include <math.h>
#include <stdio.h>

void errors_set_spread(json_t *line, const char *name, double *errors, size_t count) {
    char keys[128];
    double sum = 0, squares = 0;
    for (size_t k = 0; k < count; k++) {
        sum += errors[k];
        squares += errors[k] * errors[k];
    }
    if (count == 0) return;
    const double median = statistics_of(errors, count).median; /* sorts them */
    snprintf(keys, sizeof keys, "%s_mean %s_rms %s_median %s_99 %s_worst", name, name, name, name, name);
    results_set_numbers(line, keys,
                        (double[]){sum / (double)count, sqrt(squares / (double)count), median,
                                   errors[(size_t)(0.99 * (double)(count - 1))], errors[count - 1]});
}

/* The strict answer's cell is right, and its place is computed again. */
static void find_truth(const land *l, const true_surface *surface, const cw_ray *rays, size_t n, cw_hit *truth,
                       exact_hit *exact) {
    const cw_run strict = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    (void)cw_closest(l->field, &strict, rays, n, truth);
    for (size_t k = 0; k < n; k++)
        if (truth[k].i >= 0) exact[k] = accuracy_exact(surface, &rays[k], &truth[k]);
}

void errors_of_rays(const land *l, const cw_ray *rays, size_t n, contender_answers answers, bool any, size_t factor,
                    json_t *line) {
    const true_surface surface = true_surface_of(l->samples.z, l->samples.nx, l->samples.ny);
    const accuracy_claim none = {0};
    cw_hit *truth = memory(n, sizeof *truth);
    exact_hit *exact = memory(n, sizeof *exact);
    double *shares = memory(n, sizeof *shares), *cells = memory(n, sizeof *cells), *ulps = memory(n, sizeof *ulps);
    size_t verdicts[ACCURACY_VERDICT_COUNT] = {0}, differ = 0, both = 0;
    find_truth(l, &surface, rays, n, truth, exact);
    for (size_t k = 0; k < n; k++) {
        const bool should = truth[k].i >= 0, hit = any ? answers.occluded[k] != 0 : answers.hits[k].i >= 0;
        differ += should != hit;
        if (factor == 1)
            verdicts[any ? accuracy_judge_any(&surface, &rays[k], &none, should, hit)
                         : accuracy_judge_closest(&surface, &rays[k], &none, &truth[k], should ? &exact[k] : NULL,
                                                  &answers.hits[k])]++;
        if (any || !should || !hit) continue;
        const double t = (double)answers.hits[k].t;
        cells[both] = exact_error_cells(&rays[k], t, exact[k].t);
        ulps[both] = exact_error_ulp(t, exact[k].t);
        shares[both] = exact[k].t > 0 ? fabs(t / exact[k].t - 1) : 0;
        both++;
    }
    const double million = 1e6 / (double)n;
    results_set_number(line, "differ_per_million", (double)differ * million);
    if (factor == 1)
        results_set_numbers(line, "leaks_per_million phantoms_per_million wrong_per_million",
                            (double[]){(double)verdicts[ACCURACY_LEAK] * million,
                                       (double)verdicts[ACCURACY_PHANTOM] * million,
                                       (double)verdicts[ACCURACY_WRONG] * million});
    errors_set_spread(line, "t", shares, both);
    errors_set_spread(line, "cells", cells, both);
    if (factor == 1) errors_set_spread(line, "ulp", ulps, both);
    free(truth);
    free(exact);
    free(shares);
    free(cells);
    free(ulps);
}
