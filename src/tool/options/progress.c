/* SPDX-License-Identifier: Apache-2.0 */
#include "progress.h"

#include "clock.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static struct {
    const char *step;   /* NULL: there is no line */
    double start, last; /* seconds on the monotonic clock */
    volatile sig_atomic_t shown;
} line;

bool progress_is_shown(void) { return line.shown; }

void progress_show(const char *step, double share) {
    const double now = clock_seconds();
    if (line.step == NULL || strcmp(line.step, step) != 0) {
        progress_end();
        line.step = step;
        line.start = line.last = now;
    }
    if (now - line.last < (line.shown ? 0.1 : 0.5)) return;
    line.last = now;
    if (isatty(STDERR_FILENO) != 1) return;
    line.shown = true;
    const double passed = now - line.start;
    /* "\r" goes to the line's start, "\033[K" clears the rest of the old text. */
    fprintf(stderr, "\r%s %3.0f %%", step, 100 * share);
    if (share > 0.01) fprintf(stderr, ", %.0f s left", passed / share - passed);
    fprintf(stderr, "\033[K");
    fflush(stderr);
}

void progress_end(void) {
    if (line.shown) fprintf(stderr, "\r\033[K");
    fflush(stderr);
    line.step = NULL;
    line.shown = false;
}
