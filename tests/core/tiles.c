/* SPDX-License-Identifier: Apache-2.0 */
/* Land in tiles, as papers/using.md advises: tiles that overlap by one cell let no ray through at their borders that one field stops. */
#include "cellwalk.h"
#include "check.h"
#include "workload/random.h"

#include <math.h>
#include <string.h>

enum { ACROSS = 3, CELLS = 40, SIDE = ACROSS * CELLS + 2, BATCH = 1000 };

static float samples[SIDE * SIDE];
static cw_field *whole, *tiles[ACROSS * ACROSS];

/* Each tile has the CELLS × CELLS cells that are its own, and beyond them overlap more columns and rows of its neighbours. Its map sends
 * it to its place. */
static void make_tiles(size_t overlap) {
    for (size_t k = 0; k < ACROSS * ACROSS; k++) {
        const size_t x = k % ACROSS * CELLS, y = k / ACROSS * CELLS, side = CELLS + 1 + overlap;
        const cw_field_desc desc = {.samples = samples + y * SIDE + x,
                                    .nx = side,
                                    .ny = side,
                                    .stride = SIDE,
                                    .map = {{1, 0, 0, (double)x}, {0, 1, 0, (double)y}, {0, 0, 1, 0}}};
        check_status(cw_field_create(&desc, NULL, &tiles[k]), CW_OK);
    }
}

/* The first hit in any tile. A cell in two tiles gives two hits with one t, of which the first one stays. */
static void closest_of_tiles(const cw_user_ray *rays, size_t n, cw_hit *hits) {
    cw_hit one[BATCH];
    for (size_t k = 0; k < n; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
    for (size_t k = 0; k < ACROSS * ACROSS; k++) {
        check_status(cw_closest_user(tiles[k], NULL, rays, n, one), CW_OK);
        for (size_t m = 0; m < n; m++) {
            if (!(one[m].t < hits[m].t)) continue;
            hits[m] = one[m];
            hits[m].i += (int32_t)(k % ACROSS * CELLS); /* the cell in the whole land */
            hits[m].j += (int32_t)(k / ACROSS * CELLS);
        }
    }
}

typedef struct counts {
    size_t stopped, through, elsewhere;
} counts;

/* Rays from above at places on the inner borders, or at the corners. */
static counts shoot(size_t overlap, bool corners) {
    static cw_user_ray rays[BATCH];
    static cw_hit wanted[BATCH], got[BATCH];
    random_state r = {5};
    counts c = {0, 0, 0};
    make_tiles(overlap);
    for (size_t batch = 0; batch < test_share(100, 10); batch++) {
        for (size_t k = 0; k < BATCH; k++) {
            const double border = CELLS * (double)(1 + k % (ACROSS - 1)),
                         other = CELLS * (double)(1 + k / 2 % (ACROSS - 1));
            const double along = corners ? other : random_between(&r, 1, SIDE - 3);
            const double at[3] = {k / 4 % 2 ? border : along, k / 4 % 2 ? along : border, random_between(&r, 0, 3)};
            rays[k] =
                (cw_user_ray){.org = {random_between(&r, 0, SIDE), random_between(&r, 0, SIDE), 60}, .tmax = INFINITY};
            for (int m = 0; m < 3; m++) rays[k].dir[m] = at[m] - rays[k].org[m];
        }
        check_status(cw_closest_user(whole, NULL, rays, BATCH, wanted), CW_OK);
        closest_of_tiles(rays, BATCH, got);
        for (size_t k = 0; k < BATCH; k++) {
            if (wanted[k].i < 0) continue;
            c.stopped++;
            c.through += got[k].i < 0;
            c.elsewhere += got[k].i >= 0 && fabs((double)got[k].t - (double)wanted[k].t) > 1e-5;
        }
    }
    for (size_t k = 0; k < ACROSS * ACROSS; k++) cw_field_destroy(tiles[k]);
    return c;
}

static void no_ray_slips_between_tiles_that_overlap(void **state) {
    (void)state;
    random_state r = {7};
    for (size_t k = 0; k < SIDE * SIDE; k++) samples[k] = (float)random_between(&r, 0, 3);
    check_status(cw_field_create(&(cw_field_desc){.samples = samples, .nx = SIDE, .ny = SIDE}, NULL, &whole), CW_OK);
    for (int corners = 0; corners < 2; corners++)
        for (size_t overlap = 0; overlap < 2; overlap++) {
            const counts c = shoot(overlap, corners);
            check(c.elsewhere == 0, "%zu of %zu rays hit elsewhere", c.elsewhere, c.stopped);
            if (overlap == 1) check(c.through == 0, "%zu of %zu rays slip through", c.through, c.stopped);
            if (overlap == 0 && !corners)
                check(c.through > 0, "no ray slips through without the overlap: nothing is tested");
        }
    cw_field_destroy(whole);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_ray_slips_between_tiles_that_overlap)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
