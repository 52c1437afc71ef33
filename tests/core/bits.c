/* SPDX-License-Identifier: Apache-2.0 */
/* The bits of answers: the same on every CPU, with every compiler and at every optimisation level, as sums that were taken
 * once. lanes.c holds all kernels to the one that is asked here. Land, sea and rays are made by hashes and IEEE operations
 * alone. After a change that is meant to change answers, the new sums are what the test prints. */

#include "cellwalk_expert.h"
#include "check.h"

#include "workload/fractal_terrain.h"
#include "workload/ray_classes.h"

#include <stdio.h>
#include <string.h>

enum { SIDE = 257, RAYS = 8192, LEAVES = 2 };

static const struct {
    const char *name;
    uint64_t sum[WORKLOAD_CLASS_COUNT][LEAVES]; /* Möller-Trumbore, watertight */
} grounds[] = {
    {"land",
     {
         [WORKLOAD_PRIMARY] = {0x2694fda327ec958cu, 0xc9083b99abfad0e6u},
         [WORKLOAD_SHADOW] = {0xae7b326716deb37cu, 0x8188d0e192d620feu},
         [WORKLOAD_AO] = {0xfeb33ae194e6e09du, 0x99ac6107decbb052u},
         [WORKLOAD_BOUNCE] = {0x5ac1b73388674ecfu, 0x34b2b4f6a429e3f8u},
         [WORKLOAD_RANDOM] = {0x0f86e786cb850ca7u, 0xb48b28899266ed17u},
         [WORKLOAD_GRAZING] = {0x6871f906b0be7343u, 0xc493e5ac2d98fb4eu},
         [WORKLOAD_AFAR] = {0xe4ba737b4e9c01dcu, 0xd7e59522d316750cu},
     }},
    {"sea",
     {
         [WORKLOAD_PRIMARY] = {0x6eb205520638a393u, 0xe75d58db9533cb7du},
         [WORKLOAD_SHADOW] = {0x17e2ebed4c84feddu, 0xea33d03575bfc273u},
         [WORKLOAD_AO] = {0x9b90789cd06de471u, 0x4fb04ea21abe0625u},
         [WORKLOAD_BOUNCE] = {0x8c302c6130b33a53u, 0xd45f0122305513e7u},
         [WORKLOAD_RANDOM] = {0xe64a4dacbcf9e9ecu, 0x47a3342ffb33871fu},
         [WORKLOAD_GRAZING] = {0x8f0029d52d9697b2u, 0x51e9bb0cbaee65d1u},
         [WORKLOAD_AFAR] = {0x68b945cefbda8cbfu, 0xb30a16f6ef2bce9fu},
     }},
};
enum { GROUNDS = sizeof grounds / sizeof grounds[0] };

/* FNV-1a over the bytes (Fowler, Noll, Vo), the lowest of each number first. */
static uint64_t add(uint64_t sum, uint32_t number) {
    for (int byte = 0; byte < 4; byte++) sum = (sum ^ (number >> 8 * byte & 0xff)) * 0x100000001b3u;
    return sum;
}

static uint64_t add_float(uint64_t sum, float number) {
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return add(sum, bits);
}

static uint64_t sum_of(const cw_hit *hits, size_t n) {
    uint64_t sum = 0xcbf29ce484222325u;
    for (size_t k = 0; k < n; k++) {
        sum = add_float(add_float(add_float(sum, hits[k].t), hits[k].u), hits[k].v);
        sum = add(add(add(sum, (uint32_t)hits[k].i), (uint32_t)hits[k].j), hits[k].triangle);
    }
    return sum;
}

static void test_sums(void **state) {
    (void)state;
    static float z[SIDE * SIDE];
    static cw_ray rays[RAYS];
    static cw_hit hits[RAYS];
    size_t wrong = 0;
    for (size_t g = 0; g < GROUNDS; g++) {
        if (g == 0)
            terrain_fractal(z, SIDE, SIDE, 7, 0.1f);
        else
            terrain_sea(z, SIDE, SIDE, 7, 0.5f);
        cw_field_desc desc = {0};
        desc.samples = z;
        desc.nx = desc.ny = SIDE;
        cw_field *field;
        check_status(cw_field_create(&desc, NULL, &field), CW_OK);
        for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
            const size_t n = workload_rays_make(field, (workload_class)c, 7, RAYS, rays);
            check(n == RAYS, "%zu %s rays", n, workload_class_name((workload_class)c));
            for (int leaf = 0; leaf < LEAVES; leaf++) {
                const cw_run query = {.expert.kernel = cw_kernel_find("cell"),
                                      .expert.leaf = leaf ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE};
                check_status(cw_closest(field, &query, rays, n, hits), CW_OK);
                const uint64_t sum = sum_of(hits, n);
                const bool good = sum == grounds[g].sum[c][leaf];
                printf("%s, %-8s %-16s 0x%016llxu%s\n", grounds[g].name, workload_class_name((workload_class)c),
                       cw_leaf_name(query.expert.leaf), (unsigned long long)sum, good ? "" : " is not what it was");
                wrong += !good;
            }
        }
        cw_field_destroy(field);
    }
    check(wrong == 0, "%zu sums are others", wrong);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sums)};
    return cmocka_run_group_tests_name("bits", tests, NULL, NULL);
}
