/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds on instruction sets: the machine's, the user's by CELLWALK_ISA, the program's by cw_isa_limit. The variable is
 * read once a process, so each case is a separate process. */

#include "case.h"
#include "cellwalk_expert.h"
#include "check.h"

#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* The widest set that both include. */
static cw_isa common(cw_isa a, cw_isa b) {
    cw_isa most = CW_ISA_SCALAR;
    for (int k = CW_ISA_SCALAR; k < CW_ISA_COUNT; k++)
        if (cw_isa_includes(a, (cw_isa)k) && cw_isa_includes(b, (cw_isa)k) && cw_isa_includes((cw_isa)k, most))
            most = (cw_isa)k;
    return most;
}

static void test_what_includes_what(void **state) {
    (void)state;
    static const bool includes[CW_ISA_COUNT][CW_ISA_COUNT] = {[CW_ISA_SCALAR] = {false, true},
                                                              [CW_ISA_SSE42] = {false, true, true},
                                                              [CW_ISA_AVX2] = {false, true, true, true},
                                                              [CW_ISA_AVX512] = {false, true, true, true, true},
                                                              [CW_ISA_NEON] = {false, true, false, false, false, true}};
    for (int a = CW_ISA_SCALAR; a < CW_ISA_COUNT; a++)
        for (int b = CW_ISA_SCALAR; b < CW_ISA_COUNT; b++)
            check(cw_isa_includes((cw_isa)a, (cw_isa)b) == includes[a][b], "%s and %s", cw_isa_name((cw_isa)a),
                  cw_isa_name((cw_isa)b));
    check(!cw_isa_includes(CW_ISA_ANY, CW_ISA_SCALAR) && !cw_isa_includes(CW_ISA_SCALAR, CW_ISA_ANY), "no set");
}

/* Runs a check in a child whose CELLWALK_ISA is value, NULL for not set; what the check returns, 0 being good. */
static int in_child(const char *value, int (*run)(cw_isa allowed), cw_isa allowed) {
    fflush(stdout);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (value)
            setenv("CELLWALK_ISA", value, 1);
        else
            unsetenv("CELLWALK_ISA");
        _exit(run(allowed));
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    check(WIFEXITED(status), "the child ended with status %#x", (unsigned)status);
    return WEXITSTATUS(status);
}

static int best(cw_isa allowed) {
    (void)allowed;
    return (int)cw_isa_best();
}

/* 0 if the program's limit works within what is allowed, else the number of what does not hold. */
static int limit_within(cw_isa allowed) {
    for (int from = CW_ISA_SCALAR; from < CW_ISA_COUNT; from++)
        for (int to = CW_ISA_SCALAR; to < CW_ISA_COUNT; to++) { /* down and up */
            cw_isa_limit((cw_isa)from);
            if (cw_isa_best() != common((cw_isa)from, allowed)) return 1;
            cw_isa_limit((cw_isa)to);
            if (cw_isa_best() != common((cw_isa)to, allowed)) return 2;
            for (size_t k = 0; k < cw_kernel_count(); k++) {
                const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
                if (info.available != cw_isa_includes(cw_isa_best(), info.isa)) return 3;
            }
        }
    cw_isa_limit(CW_ISA_SCALAR);
    cw_isa_limit(CW_ISA_ANY);
    if (cw_isa_best() != allowed) return 4;
    setenv("CELLWALK_ISA", allowed == CW_ISA_SCALAR ? "avx512" : "scalar", 1); /* it has been read */
    return cw_isa_best() == allowed ? 0 : 5;
}

/* A limit set before anything asks is no way around the variable either. */
static int limit_first(cw_isa allowed) {
    cw_isa_limit(CW_ISA_ANY);
    return cw_isa_best() == allowed ? 0 : 1;
}

/* Names of sets do, and other values do not. */
static void test_the_variable_bounds_the_process(void **state) {
    (void)state;
    static const char *const unknown[] = {"", "sse", "AVX2", "avx512 ", "none"};
    enum { UNKNOWN = sizeof unknown / sizeof unknown[0] };
    const cw_isa all = (cw_isa)in_child(NULL, best, CW_ISA_AVX512); /* what the machine has, where nothing bounds it */
    printf("this machine has %s\n", cw_isa_name(all));
    for (int k = CW_ISA_SCALAR - UNKNOWN; k < CW_ISA_COUNT; k++) {
        const char *value = k < CW_ISA_SCALAR ? unknown[CW_ISA_SCALAR - 1 - k] : cw_isa_name((cw_isa)k);
        const cw_isa allowed = k < CW_ISA_SCALAR ? all : common(all, (cw_isa)k);
        check(in_child(value, best, allowed) == (int)allowed, "CELLWALK_ISA='%s' does not give %s", value,
              cw_isa_name(allowed));
        const int within = in_child(value, limit_within, allowed), first = in_child(value, limit_first, allowed);
        check(within == 0, "CELLWALK_ISA='%s': cw_isa_limit within it, case %d", value, within);
        check(first == 0, "CELLWALK_ISA='%s': cw_isa_limit comes before it", value);
    }
}

/* The last ones, since they ask here, and not in a child, what the variable says. */

static void test_a_run_keeps_within_its_limit(void **state) {
    (void)state;
    for (cw_isa isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
        const cw_run run = {.expert.isa = isa};
        const cw_isa used = cw_kernel_describe(cw_run_kernel(NULL, &run)).isa;
        check(cw_isa_includes(isa, used) && cw_isa_includes(cw_isa_best(), used), "%s for %s", cw_isa_name(used),
              cw_isa_name(isa));
        for (size_t k = 0; k < cw_kernel_count(); k++) {
            const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
            const cw_run forced = {.expert = {.kernel = cw_kernel_at(k), .isa = isa}};
            const bool may = info.available && cw_isa_includes(isa, info.isa);
            check_status(cw_run_check(NULL, &forced), may ? CW_OK : CW_ERROR_KERNEL);
        }
    }
}

static bool lower_the_limit(void *context, double done) {
    (void)context, (void)done;
    cw_isa_limit(CW_ISA_SCALAR);
    return true;
}

/* A query goes on with the kernel that it has begun with. */
static void test_a_limit_does_not_reach_into_a_query(void **state) {
    (void)state;
    static cw_user_ray user_rays[RAYS];
    static cw_hit got[RAYS];
    case_begin(state);
    for (size_t k = 0; k < RAYS; k++) user_rays[k] = ray_for_user(&rays[k]);
    for (int user = 0; user < 2; user++) {
        const cw_run run = {.expert.kernel = cw_run_kernel(NULL, NULL), .watch = lower_the_limit};
        check_status(user ? cw_closest_user(field, &run, user_rays, RAYS, got)
                          : cw_closest(field, &run, rays, RAYS, got),
                     CW_OK);
        cw_isa_limit(CW_ISA_ANY);
        for (size_t k = 0; k < RAYS; k++) check(hit_same(&got[k], &expected[k]), "ray %zu", k);
    }
    check_status(cw_closest(field, &(cw_run){.expert.isa = CW_ISA_COUNT}, rays, 1, got), CW_ERROR_ARGUMENT);
    case_end(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_includes_what),
        cmocka_unit_test(test_the_variable_bounds_the_process),
        cmocka_unit_test(test_a_run_keeps_within_its_limit),
        cmocka_unit_test(test_a_limit_does_not_reach_into_a_query),
    };
    return cmocka_run_group_tests_name("isa", tests, NULL, NULL);
}
