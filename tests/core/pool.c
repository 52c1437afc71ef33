/* SPDX-License-Identifier: Apache-2.0 */
/* A pool that several threads use at once: each gets the answers that it would get alone, and none waits for ever. A
 * watch sees growing shares of each call of the libraries, and ends it. */

#include "calls.h"
#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { RAYS = 20000, CALLERS = 4, THREADS = 4, LIMIT_SECONDS = 120 };

static test_field shape;
static cw_field *field;
static cw_ray rays[RAYS];
static cw_hit expected[RAYS];
static cw_hit got[CALLERS][RAYS];
static uint8_t occluded[CALLERS][RAYS];

static int set_up(void **state) {
    alarm(LIMIT_SECONDS); /* a deadlock is the end of this process, by a signal */
    random_state r = {7};
    field_make(&shape, FIELD_RANDOM, 17, 17, 7);
    field = field_open(&shape);
    for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &shape, &r);
    return cw_closest(field, NULL, rays, RAYS, expected) == CW_OK ? 0 : -1;
}

static int tear_down(void **state) {
    cw_field_destroy(field);
    return 0;
}

typedef struct caller {
    cw_pool *pool;
    size_t number, rounds, wrong;
    pthread_t thread;
} caller;

/* Each with another part of the rays, so that an answer from another's job shows; every fourth time with fewer, down to
 * less than what a thread takes at a time. */
static void *ask(void *argument) {
    caller *c = argument;
    const cw_run query = {.pool = c->pool};
    for (size_t k = 0; k < c->rounds; k++) {
        const size_t first = (c->number * 997 + k * 131) % (RAYS / 2), n = RAYS / 2 >> (k % 4 == 3 ? k / 4 % 14 : 0);
        if (cw_closest(field, &query, rays + first, n, got[c->number]) != CW_OK ||
            cw_occluded(field, &query, rays + first, n, occluded[c->number]) != CW_OK)
            c->wrong++;
        for (size_t r = 0; r < n; r++)
            c->wrong += !hit_same(&got[c->number][r], &expected[first + r]) ||
                        occluded[c->number][r] != (expected[first + r].i >= 0);
    }
    return NULL;
}

static void ask_at_once(cw_pool *pool, size_t rounds) {
    caller callers[CALLERS] = {{0}};
    for (size_t k = 0; k < CALLERS; k++) {
        callers[k] = (caller){.pool = pool, .number = k, .rounds = rounds};
        assert_int_equal(pthread_create(&callers[k].thread, NULL, ask, &callers[k]), 0);
    }
    for (size_t k = 0; k < CALLERS; k++) {
        assert_int_equal(pthread_join(callers[k].thread, NULL), 0);
        check(callers[k].wrong == 0, "caller %zu on %u threads: %zu wrong answers", k, cw_pool_threads(pool),
              callers[k].wrong);
    }
}

static void callers_at_once(void **state) {
    const size_t rounds = test_share(200, 1);
    ask_at_once(NULL, 1 + rounds / 40);
    for (unsigned threads = 1; threads <= 7; threads++) {
        cw_pool *pool;
        check_status(cw_pool_create(threads, &pool), CW_OK);
        assert_int_equal(cw_pool_threads(pool), threads);
        ask_at_once(pool, threads == THREADS ? rounds : 1 + rounds / 40);
        cw_pool_destroy(pool);
    }
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
    caller c = {0};
    check_status(cw_pool_create(THREADS, &c.pool), CW_OK);
    cw_pool_run(c.pool, CALLERS, 1, ask_again, &c);
    for (size_t k = 0; k < CALLERS; k++) check(got[k][0].i == 1, "wrong answers within piece %zu", k);
    cw_pool_destroy(c.pool);
}

static atomic_uchar visited[10007];

static void visit(void *context, size_t begin, size_t end) {
    for (size_t k = begin; k < end; k++) atomic_fetch_add(&visited[k], 1);
}

static void each_item_once(void **state) {
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

/* ---- threads that are cancelled ---------------------------------------------------------------------------------- */

/* The library's, by the linker's --wrap. A thread that is to be cancelled leaves here. */
static _Thread_local bool tells_of_waiting;
static atomic_bool waits;

int __real_pthread_cond_wait(pthread_cond_t *cond, pthread_mutex_t *mutex);
int __wrap_pthread_cond_wait(pthread_cond_t *cond, pthread_mutex_t *mutex);
int __wrap_pthread_cond_wait(pthread_cond_t *cond, pthread_mutex_t *mutex) {
    if (tells_of_waiting) atomic_store(&waits, true);
    return __real_pthread_cond_wait(cond, mutex);
}

typedef struct doomed {
    cw_pool *pool;
    size_t number; /* of what it does */
    bool returned;
} doomed;

static atomic_uint at_work;

/* The caller's piece ends when a helper has the other one, and that one when the caller waits for it. */
static void hold_helper(void *context, size_t begin, size_t end) {
    atomic_fetch_add(&at_work, 1);
    while (tells_of_waiting ? atomic_load(&at_work) < 2 : !atomic_load(&waits)) sched_yield();
}

/* Work with a cancellation point in the middle, as input and output are. */
static void look_for_an_end(void *context, size_t begin, size_t end) { pthread_testcancel(); }
static bool watch_for_an_end(void *context, double done) {
    look_for_an_end(context, 0, 0);
    return done <= 1;
}
static void *allocate(void *context, size_t bytes, size_t alignment) {
    look_for_an_end(context, 0, 0);
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}
static void release(void *context, void *memory) {
    look_for_an_end(context, 0, 0);
    free(memory);
}

/* What waits for threads or calls back: two pieces of work on a pool, each library function, the end of the pool. */
enum { WORK = 2 };
static cw_status do_one(const doomed *d) {
    const cw_run run = {.pool = d->pool, .watch = watch_for_an_end};
    if (d->number == 0)
        cw_pool_run(d->pool, 2, 1, hold_helper, NULL);
    else if (d->number < WORK)
        cw_pool_run(d->pool, 100, 1, look_for_an_end, NULL);
    else if (d->number < WORK + every_calls_count)
        return every_calls[d->number - WORK].make(&run);
    else
        cw_pool_destroy(d->pool);
    return CW_OK;
}

/* The end is waiting before it begins, and comes at the first cancellation point. */
static void *do_one_and_end(void *argument) {
    doomed *d = argument;
    tells_of_waiting = true;
    pthread_cancel(pthread_self());
    d->returned = do_one(d) == CW_OK;
    pthread_testcancel();
    return NULL;
}

static void no_function_is_a_cancellation_point(void **state) {
    const cw_allocator allocator = {.allocate = allocate, .release = release};
    const size_t deeds = WORK + every_calls_count + 1;
    cw_pool *pool;
    cw_hit *hits = got[1];
    check_status(cw_pool_create(2, &pool), CW_OK);
    calls_begin(&shape, &allocator);
    for (size_t k = 0; k < deeds; k++) {
        doomed d = {.pool = pool, .number = k};
        pthread_t thread;
        void *end = NULL;
        assert_int_equal(pthread_create(&thread, NULL, do_one_and_end, &d), 0);
        assert_int_equal(pthread_join(thread, &end), 0);
        check(d.returned && end == PTHREAD_CANCELED, "number %zu does not return, or the thread goes on", k);
        if (k + 1 == deeds) break;
        memset(hits, 0, RAYS * sizeof *hits);
        check_status(cw_closest(field, &(cw_run){.pool = pool}, rays, RAYS, hits), CW_OK);
        for (size_t r = 0; r < RAYS; r++) check(hit_same(&hits[r], &expected[r]), "after number %zu, ray %zu", k, r);
        check_status(cw_field_update(field, NULL, &(cw_update){.at = {1, 1, 1, 1}}), CW_OK);
    }
    check(cw_last_error()[0] == '\0', "an error of another thread's: %s", cw_last_error());
    calls_end();
}

/* ---- watches ----------------------------------------------------------------------------------------------------- */

typedef struct watch {
    double first, last, stop_at;
    unsigned calls, wrong;
    atomic_int inside;
} watch;

/* Growing shares up to all; then another call may begin. From one thread at a time. */
static bool look(void *context, double done) {
    watch *w = context;
    if (w->last >= 1 && w->last < w->stop_at) w->last = 0;
    w->wrong += atomic_fetch_add(&w->inside, 1) != 0 || !(done > w->last && done <= 1) || w->last >= w->stop_at;
    if (w->calls++ == 0) w->first = done;
    w->last = done;
    sched_yield(); /* lets another thread in if it may */
    atomic_fetch_sub(&w->inside, 1);
    return done < w->stop_at;
}

/* A watch changes no answer, and ends the call wherever it says so. */
static void each_call_is_watched(void **state) {
    static test_field large;
    cw_pool *pool;
    check_status(cw_pool_create(3, &pool), CW_OK);
    field_make_land(&large, 256, 200);
    calls_begin(&large, NULL);
    for (size_t k = 0; k < every_calls_count; k++) {
        const every_call *c = &every_calls[k];
        if (c->unwatched) continue;
        calls_sum();
        const uint64_t none = calls_sum();
        check_status(c->make(NULL), CW_OK);
        const uint64_t sum = calls_sum();
        for (int shared = 0; shared < 2; shared++) {
            watch w = {.stop_at = 2};
            const cw_run run = {.pool = shared ? pool : NULL, .watch = look, .watch_context = &w};
            check_status(c->make(&run), CW_OK);
            check(calls_sum() == sum, "%s: other answers under a watch", c->name);
            check(w.last > 1 - 1e-9 && w.calls > 2 && w.wrong == 0, "%s: %u calls, %u wrong, up to %g", c->name,
                  w.calls, w.wrong, w.last);
            /* Rays may be slow, so the first piece is small. */
            check(k > 1 || shared || w.first <= 0.011, "%s: %g at once", c->name, w.first);
            for (double stop = 1e-9; stop < 1; stop += 0.1) {
                w = (watch){.stop_at = stop};
                check(c->make(&run) == CW_ERROR_CANCELLED && w.wrong == 0, "%s goes on after %g", c->name, w.last);
                check(calls_sum() != sum || sum == none || stop > 0.5, "%s does all its work after %g", c->name,
                      w.last);
            }
        }
    }
    calls_end();
    cw_pool_destroy(pool);
}

/* ---- processes that fork ----------------------------------------------------------------------------------------- */

/* A child has none of its parent's threads, and goes on with the pool alone. It is forked while another thread has the
 * helpers, whose state the child inherits. */
static void pools_outlive_a_fork(void **state) {
    cw_pool *pool;
#ifdef __SANITIZE_THREAD__
    skip(); /* its runtime does not go on in the child of a process with threads */
#endif
    check_status(cw_pool_create(THREADS, &pool), CW_OK);
    caller busy = {.pool = pool, .rounds = test_share(40, 4)}, other = {.pool = pool, .number = 1, .rounds = 1};
    assert_int_equal(pthread_create(&busy.thread, NULL, ask, &busy), 0);
    for (int k = 0; k < 20; k++) {
        const pid_t child = fork();
        if (child == 0) {
            alarm(LIMIT_SECONDS / 2);
            ask(&other);
            cw_pool_destroy(pool);
            _exit(other.wrong > 0);
        }
        int status = -1;
        check(child > 0 && waitpid(child, &status, 0) == child && status == 0, "a child ended with %#x",
              (unsigned)status);
    }
    assert_int_equal(pthread_join(busy.thread, NULL), 0);
    check(busy.wrong == 0, "%zu wrong answers in the parent", busy.wrong);
    cw_pool_destroy(pool);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(callers_at_once),      cmocka_unit_test(work_within_work),
        cmocka_unit_test(each_item_once),       cmocka_unit_test(no_function_is_a_cancellation_point),
        cmocka_unit_test(each_call_is_watched), cmocka_unit_test(pools_outlive_a_fork),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
