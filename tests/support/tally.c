/* SPDX-License-Identifier: Apache-2.0 */
#include "tally.h"

#include <stdio.h>

void tally_add(tally *t, const cw_hit *hit, const oracle_truth *truth, const judgement *j) {
    t->rays++;
    t->hits += hit->i >= 0;
    t->passes += truth->passes;
    t->verdict[j->verdict]++;
    if (j->verdict <= VERDICT_TIE && j->residual > t->residual) t->residual = j->residual;
    t->digits += !digits_hold(j);
    t->nearest += j->place_bound > 0;
}

void tally_print(const char *what, const tally *t) {
    printf("%-22s %8zu rays, %7zu hits, %7zu pass: %8zu right, %6zu ties, %zu leaks, %zu phantoms, %zu wrong surfaces; "
           "worst |d|/E %.3f; %zu of %zu with t, u, v off\n",
           what, t->rays, t->hits, t->passes, t->verdict[VERDICT_RIGHT], t->verdict[VERDICT_TIE],
           t->verdict[VERDICT_LEAK], t->verdict[VERDICT_PHANTOM], t->verdict[VERDICT_WRONG_SURFACE], t->residual,
           t->digits, t->nearest);
}

void tally_explain(const test_field *f, const cw_ray *ray, const cw_hit *hit, const oracle_truth *truth,
                   const judgement *j) {
    printf("%s, |d|/E %g, %g off the triangle (%g), t off by %g (%g), u and v by %g (%g)\n", verdict_name(j->verdict),
           j->residual, j->apart, j->blur, j->t_error, j->t_bound, j->place_error, j->place_bound);
    field_print(f);
    ray_print(ray);
    hit_print("kernel", hit);
    printf("truth: %s, t %a, %u triangles, first (%d, %d) %u%s", truth->hit ? "hit" : "miss", truth->t, truth->at,
           (int)truth->triangle[0].i, (int)truth->triangle[0].j, (unsigned)truth->triangle[0].triangle,
           truth->coplanar ? ", coplanar" : "");
    if (truth->passes)
        printf(", has passed at t %a, through a triangle %g from its nearest edge (%g)", truth->pass_t,
               truth->pass_edge, truth->pass_blur);
    printf("\n");
}
