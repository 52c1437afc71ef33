/* SPDX-License-Identifier: Apache-2.0 */
/* Updates beside threads that ask without a pause: those that wait neither fail nor starve, nor do the queries; where
 * none waits, each call does its work or is turned away. A query sees all of an update or nothing, and ThreadSanitizer
 * no race. Where a thread starves the test does not end. One test reads the field's door to know that a call waits. */

#include "cellwalk_expert.h"
#include "check.h"
#include "field.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SIDE = 70, ASKING = 3, UPDATING = 2, TURNS = 100 };

static float heights[SIDE * SIDE];
static cw_field *field;

typedef struct worker {
    pthread_t thread;
    atomic_bool *stop; /* NULL: after TURNS */
    uint32_t wait;     /* updates do */
    cw_run run;        /* of queries */
    /* Calls; away: turned away, where updates do not wait or have freed what the kernel needs. */
    size_t done, away, failed;
    size_t torn; /* queries that saw a part of an update */
} worker;

static bool goes_on(const worker *w) { return w->stop ? !atomic_load(w->stop) : w->done + w->away + w->failed < TURNS; }

static bool count(worker *w, cw_status status) {
    const bool away =
        (status == CW_ERROR_BUSY && !w->wait) || (status == CW_ERROR_NOT_BUILT && w->run.expert.kernel != NULL);
    w->done += status == CW_OK;
    w->away += away;
    w->failed += status != CW_OK && !away;
    return status == CW_OK;
}

/* Two rays in one call, to places that are always of one height. */
static void *ask(void *argument) {
    worker *w = argument;
    const cw_ray rays[2] = {{.org = {2.5f, 3.25f, 10000}, .dir = {0, 0, -1}, .tmax = INFINITY},
                            {.org = {66.5f, 61.25f, 10000}, .dir = {0, 0, -1}, .tmax = INFINITY}};
    while (goes_on(w)) {
        cw_hit hits[2];
        if (count(w, cw_closest(field, &w->run, rays, 2, hits))) w->torn += hits[0].t != hits[1].t;
    }
    return NULL;
}

static void *update(void *argument) {
    worker *w = argument;
    static _Thread_local float z[SIDE * SIDE];
    while (goes_on(w)) {
        for (size_t k = 0; k < SIDE * SIDE; k++) z[k] = (float)((w->done & 31) + 1);
        const cw_update u = {.at = {0, 0, SIDE, SIDE}, .samples = z, .wait = w->wait};
        count(w, cw_field_update(field, NULL, &u));
    }
    return NULL;
}

/* Those who ask, or those who update, have TURNS; the others go on until they have had them. */
static void run(bool asking_is_counted, uint32_t wait) {
    field = field_of(heights, SIDE, SIDE);
    atomic_bool stop = false;
    worker w[ASKING + UPDATING] = {{.run.expert.kernel = cw_kernel_find("grid3d")}}; /* the first one's */
    check_status(cw_field_build(field, &w[0].run), CW_OK);
    for (int k = 0; k < ASKING + UPDATING; k++) {
        w[k].stop = (k < ASKING) == asking_is_counted ? NULL : &stop;
        w[k].wait = wait;
        assert_int_equal(pthread_create(&w[k].thread, NULL, k < ASKING ? ask : update, &w[k]), 0);
    }
    for (int k = 0; k < ASKING + UPDATING; k++)
        if (w[k].stop == NULL) pthread_join(w[k].thread, NULL);
    atomic_store(&stop, true);
    for (int k = 0; k < ASKING + UPDATING; k++)
        if (w[k].stop != NULL) pthread_join(w[k].thread, NULL);
    for (int k = 0; k < ASKING + UPDATING; k++) {
        check(w[k].failed == 0, "thread %d: %zu of %zu calls failed", k, w[k].failed, w[k].failed + w[k].done);
        check(w[k].torn == 0, "thread %d saw %zu parts of updates", k, w[k].torn);
        check(w[k].stop != NULL || w[k].done + w[k].away == TURNS, "thread %d: %zu turns", k, w[k].done);
    }
    cw_field_destroy(field);
}

static void none_starves(void **state) {
    for (uint32_t k = 0; k < 4; k++) run(k & 1, k >> 1);
}

/* ---- one of each, hand in hand ----------------------------------------------------------------------------------- */

typedef struct call {
    pthread_t thread;
    cw_status status;
    float t;
    atomic_bool stays; /* a query that is inside does not end before this is false */
    atomic_bool inside, ended;
} call;

static bool stay_inside(void *context, double done) {
    call *c = context;
    atomic_store(&c->inside, true);
    while (atomic_load(&c->stays)) sched_yield();
    return true;
}

static void *closest(void *argument) {
    call *c = argument;
    const cw_run run = {.watch = stay_inside, .watch_context = c};
    const cw_ray ray = {.org = {2.5f, 3.25f, 100}, .dir = {0, 0, -1}, .tmax = INFINITY};
    cw_hit hit = {0};
    c->status = cw_closest(field, &run, &ray, 1, &hit);
    c->t = hit.t;
    atomic_store(&c->ended, true);
    return NULL;
}

static void go_inside(call *c) {
    atomic_store(&c->stays, true);
    if (pthread_create(&c->thread, NULL, closest, c) != 0) abort();
    while (!atomic_load(&c->inside)) sched_yield();
}

static cw_status move(uint32_t wait) { return cw_field_move(field, (const double[3][4]){{0}}, wait); }

static void *raise_all(void *argument) {
    call *c = argument;
    static float z[SIDE * SIDE];
    for (size_t k = 0; k < SIDE * SIDE; k++) z[k] = 7;
    const cw_update u = {.at = {0, 0, SIDE, SIDE}, .samples = z, .wait = 1};
    c->status = cw_field_update(field, NULL, &u);
    atomic_store(&c->ended, true);
    return NULL;
}

static size_t queries_that_wait(void) {
    pthread_mutex_lock(&field->door.lock);
    const size_t waiting = field->door.waiting;
    pthread_mutex_unlock(&field->door.lock);
    return waiting;
}

/* Whether a child ends soon, with status 0. */
static bool child_is_well(int (*look)(cw_status expected), cw_status expected) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(60);
        _exit(look(expected));
    }
    int status = -1;
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

/* A query and an update in a child, where no call of the parent goes on, have that status. cw_field_destroy returns. */
static int ask_and_update(cw_status expected) {
    call query = {0};
    closest(&query);
    const cw_status update = move(1);
    cw_field_destroy(field);
    return query.status != expected || update != expected;
}

/* The update waits for the query inside, the newcomer for the update. */
static void newcomers_wait(void **state) {
    field = field_of(heights, SIDE, SIDE);
    call first = {0}, update_call = {0}, newcomer = {0};
    go_inside(&first);
    check_status(move(0), CW_ERROR_BUSY);
    assert_int_equal(pthread_create(&update_call.thread, NULL, raise_all, &update_call), 0);
    while (atomic_load(&field->door.state) == DOOR_OPEN && !atomic_load(&update_call.ended)) sched_yield();
    assert_int_equal(pthread_create(&newcomer.thread, NULL, closest, &newcomer), 0);
    while (queries_that_wait() == 0 && !atomic_load(&newcomer.ended)) sched_yield();
    const bool both_wait = !atomic_load(&update_call.ended) && !atomic_load(&newcomer.ended);
    const bool another_is_refused = move(0) == CW_ERROR_BUSY;
    const bool child_is_refused = child_is_well(ask_and_update, CW_ERROR_BUSY), is_old = cw_field_row(field, 0)[0] == 1;
    atomic_store(&first.stays, false);
    call *calls[] = {&first, &update_call, &newcomer};
    for (int k = 0; k < 3; k++) {
        pthread_join(calls[k]->thread, NULL);
        check_status(calls[k]->status, CW_OK);
    }
    assert_true(both_wait && another_is_refused && child_is_refused && is_old);
    check(first.t == 99 && newcomer.t == 93, "at %g and %g", (double)first.t, (double)newcomer.t);
    assert_true(child_is_well(ask_and_update, CW_OK));
    cw_field_destroy(field);
}

/* ---- processes that fork ----------------------------------------------------------------------------------------- */

static int go_on(cw_status expected);

/* Some threads are in a query, which one of them found empty. Whether their answers, and updates meanwhile and after
 * them, are right; if there are many, a child is made meanwhile. */
static bool ask_in(int threads) {
    call c[40] = {{0}};
    for (int k = 0; k < threads; k++) go_inside(&c[k]);
    bool good = move(0) == CW_ERROR_BUSY && (threads <= 2 || child_is_well(go_on, CW_OK));
    for (int k = 0; k < threads; k++) { /* up to the last one, who shares a counter with one that has left */
        good &= move(0) == CW_ERROR_BUSY;
        atomic_store(&c[k].stays, false);
        good &= pthread_join(c[k].thread, NULL) == 0 && c[k].t == 99;
    }
    return good && move(0) == CW_OK;
}

static int go_on(cw_status expected) {
    if (move(0) != expected) return 100;
#ifdef TEST_IN_EMULATOR
    return 0;
#endif
    return !ask_in(2);
}

/* Queries of the parent's other threads do not run in a child, and keep no update out. Those of the child's own do. */
static void fields_outlive_a_fork(void **state) {
#ifdef __SANITIZE_THREAD__
    skip(); /* its runtime does not go on in the child of a process with threads */
#endif
    field = field_of(heights, SIDE, SIDE);
    assert_true(ask_in(40)); /* so many that some share a counter */
    cw_field_destroy(field);
}

/* ---- one from within the other ----------------------------------------------------------------------------------- */

static const cw_ray ray = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
static const cw_user_ray user = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};

typedef struct meeting {
    cw_field *field;
    cw_update update;
    cw_status status; /* of what was tried meanwhile */
    unsigned tried;
} meeting;

/* From within a query: it runs. */
static bool update_meanwhile(void *context, double done) {
    meeting *m = context;
    m->status = cw_field_update(m->field, NULL, &m->update);
    m->tried++;
    return true;
}

/* From within an update, on whose pool this is. */
static void ask_meanwhile(void *context, cw_task_fn *task, void *argument, uint32_t count) {
    meeting *m = context;
    /* Whose grid the update frees. */
    const cw_run grid = {.expert.kernel = cw_kernel_find("grid3d")};
    cw_hit hit;
    uint8_t occluded;
    double point[3];
    const cw_status status[] = {
        cw_closest(m->field, NULL, &ray, 1, &hit),       cw_occluded(m->field, NULL, &ray, 1, &occluded),
        cw_closest_user(m->field, NULL, &user, 1, &hit), cw_occluded_user(m->field, NULL, &user, 1, &occluded),
        cw_hit_points(m->field, NULL, &hit, 1, point),   cw_field_update(m->field, NULL, &m->update),
        cw_closest(m->field, &grid, &ray, 1, &hit),      cw_occluded(m->field, &grid, &ray, 1, &occluded)};
    for (size_t k = 0; k < sizeof status / sizeof status[0]; k++) check_status(status[k], CW_ERROR_BUSY);
    m->tried++;
    for (unsigned k = 0; k < count; k++) task(argument, k);
}

static void who_comes_second_is_turned_away(void **state) {
    enum { LARGE = 300 }; /* so that the update is shared */
    static float z[LARGE * LARGE];
    cw_field *f = field_of(z, LARGE, LARGE);
    meeting m = {.field = f, .update = {.at = {.nx = LARGE, .ny = LARGE}, .samples = z}};
    const cw_run q = {.watch = update_meanwhile, .watch_context = &m};
    cw_hit hit;
    check_status(cw_closest(f, &q, &ray, 1, &hit), CW_OK);
    check_status(m.status, CW_ERROR_BUSY);
    check_status(cw_closest_user(f, &q, &user, 1, &hit), CW_OK);
    check_status(m.status, CW_ERROR_BUSY);
    assert_int_equal(m.tried, 2);

    cw_pool *pool;
    const cw_tasks tasks = {.threads = 2, .run = ask_meanwhile, .context = &m};
    check_status(cw_pool_create_on(&tasks, &pool), CW_OK);
    check_status(cw_field_build(f, &(cw_run){.expert.kernel = cw_kernel_find("grid3d")}), CW_OK);
    check_status(cw_field_update(f, &(cw_run){.pool = pool}, &m.update), CW_OK);
    check(m.tried > 2, "nothing was tried during the update");
    check_status(cw_closest(f, NULL, &ray, 1, &hit), CW_OK);
    cw_pool_destroy(pool);
    cw_field_destroy(f);
}

int main(void) {
    for (size_t k = 0; k < SIDE * SIDE; k++) heights[k] = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(newcomers_wait),
        cmocka_unit_test(none_starves),
        cmocka_unit_test(fields_outlive_a_fork),
        cmocka_unit_test(who_comes_second_is_turned_away),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
