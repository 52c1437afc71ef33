/* SPDX-License-Identifier: Apache-2.0 */
/* What is built on the queries: rays in user space, the caller's own threads, places on the
 * surface. Each gives what the plain functions give. */

#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

enum { RAYS = 30000, SIDE = 33 };

static test_field shape;
static cw_field *field;
static cw_user_ray user_rays[RAYS];
static cw_ray rays[RAYS];
static cw_hit expected[RAYS], got[RAYS];
static uint8_t occluded[RAYS];

/* Turned, scaled and far from the origin; heights stay upright. */
static const double map[3][4] = {{30, -5, 0, 3e6}, {4, 31, 0, -7e6}, {0.5, 0.25, 2, 100}};

static int set_up(void **state) {
    (void)state;
    field_make(&shape, FIELD_HOLES, SIDE, SIDE, 5);
    field = field_mapped(shape.z, SIDE, SIDE, map);
    random_state r = {9};
    for (size_t k = 0; k < RAYS; k++) {
        const double p[3] = {random_unit(&r) * SIDE, random_unit(&r) * SIDE, 3};
        const double v[3] = {random_unit(&r) - 0.5, random_unit(&r) - 0.5, -0.3 * random_unit(&r)};
        user_rays[k] = (cw_user_ray){.tmax = (double)INFINITY};
        for (int c = 0; c < 3; c++) {
            user_rays[k].org[c] = map[c][0] * p[0] + map[c][1] * p[1] + map[c][2] * p[2] + map[c][3];
            user_rays[k].dir[c] = map[c][0] * v[0] + map[c][1] * v[1] + map[c][2] * v[2];
        }
    }
    cw_rays_to_field(field, NULL, user_rays, RAYS, rays);
    return cw_closest(field, NULL, rays, RAYS, expected) == CW_OK ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    cw_field_destroy(field);
    return 0;
}

static void check_hits(size_t n, const char *what) {
    for (size_t k = 0; k < n; k++) check(hit_same(&got[k], &expected[k]), "%s: ray %zu of %zu", what, k, n);
}

static void versions_agree(void **state) {
    (void)state;
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", CW_VERSION_MAJOR, CW_VERSION_MINOR, CW_VERSION_PATCH);
    assert_string_equal(text, CW_VERSION);
    assert_string_equal(text, PROJECT_VERSION);
    assert_string_equal(cw_version(), CW_VERSION);
}

/* What the header says of the one rounding to float: map from a field of cells to user space, origins up to reach cells
 * along an axis, and how much of a cell they may lose. Doubles are off by 10^-9 cells here. */
static void check_precision(double to_user[3][4], double cell, const double reach[3], double most, const char *what) {
    static const float z[4];
    cw_field *f = field_mapped(z, 2, 2, (const double(*)[4])to_user);
    random_state r = {21};
    double worst = 0, worst_dir = 0;
    for (int k = 0; k < 4000; k++) {
        cw_user_ray in = {.tmax = 1};
        cw_ray out;
        for (int c = 0; c < 3; c++) {
            in.org[c] = to_user[c][3];
            in.dir[c] = random_between(&r, -1, 1);
        }
        for (int a = 0; a < 3; a++) {
            const double along = random_between(&r, 0.5, 1) * reach[a];
            for (int c = 0; c < 3; c++) in.org[c] += to_user[c][a] * along;
        }
        for (int c = 0; c < 3; c++) in.org[c] = round(in.org[c] * 1000) / 1000; /* millimetres */
        cw_rays_to_field(f, NULL, &in, 1, &out);
        for (int a = 0; a < 3; a++) { /* to_user's columns are at right angles and as long as a cell */
            double org = 0, dir = 0;
            for (int c = 0; c < 3; c++) {
                org += to_user[c][a] * (in.org[c] - to_user[c][3]) / (cell * cell);
                dir += to_user[c][a] * in.dir[c] / (cell * cell);
            }
            const double *v = in.dir, length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / cell;
            worst = fmax(worst, fabs((double)out.org[a] - org));
            worst_dir = fmax(worst_dir, fabs((double)out.dir[a] - dir) / length);
        }
    }
    check(worst <= most && worst > most / 4, "%s: an origin is off by %g cells, and %g are said", what, worst, most);
    check(worst_dir <= 0x1.00001p-24 && worst_dir > 0x1p-26, "%s: a direction is off by %g", what, worst_dir);
    cw_field_destroy(f);
}

static void precision_that_arrives(void **state) {
    (void)state;
    double utm[3][4] = {{1, 0, 0, 448000}, {0, 1, 0, 5411000}, {0, 0, 1, 0}};
    check_precision(utm, 1, (const double[]){10000, 10000, 1000}, 5e-4, "UTM, 10 000 cells of 1 m");
    /* East, north and up at 48 degrees north, 11 degrees east, on a sphere; a sensor 700 km up. */
    const double n = 48 * 0.017453292519943295, e = 11 * 0.017453292519943295, R = 6371000, cell = 10;
    const double axes[3][3] = {
        {-sin(e), cos(e), 0}, {-sin(n) * cos(e), -sin(n) * sin(e), cos(n)}, {cos(n) * cos(e), cos(n) * sin(e), sin(n)}};
    double earth[3][4];
    for (int c = 0; c < 3; c++) {
        for (int a = 0; a < 3; a++) earth[c][a] = cell * axes[a][c];
        earth[c][3] = R * axes[2][c];
    }
    check_precision(earth, cell, (const double[]){1000, 1000, 70000}, 4e-3,
                    "a sensor 7 * 10^6 m from the earth's centre");
}

/* Cells of 1 cm at 5 · 10^6 m: the difference to the field's origin is exact, so rays have the bits that they have at the origin. */
static void a_far_origin_comes_off_exactly(void **state) {
    (void)state;
    static const float z[4];
    static const double away[] = {0, 5000000};
    random_state r = {11};
    cw_field *f[2];
    for (int k = 0; k < 2; k++)
        f[k] =
            field_mapped(z, 2, 2, (const double[3][4]){{0.01, 0, 0, away[k]}, {0, 0.01, 0, away[k]}, {0, 0, 0.01, 0}});
    for (int k = 0; k < 2000; k++) {
        cw_user_ray ray = {.tmax = (double)INFINITY};
        cw_ray moved[2];
        for (int c = 0; c < 3; c++) { /* multiples of 2^-27 m, so that adding the origin is exact too */
            ray.org[c] = ldexp(floor(random_between(&r, -0x1p18, 0x1p20) * (c < 2 ? 16 : 2)), -27);
            ray.dir[c] = random_between(&r, -1, 1);
        }
        cw_rays_to_field(f[0], NULL, &ray, 1, &moved[0]);
        ray.org[0] += away[1];
        ray.org[1] += away[1];
        cw_rays_to_field(f[1], NULL, &ray, 1, &moved[1]);
        assert_memory_equal(&moved[0], &moved[1], sizeof moved[0]);
    }
    for (int k = 0; k < 2; k++) cw_field_destroy(f[k]);
}

static void rays_in_user_space(void **state) {
    (void)state;
    cw_pool *pool;
    check_status(cw_pool_create(3, &pool), CW_OK);
    static const size_t counts[] = {0, 1, 511, 512, 513, RAYS};
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++)
        for (int shared = 0; shared < 2; shared++) {
            const size_t n = counts[c];
            const cw_run q = {.pool = shared ? pool : NULL};
            memset(got, 0x5a, sizeof got);
            memset(occluded, 0x5a, sizeof occluded);
            check_status(cw_closest_user(field, &q, user_rays, n, got), CW_OK);
            check_status(cw_occluded_user(field, &q, user_rays, n, occluded), CW_OK);
            check_hits(n, "user space");
            for (size_t k = 0; k < n; k++) check(occluded[k] == (expected[k].i >= 0), "any hit, ray %zu", k);
            if (n < RAYS) check(got[n].i == 0x5a5a5a5a && occluded[n] == 0x5a, "wrote beyond %zu", n);
        }
    cw_pool_destroy(pool);
    const cw_run none = {.expert.kernel = cw_kernel_find("packet99")};
    check_status(cw_closest_user(field, &none, user_rays, 1, got), CW_ERROR_KERNEL);
}

/* ---- the caller's own threads ------------------------------------------------------------------------------------- */

typedef struct engine {
    atomic_uint runs, tasks;
} engine;

typedef struct task {
    cw_task_fn *run;
    void *argument;
    unsigned number;
    pthread_t thread;
} task;

static void *run_task(void *argument) {
    const task *t = argument;
    t->run(t->argument, t->number);
    return NULL;
}

/* Each on a new thread, from the last on. */
static void run_all(void *context, cw_task_fn *run, void *argument, uint32_t count) {
    engine *e = context;
    task tasks[8];
    check(count >= 1 && count <= 8, "%u tasks", count);
    atomic_fetch_add(&e->runs, 1);
    atomic_fetch_add(&e->tasks, count);
    for (unsigned k = count; k-- > 0;) {
        tasks[k] = (task){run, argument, k, 0};
        assert_int_equal(pthread_create(&tasks[k].thread, NULL, run_task, &tasks[k]), 0);
    }
    for (unsigned k = 0; k < count; k++) pthread_join(tasks[k].thread, NULL);
}

static void threads_of_the_caller(void **state) {
    (void)state;
    engine e = {0};
    cw_tasks tasks = {.threads = 8, .run = run_all, .context = &e};
    cw_pool *pool;
    check_status(cw_pool_create_on(&tasks, &pool), CW_OK);
    assert_int_equal(cw_pool_threads(pool), 8);
    const cw_run q = {.pool = pool};
    check_status(cw_closest(field, &q, rays, RAYS, got), CW_OK);
    check_hits(RAYS, "tasks");
    check(e.runs == 1 && e.tasks == 8, "%u runs of %u tasks", e.runs, e.tasks);
    check_status(cw_closest(field, &q, rays, 100, got), CW_OK); /* too few to share */
    check(e.runs == 1, "tasks for a hundred rays");
    cw_pool_destroy(pool);

    tasks.threads = 0;
    check_status(cw_pool_create_on(&tasks, &pool), CW_ERROR_ARGUMENT);
    tasks.threads = CW_THREADS_MAX + 1;
    check_status(cw_pool_create_on(&tasks, &pool), CW_ERROR_ARGUMENT);
    assert_null(pool);
}

/* ---- places -------------------------------------------------------------------------------------------------------- */

static bool is_hole(size_t i, size_t j) { return isnan(cw_field_row(field, j)[i]); }

static void places_on_the_surface(void **state) {
    (void)state;
    random_state r = {11};
    for (int k = 0; k < 20000; k++) {
        /* Samples, borders and diagonals, the far border, and anything between. */
        const double scale = k % 4 == 0 ? 1 : 0x1p-20;
        const double x = floor(random_unit(&r) * SIDE / scale) * scale;
        const double y = k % 4 == 1 ? x : floor(random_unit(&r) * SIDE / scale) * scale;
        cw_hit hit;
        check_status(cw_surface_at(field, NULL, (double[2]){x, y}, 1, &hit), CW_OK);
        const double ux = map[0][0] * x + map[0][1] * y + map[0][3], uy = map[1][0] * x + map[1][1] * y + map[1][3];
        const bool outside = x > SIDE - 1 || y > SIDE - 1;
        if (outside) {
            check(hit.i == -1 && isinf(hit.t), "(%g, %g) is outside", x, y);
            continue;
        }
        const size_t i = x >= SIDE - 2 ? SIDE - 2 : (size_t)x, j = y >= SIDE - 2 ? SIDE - 2 : (size_t)y;
        const double u = x - (double)i, v = y - (double)j;
        const bool a = v <= u,
                   hole = is_hole(i, j) || is_hole(i + 1, j + 1) || (a ? is_hole(i + 1, j) : is_hole(i, j + 1));
        check((hit.i >= 0) == !hole, "(%g, %g): a hit or a hole", x, y);
        if (hole) continue;
        const double z00 = (double)cw_field_row(field, j)[i], z11 = (double)cw_field_row(field, j + 1)[i + 1];
        const double third = (double)(a ? cw_field_row(field, j)[i + 1] : cw_field_row(field, j + 1)[i]);
        const double z = a ? z00 + u * (third - z00) + v * (z11 - third) : z00 + v * (third - z00) + u * (z11 - third);
        double p[3];
        cw_hit_points(field, NULL, &hit, 1, p);
        /* u and v are rounded to float: 2^-24 of a cell each, in a field of heights below 1. */
        const double wanted[3] = {ux, uy, map[2][0] * x + map[2][1] * y + map[2][2] * z + map[2][3]};
        for (int c = 0; c < 3; c++) {
            const double reach = fabs(map[c][0]) + fabs(map[c][1]) + 2 * fabs(map[c][2]);
            check(fabs(p[c] - wanted[c]) <= 0x1p-23 * reach + 0x1p-50 * fabs(wanted[c]), "(%g, %g): %g, not %g", x, y,
                  p[c], wanted[c]);
        }
    }
    const double outside[][2] = {{-0.001, 1}, {1, -1e-300},     {32.001, 1},
                                 {1, 1e300},  {(double)NAN, 1}, {1, (double)INFINITY}};
    cw_hit hit[6] = {{0}};
    check_status(cw_surface_at(field, NULL, outside[0], 6, hit), CW_OK);
    for (size_t k = 0; k < 6; k++) assert_int_equal(hit[k].i, -1);
}

/* Worlds whose y is up, or whose heights lean: a point is moved along the field's own up. */
static void places_along_the_fields_up(void **state) {
    (void)state;
    static const double maps[][3][4] = {{{2, 0, 0, 10}, {0, 0, 3, -5}, {0, -2, 0, 7}},
                                        {{1, 0, 0.5, 0}, {0, 1, -0.25, 0}, {0, 0, 1, 0}},
                                        {{0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}}};
    random_state r = {12};
    for (size_t m = 0; m < sizeof maps / sizeof *maps; m++) {
        cw_field *turned = field_mapped(shape.z, SIDE, SIDE, maps[m]);
        for (int k = 0; k < 2000; k++) {
            const double x = (double)random_below(&r, 8 * SIDE) / 8, y = (double)random_below(&r, 8 * SIDE) / 8,
                         z = (double)random_below(&r, 64) - 32;
            double point[3];
            cw_hit wanted, hit;
            for (int c = 0; c < 3; c++)
                point[c] = maps[m][c][0] * x + maps[m][c][1] * y + maps[m][c][2] * z + maps[m][c][3];
            check_status(cw_surface_at(turned, NULL, (double[2]){x, y}, 1, &wanted), CW_OK);
            check_status(cw_surface_at_user(turned, NULL, point, 1, &hit), CW_OK); /* all numbers are exact */
            check(memcmp(&hit, &wanted, sizeof hit) == 0, "(%g, %g) on map %zu: cell %d, %d, not %d, %d", x, y, m,
                  hit.i, hit.j, wanted.i, wanted.j);
        }
        cw_field_destroy(turned);
    }
}

/* Structs that the library fills: an older program gets the members that it knows, a newer one zeros for the others. */
static void filled_structs_grow(void **state) {
    (void)state;
    struct {
        cw_field_info info;
        unsigned char newer[64];
    } later;
    memset(&later, 0x5a, sizeof later);
    cw_field_describe_into(field, &later.info, sizeof later);
    check(later.info.nx == SIDE && later.info.map[0][0] == map[0][0], "a newer program's info");
    for (size_t k = 0; k < sizeof later.newer; k++) check(later.newer[k] == 0, "byte %zu is not clear", k);
    memset(&later, 0x5a, sizeof later);
    cw_field_describe_into(field, &later.info, offsetof(cw_field_info, holes));
    check(later.info.ny == SIDE && later.info.holes == 0x5a5a5a5a5a5a5a5a, "an older program's info");
    cw_kernel_info kernel;
    memset(&kernel, 0x5a, sizeof kernel);
    cw_kernel_describe_into(cw_kernel_at(0), &kernel, sizeof kernel.name);
    check(strcmp(kernel.name, "brute") == 0 && kernel.width == 0x5a5a5a5a, "an older program's kernel");
}

/* The sentence names argument, value and limit, and belongs to the thread. */
static void errors_say_what_was_wrong(void **state) {
    (void)state;
    cw_field *f;
    cw_field_desc d = {.samples = shape.z, .nx = 1, .ny = 5};
    check_status(cw_field_create(&d, NULL, &f), CW_ERROR_ARGUMENT);
    assert_string_equal(cw_last_error(), "nx: 1 samples; a field has 2 to 8388608 a side");
    check_status(cw_closest(field, &(cw_run){.expert.kernel = cw_kernel_find("packet99")}, rays, 1, got),
                 CW_ERROR_KERNEL);
    assert_string_equal(cw_last_error(), "kernel: there is no kernel of that name");
    check_status(cw_closest(field, NULL, NULL, 7, got), CW_ERROR_ARGUMENT);
    assert_string_equal(cw_last_error(), "rays: NULL for 7 rays");
    check_status(cw_closest(field, NULL, rays, 1, got), CW_OK);
    assert_string_equal(cw_last_error(), "rays: NULL for 7 rays");
    check_status(cw_run_check(NULL, &(cw_run){.expert.kernel = cw_kernel_find("pyramid1"),
                                              .expert.leaf = CW_LEAF_MOLLER_TRUMBORE}),
                 CW_ERROR_KERNEL);
    assert_string_equal(cw_last_error(), "leaf: pyramid1 does not have the leaf test moller-trumbore");
    check_status(cw_run_check(field, NULL), CW_OK);
}

typedef struct counted {
    atomic_long blocks;
    atomic_ulong calls;
} counted;

static void *count_allocate(void *context, size_t bytes, size_t alignment) {
    counted *c = context;
    void *memory = NULL;
    atomic_fetch_add(&c->calls, 1);
    if (posix_memalign(&memory, alignment, bytes) != 0) return NULL;
    atomic_fetch_add(&c->blocks, 1);
    return memory;
}

static void count_release(void *context, void *memory) {
    atomic_fetch_sub(&((counted *)context)->blocks, 1);
    free(memory);
}

/* All that a field holds comes from its allocator and goes back to it. */
static void memory_is_the_callers(void **state) {
    (void)state;
    counted c = {0};
    cw_allocator allocator = {.allocate = count_allocate, .release = count_release, .context = &c};
    cw_field *f;
    cw_heading *h;
    const cw_field_desc d = {.samples = shape.z, .nx = SIDE, .ny = SIDE, .allocator = &allocator};
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        check_status(cw_field_create(&d, &(cw_run){.expert.kernel = cw_kernel_at(k)}, &f), CW_OK);
        check_status(cw_heading_create(f, &(cw_heading_desc){.dir = {1, 0.5}}, &h), CW_OK);
        check(atomic_load(&c.blocks) >= 5, "%ld blocks", atomic_load(&c.blocks));
        allocator.release = NULL; /* it was copied */
        cw_heading_destroy(h);
        cw_field_destroy(f);
        check(atomic_load(&c.blocks) == 0, "%ld blocks are left", atomic_load(&c.blocks));
        allocator.release = count_release;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(versions_agree),
        cmocka_unit_test(precision_that_arrives),
        cmocka_unit_test(a_far_origin_comes_off_exactly),
        cmocka_unit_test(rays_in_user_space),
        cmocka_unit_test(threads_of_the_caller),
        cmocka_unit_test(places_along_the_fields_up),
        cmocka_unit_test(places_on_the_surface),
        cmocka_unit_test(filled_structs_grow),
        cmocka_unit_test(errors_say_what_was_wrong),
        cmocka_unit_test(memory_is_the_callers),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
