/* SPDX-License-Identifier: Apache-2.0 */
/* Runs that end without a result, by an error or by Ctrl-C: the exit status, the words, and that nothing remains. */
#ifndef CELLWALK_TESTS_TERRAIN_REFUSED_H
#define CELLWALK_TESTS_TERRAIN_REFUSED_H

#include "check.h"
#include "program.h"
#include "scratch.h"

#include <signal.h>
#include <string.h>

static inline void check_refused(program_arguments arguments, int status, const char *part) {
    const size_t entries = scratch_entries();
    const program_result *r = program_run(NULL, arguments);
    check(r->status == status, "exit status %d instead of %d: %s", r->status, status, r->err);
    check(strstr(r->err, part) != NULL, "'%s' is not in '%s'", part, r->err);
    assert_int_equal(scratch_entries(), entries);
}

/* Ctrl-C in a long run, once its first input, a .npy file, has been read; writes: and its output is open. */
static inline void check_interrupted(program_arguments arguments, bool writes) {
    const size_t entries = scratch_entries();
    const pid_t process = program_start(NULL, arguments);
    program_wait_until_read(process, arguments[1]);
    if (writes) program_wait_for_output(process);
    kill(process, SIGINT);
    const program_result *r = program_wait(process);
    check(r->status == 128 + SIGINT, "exit status %d: %s", r->status, r->err);
    assert_int_equal(scratch_entries(), entries);
}

#endif
