/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"
#include "extension.h"

/* Seconds between two looks for signals. */
static const double look_after = 0.05;

/* Its address tells threads apart. */
static _Thread_local char here;

void work_begin(work *w) {
    w->run.watch = work_watch;
    w->run.watch_context = w;
    w->caller = &here;
    w->share = 1;
    w->next = clock_seconds() + look_after;
}

bool work_watch(void *context, double done) {
    work *w = context;
    if (atomic_load_explicit(&w->stopped, memory_order_relaxed)) return false;
    if (w->caller != &here || clock_seconds() < w->next) return true;
    const bool good = python_watch(w, w->begin + w->share * done);
    if (!good) atomic_store(&w->stopped, true);
    w->next = clock_seconds() + look_after;
    return good;
}

void drop_pool(cw_pool **pool) { cw_pool_destroy(*pool); }
void drop_field(cw_field **field) { cw_field_destroy(*field); }
void drop_bounds(sight_bounds **bounds) { cw_sight_bounds_destroy(*bounds); }
void drop_insolation(insolation **sum) { cw_insolation_destroy(*sum); }
void drop_samples(float *memory) { io_raster_free(&(io_raster){.memory = memory}); }
