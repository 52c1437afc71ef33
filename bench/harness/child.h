/* SPDX-License-Identifier: Apache-2.0 */
/* Other programs, run to their end. */
#ifndef CELLWALK_BENCH_HARNESS_CHILD_H
#define CELLWALK_BENCH_HARNESS_CHILD_H

/* argv[0] is the program, looked for in PATH unless it has a slash. Its standard output goes to the file out, its output to
 * standard error to the file err; where they are NULL, to where this program's goes. Its exit status, or 128 and the number of
 * the signal that ended it; 127 if there is no such program; -1 with errno if it could not be started otherwise. */
int child_run(const char *const *argv, const char *out, const char *err);

#endif
