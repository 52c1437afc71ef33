/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-guard: counts the instructions of a fixed small workload under callgrind and compares them
 * with committed figures, so that a slow-down is found without timing.
 *
 * Instructions repeat to the last digit, on a loaded machine and on another one, because callgrind simulates a CPU
 * with a fixed set of features (up to AVX2, without AVX-512). They do not show cache and TLB misses, mispredicted
 * branches, slow instructions in place of fast ones, and waiting. A change may cut instructions and still be slower;
 * cellwalk-bench measures that. Another compiler makes other code, so the figures hold for one compiler and one set
 * of flags, and every other build is skipped. */
#include "build_info.h"
#include "instructions/figures.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SKIPPED = 77 }; /* the exit status that the test's property SKIP_RETURN_CODE names */

static const char *const usage = "Usage: cellwalk-guard check|update WORK FIGURES\n\n"
                                 "Counts the instructions of the program WORK (cellwalk-counted-work) with\n"
                                 "valgrind and compares them with the file FIGURES, or writes them there. Leaves\n"
                                 "guard.runs and guard.callgrind in the current folder, for callgrind_annotate.\n"
                                 "Exit status: 0 within the tolerance, 1 above it or failed, 77 if there is\n"
                                 "nothing to compare.\n";

static int skip(const char *reason) {
    printf("skipped: %s\n", reason);
    return SKIPPED;
}

static int fail(const io_error *error) {
    fprintf(stderr, "cellwalk-guard: %s\n", error->text);
    return EXIT_FAILURE;
}

static int check(const guard_figures *committed, const guard_figures *now) {
    const guard_verdict v = guard_compare(&committed->all, &now->all, stdout);
    printf("%zu counts compared, tolerance %d %%: %zu above, %zu below", v.compared, GUARD_TOLERANCE, v.above, v.below);
    if (v.absent) printf("; %zu figures are of kernels that this machine cannot run", v.absent);
    printf("\n");
    const bool bad = v.above || v.missing || v.stale;
    if (bad || v.below)
        printf("%s:\n  cmake --build --preset ci --target guard-update\n",
               bad ? "If this is meant, rewrite the figures and commit them with the change that explains them"
                   : "An improvement; rewrite the figures, so that it cannot be lost again unseen");
    return bad ? EXIT_FAILURE : EXIT_SUCCESS;
}

static int update(const guard_figures *now, const char *path) {
    io_error error;
    io_output out = {0};
    const bool good =
        io_output_open(&out, path, &error) && guard_write(now, &out, &error) && io_output_commit(&out, &error);
    io_output_discard(&out);
    return good ? printf("%s is rewritten\n", path), EXIT_SUCCESS : fail(&error);
}

int main(int argc, char **argv) {
    const bool updates = argc == 4 && strcmp(argv[1], "update") == 0;
    if (argc != 4 || (!updates && strcmp(argv[1], "check") != 0)) {
        fputs(usage, stderr);
        return 2;
    }
    static guard_figures committed, now;
    io_error error;
    const bool first = updates && access(argv[3], F_OK) != 0;
    if (!first && !guard_read(&committed, argv[3], &error)) return fail(&error);
    snprintf(now.compiler, sizeof now.compiler, "%s", BUILD_INFO_COMPILER);
    snprintf(now.flags, sizeof now.flags, "%s", BUILD_INFO_FLAGS);
    if (!first && (strcmp(committed.compiler, now.compiler) != 0 || strcmp(committed.flags, now.flags) != 0)) {
        printf("The figures hold for %s with %s,\nthis build is by %s with %s.\n", committed.compiler, committed.flags,
               now.compiler, now.flags);
        if (!updates) return skip("another compiler or other flags make other code");
        printf("To take this build for the measure from now on, remove %s first.\n", argv[3]);
        return EXIT_FAILURE;
    }
    bool missing;
    if (!callgrind_run(&now.all, "guard", (const char *[]){argv[2], NULL}, NULL, &missing, &error))
        return missing ? skip(error.text) : fail(&error);
    return updates ? update(&now, argv[3]) : check(&committed, &now);
}
