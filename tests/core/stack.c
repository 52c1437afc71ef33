/* SPDX-License-Identifier: Apache-2.0 */
/* The stack that calls take is what the headers say: each runs in a thread on memory that was painted before. The threads of a pool
 * have the megabyte that they are promised. */

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* What the headers say; and so many rays are few. */
enum { FEW = 8, FOR_FEW = 16 << 10, FOR_ALL = 128 << 10, FOR_TERRAIN = 48 << 10 };
enum { SIDE = 256, RAYS = 300, ARENA = 1 << 18, PAINT = 0xa7 };

static test_field shape;
static float *const samples = shape.z;
static cw_field *field, *longest;
static cw_terrain *terrain;

/* ---- measuring --------------------------------------------------------------------------------------------------------- */

typedef void call(const void *what);

typedef struct measured {
    call *call;
    const void *what;
    const unsigned char *begin; /* of the call's stack */
} measured;

static void *run(void *context) {
    measured *m = context;
    unsigned char here = 0;
    m->begin = &here;
    m->call(m->what);
    return (void *)(uintptr_t)here;
}

/* Bytes of stack that a call takes. Made once before, so that the linker has found all names. */
static size_t stack_of(call *function, const void *what) {
    static unsigned char *arena;
    if (arena == NULL) arena = aligned_alloc(1 << 16, ARENA);
    pthread_attr_t how;
    pthread_t thread;
    measured m = {.call = function, .what = what};
    function(what);
    memset(arena, PAINT, ARENA);
    assert_int_equal(pthread_attr_init(&how), 0);
    assert_int_equal(pthread_attr_setstack(&how, arena, ARENA), 0);
    assert_int_equal(pthread_create(&thread, &how, run, &m), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_int_equal(pthread_attr_destroy(&how), 0);
    const unsigned char *low = arena;
    while (*low == PAINT) low++;
    return (size_t)(m.begin - low);
}

static void keeps_to(size_t limit, const char *name, size_t n, call *function, const void *what) {
    const size_t bytes = stack_of(function, what);
    check(bytes <= limit, "%s, n = %zu: %zu bytes of stack; the header says %zu", name, n, bytes, limit);
}

/* ---- rays -------------------------------------------------------------------------------------------------------------- */

/* Those that take each way through a kernel: of all classes; close above a slope, which take long; together; and close above a slope
 * in the longest field, whose pyramid has the most levels. */
enum { OF_ALL_CLASSES, ALONG_THE_SLOPE, TOGETHER, FAR_ALONG, KINDS };
static cw_ray rays[KINDS][RAYS];
static cw_user_ray user_rays[KINDS][RAYS];

static int set_up(void **state) {
    (void)state;
    random_state r = {3};
    for (size_t k = 0; k < SIDE * SIDE; k++)
        samples[k] = 0.37f * (float)(k % SIDE) + (k / SIDE < SIDE / 2 ? 20 : 0.02f) * (float)random_unit(&r);
    check_status(cw_field_create(&(cw_field_desc){.samples = samples, .nx = SIDE, .ny = SIDE}, NULL, &field), CW_OK);
    float *line = malloc(2 * sizeof *line * CW_SIDE_MAX);
    assert_non_null(line);
    for (size_t k = 0; k < CW_SIDE_MAX; k++)
        line[k] = line[k + CW_SIDE_MAX] = (float)k * 0x1p-10f + (float)(random_unit(&r) * 0x1p-12);
    check_status(cw_field_create(&(cw_field_desc){.samples = line, .nx = CW_SIDE_MAX, .ny = 2}, NULL, &longest), CW_OK);
    free(line);
    check_status(cw_terrain_create(&(cw_terrain_desc){.field = field}, NULL, &terrain), CW_OK);
    shape.nx = shape.ny = SIDE;
    shape.low = 0, shape.high = 115;
    for (size_t k = 0; k < RAYS; k++) {
        rays[OF_ALL_CLASSES][k] = ray_make((ray_class)(k % RAY_CLASSES), &shape, &r);
        const float x = (float)random_unit(&r), y = (float)(random_unit(&r) * SIDE / 2 + SIDE / 2);
        rays[ALONG_THE_SLOPE][k] =
            (cw_ray){.org = {x, y, 0.37f * x + 0.021f}, .dir = {1, 0.001f * (float)(k % 9), 0.37f}, .tmax = INFINITY};
        rays[TOGETHER][k] = (cw_ray){.org = {50 + 0.1f * (float)(k % 64), 50, 300},
                                     .dir = {0.1f, 0.2f, -1 - 0.001f * (float)(k % 64)},
                                     .tmax = INFINITY};
    }
    for (size_t k = 0; k < RAYS; k++) {
        const float x = 5000 * (float)k;
        rays[FAR_ALONG][k] = (cw_ray){.org = {x, 0.5f, x * 0x1p-10f + 0x1p-11f}, .dir = {1, 0, 0x1p-10f}, .tmax = 2000};
    }
    for (size_t k = 0; k < KINDS * RAYS; k++) {
        const cw_ray *from = &rays[k % KINDS][k / KINDS];
        cw_user_ray *to = &user_rays[k % KINDS][k / KINDS];
        for (int c = 0; c < 3; c++) to->org[c] = (double)from->org[c], to->dir[c] = (double)from->dir[c];
        to->tmin = (double)from->tmin;
        to->tmax = (double)from->tmax;
    }
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
    cw_field_destroy(longest);
    return 0;
}

/* ---- queries ----------------------------------------------------------------------------------------------------------- */

typedef struct query {
    cw_run run;
    size_t first, n;
    int kind;
    bool user, any;
} query;

static void ask(const void *what) {
    static cw_hit hits[RAYS];
    static uint8_t occluded[RAYS];
    const query *q = what;
    const cw_field *f = q->kind == FAR_ALONG ? longest : field;
    const cw_ray *field_rays = rays[q->kind] + q->first;
    const cw_user_ray *users = user_rays[q->kind] + q->first;
    const cw_status status = q->user  ? q->any ? cw_occluded_user(f, &q->run, users, q->n, occluded)
                                               : cw_closest_user(f, &q->run, users, q->n, hits)
                              : q->any ? cw_occluded(f, &q->run, field_rays, q->n, occluded)
                                      : cw_closest(f, &q->run, field_rays, q->n, hits);
    assert_int_equal(status, CW_OK);
}

static void ask_in_all_ways(const char *name, const cw_run *how, size_t limit_of_few) {
    static const size_t counts[] = {1, 2, 4, FEW, 40, RAYS};
    size_t number = 0;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (int way = 0; way < 4 * KINDS; way++) {
            query q = {.run = *how, .n = counts[c], .kind = way / 4, .user = way & 1, .any = way & 2};
            for (int round = 0; round < (q.n <= FEW ? 3 : 1); round++, q.first += FEW)
                if (test_takes(number++, 8)) keeps_to(q.n <= FEW ? limit_of_few : FOR_ALL, name, q.n, ask, &q);
        }
}

static void queries_keep_to_it(void **state) {
    (void)state;
    for (cw_isa isa = CW_ISA_ANY; isa < CW_ISA_COUNT; isa++)
        ask_in_all_ways("the default kernel", &(cw_run){.expert.isa = isa}, FOR_FEW);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (!info.available || info.needs_build || strcmp(info.name, "brute") == 0) continue;
        for (cw_leaf leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_run how = {.expert = {.kernel = cw_kernel_at(k), .leaf = leaf}};
            if (cw_run_check(field, &how) != CW_OK) continue;
            ask_in_all_ways(info.name, &how,
                            info.width <= 16 ? FOR_FEW : FOR_ALL); /* the widest has vectors of 2 KiB */
        }
    }
}

/* ---- everything else --------------------------------------------------------------------------------------------------- */

static cw_hit found[RAYS];
static float numbers[SIDE * SIDE];
static double points[RAYS][3];

static void make_fields(const void *what) {
    cw_field *other;
    cw_run run = {.pool = NULL};
    (void)what;
    check_status(cw_field_create(&(cw_field_desc){.samples = samples, .nx = SIDE, .ny = SIDE}, &run, &other), CW_OK);
    cw_field_destroy(other);
}
static void update(const void *what) {
    (void)what;
    const cw_update change = {
        .at = {.i = 3, .j = 5, .nx = 150, .ny = 100}, .samples = samples + 5 * SIDE + 3, .stride = SIDE};
    check_status(cw_field_update(field, NULL, &change), CW_OK);
}
static void update_waiting(const void *what) {
    (void)what;
    const cw_update change = {
        .at = {.i = 3, .j = 5, .nx = 2, .ny = 1}, .samples = samples + 5 * SIDE + 3, .stride = SIDE, .wait = 1};
    check_status(cw_field_update(field, NULL, &change), CW_OK);
}
static void move_field(const void *what) {
    (void)what;
    check_status(cw_field_move(field, (const double[3][4]){{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, 1), CW_OK);
}
static void fail_once(const void *what) {
    (void)what;
    check_status(cw_closest(NULL, NULL, rays[0], 1, found), CW_ERROR_ARGUMENT);
    check_status(cw_field_update(field, NULL, &(cw_update){.at = {0, 0, SIDE + 1, 1}, .samples = samples}),
                 CW_ERROR_ARGUMENT);
    assert_int_not_equal(cw_last_error()[0], 0);
}
static void places(const void *what) {
    (void)what;
    check_status(cw_surface_at(field, NULL, points[0], RAYS, found), CW_OK);
    check_status(cw_surface_at_user(field, NULL, points[0], RAYS, found), CW_OK);
    check_status(cw_hit_points(field, NULL, found, RAYS, points[0]), CW_OK);
    check_status(cw_hit_normals(field, NULL, found, RAYS, points[0]), CW_OK);
    check_status(cw_hit_phong_normals(field, NULL, found, RAYS, points[0]), CW_OK);
    static cw_ray moved[RAYS];
    check_status(cw_rays_to_field(field, NULL, user_rays[0], RAYS, moved), CW_OK);
}
static void few_places(const void *what) {
    (void)what;
    check_status(cw_surface_at(field, NULL, points[0], 1, found), CW_OK);
    check_status(cw_surface_at_user(field, NULL, points[0], 1, found), CW_OK);
    check_status(cw_hit_points(field, NULL, found, 1, points[0]), CW_OK);
    check_status(cw_hit_normals(field, NULL, found, 1, points[0]), CW_OK);
    check_status(cw_hit_phong_normals(field, NULL, found, 1, points[0]), CW_OK);
}
static void heading(const void *what) {
    (void)what;
    cw_heading *h;
    check_status(cw_heading_create(field, &(cw_heading_desc){.dir = {0.3, 1}}, &h), CW_OK);
    check_status(cw_heading_steepest(h, NULL, -INFINITY, INFINITY, (cw_rectangle){0, 7, SIDE, 100}, numbers), CW_OK);
    check_status(cw_heading_occluded(h, NULL, 0.1f, (cw_rectangle){0, 7, SIDE, 100}, (uint8_t *)numbers), CW_OK);
    cw_heading_destroy(h);
}
static void coarser(const void *what) {
    (void)what;
    for (int32_t filter = CW_FILTER_MEAN; filter <= CW_FILTER_LOWEST; filter++) {
        cw_field *other;
        cw_difference difference;
        check_status(cw_field_coarser(field, NULL, 3, filter, &other, &difference, sizeof difference), CW_OK);
        cw_field_destroy(other);
    }
}
static void make_terrain(const void *what) {
    (void)what;
    static double scale[CW_SCALE_ROWS * CW_SCALE_COLUMNS][2];
    for (size_t k = 0; k < CW_SCALE_ROWS * CW_SCALE_COLUMNS; k++) scale[k][0] = scale[k][1] = 1;
    cw_terrain *other;
    check_status(cw_terrain_create(&(cw_terrain_desc){.field = field, .scale = scale[0]}, NULL, &other), CW_OK);
    cw_terrain_destroy(other);
}
static const cw_area part = {.at = {100, 100, 90, 60}};
static void shadow(const void *what) {
    (void)what;
    check_status(cw_shadow(terrain, NULL, &(cw_light){.azimuth = 200, .altitude = 15}, part, (uint8_t *)numbers),
                 CW_OK);
}
static void sunlight(const void *what) {
    (void)what;
    const cw_light sun = {.azimuth = 200, .altitude = 15, .radius = 1, .hillshade = 1};
    check_status(cw_sunlight(terrain, NULL, &sun, part, numbers), CW_OK);
}
static void horizon(const void *what) {
    (void)what;
    static double azimuths[3600];
    const cw_horizon all = {.curvature = 1, .count = 3600}, some = {.count = 12, .flags = CW_HORIZON_TILTED};
    const cw_horizon below = {.count = 12, .flags = CW_HORIZON_BELOW};
    static float metres[SIDE * SIDE];
    check_status(cw_horizon_azimuths(terrain, &all, azimuths), CW_OK);
    check_status(cw_horizon_angles(terrain, NULL, &all, 5, part, numbers, metres), CW_OK);
    check_status(cw_sky_view(terrain, NULL, &some, part, numbers), CW_OK);
    check_status(cw_openness(terrain, NULL, &below, part, numbers), CW_OK);
}
static void viewshed(const void *what) {
    (void)what;
    const cw_observer from = {.x = 100.5,
                              .y = 130,
                              .height = 3,
                              .target = 1,
                              .curvature = 1,
                              .limits = CW_OBSERVER_AZIMUTHS,
                              .azimuths = {10, 300}};
    static float needed[SIDE * SIDE];
    static double sum[SIDE * SIDE];
    const cw_view view = {.seen = (uint16_t *)numbers, .sum = sum, .needed = needed};
    memset(numbers, 0, sizeof numbers);
    check_status(cw_viewshed(terrain, NULL, &from, (cw_area){0}, &view), CW_OK);
    check_status(cw_viewshed(terrain, NULL, &from, (cw_area){0}, &(cw_view){.angle = numbers}), CW_OK);
}
static void lines(const void *what) {
    (void)what;
    static cw_sight all[RAYS];
    static cw_sight_answer answers[RAYS];
    for (size_t k = 0; k < RAYS; k++)
        all[k] = (cw_sight){.from = {10, (double)(k % SIDE), 2}, .to = {240, (double)(k * 7 % SIDE), 2}};
    check_status(cw_lines_of_sight(terrain, NULL, 1, all, RAYS, answers), CW_OK);
}
static void visibility(const void *what) {
    (void)what;
    const cw_visibility_desc desc = {.directions = 9, .height = 2, .every = 3};
    static float share[SIDE * SIDE], farthest[SIDE * SIDE], azimuth[SIDE * SIDE];
    const cw_visibility_answers to = {.area = numbers, .share = share, .farthest = farthest, .azimuth = azimuth};
    check_status(cw_visibility(terrain, NULL, &desc, part, &to), CW_OK);
}

static const struct {
    const char *name;
    call *make;
    size_t limit;
} calls[] = {
    {"cw_field_create", make_fields, FOR_ALL},
    {"cw_field_update", update, FOR_ALL},
    {"cw_field_update waiting", update_waiting, FOR_ALL},
    {"cw_field_move", move_field, FOR_ALL},
    {"errors", fail_once, FOR_FEW},
    {"places, points and normals", places, FOR_ALL},
    {"one place, point and normal", few_places, FOR_FEW},
    {"a heading", heading, FOR_ALL},
    {"cw_field_coarser", coarser, FOR_TERRAIN},
    {"cw_terrain_create", make_terrain, FOR_TERRAIN},
    {"cw_shadow", shadow, FOR_TERRAIN},
    {"cw_sunlight", sunlight, FOR_TERRAIN},
    {"horizons", horizon, FOR_TERRAIN},
    {"cw_viewshed", viewshed, FOR_TERRAIN},
    {"cw_lines_of_sight", lines, FOR_TERRAIN},
    {"cw_visibility", visibility, FOR_TERRAIN},
};

static void other_calls_keep_to_it(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof calls / sizeof *calls; k++)
        keeps_to(calls[k].limit, calls[k].name, 0, calls[k].make, NULL);
}

/* ---- threads of pools -------------------------------------------------------------------------------------------------- */

/* Most of a megabyte, by each thread. */
static void take_much(void *context, size_t begin, size_t end) {
    enum { MUCH = 900 << 10 };
    volatile char room[MUCH];
    for (size_t k = 0; k < MUCH; k += 1024) room[k] = (char)k;
    for (size_t k = begin; k < end; k++) ((unsigned char *)context)[k] = (unsigned char)(room[1024] == 0);
}

/* As under musl, whose threads get 128 KiB unless told otherwise. */
static void threads_of_pools_have_more(void **state) {
    (void)state;
#ifdef __GLIBC__
    enum { ITEMS = 4000 };
    static unsigned char done[ITEMS];
    pthread_attr_t how;
    cw_pool *pool;
    assert_int_equal(pthread_attr_init(&how), 0);
    assert_int_equal(pthread_attr_setstacksize(&how, 128 << 10), 0);
    assert_int_equal(pthread_setattr_default_np(&how), 0);
    assert_int_equal(pthread_attr_destroy(&how), 0);
    check_status(cw_pool_create(4, &pool), CW_OK);
    for (int round = 0; round < 20; round++) cw_pool_run(pool, ITEMS, 1, take_much, done);
    for (size_t k = 0; k < ITEMS; k++) assert_int_equal(done[k], 1);
    cw_pool_destroy(pool);
#else
    skip();
#endif
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queries_keep_to_it),
        cmocka_unit_test(other_calls_keep_to_it),
        cmocka_unit_test(threads_of_pools_have_more),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
