/* SPDX-License-Identifier: Apache-2.0 */
/* Differences between hits are seen, counted once, and put down to the right reason. */
#include "harness/agree.h"

#include "check.h"

#include <math.h>
#include <string.h>

static const float flat[9] = {0};

static cw_field *new_field(void) {
    cw_field_desc desc = {0};
    desc.samples = flat;
    desc.nx = desc.ny = 3;
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    return field;
}

/* Straight down on a flat field of height 0 from height 1. */
static const cw_ray down = {.org = {0.5f, 0.25f, 1}, .dir = {0, 0, -1}, .tmin = 0, .tmax = INFINITY};
static const cw_hit inside = {.t = 1, .u = 0.25f, .v = 0.25f, .triangle = CW_TRIANGLE_A};
static const cw_hit nothing = {.t = INFINITY, .i = -1, .j = -1};

static agreement of(const cw_ray *ray, const cw_hit *a, const cw_hit *b) {
    agreement sum = {0};
    cw_field *field = new_field();
    agree_closest(&sum, field, ray, 1, a, b);
    cw_field_destroy(field);
    return sum;
}

static void equal_hits(void **state) {
    (void)state;
    agreement sum = of(&down, &inside, &inside);
    check((sum.only_a + sum.only_b + sum.far) == 0 && sum.same_bits == 1 && sum.hits_a == 1 && sum.hits_b == 1,
          "equal hits differ");
    sum = of(&down, &nothing, &nothing);
    check((sum.only_a + sum.only_b + sum.far) == 0 && sum.same_bits == 1 && sum.hits_a == 0, "misses differ");
}

static void rounding_is_not_a_difference(void **state) {
    (void)state;
    cw_hit rounded = inside;
    rounded.t = nextafterf(1, 2);
    agreement sum = of(&down, &inside, &rounded);
    check((sum.only_a + sum.only_b + sum.far) == 0 && sum.same_bits == 0 && sum.worst > 0,
          "one rounding counts as a difference");
    rounded.triangle = CW_TRIANGLE_B;
    sum = of(&down, &inside, &rounded);
    check((sum.only_a + sum.only_b + sum.far) == 0 && sum.other_triangle == 1, "a tie is not counted as one");
    rounded.t = 1.001f;
    sum = of(&down, &inside, &rounded);
    check(sum.far == 1 && (sum.only_a + sum.only_b + sum.far) == 1, "a thousandth counts as rounding");
}

static void reasons(void **state) {
    (void)state;
    agreement sum = of(&down, &inside, &nothing);
    check(sum.only_a == 1 && sum.why[AGREE_OTHER] == 1, "a miss in the middle of a triangle is not a defect");
    cw_hit edge = inside;
    edge.v = 1e-7f;
    sum = of(&down, &nothing, &edge);
    check(sum.only_b == 1 && sum.why[AGREE_EDGE] == 1, "a miss at an edge is not put down to it");
    edge.u = 0.75f;
    edge.v = 0.25f;
    sum = of(&down, &edge, &nothing);
    check(sum.why[AGREE_EDGE] == 1, "a miss at the third edge is not put down to it");
    cw_ray touching = down;
    touching.tmax = 1;
    sum = of(&touching, &inside, &nothing);
    check(sum.why[AGREE_END] == 1, "a miss at the ray's end is not put down to it");
    const cw_ray level = {.org = {0, 0.25f, 1e-7f}, .dir = {1, 0, -1e-7f}, .tmin = -1, .tmax = 2};
    sum = of(&level, &inside, &nothing);
    check(sum.why[AGREE_GRAZING] == 1 || sum.why[AGREE_END] == 1, "a miss of a level ray counts as a defect");
}

static void closest_finds(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    (void)self, (void)rays;
    for (size_t k = 0; k < n; k++) hits[k] = inside;
}

static void any_hit(void **state) {
    (void)state;
    cw_field *field = new_field();
    const contender finder = {.closest = closest_finds};
    const uint8_t yes = 1, no = 0;
    agreement sum = {0};
    agree_any(&sum, field, &down, 1, &yes, &yes, &finder, &finder);
    check(sum.rays == 1 && (sum.only_a + sum.only_b + sum.far) == 0, "equal answers differ");
    agree_any(&sum, field, &down, 1, &yes, &no, &finder, &finder);
    agree_any(&sum, field, &down, 1, &no, &yes, &finder, &finder);
    check(sum.rays == 3 && sum.only_a == 1 && sum.only_b == 1 && sum.why[AGREE_OTHER] == 2, "different answers agree");
    cw_field_destroy(field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_hits),
        cmocka_unit_test(rounding_is_not_a_difference),
        cmocka_unit_test(reasons),
        cmocka_unit_test(any_hit),
    };
    return cmocka_run_group_tests_name("bench_agree", tests, NULL, NULL);
}
