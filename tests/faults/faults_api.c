/* SPDX-License-Identifier: Apache-2.0 */
/* Each allocation and thread start of the library's functions fails once: the status says which, what was to be made is
 * NULL, what was there works on, no memory is lost. Queries and updates allocate nothing and start no thread. */

#include "calls.h"
#include "cellwalk_expert.h"
#include "check.h"
#include "faults.h"

#include <math.h>

enum { SIDE = 70, THREADS = 5 };

static test_field land;

static int set_up(void **state) {
    field_make_land(&land, SIDE, SIDE);
    return 0;
}

/* Does one thing, undoes it, and tells how it went. */
typedef cw_status act(const void *context);

static cw_status make_call(const void *context) { return ((const every_call *)context)->make(NULL); }

/* Built anew after a failure, and asked. */
static cw_status build(const void *context) {
    const cw_kernel *kernel = context;
    const cw_ray ray = {.org = {30, 30.5f, 2000}, .dir = {0.1f, 0, -1}, .tmax = INFINITY};
    const cw_field_desc d = {.samples = land.z, .nx = SIDE, .ny = SIDE};
    cw_field *field;
    cw_hit hit;
    cw_status status = cw_field_create(&d, &(cw_run){.expert.kernel = cw_kernel_find("cell")}, &field);
    if (status != CW_OK) return status;
    status = cw_field_build(field, &(cw_run){.expert.kernel = kernel});
    const cw_run q = {.expert.kernel = kernel};
    if (status != CW_OK && (cw_field_build(field, &(cw_run){.expert.kernel = kernel}) != CW_OK ||
                            cw_closest(field, &q, &ray, 1, &hit) != CW_OK))
        status = CW_ERROR_ARGUMENT;
    cw_field_destroy(field);
    return status;
}

static void run_one(void *context, cw_task_fn *task, void *argument, uint32_t count) {
    for (unsigned k = 0; k < count; k++) task(argument, k);
}

/* On the caller's tasks if there is a context. */
static cw_status make_pool(const void *context) {
    const cw_tasks tasks = {.threads = 2, .run = run_one};
    cw_pool *pool = (cw_pool *)&land; /* anything but NULL */
    const cw_status status = context ? cw_pool_create_on(&tasks, &pool) : cw_pool_create(THREADS, &pool);
    if ((pool == NULL) != (status != CW_OK)) return CW_ERROR_ARGUMENT; /* which is told as another failure */
    cw_pool_destroy(pool);
    return status;
}

static unsigned long check_every_fault(const char *name, act *what, const void *context) {
    check_status(what(context), CW_OK); /* libc keeps the stacks of threads that have ended, and what belongs to them */
    faults_begin(FAULT_MEMORY, 0);
    const cw_status status = what(context);
    const fault_counts good = faults_end();
    check_status(status, CW_OK);
    check(good.blocks == 0, "%s: %ld blocks lost", name, good.blocks);
    unsigned long injections = 0;
    static const fault_kind kinds[] = {FAULT_MEMORY, FAULT_THREAD};
    for (size_t k = 0; k < 2; k++)
        for (unsigned long n = 1; n <= good.calls[kinds[k]]; n++, injections++) {
            faults_begin(kinds[k], n);
            const cw_status failed = what(context);
            const fault_counts counts = faults_end();
            check(failed == CW_ERROR_MEMORY && counts.blocks == 0, "%s, %s %lu: %s, %ld blocks lost", name,
                  fault_names[kinds[k]], n, cw_status_message(failed), counts.blocks);
        }
    return injections;
}

static void what_is_made_is_made_whole(void **state) {
    unsigned long injections =
        check_every_fault("pool", make_pool, NULL) + check_every_fault("pool on tasks", make_pool, &land);
    calls_begin(&land, NULL);
    for (size_t k = 0; k < every_calls_count; k++)
        if (every_calls[k].allocates) injections += check_every_fault(every_calls[k].name, make_call, &every_calls[k]);
    calls_end();
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (info.available)
            injections += check_every_fault(info.name, build, cw_kernel_at(k)); /* it is asked as well */
    }
    check(injections > 20, "%lu faults alone", injections); /* with the scalar kernels alone */
    print_message("%lu faults\n", injections);
}

static bool go_on(void *context, double done) { return true; }

static void queries_ask_for_nothing(void **state) {
    cw_field *field = calls_begin(&land, NULL);
    cw_pool *pool;
    check_status(cw_pool_create(2, &pool), CW_OK);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run q = {.expert.kernel = cw_kernel_at(k), .pool = pool, .watch = k % 2 ? go_on : NULL};
        const cw_kernel_info info = cw_kernel_describe(q.expert.kernel);
        if (!info.available) continue;
        for (size_t c = 0; c < every_calls_count; c++) {
            if (every_calls[c].allocates) continue;
            check_status(cw_field_build(field, &(cw_run){.expert.kernel = q.expert.kernel}), CW_OK);
            faults_begin(FAULT_MEMORY, 0);
            const cw_status status = every_calls[c].make(&q);
            const fault_counts counts = faults_end();
            check_status(status, CW_OK);
            check(counts.calls[FAULT_MEMORY] == 0 && counts.calls[FAULT_THREAD] == 0,
                  "%s by %s: %lu allocations, %lu threads", every_calls[c].name, info.name, counts.calls[FAULT_MEMORY],
                  counts.calls[FAULT_THREAD]);
        }
    }
    cw_pool_destroy(pool);
    calls_end();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_made_is_made_whole),
        cmocka_unit_test(queries_ask_for_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
