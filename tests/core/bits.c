/* SPDX-License-Identifier: Apache-2.0 */
/* The bits of answers: the same on every CPU, with every compiler and at every optimisation level, as sums that were taken
 * once. lanes.c holds all kernels to the one that is asked here. Land, sea and rays are made by hashes and IEEE operations
 * alone. After a change that is meant to change answers, the new sums are what the test prints. */

#include "check.h"

#include "workload/ray_classes.h"
#include "workload/terrain.h"

#include <stdio.h>
#include <string.h>

enum { SIDE = 257, RAYS = 8192, LEAVES = 2 };

static const struct {
    const char *name;
    uint64_t sum[WORKLOAD_CLASS_COUNT][LEAVES]; /* Möller-Trumbore, watertight */
} grounds[] = {
    {"land",
     {
         [WORKLOAD_PRIMARY] = {0x2803883c19b05ae5u, 0x4de7a7d3baf3498cu},
         [WORKLOAD_SHADOW] = {0x09775a42896e27ffu, 0xf4e379a61ddc74f3u},
         [WORKLOAD_AO] = {0x51e1579fa0d051c7u, 0xcff4eb5326a0d5beu},
         [WORKLOAD_BOUNCE] = {0xaac6e33ee4f25863u, 0xffcb46a5755f799bu},
         [WORKLOAD_RANDOM] = {0x742af493ce3a2e6eu, 0x81b6bb25777b54e1u},
         [WORKLOAD_GRAZING] = {0x1f53c834e6ab4f23u, 0x462f8d97a3f353cau},
     }},
    {"sea",
     {
         [WORKLOAD_PRIMARY] = {0xd439439fbc02d521u, 0x89c89a19ba937f26u},
         [WORKLOAD_SHADOW] = {0x72e1c88cd9a0b5f2u, 0x85e28562663575b6u},
         [WORKLOAD_AO] = {0xc2ae3b1f44a17e01u, 0xdd9da35640bd99beu},
         [WORKLOAD_BOUNCE] = {0x0e7259534f05d732u, 0x3975424932d5aa6au},
         [WORKLOAD_RANDOM] = {0x597f5f10125bf921u, 0xcc29b46f750f0732u},
         [WORKLOAD_GRAZING] = {0xb06f67c625c44925u, 0xe1ef32e9fd78d7cau},
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
        cw_field_desc desc = cw_field_desc_default();
        desc.samples = z;
        desc.nx = desc.ny = SIDE;
        cw_field *field;
        check_status(cw_field_create(&desc, &field), CW_OK);
        for (int c = 0; c < WORKLOAD_CLASS_COUNT; c++) {
            const size_t n = workload_rays_make(field, (workload_class)c, 7, RAYS, rays);
            check(n == RAYS, "%zu %s rays", n, workload_class_name((workload_class)c));
            for (int leaf = 0; leaf < LEAVES; leaf++) {
                const cw_query query = {.kernel = cw_kernel_find("cell"),
                                        .leaf = leaf ? CW_LEAF_WATERTIGHT : CW_LEAF_MOLLER_TRUMBORE};
                check_status(cw_closest(field, &query, rays, n, hits), CW_OK);
                const uint64_t sum = sum_of(hits, n);
                const bool good = sum == grounds[g].sum[c][leaf];
                printf("%s, %-8s %-16s 0x%016llxu%s\n", grounds[g].name, workload_class_name((workload_class)c),
                       cw_leaf_name(query.leaf), (unsigned long long)sum, good ? "" : " is not what it was");
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
