/* SPDX-License-Identifier: Apache-2.0 */
/* Answers to rays before the tests' exact oracle, which needs GMP. */
#include "measure/measure.h"

#include "harness/harness_memory.h"
#include "harness/results.h"
#if BENCH_ORACLE
#include "oracle.h"
#endif

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

#if BENCH_ORACLE
void errors_forget(land *l) { oracle_destroy(l->oracle); }

/* 0 where it judges nothing wrong. */
static const char *const wrong_keys[VERDICTS] = {
    [VERDICT_LEAK] = "leaks_per_million",
    [VERDICT_PHANTOM] = "phantoms_per_million",
    [VERDICT_WRONG_SURFACE] = "wrong_per_million",
};

/* What the contender has at a ray that it answers alone; an any-hit query tells less: its closest hit speaks for it. */
static cw_hit hit_of(const contender *of, const cw_ray *ray, contender_answers answers, size_t k, bool any) {
    cw_hit hit = {.t = INFINITY, .i = -1, .j = -1};
    if (!any) return answers.hits[k];
    if (answers.occluded[k]) of->closest(of, ray, 1, &hit);
    return hit;
}

bool errors_of_rays(land *l, const contender *of, const cw_ray *rays, size_t n, contender_answers answers, bool any,
                    json_t *line, io_error *error) {
    const workload_field *s = &l->samples;
    if (l->oracle == NULL) l->oracle = oracle_create(s->z, s->nx, s->ny);
    if (l->oracle == NULL) return io_fail(error, "field %s: out of memory for the exact oracle", l->name);
    double *shares = memory(n, sizeof *shares), *ulps = memory(n, sizeof *ulps);
    size_t verdicts[VERDICTS] = {0}, both = 0;
    for (size_t k = 0; k < n; k++) {
        const oracle_truth *truth = oracle_trace(l->oracle, &rays[k]);
        const cw_hit hit = hit_of(of, &rays[k], answers, k, any);
        verdict v = any && answers.occluded[k] && hit.i < 0 ? VERDICT_PHANTOM : oracle_judge(l->oracle, &hit).verdict;
        /* Bounds on a hit are for this library's rounding. Others may be farther off, but not hit what is not there. */
        if (v == VERDICT_PHANTOM && of->field == NULL && truth->hit) v = VERDICT_TIE;
        verdicts[v]++;
        if (any || !truth->hit || hit.i < 0) continue;
        const double off = fabs((double)hit.t - truth->t);
        shares[both] = truth->t > 0 ? off / truth->t : 0;
        ulps[both++] = off / ldexp(1, ilogb(fmax(fabs(truth->t), 0x1p-126)) - 23);
    }
    for (int v = 0; v < VERDICTS; v++)
        if (wrong_keys[v]) results_set_numbers(line, wrong_keys[v], &(double){(double)verdicts[v] * 1e6 / (double)n});
    errors_set_spread(line, "t", shares, both);
    errors_set_spread(line, "ulp", ulps, both);
    free(shares);
    free(ulps);
    return true;
}
#else
void errors_forget(land *l) { (void)l; }

bool errors_of_rays(land *l, const contender *of, const cw_ray *rays, size_t n, contender_answers answers, bool any,
                    json_t *line, io_error *error) {
    (void)l, (void)of, (void)rays, (void)n, (void)answers, (void)any, (void)error;
    json_object_set_new(line, "not_judged",
                        json_string("built without the exact oracle, which needs GMP (Debian: libgmp-dev)"));
    return true;
}
#endif

void errors_of_choice(const cw_hit *truth, const cw_hit *hits, size_t n, json_t *line) {
    double *shares = memory(n, sizeof *shares);
    size_t both = 0, differ = 0;
    for (size_t k = 0; k < n; k++) {
        differ += (truth[k].i >= 0) != (hits[k].i >= 0);
        if (truth[k].i >= 0 && hits[k].i >= 0 && truth[k].t > 0)
            shares[both++] = fabs((double)hits[k].t / (double)truth[k].t - 1);
    }
    results_set_numbers(line, "differ_per_million", &(double){(double)differ * 1e6 / (double)n});
    errors_set_spread(line, "t", shares, both);
    free(shares);
}
