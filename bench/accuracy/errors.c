/* SPDX-License-Identifier: Apache-2.0 */
/* How far answers are from the truth. */

#include "accuracy/accuracy.h"
#include "harness/memory.h"

#include <math.h>
#include <stdlib.h>

enum { RUN = 16 };

size_t accuracy_thinned_at(size_t m, unsigned thin) { return ((m / RUN) << thin) * RUN + m % RUN; }

size_t accuracy_thin(const cw_ray *rays, size_t n, unsigned thin, cw_ray *out) {
    size_t m = 0;
    for (; accuracy_thinned_at(m, thin) < n; m++)
        if (out) out[m] = rays[accuracy_thinned_at(m, thin)];
    return m;
}

cw_status accuracy_truth_make(accuracy_truth *truth, const true_surface *surface, const cw_field *field,
                              const cw_ray *rays, size_t n) {
    const cw_run query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    *truth = (accuracy_truth){.surface = surface, .field = field, .rays = rays, .n = n};
    truth->hits = memory(n, sizeof *truth->hits);
    truth->exact = memory(n, sizeof *truth->exact);
    for (int k = 0; k < ACCURACY_ERROR_KINDS; k++) truth->scratch[k] = memory(n, sizeof *truth->scratch[k]);
    const cw_status status = cw_closest(field, &query, rays, n, truth->hits);
    for (size_t k = 0; status == CW_OK && k < n; k++)
        if (truth->hits[k].i >= 0) truth->exact[k] = accuracy_exact(surface, &rays[k], &truth->hits[k]);
    return status;
}

void accuracy_truth_free(accuracy_truth *truth) {
    free(truth->hits);
    free(truth->exact);
    for (int k = 0; k < ACCURACY_ERROR_KINDS; k++) free(truth->scratch[k]);
    *truth = (accuracy_truth){0};
}

double accuracy_degrees(const double a[3], const double b[3]) {
    return 2 * asin(fmin(1, hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]) / 2)) * (180 / 3.14159265358979323846);
}

static double normal_error(const accuracy_truth *truth, const exact_hit *exact, const cw_field *field,
                           const cw_hit *answer) {
    const cw_hit right = {
        .u = (float)exact->u, .v = (float)exact->v, .i = exact->i, .j = exact->j, .triangle = exact->triangle};
    double a[3], b[3];
    cw_hit_phong_normals(truth->field, NULL, &right, 1, a);
    cw_hit_phong_normals(field, NULL, answer, 1, b);
    return accuracy_degrees(a, b);
}

/* How far the answer's place is from the exact one, in u or v of the exact triangle. */
static double uv_error(const exact_hit *exact, const cw_hit *answer) {
    const double u = (double)answer->u, v = (double)answer->v;
    const bool a = answer->triangle == CW_TRIANGLE_A;
    const double x = answer->i - exact->i + (a ? u + v : u), y = answer->j - exact->j + (a ? v : u + v);
    const bool in_a = exact->triangle == CW_TRIANGLE_A;
    return fmax(fabs((in_a ? x - y : x) - exact->u), fabs((in_a ? y : y - x) - exact->v));
}

static double point_error(const cw_ray *ray, double t, const cw_field *field, const cw_hit *answer) {
    double p[3], squares = 0;
    cw_hit_points(field, NULL, answer, 1, p);
    for (int c = 0; c < 3; c++) {
        const double d = p[c] - ((double)ray->org[c] + t * (double)ray->dir[c]);
        squares += d * d;
    }
    return sqrt(squares);
}

/* Of a ray that is answered right. */
static void measure(const accuracy_truth *truth, size_t k, size_t n, const cw_field *field, const cw_hit *answer) {
    const cw_ray *ray = &truth->rays[k];
    const exact_hit *exact = &truth->exact[k];
    const double t = (double)answer->t;
    const double errors[ACCURACY_ERROR_KINDS] = {exact_error_ulp(t, exact->t),
                                                 exact_error_cells(ray, t, exact->t),
                                                 accuracy_off_surface(truth->surface, ray, t),
                                                 normal_error(truth, exact, field, answer),
                                                 exact->t == 0 ? 0 : fabs(t / exact->t - 1),
                                                 uv_error(exact, answer),
                                                 point_error(ray, exact->t, field, answer)};
    for (int kind = 0; kind < ACCURACY_ERROR_KINDS; kind++) truth->scratch[kind][n] = errors[kind];
}

static accuracy_verdict judge(const accuracy_truth *truth, size_t k, const accuracy_claim *claim, const cw_hit *hit,
                              bool answer) {
    const bool should = truth->hits[k].i >= 0;
    return hit ? accuracy_judge_closest(truth->surface, &truth->rays[k], claim, &truth->hits[k],
                                        should ? &truth->exact[k] : NULL, hit)
               : accuracy_judge_any(truth->surface, &truth->rays[k], claim, should, answer);
}

accuracy_errors accuracy_errors_of(const accuracy_truth *truth, unsigned thin, const accuracy_claim *claim,
                                   const cw_field *field, contender_answers answers) {
    static const accuracy_claim none;
    accuracy_errors e = {.rays = accuracy_thin(truth->rays, truth->n, thin, NULL)};
    for (size_t m = 0; m < e.rays; m++) {
        const size_t k = accuracy_thinned_at(m, thin);
        const cw_hit *hit = answers.hits ? &answers.hits[m] : NULL;
        const bool answer = hit ? hit->i >= 0 : answers.occluded[m] != 0;
        const accuracy_verdict v = judge(truth, k, claim, hit, answer);
        e.hits += answer;
        e.broken += v > ACCURACY_TIE;
        e.verdicts[v == ACCURACY_TIE ? judge(truth, k, &none, hit, answer) : v]++;
        if (hit && v == ACCURACY_RIGHT && truth->hits[k].i >= 0) measure(truth, k, e.right_hits++, field, hit);
    }
    for (int k = 0; k < ACCURACY_ERROR_KINDS; k++) {
        e.median[k] = statistics_of(truth->scratch[k], e.right_hits).median;
        e.most[k] =
            e.right_hits ? truth->scratch[k][(size_t)(0.999 * (double)(e.right_hits - 1))] : 0; /* sorted by now */
        e.worst[k] = e.right_hits ? truth->scratch[k][e.right_hits - 1] : 0;
    }
    return e;
}
