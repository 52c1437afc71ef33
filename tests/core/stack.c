/* SPDX-License-Identifier: Apache-2.0 */
/* The stack that calls take is what the headers say: each runs in a thread on memory that was painted before. The
 * threads of a pool have the megabyte that they are promised. */

#include "calls.h"
#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 256, RAYS = 300, FEW = 8, ARENA = 1 << 18, PAINT = 0xa7 };

/* In an emulator the longest field would take a minute to make; this one's pyramid has three levels fewer. */
#ifdef TEST_IN_EMULATOR
enum { LONGEST = CW_SIDE_MAX / 64 };
#else
enum { LONGEST = CW_SIDE_MAX };
#endif

static test_field shape;
static float *const samples = shape.z;
static cw_field *field, *longest;

/* ---- measuring --------------------------------------------------------------------------------------------------- */

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

/* ---- rays -------------------------------------------------------------------------------------------------------- */

/* Those that take each way through a kernel: of all classes; close above a slope, which take long; together; and close
 * above a slope in the longest field, whose pyramid has the most levels. */
enum { OF_ALL_CLASSES, ALONG_THE_SLOPE, TOGETHER, FAR_ALONG, KINDS };
static cw_ray rays[KINDS][RAYS];
static cw_user_ray user_rays[KINDS][RAYS];

static int set_up(void **state) {
    random_state r = {3};
    for (size_t k = 0; k < SIDE * SIDE; k++)
        samples[k] = 0.37f * (float)(k % SIDE) + (k / SIDE < SIDE / 2 ? 20 : 0.02f) * (float)random_unit(&r);
    float *line = malloc(2 * sizeof *line * LONGEST);
    assert_non_null(line);
    for (size_t k = 0; k < LONGEST; k++)
        line[k] = line[k + LONGEST] = (float)k * 0x1p-10f + (float)(random_unit(&r) * 0x1p-12);
    longest = field_of(line, LONGEST, 2);
    free(line);
    shape.nx = shape.ny = SIDE;
    shape.low = 0, shape.high = 115;
    field = calls_begin(&shape, NULL);
    for (size_t k = 0; k < RAYS; k++) {
        rays[OF_ALL_CLASSES][k] = ray_make((ray_class)(k % RAY_CLASSES), &shape, &r);
        const float x = (float)random_unit(&r), y = (float)(random_unit(&r) * SIDE / 2 + SIDE / 2);
        rays[ALONG_THE_SLOPE][k] =
            (cw_ray){.org = {x, y, 0.37f * x + 0.021f}, .dir = {1, 0.001f * (float)(k % 9), 0.37f}, .tmax = INFINITY};
        rays[TOGETHER][k] = (cw_ray){.org = {50 + 0.1f * (float)(k % 64), 50, 300},
                                     .dir = {0.1f, 0.2f, -1 - 0.001f * (float)(k % 64)},
                                     .tmax = INFINITY};
        const float far = (float)(LONGEST / 1700 * k), high = far * 0x1p-10f + 0x1p-11f;
        rays[FAR_ALONG][k] = (cw_ray){.org = {far, 0.5f, high}, .dir = {1, 0, 0x1p-10f}, .tmax = 2000};
        for (int kind = 0; kind < KINDS; kind++) user_rays[kind][k] = ray_for_user(&rays[kind][k]);
    }
    return 0;
}

static int tear_down(void **state) {
    calls_end();
    cw_field_destroy(longest);
    return 0;
}

/* ---- queries ----------------------------------------------------------------------------------------------------- */

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
                if (test_takes(number++, 16)) keeps_to(q.n <= FEW ? limit_of_few : STACK_FOR_ALL, name, q.n, ask, &q);
        }
}

static void queries_keep_to_it(void **state) {
    for (cw_isa isa = CW_ISA_ANY; isa < CW_ISA_COUNT; isa++)
        ask_in_all_ways("the default kernel", &(cw_run){.expert.isa = isa}, STACK_FOR_FEW);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (!info.available || info.needs_build || strcmp(info.name, "brute") == 0) continue;
        for (cw_leaf leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_run how = {.expert = {.kernel = cw_kernel_at(k), .leaf = leaf}};
            if (cw_run_check(field, &how) != CW_OK) continue;
            ask_in_all_ways(info.name, &how,
                            info.width <= 16 ? STACK_FOR_FEW : STACK_FOR_ALL); /* the widest has vectors of 2 KiB */
        }
    }
}

/* ---- everything else --------------------------------------------------------------------------------------------- */

static void make_call(const void *what) {
    const every_call *c = what;
    assert_int_equal(c->make(NULL), CW_OK);
}

static void other_calls_keep_to_it(void **state) {
    for (size_t k = 0; k < every_calls_count; k++)
        keeps_to(every_calls[k].stack, every_calls[k].name, 0, make_call, &every_calls[k]);
}

/* ---- threads of pools -------------------------------------------------------------------------------------------- */

/* Most of a megabyte, by each thread. */
static void take_much(void *context, size_t begin, size_t end) {
    enum { MUCH = 900 << 10 };
    volatile char room[MUCH];
    for (size_t k = 0; k < MUCH; k += 1024) room[k] = (char)k;
    for (size_t k = begin; k < end; k++) ((unsigned char *)context)[k] = (unsigned char)(room[1024] == 0);
}

/* As under musl, whose threads get 128 KiB unless told otherwise. */
static void threads_of_pools_have_more(void **state) {
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
    for (size_t round = test_share(20, 2); round > 0; round--) cw_pool_run(pool, ITEMS, 1, take_much, done);
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
