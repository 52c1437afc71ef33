/* SPDX-License-Identifier: Apache-2.0 */
/* Prints the number of kernels, counted once for each leaf test, and a hash of the bits of hits that all of them
 * return, alone and on a pool. Systems and C libraries must not differ in it, nor a program that is compiled with
 * -ffast-math. Heights and rays are made by integers and exact divisions alone. */

#include <cellwalk_expert.h>

#include <stdio.h>
#include <string.h>

enum { SIDE = 129, RAYS = 20000 };

static float samples[SIDE * SIDE];
static cw_ray rays[RAYS];
static cw_hit expected[RAYS], hits[RAYS];

static int fail(const char *what) {
    fprintf(stderr, "%s: %s\n", what, cw_last_error());
    return 1;
}

static uint32_t next(void) { /* Marsaglia's xorshift */
    static uint32_t state = 2463534242u;
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
}

/* From -scale to scale, a multiple of 2^-23 of it. Products of fewer bits would be exact, fused or not. */
static float number(float scale) { return ((float)(next() >> 8) / 8388608 - 1) * scale; }

int main(void) {
    for (int k = 0; k < SIDE * SIDE; k++) samples[k] = number(2);
    for (int k = 0; k < RAYS; k++) {
        cw_ray *r = &rays[k];
        *r = (cw_ray){.org = {SIDE / 2 + number(SIDE / 2), SIDE / 2 + number(SIDE / 2), number(4)}, .tmax = 1e9f};
        for (int c = 0; c < 3; c++) r->dir[c] = number(1);
    }
    const uint32_t holes[2] = {0x7fc00000,
                               0x7f800000}; /* NaN and infinity, which a compiler with -ffast-math does not know */
    memcpy(&samples[20 * SIDE + 20], &holes[0], sizeof holes[0]);
    memcpy(&samples[20 * SIDE + 25], &holes[1], sizeof holes[1]);
    rays[0] =
        (cw_ray){.org = {20.25f, 19.75f, 9}, .dir = {0, 0, -1}, .tmax = 100}; /* through triangles at the first one */
    const cw_field_desc desc = {.samples = samples, .nx = SIDE, .ny = SIDE};
    cw_field *field;
    cw_pool *pool;
    if (cw_field_create(&desc, NULL, &field) != CW_OK || cw_pool_create(3, &pool) != CW_OK)
        return fail("no field or pool");
    if (cw_field_describe(field).holes != 2) return fail("holes are not counted");
    int kernels = 0;
    uint64_t hash = 14695981039346656037u; /* FNV-1a */
    /* Of each leaf test: answers of one are computed in float, where it shows soonest if multiply and add are fused. */
    for (cw_leaf leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
        const cw_run plain = {.expert = {.kernel = cw_kernel_find("cell"), .leaf = leaf}};
        if (cw_closest(field, &plain, rays, RAYS, expected) != CW_OK) return fail("cell");
        if (expected[0].i != -1) return fail("a ray hits a hole");
        for (size_t k = 0; k < cw_kernel_count(); k++) {
            const char *name = cw_kernel_describe(cw_kernel_at(k)).name;
            cw_run run = {.expert = {.kernel = cw_kernel_at(k), .leaf = leaf}};
            if (cw_run_check(field, &run) != CW_OK) continue; /* not on this CPU, or not with this test */
            for (int threads = 1; threads <= 2; threads++) {
                run.pool = threads == 1 ? NULL : pool;
                memset(hits, -1, sizeof hits);
                if (cw_closest(field, &run, rays, RAYS, hits) != CW_OK) return fail(name);
                if (memcmp(hits, expected, sizeof hits) != 0) return fail(name);
            }
            kernels++;
        }
        for (size_t k = 0; k < sizeof hits; k++) hash = (hash ^ ((const unsigned char *)expected)[k]) * 1099511628211u;
    }
    printf("%d kernels, hits %016llx\n", kernels, (unsigned long long)hash);
    cw_pool_destroy(pool);
    cw_field_destroy(field);
    return kernels < 3; /* cell with both, pyramid1 */
}
