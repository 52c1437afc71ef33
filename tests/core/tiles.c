/* SPDX-License-Identifier: Apache-2.0 */
/* Land in tiles, as papers/using.md advises: tiles that overlap by one cell let no ray through at their borders that one field stops. */
#include "cellwalk.h"
#include "check.h"
#include "workload/random.h"

#include <math.h>

enum { ACROSS = 3, CELLS = 40, SIDE = ACROSS * CELLS + 2, BATCH = 1000 };

static float samples[SIDE * SIDE];

/* The CELLS × CELLS cells of a tile from (x, y) on, and beyond them overlap more columns and rows of its neighbours. The map sends it to
 * its place. */
static cw_field *make_tile(size_t x, size_t y, size_t cells) {
    const cw_field_desc desc = {.samples = samples + y * SIDE + x,
                                .nx = cells + 1,
                                .ny = cells + 1,
                                .stride = SIDE,
                                .map = {{1, 0, 0, (double)x}, {0, 1, 0, (double)y}, {0, 0, 1, 0}}};
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    return field;
}

/* Rays from above at places on the inner borders, or at their crossings. Returns how many only the whole land stops. */
static size_t slip_through(size_t overlap, bool corners) {
    static cw_user_ray rays[BATCH];
    static cw_hit wanted[BATCH], one[BATCH];
    random_state r = {5};
    cw_field *whole = make_tile(0, 0, SIDE - 1), *tiles[ACROSS * ACROSS];
    size_t through = 0;
    for (size_t k = 0; k < ACROSS * ACROSS; k++)
        tiles[k] = make_tile(k % ACROSS * CELLS, k / ACROSS * CELLS, CELLS + overlap);
    for (size_t batch = 0; batch < test_share(100, 10); batch++) {
        float nearest[BATCH];
        for (size_t k = 0; k < BATCH; k++) {
            const double border = CELLS * (double)(1 + k % 2), other = CELLS * (double)(1 + k / 2 % 2),
                         along = corners ? other : random_between(&r, 1, SIDE - 3);
            const double at[3] = {k / 4 % 2 ? border : along, k / 4 % 2 ? along : border, random_between(&r, 0, 3)};
            rays[k] =
                (cw_user_ray){.org = {random_between(&r, 0, SIDE), random_between(&r, 0, SIDE), 60}, .tmax = INFINITY};
            for (int m = 0; m < 3; m++) rays[k].dir[m] = at[m] - rays[k].org[m];
            nearest[k] = INFINITY;
        }
        check_status(cw_closest_user(whole, NULL, rays, BATCH, wanted), CW_OK);
        for (size_t k = 0; k < ACROSS * ACROSS; k++) {
            check_status(cw_closest_user(tiles[k], NULL, rays, BATCH, one), CW_OK);
            for (size_t m = 0; m < BATCH; m++) nearest[m] = fminf(nearest[m], one[m].t);
        }
        for (size_t k = 0; k < BATCH; k++) {
            through += wanted[k].i >= 0 && isinf(nearest[k]);
            check(wanted[k].i < 0 || isinf(nearest[k]) || fabsf(nearest[k] - wanted[k].t) <= 1e-5f,
                  "a hit at %g, not %g", (double)nearest[k], (double)wanted[k].t);
        }
    }
    for (size_t k = 0; k < ACROSS * ACROSS; k++) cw_field_destroy(tiles[k]);
    cw_field_destroy(whole);
    return through;
}

static void no_ray_slips_between_tiles_that_overlap(void **state) {
    (void)state;
    random_state r = {7};
    for (size_t k = 0; k < SIDE * SIDE; k++) samples[k] = (float)random_between(&r, 0, 3);
    for (int corners = 0; corners < 2; corners++) {
        const size_t through = slip_through(1, corners);
        check(through == 0, "%zu rays slip through", through);
    }
    check(slip_through(0, false) > 0, "no ray slips through without the overlap: nothing is tested");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_ray_slips_between_tiles_that_overlap)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
