/* SPDX-License-Identifier: Apache-2.0 */
/* No answer depends on what earlier calls have left on the stack, and none of it is computed with: under
 * UndefinedBehaviorSanitizer an integer that was never set overflows here. */

#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <string.h>

/* More than a call takes of the stack (the header says 128 KiB). */
enum { ROOM = 160 << 10, RAYS = 150 };

/* The least and the largest integer, both signs of not-a-number, infinity, a living lane in each bit. */
static const uint32_t words[] = {0x80000000, 0x7fffffff, 0xffffffff, 0x7f800000, 0x00010001};
static const size_t counts[] = {1, 5, 64, RAYS};

static void __attribute__((noinline, no_sanitize("address", "undefined"))) leave_behind(uint32_t word) {
    volatile uint32_t room[ROOM / sizeof(uint32_t)];
    for (size_t k = 0; k < ROOM / sizeof(uint32_t); k++) room[k] = word;
    (void)room[0];
}

static void compare(const cw_field *field, const cw_kernel *kernel, cw_leaf leaf, const cw_ray *rays) {
    const cw_run q = {.expert.kernel = kernel, .expert.leaf = leaf};
    static cw_hit expected[RAYS], hits[RAYS];
    static uint8_t occluded[RAYS];
    leave_behind(0);
    if (cw_closest(field, &q, rays, RAYS, expected) == CW_ERROR_KERNEL) return;
    for (size_t w = 0; w < sizeof words / sizeof words[0]; w++)
        for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
            leave_behind(words[w]);
            check_status(cw_closest(field, &q, rays, counts[c], hits), CW_OK);
            leave_behind(words[w]);
            check_status(cw_occluded(field, &q, rays, counts[c], occluded), CW_OK);
            for (size_t k = 0; k < counts[c]; k++)
                check(hit_same(&hits[k], &expected[k]) && occluded[k] == (expected[k].i >= 0),
                      "%s: ray %zu of %zu after words %08x", cw_kernel_describe(kernel).name, k, counts[c],
                      (unsigned)words[w]);
        }
}

static void no_answer_depends_on_them(void **state) {
    (void)state;
    static test_field f;
    static cw_ray rays[RAYS];
    static cw_hit hits[RAYS];
    static const field_size sizes[] = {{2, 2}, {9, 5}, {65, 33}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
        cw_field *field =
            ray_case(&f, s % 2 ? FIELD_HOLES : FIELD_RANDOM, sizes[s].nx, sizes[s].ny, s, rays, hits, RAYS);
        for (size_t k = 0; k < cw_kernel_count(); k++)
            for (int leaf = 0; cw_kernel_describe(cw_kernel_at(k)).available && leaf < CW_LEAF_COUNT; leaf++)
                compare(field, cw_kernel_at(k), (cw_leaf)leaf, rays);
        cw_field_destroy(field);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_answer_depends_on_them)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
