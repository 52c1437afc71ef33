/* SPDX-License-Identifier: Apache-2.0 */
/* Runs a workload under callgrind, which counts inside its function guard_trace alone, a part each time that it returns. */
#ifndef CELLWALK_BENCH_INSTRUCTIONS_CALLGRIND_H
#define CELLWALK_BENCH_INSTRUCTIONS_CALLGRIND_H

/* options: of callgrind, ending with NULL, at most 4; or NULL for none. workload: the program and its arguments, ending
 * with NULL; at most 8. What it prints goes to the file runs, what it writes to standard error to the file errors unless
 * that is NULL, the counts to the file profile. The exit status; 127 if valgrind is not installed; -1 with errno if it
 * could not be started otherwise. */
int guard_callgrind(char *const *options, char *const *workload, const char *runs, const char *errors,
                    const char *profile);

#endif
