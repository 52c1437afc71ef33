/* SPDX-License-Identifier: Apache-2.0 */
/* How far answers are from the truth. */

#include "accuracy/tradeoff.h"
#include "harness/memory.h"

#include <math.h>
#include <stdlib.h>

enum { RUN = 16 };

static const tradeoff_claim none;

size_t tradeoff_thinned_at(size_t m, unsigned thin) { return ((m / RUN) << thin) * RUN + m % RUN; }

size_t tradeoff_thin(const cw_ray *rays, size_t n, unsigned thin, cw_ray *out) {
    size_t m = 0;
    for (; tradeoff_thinned_at(m, thin) < n; m++)
        if (out) out[m] = rays[tradeoff_thinned_at(m, thin)];
    return m;
}

cw_status tradeoff_truth_make(tradeoff_truth *truth, const true_surface *surface, const cw_field *field,
                              const cw_ray *rays, size_t n) {
    const cw_query query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    *truth = (tradeoff_truth){.surface = surface, .field = field, .rays = rays, .n = n};
    truth->hits = memory(n, sizeof *truth->hits);
    truth->exact = memory(n, sizeof *truth->exact);
    for (int k = 0; k < TRADEOFF_ERROR_KINDS; k++) truth->scratch[k] = memory(n, sizeof *truth->scratch[k]);
    const cw_status status = cw_closest(field, &query, rays, n, truth->hits);
    for (size_t k = 0; status == CW_OK && k < n; k++)
        if (truth->hits[k].i >= 0) truth->exact[k] = tradeoff_exact(surface, &rays[k], &truth->hits[k]);
    return status;
}

void tradeoff_truth_free(tradeoff_truth *truth) {
    free(truth->hits);
    free(truth->exact);
    for (int k = 0; k < TRADEOFF_ERROR_KINDS; k++) free(truth->scratch[k]);
    *truth = (tradeoff_truth){0};
}

/* By the cross product, since the cosine of a small angle is 1. */
static double angle(const double a[3], const double b[3]) {
    double cross = 0, dot = 0;
    for (int k = 0; k < 3; k++) {
        const int m = (k + 1) % 3, n = (k + 2) % 3;
        const double c = a[m] * b[n] - a[n] * b[m];
        cross += c * c;
        dot += a[k] * b[k];
    }
    return atan2(sqrt(cross), dot) * (180 / 3.14159265358979323846);
}

static double normal_error(const tradeoff_truth *truth, const exact_hit *exact, const cw_field *field,
                           const cw_hit *answer) {
    const cw_hit right = {
        .u = (float)exact->u, .v = (float)exact->v, .i = exact->i, .j = exact->j, .triangle = exact->triangle};
    double a[3], b[3];
    cw_hit_phong_normal(truth->field, &right, a);
    cw_hit_phong_normal(field, answer, b);
    return angle(a, b);
}

tradeoff_errors tradeoff_errors_closest(const tradeoff_truth *truth, unsigned thin, const tradeoff_claim *claim,
                                        const cw_field *field, const cw_hit *answers) {
    tradeoff_errors e = {.rays = tradeoff_thin(truth->rays, truth->n, thin, NULL)};
    size_t n = 0;
    for (size_t m = 0; m < e.rays; m++) {
        const size_t k = tradeoff_thinned_at(m, thin);
        const cw_ray *ray = &truth->rays[k];
        const exact_hit *exact = truth->hits[k].i >= 0 ? &truth->exact[k] : NULL;
        const tradeoff_verdict v =
            tradeoff_judge_closest(truth->surface, ray, claim, &truth->hits[k], exact, &answers[m]);
        e.broken += v > TRADEOFF_TIE;
        e.hits += answers[m].i >= 0;
        e.verdicts[v == TRADEOFF_TIE
                       ? tradeoff_judge_closest(truth->surface, ray, &none, &truth->hits[k], exact, &answers[m])
                       : v]++;
        if (v != TRADEOFF_RIGHT || exact == NULL) continue;
        truth->scratch[0][n] = exact_error_ulp((double)answers[m].t, exact->t);
        truth->scratch[1][n] = exact_error_cells(ray, (double)answers[m].t, exact->t);
        truth->scratch[2][n] = tradeoff_off_surface(truth->surface, ray, (double)answers[m].t);
        truth->scratch[3][n++] = normal_error(truth, exact, field, &answers[m]);
    }
    e.right_hits = n;
    for (int k = 0; k < TRADEOFF_ERROR_KINDS; k++) {
        e.median[k] = statistics_of(truth->scratch[k], n).median;
        e.worst[k] = n ? truth->scratch[k][n - 1] : 0; /* sorted by now */
    }
    return e;
}

tradeoff_errors tradeoff_errors_any(const tradeoff_truth *truth, unsigned thin, const tradeoff_claim *claim,
                                    const uint8_t *answers) {
    tradeoff_errors e = {.rays = tradeoff_thin(truth->rays, truth->n, thin, NULL)};
    for (size_t m = 0; m < e.rays; m++) {
        const size_t k = tradeoff_thinned_at(m, thin);
        const bool right = truth->hits[k].i >= 0, answer = answers[m] != 0;
        e.hits += answer;
        e.broken += tradeoff_judge_any(truth->surface, &truth->rays[k], claim, right, answer) > TRADEOFF_TIE;
        e.verdicts[tradeoff_judge_any(truth->surface, &truth->rays[k], &none, right, answer)]++;
    }
    return e;
}
