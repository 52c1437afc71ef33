/* SPDX-License-Identifier: Apache-2.0 */
/* Every call keeps to the stack that the header says, and the threads of a pool have the megabyte that they are promised. */

#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

/* What the header says; and what the thread itself and its start need. */
enum { STATED = 128 << 10, THREAD = 16 << 10, SIDE = 300, RAYS = 3000 };

static float samples[SIDE * SIDE];
static cw_ray rays[RAYS];
static cw_user_ray user_rays[RAYS];
static cw_hit hits[RAYS];
static uint8_t occluded[RAYS];
static double points[RAYS][3];

static int set_up(void **state) {
    (void)state;
    random_state r = {3};
    for (size_t k = 0; k < SIDE * SIDE; k++) samples[k] = (float)random_unit(&r) * 20;
    for (size_t k = 0; k < RAYS; k++) {
        const double x = random_unit(&r) * SIDE, y = random_unit(&r) * SIDE;
        const double dx = random_unit(&r) - 0.5, dy = random_unit(&r) - 0.5, dz = -0.02 * random_unit(&r);
        rays[k] = (cw_ray){.org = {(float)x, (float)y, 25}, .dir = {(float)dx, (float)dy, (float)dz}, .tmax = INFINITY};
        user_rays[k] = (cw_user_ray){.org = {x, y, 25}, .dir = {dx, dy, dz}, .tmax = INFINITY};
    }
    return 0;
}

static void *do_everything(void *failure) {
    const char **failed = failure;
    const cw_field_desc desc = {.samples = samples, .nx = SIDE, .ny = SIDE};
    cw_field *field;
    *failed = "cw_field_create";
    if (cw_field_create(&desc, NULL, &field) != CW_OK) return NULL;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        const size_t n = strcmp(info.name, "brute") != 0 ? RAYS : 30; /* brute force takes its time */
        if (!info.available) continue;
        *failed = info.name;
        if (cw_field_build(field, &(cw_run){.expert.kernel = cw_kernel_at(k)}) != CW_OK) return NULL;
        for (int leaf = 0; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_run q = {.expert.kernel = cw_kernel_at(k), .expert.leaf = (cw_leaf)leaf};
            const cw_status status = cw_closest(field, &q, rays, n, hits);
            if (status == CW_ERROR_KERNEL) continue;
            if (status != CW_OK || cw_occluded(field, &q, rays, n, occluded) != CW_OK ||
                cw_closest_user(field, &q, user_rays, n, hits) != CW_OK ||
                cw_occluded_user(field, &q, user_rays, n, occluded) != CW_OK)
                return NULL;
        }
    }
    *failed = "what follows from hits";
    if (cw_hit_points(field, NULL, hits, RAYS, points[0]) != CW_OK ||
        cw_hit_normals(field, NULL, hits, RAYS, points[0]) != CW_OK ||
        cw_hit_phong_normals(field, NULL, hits, RAYS, points[0]) != CW_OK)
        return NULL;
    *failed = "cw_field_update";
    const cw_update update = {.at = {.i = 3, .j = 5, .nx = 200, .ny = 150}, .samples = samples, .stride = SIDE};
    if (cw_field_update(field, NULL, &update) != CW_OK) return NULL;
    *failed = "a heading";
    cw_heading *heading;
    float slopes[SIDE];
    if (cw_heading_create(field, &(cw_heading_desc){.dir = {0.3, 1}}, &heading) != CW_OK ||
        cw_heading_steepest(heading, NULL, -INFINITY, INFINITY, (cw_rectangle){0, 7, SIDE, 1}, slopes) != CW_OK)
        return NULL;
    cw_heading_destroy(heading);
    cw_field_destroy(field);
    *failed = NULL;
    return NULL;
}

static void every_call_keeps_to_it(void **state) {
    (void)state;
    pthread_attr_t how;
    pthread_t thread;
    const char *failed = "the thread";
    assert_int_equal(pthread_attr_init(&how), 0);
    assert_int_equal(pthread_attr_setstacksize(&how, STATED + THREAD), 0);
    assert_int_equal(pthread_create(&thread, &how, do_everything, &failed),
                     0); /* overflows into its guard page: SIGSEGV */
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_int_equal(pthread_attr_destroy(&how), 0);
    check(failed == NULL, "%s failed", failed);
}

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
        cmocka_unit_test(every_call_keeps_to_it),
        cmocka_unit_test(threads_of_pools_have_more),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
