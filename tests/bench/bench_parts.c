/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's fields and rays are the same numbers everywhere; its arithmetic is right on cases done by hand. */
#include "harness/agree.h"
#include "harness/interleave.h"
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include "check.h"

#include <math.h>
#include <string.h>

/* FNV-1a over the bytes (Fowler, Noll, Vo). */
static uint64_t sum_of(const void *bytes, size_t size) {
    const unsigned char *b = bytes;
    uint64_t h = 0xcbf29ce484222325u;
    for (size_t k = 0; k < size; k++) h = (h ^ b[k]) * 0x100000001b3u;
    return h;
}

static void fields_are_what_they_were(void **state) {
    static const struct {
        const char *name;
        size_t side;
        uint64_t sum;
    } known[] = {{"65", 65, 0xb6efb7d0d6e51bf0u},
                 {"257", 257, 0xb09c7f2aa10db23fu},
                 {"1025", 1025, 0xac9dd3e347b17868u},
                 {"sea-calm", 1000, 0xdd566efff66c770du},
                 {"sea-rough", 1000, 0x7e6b294aed11b039u},
                 {"plane", 1025, 0x7c735dd77ebf756eu},
                 {"grooves", 1025, 0x6bac00c391466f98u},
                 {"comb", 1025, 0xe7e9a01493ec6f98u},
                 {"checkerboard", 1025, 0xe4e544cd75536f98u}};
    workload_field f;
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        check(workload_field_make(known[k].name, &f), "no field %s", known[k].name);
        check(f.nx == known[k].side && f.ny == known[k].side, "field %s is %zu x %zu", known[k].name, f.nx, f.ny);
        const uint64_t sum = sum_of(f.z, f.nx * f.ny * sizeof *f.z);
        check(sum == known[k].sum, "field %s has sum 0x%016llx", known[k].name, (unsigned long long)sum);
        workload_field_free(&f);
    }
    check(!workload_field_make("66x", &f) && f.z == NULL && f.name == NULL, "there is a field 66x");
}

static void rays_are_what_they_were(void **state) {
    enum { RAYS = 8192 };
    static cw_ray rays[RAYS];
    static const uint64_t known[WORKLOAD_CLASS_COUNT + 1] = {
        0x178632adbd0683f1u, 0xb13b39c9883f0f8fu, 0x8e8fceed79817928u, 0xa26b27529c7f380bu,
        0x0ce8f34c2a14040cu, 0x4f700ae024e1b3e8u, 0x7461cedfbac259dau, 0xcf4e2a03d9838379u};
    workload_field samples;
    cw_field *field;
    check(workload_field_make("257", &samples) && workload_field_open(&samples, &field) == CW_OK, "no field");
    for (int k = 0; k <= WORKLOAD_CLASS_COUNT; k++) {
        const workload_class c = k < WORKLOAD_CLASS_COUNT ? (workload_class)k : WORKLOAD_BESIDE;
        const bool seeded = c != WORKLOAD_PRIMARY && c != WORKLOAD_SHADOW && c != WORKLOAD_AFAR;
        for (uint32_t seed = 2; seed > 0; seed--) {
            const size_t n = workload_rays_make(field, c, seed, RAYS, rays);
            const uint64_t sum = sum_of(rays, sizeof rays);
            check(n == RAYS && (sum == known[k]) == (seed == 1 || !seeded), "%zu %s rays of seed %u have sum 0x%016llx",
                  n, workload_class_name(c), (unsigned)seed, (unsigned long long)sum);
        }
    }
    cw_field_destroy(field);
    workload_field_free(&samples);
}

/* ---- medians, intervals and ratios ------------------------------------------------------------------------------- */

/* The chance that fewer than k + 1 of n fair coins show heads, twice, is what an interval without the k outermost
 * samples at either end misses: at n = 10, k = 1 that is 2 (1 + 10) / 1024 = 0.0215, at k = 2 it is 0.109. */
static void intervals(void **state) {
    static const struct {
        size_t n;
        double confidence;
        int rank;
    } ranks[] = {{1, 0.975, -1}, {6, 0.975, -1}, {7, 0.975, 0}, {9, 0.975, 0},   {10, 0.975, 1},
                 {5, 0.95, -1},  {6, 0.95, 0},   {9, 0.95, 1},  {100, 0.95, 39}, {1000, 0.95, 468}};
    for (size_t k = 0; k < sizeof ranks / sizeof ranks[0]; k++) {
        const int rank = statistics_interval_rank(ranks[k].n, ranks[k].confidence);
        check(rank == ranks[k].rank, "of %zu samples at %g, rank %d", ranks[k].n, ranks[k].confidence, rank);
    }
    static struct {
        double samples[10];
        statistics wanted;
    } cases[] = {{{9, 1, 4, 2, 100}, {5, 1, 4, 1, 100, false}},
                 {{3, 1, 8, 6}, {4, 1, 4.5, 1, 8, false}},
                 {{7}, {1, 7, 7, 7, 7, false}},
                 {{7}, {0, 0, 0, 0, 0, false}},
                 {{10, 9, 8, 7, 6, 5, 4, 3, 2, 1}, {10, 1, 5.5, 2, 9, true}}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const statistics w = cases[k].wanted, s = statistics_of(cases[k].samples, w.n);
        check(s.n == w.n && s.min == w.min && s.median == w.median && s.low == w.low && s.high == w.high &&
                  s.sure == w.sure,
              "of %zu samples: from %g, median %g in [%g, %g]", w.n, s.min, s.median, s.low, s.high);
    }
}

/* Times that are given, not measured: the machine slows down from round to round. */
typedef struct given {
    double share, slower;
    const char *group;
    double seconds;
    unsigned rounds;
} given;

static void take_given(void *context) {
    given *g = context;
    g->seconds = g->share + g->slower * g->rounds++;
}

static interleave_job jobs[5];

static void interleave_given(given *times, size_t n, double seconds) {
    interleave_job *all[5];
    for (size_t k = 0; k < n; k++) {
        jobs[k] = (interleave_job){
            .run = take_given, .context = &times[k], .counts = &times[k].seconds, .group = times[k].group};
        all[k] = &jobs[k];
    }
    interleave(all, n, &(interleave_limits){.width = 0.01, .seconds = seconds, .seed = 1});
}

static void ratios_are_of_rounds(void **state) {
    given times[4] = {{2, 2, NULL, 0, 0}, {5, 5, "a", 0, 0}, {3, 3, "a", 0, 0}, {4, 4, NULL, 0, 0}};
    interleave_given(times, 4, 1e6);
    for (size_t k = 0; k < 4; k++) {
        const statistics s = interleave_ratio(&jobs[k], &jobs[0]);
        check(jobs[k].seconds.n == INTERLEAVE_LEAST, "not as many rounds as an interval needs");
        check(jobs[k].converged && s.sure, "equal ratios have not converged");
        check(s.median == times[k].share / 2 && s.low == s.median && s.high == s.median, "not the rounds' ratio");
        check(jobs[k].best == (k != 1), "the fastest of a group is another");
    }
    interleave_given(times, 4, 0);
    check(jobs[0].seconds.n == 1 && !jobs[2].converged, "one round has converged");
}

static void clearly_slower_ones_of_a_group_end(void **state) {
    enum { FAST = 1, SLOW };
    given times[5] = {{2, 1e-9, NULL, 0, 0},
                      {1, 1e-9, "a", 0, 0},
                      {1.3, 1e-9, "a", 0, 0},
                      {1.1, 1e-9, "a", 0, 0},
                      {40, 1e-9, NULL, 0, 0}};
    static const unsigned runs[5] = {5, 8, 7, 8, 1}; /* of a round, so that each gets a fair part of it */
    interleave_given(times, 5, 1e6);
    for (size_t k = 0; k < 5; k++)
        check(jobs[k].seconds.n == (k == SLOW ? 3 : INTERLEAVE_LEAST) &&
                  times[k].rounds == 1 + runs[k] * (jobs[k].seconds.n - 1),
              "job %zu: %zu rounds, %u runs", k, jobs[k].seconds.n, times[k].rounds);
    check(jobs[FAST].best && !jobs[SLOW].best && !jobs[SLOW].converged, "the fastest of a group is another");
    times[FAST] = times[3] = (given){1, 0.005, "a", 0, 0}; /* in the end slower than the one that has ended */
    interleave_given(times, 5, 1e6);
    check(jobs[FAST].best && jobs[3].best && !jobs[SLOW].best, "the fastest of a group has ended");
}

/* ---- differences between hits are counted once, and put down to the right reason --------------------------------- */

/* Straight down on a flat field of height 0 from height 1; with its end there; from afar; and level. */
static const cw_ray down = {.org = {0.5f, 0.25f, 1}, .dir = {0, 0, -1}, .tmax = INFINITY},
                    touching = {.org = {0.5f, 0.25f, 1}, .dir = {0, 0, -1}, .tmax = 1},
                    afar = {.org = {0.5f, 0.25f, 1e6f}, .dir = {0, 0, -1}, .tmax = INFINITY},
                    level = {.org = {0, 0.25f, 1e-5f}, .dir = {1, 0, -1e-5f}, .tmin = -1, .tmax = INFINITY};
static const cw_hit inside = {.t = 1, .u = 0.25f, .v = 0.25f};

static void closest_finds(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    for (size_t k = 0; k < n; k++) hits[k] = inside;
}

static void agreement_of_hits(void **state) {
    const cw_hit nothing = {.t = INFINITY, .i = -1, .j = -1}, rounded = {.t = nextafterf(1, 2), .u = 0.25f, .v = 0.25f},
                 tie = {.t = nextafterf(1, 2), .u = 0.25f, .v = 0.25f, .triangle = CW_TRIANGLE_B},
                 apart = {.t = 1.001f, .u = 0.25f, .v = 0.25f}, edge = {.t = 1, .u = 0.25f, .v = 1e-7f},
                 third_edge = {.t = 1, .u = 0.75f, .v = 0.25f}, no_number = {.t = NAN, .u = 0.25f, .v = 1e-7f};
    const struct {
        const char *what;
        const cw_ray *ray;
        const cw_hit *a, *b;
        agreement wanted;
    } cases[] = {
        {"equal hits", &down, &inside, &inside, {.hits_a = 1, .hits_b = 1, .same_bits = 1}},
        {"misses", &down, &nothing, &nothing, {.same_bits = 1}},
        {"a rounding", &down, &inside, &rounded, {.hits_a = 1, .hits_b = 1}},
        {"a tie", &down, &inside, &tie, {.hits_a = 1, .hits_b = 1, .other_triangle = 1}},
        {"a thousandth", &down, &inside, &apart, {.hits_a = 1, .hits_b = 1, .far = 1, .why[AGREE_OTHER] = 1}},
        {"a miss in the middle", &down, &inside, &nothing, {.hits_a = 1, .only_a = 1, .why[AGREE_OTHER] = 1}},
        {"a miss at an edge", &down, &nothing, &edge, {.hits_b = 1, .only_b = 1, .why[AGREE_EDGE] = 1}},
        {"a miss at the third edge", &down, &third_edge, &nothing, {.hits_a = 1, .only_a = 1, .why[AGREE_EDGE] = 1}},
        {"a miss at the end", &touching, &inside, &nothing, {.hits_a = 1, .only_a = 1, .why[AGREE_END] = 1}},
        {"no number", &down, &no_number, &edge, {.hits_a = 1, .hits_b = 1, .far = 1, .why[AGREE_OTHER] = 1}},
        {"a miss or no number", &down, &nothing, &no_number, {.hits_b = 1, .only_b = 1, .why[AGREE_OTHER] = 1}},
        {"a miss from afar", &afar, &inside, &nothing, {.hits_a = 1, .only_a = 1, .why[AGREE_UNJUDGED] = 1}},
        {"a tie from afar", &afar, &inside, &tie, {.hits_a = 1, .hits_b = 1, .far = 1, .why[AGREE_UNJUDGED] = 1}},
        {"a miss of a level ray", &level, &inside, &nothing, {.hits_a = 1, .only_a = 1, .why[AGREE_GRAZING] = 1}},
    };
    cw_field *field = field_of((const float[9]){0}, 3, 3);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        agreement sum = {0}, wanted = cases[k].wanted;
        agree_closest(&sum, field, cases[k].ray, 1, cases[k].a, cases[k].b);
        wanted.rays = 1;
        check(memcmp(&sum, &wanted, sizeof sum) == 0, "%s: %zu, %zu, %zu differ, at %zu ends, %zu edges, %zu grazing",
              cases[k].what, sum.only_a, sum.only_b, sum.far, sum.why[AGREE_END], sum.why[AGREE_EDGE],
              sum.why[AGREE_GRAZING]);
    }
    const contender finder = {.closest = closest_finds};
    const uint8_t yes[3] = {1, 1, 0}, no[3] = {1, 0, 1};
    const cw_ray rays[3] = {down, down, down};
    agreement sum = {0};
    agree_any(&sum, field, rays, 3, yes, no, &finder, &finder);
    check(sum.rays == 3 && sum.only_a == 1 && sum.only_b == 1 && sum.why[AGREE_OTHER] == 2, "different answers agree");
    cw_field_destroy(field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_are_what_they_were),
        cmocka_unit_test(rays_are_what_they_were),
        cmocka_unit_test(intervals),
        cmocka_unit_test(ratios_are_of_rounds),
        cmocka_unit_test(clearly_slower_ones_of_a_group_end),
        cmocka_unit_test(agreement_of_hits),
    };
    return cmocka_run_group_tests_name("bench_parts", tests, NULL, NULL);
}
