/* SPDX-License-Identifier: Apache-2.0 */
/* The part of the long run (cellwalk-stability) that a test has time for: at least 10^6 aimed rays a class through the default
 * kernel, and a share of them through every other one; no leak, no phantom, the same bits. And that the run would see a
 * fault if there were one. */

#include "check.h"
#include "stability/run.h"

#include <math.h>
#include <stdio.h>

enum { ROUNDS = 1000000 / (AIMED_FIELDS * BATCH_RAYS) + 1 };

static stability run;

static int set_up(void **state) {
    (void)state;
    io_error error = {{0}};
    const bool good = stability_make(&run, (stability_shares){.others = 8, .slow = 31}, 512, &error);
    check(good, "%s", error.text);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    stability_free(&run);
    return 0;
}

static void test_million_rays_a_class(void **state) {
    (void)state;
    const size_t batches = test_share(test_rounds() * ROUNDS, 1) * ROUND_BATCHES;
    for (size_t n = 0; n < batches; n++) stability_batch(&run, n);
    for (int kind = 0; kind < AIM_COUNT; kind++) {
        const counts sum = stability_sum(&run, 0, (aim)kind), *c = &sum;
        printf("%-9s %9zu rays, %9zu known to pass, %zu leaks, %zu phantoms; worst |d| / E %.3f, off the triangle / "
               "delta %.3f, error of t / bound %.3f\n",
               aim_name((aim)kind), c->of[RAYS], c->of[PASS], c->of[LEAKS], c->of[PHANTOMS], c->residual, c->apart,
               c->t_error);
        const size_t least = kind == AIM_GRAZING ? c->of[RAYS] / 8 : c->of[RAYS] - c->of[RAYS] / 100;
        check(c->of[PASS] >= least, "class %s: too few rays are known to pass for the test to mean anything",
              aim_name((aim)kind));
    }
    for (unsigned n = 1; n < run.contenders; n++) {
        const counts sum = stability_sum(&run, n, AIM_COUNT);
        printf("%-26s %9zu rays, %zu leaks, %zu phantoms, %zu other bits\n", run.tested[0][n].contender.name,
               sum.of[RAYS], sum.of[LEAKS], sum.of[PHANTOMS], sum.of[OTHER]);
        check(sum.of[RAYS] > 0 || batches < run.tested[0][n].every * (size_t)ROUND_BATCHES, "%s took no part",
              run.tested[0][n].contender.name);
    }
    check(stability_faults(&run) == 0, "%zu faults", stability_faults(&run));
}

/* A wrapper around the reference that answers wrongly now and then. */
static const contender *honest;
static double wrong_by; /* cells of height; 0: miss instead */

static void lie(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    honest->closest(self, rays, n, hits);
    for (size_t k = 0; k < n; k += 64) {
        if (hits[k].i < 0) continue;
        if (wrong_by == 0)
            hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
        else
            hits[k].t += (float)(wrong_by / fabs((double)rays[k].dir[2]));
    }
}

static counts lies(double by) {
    static stability liar;
    io_error error = {{0}};
    check(stability_make(&liar, (stability_shares){.others = 1u << 30, .slow = 1u << 30}, 512, &error), "%s",
          error.text);
    for (size_t f = 0; f < AIMED_FIELDS; f++) liar.tested[f][0].contender.closest = lie;
    honest = &run.tested[0][0].contender;
    wrong_by = by;
    for (size_t n = 0; n < ROUND_BATCHES; n++) stability_batch(&liar, n);
    const counts sum = stability_sum(&liar, 0, AIM_COUNT);
    stability_free(&liar);
    return sum;
}

static void test_faults_are_seen(void **state) {
    (void)state;
    const size_t changed = (size_t)ROUND_BATCHES * BATCH_RAYS / 64;
    const counts missing = lies(0), shifted = lies(1);
    check(missing.of[LEAKS] > changed / 2, "only %zu of %zu hits that were taken away count as leaks",
          missing.of[LEAKS], changed);
    check(missing.of[PHANTOMS] == 0, "a miss counts as a phantom");
    check(shifted.of[PHANTOMS] > changed / 2, "only %zu of %zu shifted hits count as phantoms", shifted.of[PHANTOMS],
          changed);
    check(shifted.of[LEAKS] == 0, "a shifted hit counts as a leak");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_million_rays_a_class),
        cmocka_unit_test(test_faults_are_seen),
    };
    return cmocka_run_group_tests_name("stability", tests, set_up, tear_down);
}
