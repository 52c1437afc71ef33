/* SPDX-License-Identifier: Apache-2.0 */
/* What cffi binds to Python: the libraries' functions, which bind.py finds in the headers below, and what C does for
 * Python beside them: the watch of a call, and loops over many items. No file here uses Python's interface. cffi
 * releases the GIL around each call. Python checks arrays, which have room for all that is written. */
#ifndef CELLWALK_PYTHON_EXTENSION_H
#define CELLWALK_PYTHON_EXTENSION_H

#include "insolation.h"
#include "line.h"
#include "raster_out.h"
#include "sun_day.h"
#include "suns.h"

#include <cellwalk_expert.h>
#include <stdatomic.h>

/* ---- the watch of a call ----------------------------------------------------------------------------------------- */

typedef struct work {
    cw_run run;          /* with this watch; pool and kernel are Python's choice */
    void *python;        /* Python's handle */
    const void *caller;  /* what only the calling thread has */
    double next;         /* when python_watch is called again, by the clock */
    double begin, share; /* the part of all work that is being done */
    atomic_bool stopped; /* python_watch has returned false */
} work;

/* By the thread that calls the libraries with w->run. python, pool and kernel are set, all else is 0. */
void work_begin(work *w);

/* A cw_watch_fn: context is the work. Threads other than the caller's only read whether the work is stopped, since
 * Python handles signals on its own threads. */
bool work_watch(void *context, double done);

/* In Python; context is the work. The first handles signals and tells progress; false: an exception is kept. */
bool python_watch(void *context, double share);
void python_warn(void *context, const char *text);

/* Destructors for cffi's owners. Written in C: Python drops Ctrl-C in destructors. */
void drop_pool(cw_pool **pool);
void drop_field(cw_field **field);
void drop_bounds(sight_bounds **bounds);
void drop_insolation(insolation **sum);
void drop_samples(float *memory); /* of an io_raster */

/* ---- loops ------------------------------------------------------------------------------------------------------- */

/* n rays from arrays of any layout: number k of an operand is at + k * step bytes; step 0 is one for all. */
enum { RAYS_ORIGIN, RAYS_DIRECTION, RAYS_TMIN, RAYS_TMAX, RAYS_OPERANDS };
typedef struct rays {
    uintptr_t at[RAYS_OPERANDS];
    ptrdiff_t step[RAYS_OPERANDS];
    size_t n;
    bool wide; /* operands are double, else float */
    bool user; /* rays go to the library in user space, as doubles; else as they are, user space being field space */
} rays;

/* A hit for each, or where hits is NULL a byte. */
cw_status rays_trace(const rays *r, const cw_field *field, work *w, cw_hit *hits, uint8_t *any);

/* Places of the sun at so many times. */
void suns_at(const sun_place *place, const double *times, size_t n, sun_position *suns);

/* Clearances of radio links. A line whose ends have no ground keeps its entry. False if memory is short. */
bool lines_clearance(const terrain *t, work *w, double curvature, double megahertz, const cw_sight *lines, size_t n,
                     clearance *out);

/* A row for each point. */
void line_rows(const line *l, double megahertz, const profile *p, line_row *rows);

#endif
