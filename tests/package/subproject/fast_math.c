/* SPDX-License-Identifier: Apache-2.0 */
/* A program compiled with -ffast-math, whose Cellwalk is not: holes are holes, and kernels agree in every bit. Looks at bits and
 * whole numbers alone, since its own comparisons of floats are worth nothing. */

#include <cellwalk_expert.h>

#include <stdio.h>
#include <string.h>

enum { SIDE = 40, RAYS = 4000 };

static union {
    float z[SIDE * SIDE];
    uint32_t bits[SIDE * SIDE];
} samples;
static cw_ray rays[RAYS];
static cw_hit expected[RAYS], hits[RAYS];

static int fail(const char *what) {
    fprintf(stderr, "%s\n", what);
    return 1;
}

static void make_rays(void) {
    for (int k = 0; k < RAYS; k++) {
        const int a = k * 7919 % 4001, b = k * 104729 % 3001;
        rays[k] = (cw_ray){.org = {(float)(a % SIDE), (float)(b % SIDE), 9},
                           .dir = {(float)(a - 2000) / 2001, (float)(b - 1500) / 1501, -1.0f / (float)(1 + k % 50)},
                           .tmax = 1e9f};
    }
}

int main(void) {
    for (int k = 0; k < SIDE * SIDE; k++) samples.z[k] = (float)(k * 31 % 17) * 0.25f;
    const int hole = 20 * SIDE + 20;
    samples.bits[hole] = 0x7fc00000;
    samples.bits[hole + 5] = 0x7f800000;
    const cw_field_desc desc = {.samples = samples.z, .nx = SIDE, .ny = SIDE};
    cw_field *field;
    if (cw_field_create(&desc, NULL, &field) != CW_OK) return fail("no field");
    if (cw_field_describe(field).holes != 2) return fail("holes are not counted");

    make_rays();
    rays[0] =
        (cw_ray){.org = {20.25f, 19.75f, 9}, .dir = {0, 0, -1}, .tmax = 100}; /* through the triangles at the hole */
    const cw_kernel *cell = cw_kernel_find("cell");
    const cw_run plain = {.expert.kernel = cell};
    if (cw_closest(field, &plain, rays, RAYS, expected) != CW_OK) return fail("no query");
    if (expected[0].i != -1) return fail("a ray hits a hole");
    int kernels = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(kernel);
        const bool same_rules = strncmp(info.name, "packet", 6) == 0 || strncmp(info.name, "pyramid", 7) == 0;
        const cw_run query = {.expert.kernel = kernel};
        if (!info.available || !same_rules) continue;
        if (cw_field_build(field, &(cw_run){.expert.kernel = kernel}) != CW_OK) return fail("not built");
        if (cw_closest(field, &query, rays, RAYS, hits) != CW_OK) return fail("no query");
        if (memcmp(hits, expected, sizeof hits) != 0) return fail(info.name);
        kernels++;
    }
    printf("%d kernels agree with cell\n", kernels);
    cw_field_destroy(field);
    return kernels > 0 ? 0 : fail("no kernels");
}
