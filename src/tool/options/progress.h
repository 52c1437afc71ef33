/* SPDX-License-Identifier: Apache-2.0 */
/* The line on the terminal that says how far a long run is. Where standard error is no terminal nothing is printed. */
#ifndef CELLWALK_OPTIONS_PROGRESS_H
#define CELLWALK_OPTIONS_PROGRESS_H

#include <stdbool.h>

/* step, "tracing", must stay; another one begins a new line. share is in [0, 1]. Prints at most ten times a second, and not in a run
 * that is over at once. Calls must not overlap. */
void progress_show(const char *step, double share);

/* Removes the line. Messages (command.h) do so themselves; to be called before anything is printed to standard output. */
void progress_end(void);

/* Whether there is a line. For signal handlers. */
bool progress_is_shown(void);

#endif
