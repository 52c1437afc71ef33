/* SPDX-License-Identifier: Apache-2.0 */
/* Ctrl-C: the first asks the program to stop and clean up, and ends it where that takes longer than a moment: reading,
 * building and slow kernels do not look whether they are asked. The second ends it at once. No output is left either way. */
#ifndef CELLWALK_TOOL_CANCEL_H
#define CELLWALK_TOOL_CANCEL_H

#include <stdatomic.h>
#include <stdbool.h>

/* Handles SIGINT, SIGTERM and SIGHUP from now on, and turns signals that would kill the program (a file size
 * limit, a reader that goes away) into errors. */
void cancel_install(void);

/* Turns true with the first signal and stays so. */
const atomic_bool *cancel_flag(void);

/* The line of progress, and whether the work is to go on: the tell of a ground_watch. Without a step there is no line. */
bool cancel_tell(void *unused, const char *step, double share);

/* Ends the program by the signal that was caught, so that a shell script which runs it also stops. Returns if none
 * was caught. */
void cancel_finish(void);

#endif
