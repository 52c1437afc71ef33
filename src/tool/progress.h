/* SPDX-License-Identifier: Apache-2.0 */
/* A line on the terminal that says how far a long run is. Where standard error is no terminal nothing is printed. */
#ifndef CELLWALK_TOOL_PROGRESS_H
#define CELLWALK_TOOL_PROGRESS_H

#include <stdbool.h>

typedef struct progress {
    const char *what;   /* "tracing" */
    double start, last; /* seconds on the monotonic clock */
    bool terminal;
    bool shown;
} progress;

progress progress_start(const char *what);

/* share is in [0, 1]. context is a progress; prints at most ten times a second, and not in a run that is over at once.
 * Calls must not overlap. */
void progress_update(void *context, double share);

/* Removes the line. To be called before anything else is printed. */
void progress_end(progress *p);

#endif
