/* SPDX-License-Identifier: Apache-2.0 */
/* A pool that several threads use at once: each gets the answers that it would get alone, and none waits for ever. */

#include "check.h"
#include "rays.h"

#include <pthread.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RAYS = 20000, CALLERS = 4, THREADS = 4, LIMIT_SECONDS = 120 };

static test_field shape;
static cw_field *field;
static cw_ray rays[RAYS];
static cw_hit expected[RAYS], got[CALLERS][RAYS];
static uint8_t occluded[CALLERS][RAYS];

static int set_up(void **state) {
    (void)state;
    field = ray_case(&shape, FIELD_RANDOM, 17, 17, 7, rays, expected, RAYS);
    alarm(LIMIT_SECONDS); /* a deadlock is the end of this process, by a signal */
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    cw_field_destroy(field);
    return 0;
}

typedef struct caller {
    cw_pool *pool;
    size_t number, rounds, wrong;
    pthread_t thread;
} caller;

/* Each with another part of the rays, so that an answer from another's job shows. */
static void *ask(void *argument) {
    caller *c = argument;
    const cw_run query = {.pool = c->pool};
    for (size_t k = 0; k < c->rounds; k++) {
        const size_t first = (c->number * 997 + k * 131) % (RAYS / 2), n = RAYS / 2;
        if (cw_closest(field, &query, rays + first, n, got[c->number]) != CW_OK ||
            cw_occluded(field, &query, rays + first, n, occluded[c->number]) != CW_OK)
            c->wrong++;
        for (size_t r = 0; r < n; r++)
            c->wrong += !hit_same(&got[c->number][r], &expected[first + r]) ||
                        occluded[c->number][r] != (expected[first + r].i >= 0);
    }
    return NULL;
}

static void callers_at_once(void **state) {
    (void)state;
    caller callers[CALLERS] = {{0}};
    cw_pool *pool;
    check_status(cw_pool_create(THREADS, &pool), CW_OK);
    for (size_t k = 0; k < CALLERS; k++) {
        callers[k] = (caller){.pool = pool, .number = k, .rounds = test_share(200, 1)};
        assert_int_equal(pthread_create(&callers[k].thread, NULL, ask, &callers[k]), 0);
    }
    for (size_t k = 0; k < CALLERS; k++) {
        assert_int_equal(pthread_join(callers[k].thread, NULL), 0);
        check(callers[k].wrong == 0, "caller %zu: %zu wrong answers", k, callers[k].wrong);
    }
    cw_pool_destroy(pool);
}

/* Work that asks the pool which it runs on. */
static void ask_again(void *context, size_t begin, size_t end) {
    caller *c = context;
    for (size_t k = begin; k < end; k++) {
        caller inner = {.pool = c->pool, .number = k, .rounds = 1};
        ask(&inner);
        got[k][0].i = inner.wrong == 0 ? 1 : 0;
    }
}

static void work_within_work(void **state) {
    (void)state;
    caller c = {0};
    check_status(cw_pool_create(THREADS, &c.pool), CW_OK);
    cw_pool_run(c.pool, CALLERS, 1, ask_again, &c);
    for (size_t k = 0; k < CALLERS; k++) check(got[k][0].i == 1, "wrong answers within piece %zu", k);
    cw_pool_destroy(c.pool);
}

static atomic_uchar visited[10007];

static void visit(void *context, size_t begin, size_t end) {
    (void)context;
    for (size_t k = begin; k < end; k++) atomic_fetch_add(&visited[k], 1);
}

static void each_item_once(void **state) {
    (void)state;
    enum { ITEMS = sizeof visited / sizeof visited[0] };
    static const size_t grains[] = {1, 7, 4096, ITEMS - 1, ITEMS, ITEMS + 1, SIZE_MAX};
    cw_pool *pool;
    check_status(cw_pool_create(THREADS, &pool), CW_OK);
    unsigned times = 0;
    for (size_t k = 0; k < sizeof grains / sizeof grains[0]; k++) {
        cw_pool_run(pool, ITEMS, grains[k], visit, NULL);
        times++;
        for (size_t item = 0; item < ITEMS; item++)
            check(visited[item] == times, "grain %zu: item %zu, %u times in all", grains[k], item, visited[item]);
    }
    cw_pool_run(pool, 0, 1, NULL, NULL);
    cw_pool_destroy(pool);
}

/* A child has none of its parent's threads, and goes on with the pool alone. */
static void pools_outlive_a_fork(void **state) {
    (void)state;
    enum { ROUNDS = 20 };
    cw_pool *pool;
#ifdef __SANITIZE_THREAD__
    skip(); /* its runtime does not go on in the child of a process with threads */
#endif
    check_status(cw_pool_create(THREADS, &pool), CW_OK);
    caller busy = {.pool = pool, .rounds = test_share(40, 4)}, other = {.pool = pool, .number = 1, .rounds = 1};
    /* Forked while another thread has the helpers, whose state the child inherits. */
    assert_int_equal(pthread_create(&busy.thread, NULL, ask, &busy), 0);
    for (int k = 0; k < ROUNDS; k++) {
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            alarm(LIMIT_SECONDS / 2);
            ask(&other);
            cw_pool_destroy(pool);
            _exit(other.wrong == 0 ? 0 : 1);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        check(WIFEXITED(status) && WEXITSTATUS(status) == 0, "the child ended with %#x", (unsigned)status);
    }
    assert_int_equal(pthread_join(busy.thread, NULL), 0);
    check(busy.wrong == 0, "%zu wrong answers in the parent", busy.wrong);
    cw_pool_destroy(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(callers_at_once),
        cmocka_unit_test(work_within_work),
        cmocka_unit_test(each_item_once),
        cmocka_unit_test(pools_outlive_a_fork),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
