/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's fields and rays are the same numbers everywhere. */
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 8192 };

typedef struct ground {
    workload_field samples;
    cw_field *field;
    cw_ray rays[RAYS];
} ground;

/* FNV-1a over the bytes (Fowler, Noll, Vo). */
static uint64_t hash(const void *bytes, size_t size) {
    const unsigned char *b = bytes;
    uint64_t h = 0xcbf29ce484222325u;
    for (size_t k = 0; k < size; k++) h = (h ^ b[k]) * 0x100000001b3u;
    return h;
}

static int open_ground(void **state) {
    ground *g = calloc(1, sizeof *g);
    if (g == NULL || !workload_field_make("257", &g->samples)) return -1;
    cw_field_desc desc = {0};
    desc.samples = g->samples.z;
    desc.nx = g->samples.nx;
    desc.ny = g->samples.ny;
    desc.storage = CW_BORROW;
    *state = g;
    return cw_field_create(&desc, NULL, &g->field) == CW_OK ? 0 : -1;
}

static int close_ground(void **state) {
    ground *g = *state;
    cw_field_destroy(g->field);
    workload_field_free(&g->samples);
    free(g);
    return 0;
}

static void fields_are_what_they_were(void **state) {
    (void)state;
    static const struct {
        const char *name;
        size_t side;
        float range; /* of heights, exactly; 0: not given */
        uint64_t hash;
    } known[] = {
        {"65", 65, 6.4f, 0xb6efb7d0d6e51bf0u},          {"257", 257, 25.6f, 0xb09c7f2aa10db23fu},
        {"1025", 1025, 102.4f, 0xac9dd3e347b17868u},    {"sea-calm", 1000, 0, 0xdd566efff66c770du},
        {"sea-rough", 1000, 0, 0x7e6b294aed11b039u},    {"plane", 1025, 384, 0x7c735dd77ebf756eu},
        {"grooves", 1025, 1, 0x6bac00c391466f98u},      {"comb", 1025, 1, 0xe7e9a01493ec6f98u},
        {"checkerboard", 1025, 1, 0xe4e544cd75536f98u},
    };
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        workload_field f;
        check(workload_field_make(known[k].name, &f), "no field %s", known[k].name);
        check(f.nx == known[k].side && f.ny == known[k].side, "field %s is %zu x %zu", known[k].name, f.nx, f.ny);
        float low = f.z[0], high = f.z[0];
        for (size_t s = 0; s < f.nx * f.ny; s++) {
            low = f.z[s] < low ? f.z[s] : low;
            high = f.z[s] > high ? f.z[s] : high;
        }
        check(known[k].range == 0 || fabsf(high - low - known[k].range) < 1e-4f, "field %s spans %g", known[k].name,
              (double)(high - low));
        const uint64_t h = hash(f.z, f.nx * f.ny * sizeof *f.z);
        check(h == known[k].hash, "field %s has hash 0x%016llx", known[k].name, (unsigned long long)h);
        workload_field_free(&f);
    }
}

static void unknown_field(void **state) {
    (void)state;
    workload_field f;
    check(!workload_field_make("66x", &f) && f.z == NULL && f.name == NULL, "there is a field 66x");
}

static void rays_are_what_they_were(void **state) {
    ground *g = *state;
    static const uint64_t known[WORKLOAD_CLASS_COUNT + 1] = {
        0x178632adbd0683f1u, 0xb13b39c9883f0f8fu, 0x8e8fceed79817928u, 0xa26b27529c7f380bu,
        0x0ce8f34c2a14040cu, 0x4f700ae024e1b3e8u, 0x7461cedfbac259dau, 0xcf4e2a03d9838379u};
    for (int k = 0; k <= WORKLOAD_CLASS_COUNT; k++) {
        const workload_class c = k < WORKLOAD_CLASS_COUNT ? (workload_class)k : WORKLOAD_BESIDE;
        const char *name = workload_class_name(c);
        const size_t n = workload_rays_make(g->field, c, 1, RAYS, g->rays);
        check(n == RAYS, "%zu %s rays", n, name);
        const uint64_t first = hash(g->rays, sizeof g->rays);
        check(first == known[k], "%s rays have hash 0x%016llx", name, (unsigned long long)first);
        workload_rays_make(g->field, c, 1, RAYS, g->rays);
        check(hash(g->rays, sizeof g->rays) == first, "%s rays change when made again", name);
        workload_rays_make(g->field, c, 2, RAYS, g->rays);
        const bool seeded = c != WORKLOAD_PRIMARY && c != WORKLOAD_SHADOW && c != WORKLOAD_AFAR;
        check((hash(g->rays, sizeof g->rays) != first) == seeded, "%s rays and their seed", name);
        for (size_t m = 0; m < n; m++) {
            double length = 0;
            for (int a = 0; a < 3; a++) length += (double)g->rays[m].dir[a] * (double)g->rays[m].dir[a];
            check(fabs(length - 1) < 1e-6, "%s ray %zu has direction of squared length %g", name, m, length);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_are_what_they_were),
        cmocka_unit_test(unknown_field),
        cmocka_unit_test(rays_are_what_they_were),
    };
    return cmocka_run_group_tests_name("bench_workload", tests, open_ground, close_ground);
}
