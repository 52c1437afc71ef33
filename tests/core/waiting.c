/* SPDX-License-Identifier: Apache-2.0 */
/* Updates beside threads that ask without a pause: those that wait do not fail or starve, nor do the queries; where none waits, each call
 * does its work or is turned away. A query sees all of an update or nothing of it, and ThreadSanitizer sees no race. Where a thread
 * starves the test does not end. One test looks into the field's door to know that a call waits. */

#include "cellwalk_expert.h"
#include "check.h"
#include "field.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>
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
    atomic_bool stop;
    atomic_init(&stop, false);
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
    (void)state;
    for (uint32_t k = 0; k < 4; k++) run(k & 1, k >> 1);
}

/* ---- one of each, hand in hand ----------------------------------------------------------------------------------- */

typedef struct held {
    atomic_bool inside, released;
} held;

static bool hold(void *context, double done) {
    (void)done;
    held *h = context;
    atomic_store(&h->inside, true);
    while (!atomic_load(&h->released)) sched_yield();
    return true;
}

typedef struct call {
    pthread_t thread;
    cw_run run;
    cw_status status;
    float t;
    atomic_bool ended;
} call;

static void *closest(void *argument) {
    call *c = argument;
    const cw_ray ray = {.org = {2.5f, 3.25f, 100}, .dir = {0, 0, -1}, .tmax = INFINITY};
    cw_hit hit = {0};
    c->status = cw_closest(field, &c->run, &ray, 1, &hit);
    c->t = hit.t;
    atomic_store(&c->ended, true);
    return NULL;
}

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

/* A query and an update in a child, where no call of the parent's goes on, have that status. cw_field_destroy returns there. */
static bool a_child_has(cw_status expected) {
    const pid_t child = fork();
    if (child == 0) {
        call query = {0};
        closest(&query);
        const cw_status update = cw_field_move(field, (const double[3][4]){{0}}, 1);
        cw_field_destroy(field);
        _exit(query.status == expected && update == expected ? 0 : 1);
    }
    int status = -1;
    return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* The update waits for the query inside, the newcomer for the update. */
static void newcomers_wait(void **state) {
    (void)state;
    field = field_of(heights, SIDE, SIDE);
    held h;
    atomic_init(&h.inside, false);
    atomic_init(&h.released, false);
    call first = {.run = {.watch = hold, .watch_context = &h}}, update_call = {0}, newcomer = {0};
    assert_int_equal(pthread_create(&first.thread, NULL, closest, &first), 0);
    while (!atomic_load(&h.inside)) sched_yield();
    check_status(cw_field_move(field, (const double[3][4]){{0}}, 0), CW_ERROR_BUSY);
    assert_int_equal(pthread_create(&update_call.thread, NULL, raise_all, &update_call), 0);
    while (atomic_load(&field->door.state) == DOOR_OPEN && !atomic_load(&update_call.ended)) sched_yield();
    assert_int_equal(pthread_create(&newcomer.thread, NULL, closest, &newcomer), 0);
    while (queries_that_wait() == 0 && !atomic_load(&newcomer.ended)) sched_yield();
    const bool both_wait = !atomic_load(&update_call.ended) && !atomic_load(&newcomer.ended);
    const cw_status other = cw_field_move(field, (const double[3][4]){{0}}, 0);
    const bool child_is_refused = a_child_has(CW_ERROR_BUSY), is_old = cw_field_row(field, 0)[0] == 1;
    atomic_store(&h.released, true);
    pthread_join(first.thread, NULL);
    pthread_join(update_call.thread, NULL);
    pthread_join(newcomer.thread, NULL);
    assert_true(both_wait && child_is_refused && is_old);
    check_status(other, CW_ERROR_BUSY);
    check_status(first.status, CW_OK);
    check_status(update_call.status, CW_OK);
    check_status(newcomer.status, CW_OK);
    check(first.t == 99 && newcomer.t == 93, "at %g and %g", (double)first.t, (double)newcomer.t);
    assert_true(a_child_has(CW_OK));
    cw_field_destroy(field);
}

/* ---- one from within the other ------------------------------------------------------------------------------------- */

typedef struct meeting {
    cw_field *field;
    cw_update update;
    cw_status status[3]; /* of what was tried meanwhile */
    unsigned tried;
} meeting;

/* From within a query: it runs. */
static bool update_meanwhile(void *context, double done) {
    meeting *m = context;
    (void)done;
    m->status[0] = cw_field_update(m->field, NULL, &m->update);
    m->tried++;
    return true;
}

/* From within an update, on whose pool this is. */
static void ask_meanwhile(void *context, cw_task_fn *task, void *argument, uint32_t count) {
    meeting *m = context;
    const cw_ray ray = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_user_ray user = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
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
    (void)state;
    enum { LARGE = 300 }; /* so that the update is shared */
    static float z[LARGE * LARGE];
    cw_field *f = field_of(z, LARGE, LARGE);
    meeting m = {.field = f, .update = {.at = {.nx = LARGE, .ny = LARGE}, .samples = z}};
    const cw_ray ray = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_user_ray user = {.org = {1, 1, 0}, .dir = {1, 0, 0}, .tmax = 1};
    const cw_run q = {.watch = update_meanwhile, .watch_context = &m};
    cw_hit hit;
    check_status(cw_closest(f, &q, &ray, 1, &hit), CW_OK);
    check_status(m.status[0], CW_ERROR_BUSY);
    check_status(cw_closest_user(f, &q, &user, 1, &hit), CW_OK);
    check_status(m.status[0], CW_ERROR_BUSY);
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

static int set_up(void **state) {
    (void)state;
    for (size_t k = 0; k < SIDE * SIDE; k++) heights[k] = 1;
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(newcomers_wait),
        cmocka_unit_test(none_starves),
        cmocka_unit_test(who_comes_second_is_turned_away),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
