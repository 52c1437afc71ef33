/* SPDX-License-Identifier: Apache-2.0 */
/* Every kernel with a cell walk gives the same bits: packets of any width, any later walk, closest and any hit, each
 * leaf test, on rays and fields from rays.h and fields.h, in runs of any length. There is no tolerance. */

#include "as_cell.h"
#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Kernels whose hits do not follow the rules of src/scalar/strict.h; brute.c judges them. */
static bool has_own_rules(const cw_kernel *kernel) {
    static const char *const names[] = {"brute", "grid3d"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        if (strcmp(cw_kernel_describe(kernel).name, names[k]) == 0) return true;
    return false;
}

enum { RUN_MAX = 4096, SIZES = FIELD_SIZES + 1 };
static const field_size large = {261, 131}; /* several levels of any pyramid, and blocks that stick out */

typedef struct run {
    const test_field *shape;
    const cw_field *field;
    cw_leaf leaf;
    size_t n;
    cw_ray rays[RUN_MAX + 16];
    cw_hit hits[RUN_MAX];
    size_t compared[CW_LEAF_COUNT]; /* kernels so far, cell among them */
} run;

static void compare(const run *q, const cw_kernel *kernel) {
    const cw_run query = {.expert.kernel = kernel, .expert.leaf = q->leaf};
    if (as_cell_differ(q->field, &query, q->rays, q->n, q->hits) == 0) return;
    field_print(q->shape);
    check(false, "%s and cell differ", cw_kernel_describe(kernel).name);
}

/* The reference, then each kernel against it. */
static void run_all(run *q) {
    const cw_kernel *reference = cw_kernel_find("cell");
    for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
        q->leaf = (cw_leaf)leaf;
        const cw_run query = {.expert.kernel = reference, .expert.leaf = q->leaf};
        check_status(cw_closest(q->field, &query, q->rays, q->n, q->hits), CW_OK);
        for (size_t k = 0; k < q->n; k++) {
            if (q->hits[k].i < 0 || (q->hits[k].t >= q->rays[k].tmin && q->hits[k].t <= q->rays[k].tmax)) continue;
            field_print(q->shape);
            ray_print(&q->rays[k]);
            hit_print("cell", &q->hits[k]);
            check(false, "a hit lies outside of its ray's range");
        }
        for (size_t k = 0; k < cw_kernel_count(); k++) {
            const cw_kernel *kernel = cw_kernel_at(k);
            if (has_own_rules(kernel) ||
                cw_run_check(NULL, &(cw_run){.expert.kernel = kernel, .expert.leaf = q->leaf}) != CW_OK)
                continue;
            compare(q, kernel);
            q->compared[leaf]++;
        }
    }
}

/* Rays beyond the run that no kernel may look at, or may and must not heed. */
static void add_junk(run *q) {
    for (size_t k = q->n; k < q->n + 16; k++) memset(&q->rays[k], 0xff, sizeof q->rays[k]);
}

/* A run in bundles of rays alike, as cameras, lights and leaf hits send them: some kernels treat such rays together. */
static void fill_bundles(run *q, ray_class first, ray_class last, random_state *r) {
    static const double spreads[] = {0, 1e-7, 1e-3, 0.02, 0.1, 0.3};
    for (size_t k = 0; k < q->n;) {
        const cw_ray one = ray_make((ray_class)(first + random_below(r, (size_t)(last - first + 1))), q->shape, r);
        const double turn = spreads[random_below(r, 6)], shift = 10 * spreads[random_below(r, 6)];
        float longest = 0;
        for (int c = 0; c < 3; c++) longest = fmaxf(longest, fabsf(one.dir[c]));
        for (size_t left = 4 + random_below(r, 60); left > 0 && k < q->n; left--, k++) {
            q->rays[k] = one;
            for (int c = 0; c < 3; c++) {
                q->rays[k].dir[c] += (float)(turn * random_between(r, -1, 1)) * longest;
                if (c < 2) q->rays[k].org[c] += (float)(shift * random_between(r, -1, 1));
            }
        }
    }
}

static void fill(run *q, ray_class first, ray_class last, random_state *r) {
    for (size_t k = 0; k < q->n; k++)
        q->rays[k] = ray_make((ray_class)(first + random_below(r, (size_t)(last - first + 1))), q->shape, r);
}

static void sweep(ray_class first, ray_class last, size_t most_rays_a_field) {
    const size_t rays_a_field = test_share(most_rays_a_field, 20);
    static test_field shape;
    static run q;
    random_state r = {20260101 + (uint64_t)first};
    size_t rays = 0, hits = 0;
    for (size_t s = 0; s < SIZES; s++)
        for (int kind = 0; kind < FIELD_ALL_SHAPES; kind++) {
            const field_size size = s < FIELD_SIZES ? field_sizes[s] : large;
            field_make(&shape, (field_shape)kind, size.nx, size.ny, s + 1);
            cw_field *field = field_open(&shape);
            q.shape = &shape;
            q.field = field;
            for (size_t left = rays_a_field; left > 0; left -= q.n) {
                q.n = 1 + random_below(&r, RUN_MAX);
                if (q.n > left) q.n = left;
                if (random_below(&r, 2))
                    fill(&q, first, last, &r);
                else
                    fill_bundles(&q, first, last, &r);
                add_junk(&q);
                run_all(&q);
                for (size_t k = 0; k < q.n; k++) hits += q.hits[k].i >= 0;
            }
            rays += rays_a_field;
            cw_field_destroy(field);
        }
    printf("%zu rays from class %s to %s, %zu hits, the same bits in every kernel\n", rays, ray_class_name(first),
           ray_class_name(last), hits);
    check(hits > rays / 10, "too few rays hit for the test to mean anything");
}

enum { FIELDS = SIZES * FIELD_ALL_SHAPES, RAYS = 1001000 / FIELDS };

static void test_random(void **state) {
    (void)state;
    sweep(RAY_RANDOM, RAY_RANDOM, RAYS);
}

static void test_adversarial(void **state) {
    (void)state;
    sweep(RAY_VERTEX, RAY_NOT_FINITE, RAYS);
}

/* Rays on which kernels once differed: a component that counts as zero, and signs of zeros. */
static void test_known(void **state) {
    (void)state;
    static const struct {
        float z[4];
        cw_ray ray;
    } known[] = {
        {{0x1.22145cp-1f, 0x1.f12746p-1f, 0x1.c6ed54p-2f, 0x1.c133d8p-1f},
         {{0, 0x1.b5880ep-2f, 0x1.5148aap+0f}, 0, {0x1p-128f, 0x1.bd3f8ap-2f, -0x1.b678p-1f}, INFINITY}},
        {{0, 0, 0, 0x1.e848p+19f},
         {{0, 0x1.e4c49cp-3f, -0.0f}, 0, {0x1.00001p-128f, 0x1.1deefp-1f, 0x1.9a5836p+19f}, INFINITY}},
        {{0, 0, 0, 0}, {{0, -0.0f, -0.0f}, 0, {1, -0x1.fffd62p-1f, 0x1p-128f}, INFINITY}},
    };
    static test_field shape = {.shape = FIELD_RANDOM, .nx = 2, .ny = 2};
    static run q = {.shape = &shape};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        memcpy(shape.z, known[k].z, sizeof known[k].z);
        cw_field *field = field_open(&shape);
        q.field = field;
        for (q.n = 1; q.n <= 33; q.n += 16) { /* alone and among its like */
            for (size_t m = 0; m < q.n; m++) q.rays[m] = known[k].ray;
            add_junk(&q);
            run_all(&q);
        }
        cw_field_destroy(field);
    }
}

/* Samples 2^20 to 2^60 times their neighbours stand up or hang down. Next to one a triangle is all but vertical, and Möller and
 * Trumbore's test tosses a coin where a ray passes the foot of it, at any height. Without a spike on the other side all that is
 * not a tower lies at an end of the field's heights, so that rays are cut off close by; with one, only climbing rays are. */
enum { TOWER_FIELDS = 200, TOWER_IN = 128 };

typedef struct towers {
    test_field field;
    bool up;
} towers;

static bool is_tower(const towers *f, size_t k) { return fabsf(f->field.z[k]) >= 0x1p20f; }

static void make_towers(towers *f, size_t nx, size_t ny, random_state *r) {
    const bool spike = random_below(r, 2);
    const size_t small = random_below(r, 2) ? 0 : 1 + random_below(r, 40);
    f->up = random_below(r, 2);
    f->field.shape = FIELD_MIXED;
    f->field.nx = nx;
    f->field.ny = ny;
    f->field.low = -(float)small;
    f->field.high = (float)small;
    for (size_t k = 0; k < nx * ny; k++) {
        const double size = ldexp(random_between(r, 1, 2), 20 + (int)random_below(r, 41));
        f->field.z[k] = (float)((int)random_below(r, 2 * small + 1) - (int)small);
        if (random_below(r, TOWER_IN) == 0 || k == nx + 1) f->field.z[k] = (float)(f->up ? size : -size);
    }
    if (spike) f->field.z[0] = (float)ldexp(f->up ? -1 : 1, (int)random_below(r, 60));
}

/* Past the foot of a tower, in or out of one of its four cells, where it is below or above the cell's other samples, or little
 * beside that; and across their height within the cell. */
static cw_ray past_tower(const towers *w, random_state *r) {
    const test_field *f = &w->field;
    size_t i, j;
    do {
        i = 1 + random_below(r, f->nx - 2);
        j = 1 + random_below(r, f->ny - 2);
    } while (!is_tower(w, j * f->nx + i));
    const int side[2] = {random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 1 : -1};
    const float *z = f->z + j * f->nx + i;
    const float z0 = z[side[0]], z1 = z[side[0] + side[1] * (int)f->nx], out = w->up ? -1 : 1;
    const float beside = 0.0625f * (float)((int)random_below(r, 17) - 1), away = 0.25f * (float)random_below(r, 9);
    const float p[3] = {(float)i + (float)side[0], (float)j + (float)side[1] * beside,
                        (w->up ? fminf(z0, z1) : fmaxf(z0, z1)) + out * away};
    cw_ray ray = {.tmin = random_below(r, 4) ? -INFINITY : 0, .tmax = INFINITY};
    const float d[3] = {-(float)side[0] * 0.25f * (float)(1 + random_below(r, 64)),
                        0.25f * (float)((int)random_below(r, 65) - 32), -out * 0.25f * (float)random_below(r, 128)};
    const float t = 0.125f * (float)((int)random_below(r, 33) - 16), turn = random_below(r, 2) ? 1 : -1;
    const bool odd = random_below(r, 2);
    for (int c = 0; c < 3; c++) {
        ray.dir[c] = turn * d[c] * (odd ? (float)random_between(r, 0.5, 1) : 1);
        ray.org[c] = p[c] - t * ray.dir[c];
    }
    return ray;
}

static void test_towers(void **state) {
    (void)state;
    static towers shape;
    static run q = {.shape = &shape.field};
    random_state r = {20261122};
    const size_t fields = test_share(TOWER_FIELDS, 1);
    size_t hits = 0;
    for (size_t k = 0; k < fields; k++) {
        make_towers(&shape, 12 + random_below(&r, 80), 12 + random_below(&r, 80), &r);
        cw_field *field = field_open(&shape.field);
        q.field = field;
        q.n = RUN_MAX;
        for (size_t m = 0; m < q.n; m++)
            q.rays[m] = random_below(&r, 8) ? past_tower(&shape, &r) : ray_make(RAY_LATTICE, &shape.field, &r);
        /* Some that are alike, which share their walk. */
        if (k / 3 % 2)
            for (size_t m = 1; m < q.n; m++)
                if (m % 64) q.rays[m] = q.rays[m - 1], q.rays[m].org[m % 3] += 0.125f;
        add_junk(&q);
        run_all(&q);
        for (size_t m = 0; m < q.n; m++) hits += q.hits[m].i >= 0;
        cw_field_destroy(field);
    }
    printf("%zu rays at towers, %zu hits, the same bits in every kernel\n", fields * RUN_MAX, hits);
    check(hits > fields * RUN_MAX / 10, "too few rays hit for the test to mean anything");
}

/* One of them, as it was found. */
static void test_tower(void **state) {
    (void)state;
    static test_field shape = {.shape = FIELD_MIXED, .nx = 47, .ny = 54, .low = -37, .high = 0x1.98p+42f};
    static run q = {.shape = &shape, .n = 1};
    shape.z[20 * shape.nx + 12] = shape.high;
    shape.z[21 * shape.nx + 13] = shape.low;
    q.rays[0] = (cw_ray){{0, 28.5f, -16.75f}, -108, {-14.25f, 9.25f, 23}, INFINITY};
    cw_field *field = field_open(&shape);
    q.field = field;
    add_junk(&q);
    run_all(&q);
    cw_field_destroy(field);
}

/* Many rays in one call, as runs of few answer them: the lane walk keeps rays from batch to batch, and counts them anew
 * after some 2^16. In slow builds they are no more than that takes, and only for the kernels that need all of the CPU: the others
 * take their turn on an older one. */
enum { LONG = 140000, LONG_ENOUGH = 66000 };

static bool takes_long_calls(const cw_kernel_info *info) {
    return info->available && strncmp(info->name, "pyramid", 7) == 0;
}

static void test_long_call(void **state) {
    (void)state;
    static cw_ray rays[LONG];
    static cw_hit hits[LONG];
    static test_field shape;
    if (test_divisor() >= 1000) skip(); /* on an emulated CPU (old_cpu.cmake) */
    const bool slow = test_divisor() >= 8;
    const size_t n = slow ? LONG_ENOUGH : LONG;
    cw_isa most = CW_ISA_SCALAR;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (takes_long_calls(&info) && info.isa > most) most = info.isa;
    }
    random_state r = {20261121};
    field_make(&shape, FIELD_RANDOM, large.nx, large.ny, 1);
    cw_field *field = field_open(&shape);
    for (size_t k = 0; k < n; k++) rays[k] = ray_make(RAY_RANDOM, &shape, &r);
    size_t kernels = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (!takes_long_calls(&info) || (slow && info.isa != most)) continue;
        kernels++;
        const cw_run query = {.expert.kernel = cw_kernel_at(k), .expert.leaf = CW_LEAF_WATERTIGHT};
        for (size_t begin = 0; begin < n; begin += RUN_MAX)
            check_status(
                cw_closest(field, &query, rays + begin, n - begin < RUN_MAX ? n - begin : RUN_MAX, hits + begin),
                CW_OK);
        check(as_cell_differ(field, &query, rays, n, hits) == 0, "%s: a long call answers otherwise than short ones",
              info.name);
    }
    check(kernels > 0, "no kernel took a long call");
    cw_field_destroy(field);
}

/* All kernels that this machine can run took part: forget one and the rest proves less than it says. */
static void test_every_kernel_takes_part(void **state) {
    (void)state;
    size_t part = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        const bool in = !has_own_rules(cw_kernel_at(k)) && info.available;
        check(has_own_rules(cw_kernel_at(k)) == (info.default_leaf != CW_LEAF_WATERTIGHT),
              "%s: does it obey other rules?", info.name);
        printf("%-14s %s\n", info.name, in ? "compared" : info.available ? "obeys other rules" : "not on this CPU");
        part += in;
    }
    check(part >= 2, "fewer than two kernels to compare");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_kernel_takes_part),
        cmocka_unit_test(test_known),
        cmocka_unit_test(test_tower),
        cmocka_unit_test(test_towers),
        cmocka_unit_test(test_long_call),
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_adversarial),
    };
    return cmocka_run_group_tests_name("lanes", tests, NULL, NULL);
}
