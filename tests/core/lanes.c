/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel with a cell walk gives the same bits as cell: packets of any width, any later walk, closest and any hit,
 * each leaf test, in calls of any length. There is no tolerance. A row of the table below is a test: a maker of fields,
 * a maker of rays, how many, and how the kernels are compared. lanes PATTERN… runs the rows whose names match.
 *
 * CELLWALK_TEST_ROUNDS = n takes n times the fields. JSON lines are for papers/robustness.md (support/counts.cmake). */

#include "lanes_grounds.h"

#include "cellwalk_expert.h"
#include "paths.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { RAYS_MAX = 140000, JUNK = 16 };

static float samples[GROUND_SAMPLES];
static test_field shape;
static cw_ray rays[RAYS_MAX + JUNK];
static cw_hit expected[RAYS_MAX], hits[RAYS_MAX];
static uint8_t occluded[RAYS_MAX];

/* Answers: of all kernels but the one that is the reference; other: those with other bits. */
typedef struct counts {
    size_t rays, hits, answers, other;
} counts;

/* Counts those of n rays with another closest hit than expected, or another any-hit answer, and prints the first. */
static void count_other(const ground *g, const cw_run *run, size_t first, size_t n, counts *c) {
    memset(hits, 0xff, n * sizeof *hits);
    check_status(cw_closest(g->field, run, rays + first, n, hits), CW_OK);
    check_status(cw_occluded(g->field, run, rays + first, n, occluded), CW_OK);
    c->answers += n;
    for (size_t k = 0; k < n; k++) {
        const cw_hit *wanted = &expected[first + k];
        if (hit_same(&hits[k], wanted) && occluded[k] == (wanted->i >= 0)) continue;
        if (c->other++ > 0) continue;
        const char *name = run->expert.kernel ? cw_kernel_describe(run->expert.kernel).name : "the kernel by default";
        printf("%s with leaf test %s, limit %s, ray %zu of %zu:\n", name, cw_leaf_name(run->expert.leaf),
               cw_isa_name(run->expert.isa), k, n);
        ray_print(&rays[first + k]);
        hit_print("expected", wanted);
        hit_print(name, &hits[k]);
        printf("any hit: %d\n", occluded[k]);
    }
}

static void expect_of_cell(const ground *g, cw_leaf leaf, size_t n) {
    const cw_run run = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = leaf};
    check_status(cw_closest(g->field, &run, rays, n, expected), CW_OK);
    for (size_t k = 0; k < n; k++)
        check(expected[k].i < 0 || (expected[k].t >= rays[k].tmin && expected[k].t <= rays[k].tmax),
              "a hit of ray %zu lies outside of its range", k);
}

/* ---- ways to compare --------------------------------------------------------------------------------------------- */

typedef void comparison(const ground *g, size_t n, counts *c);

static void of_cell(const ground *g, size_t n, counts *c, cw_leaf first, const char *like) {
    for (cw_leaf leaf = first; leaf < CW_LEAF_COUNT; leaf++) {
        expect_of_cell(g, leaf, n);
        for (size_t p = 0; p < path_count; p++)
            if (paths[p].strict && paths[p].leaf == leaf && strncmp(paths[p].name, like, strlen(like)) == 0 &&
                strcmp(paths[p].name, "cell") != 0)
                count_other(g, &paths[p].query, 0, n, c);
    }
}

static void every_kernel(const ground *g, size_t n, counts *c) { of_cell(g, n, c, CW_LEAF_MOLLER_TRUMBORE, ""); }
/* With the default leaf test, which is the last. */
static void pyramids(const ground *g, size_t n, counts *c) { of_cell(g, n, c, CW_LEAF_WATERTIGHT, "pyramid"); }

/* Calls of few rays, for which the library chooses other kernels, with each limit on the instruction set. */
static void small_calls(const ground *g, size_t n, counts *c) {
    enum { MOST = 17 };
    expect_of_cell(g, CW_LEAF_WATERTIGHT, n);
    for (cw_isa isa = CW_ISA_ANY; isa < CW_ISA_COUNT; isa++) {
        const cw_run run = {.expert.isa = isa};
        for (size_t k = 0, few = 1; k + few <= n; k += few, few = few % MOST + 1) {
            cw_user_ray user[MOST];
            count_other(g, &run, k, few, c);
            for (size_t m = 0; m < few; m++) user[m] = ray_for_user(&rays[k + m]);
            check_status(cw_closest_user(g->field, &run, user, few, hits), CW_OK);
            for (size_t m = 0; m < few; m++) c->other += !hit_same(&hits[m], &expected[k + m]);
        }
    }
}

static void __attribute__((noinline, no_sanitize("address", "undefined"))) leave_behind(uint32_t word) {
    enum { ROOM = 160 << 10 }; /* more than a call takes of the stack: the header says 128 KiB */
    volatile uint32_t room[ROOM / sizeof(uint32_t)];
    for (size_t k = 0; k < ROOM / sizeof(uint32_t); k++) room[k] = word;
    (void)room[0];
}

/* No answer depends on what earlier calls left on the stack. UndefinedBehaviorSanitizer shows that none of it is
 * computed with: an integer that was never set overflows here. Also kernels with other rules, held to themselves. */
static void painted_stack(const ground *g, size_t n, counts *c) {
    /* The least and the largest integer, both signs of not-a-number, infinity, a living lane in each bit. */
    static const uint32_t words[] = {0x80000000, 0x7fffffff, 0xffffffff, 0x7f800000, 0x00010001};
    for (size_t p = 0; p < path_count; p++) {
        leave_behind(0);
        check_status(cw_closest(g->field, &paths[p].query, rays, n, expected), CW_OK);
        for (size_t w = 0; w < sizeof words / sizeof words[0]; w++)
            for (size_t m = 0; m < 4; m++) {
                const size_t few = (size_t[]){1, 5, 64, n}[m];
                leave_behind(words[w]);
                check_status(cw_occluded(g->field, &paths[p].query, rays, few, occluded), CW_OK);
                for (size_t k = 0; k < few; k++) c->other += occluded[k] != (expected[k].i >= 0);
                leave_behind(words[w]);
                count_other(g, &paths[p].query, 0, few, c);
            }
    }
}

/* FNV-1a over the bytes (Fowler, Noll, Vo), the lowest of each number first. */
static uint64_t sum_of(const cw_hit *hit, size_t n) {
    uint64_t sum = 0xcbf29ce484222325u;
    for (size_t k = 0; k < n; k++, hit++) {
        uint32_t numbers[6] = {0, 0, 0, (uint32_t)hit->i, (uint32_t)hit->j, hit->triangle};
        memcpy(numbers, (float[]){hit->t, hit->u, hit->v}, 3 * sizeof *numbers);
        for (int byte = 0; byte < 24; byte++)
            sum = (sum ^ (numbers[byte / 4] >> 8 * (byte % 4) & 0xff)) * 0x100000001b3u;
    }
    return sum;
}

/* The bits of cell's answers on every CPU, with every compiler and at every optimisation level, as sums that were taken
 * once. After a change that is meant to change answers, the new sums are what the test prints. */
static void recorded(const ground *g, size_t n, counts *c) {
    static const uint64_t sums[WORKLOAD_CLASS_COUNT][2][2] = {
        /* land: Möller-Trumbore, watertight; sea */
        [WORKLOAD_PRIMARY] = {{0x2694fda327ec958cu, 0xc9083b99abfad0e6u}, {0x6eb205520638a393u, 0xe75d58db9533cb7du}},
        [WORKLOAD_SHADOW] = {{0xae7b326716deb37cu, 0x8188d0e192d620feu}, {0x17e2ebed4c84feddu, 0xea33d03575bfc273u}},
        [WORKLOAD_AO] = {{0xfeb33ae194e6e09du, 0x99ac6107decbb052u}, {0x9b90789cd06de471u, 0x4fb04ea21abe0625u}},
        [WORKLOAD_BOUNCE] = {{0x5ac1b73388674ecfu, 0x34b2b4f6a429e3f8u}, {0x8c302c6130b33a53u, 0xd45f0122305513e7u}},
        [WORKLOAD_RANDOM] = {{0x0f86e786cb850ca7u, 0xb48b28899266ed17u}, {0xe64a4dacbcf9e9ecu, 0x47a3342ffb33871fu}},
        [WORKLOAD_GRAZING] = {{0x6871f906b0be7343u, 0xc493e5ac2d98fb4eu}, {0x8f0029d52d9697b2u, 0x51e9bb0cbaee65d1u}},
        [WORKLOAD_AFAR] = {{0xe4ba737b4e9c01dcu, 0xd7e59522d316750cu}, {0x68b945cefbda8cbfu, 0xb30a16f6ef2bce9fu}},
    };
    for (int leaf = 0; leaf < 2; leaf++) {
        expect_of_cell(g, leaf ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE, n);
        const uint64_t sum = sum_of(expected, n);
        c->answers += n;
        if (sum == sums[g->class][g->number % 2][leaf]) continue;
        printf("%s, %s: 0x%016llxu is not what it was\n", g->number % 2 ? "sea" : "land", leaf ? "watertight" : "MT",
               (unsigned long long)sum);
        c->other += n;
    }
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

typedef struct row {
    const char *name;
    field_maker *field;
    ray_maker *ray;
    comparison *compare;
    size_t fields, least_fields, rays, least_rays; /* rays: a field; least: in slow builds */
    bool one_call;                                 /* a field, with at most that many rays */
    bool slow;                                     /* not on an emulated CPU (test_old_cpu) */
    bool some_miss;
    double hits; /* at least that share of the rays */
    workload_class class;
} row;

static const row table[] = {
    {"known", known_field, known_rays, every_kernel, KNOWN, KNOWN, KNOWN_RAYS, KNOWN_RAYS, .hits = 0},
    {"random", any_shape, random_rays, every_kernel, ALL_SHAPES, ALL_SHAPES, 10214, 20, .hits = 0.1},
    {"adversarial", any_shape, adversarial_rays, every_kernel, ALL_SHAPES, ALL_SHAPES, 10214, 20, .hits = 0.1},
    {"towers", towers, rays_past_towers, every_kernel, 200, 1, RUN_MAX, RUN_MAX, .hits = 0.1},
    {"steep", large_shape, steep_rays, pyramids, 1, 1, 61440, 960, .hits = 0.3},
    {"standing", large_shape, standing_rays, pyramids, 1, 1, 61440, 960, .hits = 0.3},
    /* The lane walk keeps rays from batch to batch, and counts them anew after some 2^16. */
    {"long call", large_shape, rays_in_turn, pyramids, 1, 1, RAYS_MAX, 66000, .slow = true, .hits = 0.1},
    {"beside", plane, rays_beside_plane, pyramids, 600, 14, 600, 600, .one_call = true, .slow = true, .some_miss = true,
     .hits = 0.1},
    {"corners behind holes", corner_behind_hole, ray_through_corners, pyramids, CORNERS, CORNERS, 1, 1, .slow = true,
     .hits = 1},
    {"climb", towers_beside_nodes, climbing_rays, pyramids, 240, 12, 1024, 1024, .some_miss = true, .hits = 0.05},
    {"climb far out", wide_towers_beside_nodes, climbing_rays, pyramids, 1, 1, 60 << 10, 2 << 10, .slow = true,
     .some_miss = true, .hits = 0.05},
    {"few", small_shape, rays_in_turn, small_calls, 3, 3, 6000, 1500, .hits = 0.05},
    {"few over a cliff", cliff, rays_over_cliff, small_calls, 2, 1, 6000, 1500, .some_miss = true, .hits = 0.3},
    {"few in a large field", large_land, benchmark_rays, small_calls, 1, 1, 6000, 1500, .slow = true, .hits = 0.05,
     .class = WORKLOAD_RANDOM},
    {"leftovers", small_shape, rays_in_turn, painted_stack, 3, 3, 150, 150, .slow = true},
#define ROWS(rays, name)                                                                                               \
    {"bits " name, same_land, benchmark_rays, recorded, 2, 2, 8192, 8192, true, true, .class = rays}, {                \
        "stress " name, any_land, benchmark_rays, every_kernel, 4, 2, 15360, 960, true, .hits = 0.02, .class = rays    \
    }
    ROWS(WORKLOAD_PRIMARY, "primary"),
    ROWS(WORKLOAD_SHADOW, "shadow"),
    ROWS(WORKLOAD_AO, "ao"),
    ROWS(WORKLOAD_BOUNCE, "bounce"),
    ROWS(WORKLOAD_RANDOM, "random"),
    ROWS(WORKLOAD_GRAZING, "grazing"),
    ROWS(WORKLOAD_AFAR, "afar"),
#undef ROWS
};
enum { ROWS = sizeof table / sizeof table[0] };

static void trace_field(const row *of, ground *g, random_state *r, counts *c) {
    g->field = of->field(g, r);
    size_t n;
    for (size_t left = test_share(of->rays, of->least_rays); left > 0 && c->other == 0;
         left -= of->one_call ? left : n) {
        n = of->ray(g, rays, left, r);
        check(n > 0 && n <= left, "%zu rays", n);
        memset(rays + n, 0xff, JUNK * sizeof *rays); /* which no kernel may look at, or may and must not heed */
        of->compare(g, n, c);
        c->rays += n;
        for (size_t k = 0; k < n; k++) c->hits += expected[k].i >= 0;
    }
    cw_field_destroy(g->field);
}

static void test_row(void **state) {
    const row *of = *state;
    if (of->slow && test_divisor() >= 1000) skip();
    random_state r = {20261124};
    ground g = {.class = of->class, .shape = &shape, .z = samples};
    counts c = {0};
    const size_t fields = test_share(of->fields, of->least_fields) * test_rounds();
    for (; g.number < fields && c.other == 0; g.number++) trace_field(of, &g, &r, &c);
    printf("%zu rays, %zu hits, %zu answers, %zu with other bits\n", c.rays, c.hits, c.answers, c.other);
    if (of->field == any_land)
        printf("{\"kind\": \"stress\", \"rays\": \"%s\", \"traced\": %zu, \"hits\": %zu, \"answers\": %zu, "
               "\"other_bits\": %zu}\n",
               workload_class_name(of->class), c.rays, c.hits, c.answers, c.other);
    if (c.other > 0 && of->field == any_shape) field_print(&shape);
    check(c.other == 0, "kernels differ on field %zu", g.number - 1);
    check(c.answers >= c.rays, "no kernel was compared");
    check((double)c.hits >= of->hits * (double)c.rays && !(of->some_miss && c.hits == c.rays),
          "too few rays hit or miss for the test to mean anything");
}

int main(int argc, char **argv) {
    struct CMUnitTest tests[ROWS];
    for (size_t k = 0; k < ROWS; k++)
        tests[k] =
            (struct CMUnitTest){.name = table[k].name, .test_func = test_row, .initial_state = (void *)&table[k]};
    return paths_run("lanes", tests, ROWS, argc, argv);
}
