/* SPDX-License-Identifier: Apache-2.0 */
/* Calls functions of src/ground for each item of an array. */
#include "extension.h"

void suns_at(const sun_place *place, const double *times, size_t n, sun_position *suns) {
    for (size_t k = 0; k < n; k++) suns[k] = cw_sun_at_place(times[k], place);
}

void line_rows(const line *l, double megahertz, const profile *p, line_row *rows) {
    for (size_t k = 0; k < p->count; k++) rows[k] = line_row_of(l, megahertz, &p->points[k]);
}

typedef struct clearing {
    const terrain *terrain;
    work *work;
    const cw_sight *lines;
    size_t n;
    double curvature, megahertz;
    clearance *out;
    atomic_size_t done;
    atomic_bool failed;
} clearing;

static bool clear_along(const clearing *c, size_t k, profile *p) {
    const cw_sight *s = &c->lines[k];
    const io_place ends[2] = {
        {.x = s->from[0], .y = s->from[1], .z = s->from[2], .absolute = (s->absolute & 1) != 0},
        {.x = s->to[0], .y = s->to[1], .z = s->to[2], .absolute = (s->absolute & 2) != 0},
    };
    line l;
    if (!line_find(&l, c->terrain, ends, c->curvature, NULL)) return true;
    if (!line_profile(&l, p, NULL)) return false;
    line_clearance(&l, c->megahertz, p, &c->out[k]);
    return true;
}

static void clear_along_some(void *context, size_t begin, size_t end) {
    clearing *c = context;
    profile p = {0};
    for (; begin < end; begin++) {
        if (!clear_along(c, begin, &p)) atomic_store(&c->failed, true);
        if (!work_watch(c->work, (double)(atomic_fetch_add(&c->done, 1) + 1) / (double)c->n)) break;
    }
    cw_profile_free(&p);
}

bool lines_clearance(const terrain *t, work *w, double curvature, double megahertz, const cw_sight *lines, size_t n,
                     clearance *out) {
    clearing c = {t, w, lines, n, curvature, megahertz, out, 0, false};
    cw_pool_run(w->run.pool, n, 64, clear_along_some, &c);
    return !atomic_load(&c.failed);
}
