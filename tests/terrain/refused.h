/* SPDX-License-Identifier: Apache-2.0 */
/* What the program refuses: its exit status, its words, and that it leaves nothing behind. */
#ifndef CELLWALK_TESTS_TERRAIN_REFUSED_H
#define CELLWALK_TESTS_TERRAIN_REFUSED_H

#include "check.h"
#include "program.h"
#include "scratch.h"

#include <string.h>

static inline void check_refused(program_arguments arguments, int status, const char *part) {
    const size_t entries = scratch_entries();
    const program_result *r = program_run(NULL, arguments);
    check(r->status == status, "exit status %d instead of %d: %s", r->status, status, r->err);
    check(strstr(r->err, part) != NULL, "'%s' is not in '%s'", part, r->err);
    assert_int_equal(scratch_entries(), entries);
}

#endif
