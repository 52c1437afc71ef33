/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include "clock.h"

#include <stdio.h>
#include <unistd.h>

progress progress_start(const char *what) {
    const double now = clock_seconds();
    return (progress){.what = what, .start = now, .last = now, .terminal = isatty(STDERR_FILENO) == 1};
}

void progress_update(void *context, double share) {
    progress *p = context;
    if (!p->terminal) return;
    const double now = clock_seconds();
    const double interval = p->shown ? 0.1 : 0.5;
    if (now - p->last < interval) return;
    p->last = now;
    p->shown = true;
    const double passed = now - p->start;
    /* "\r" goes to the line's start, "\033[K" clears the rest of the old text. */
    fprintf(stderr, "\r%s %3.0f %%", p->what, 100 * share);
    if (share > 0.01) fprintf(stderr, ", %.0f s left", passed / share - passed);
    fprintf(stderr, "\033[K");
    fflush(stderr);
}

void progress_end(progress *p) {
    if (!p->shown) return;
    fprintf(stderr, "\r\033[K");
    fflush(stderr);
    p->shown = false;
}
