/* SPDX-License-Identifier: Apache-2.0 */
/* Loops over many items, of which each is a function's of src/ground. */
#include "extension.h"

#include <math.h>

void suns_at(const sun_place *place, const double *times, size_t n, sun_position *suns) {
    for (size_t k = 0; k < n; k++) suns[k] = sun_place_at(place, times[k]);
}

void horizon_round(sight *s, const cw_horizon *h, place_horizon *out) {
    for (uint32_t k = 0; k < h->count; k++)
        out[k] = place_horizon_toward(s, fmod(h->start + 360.0 * (double)k / (double)h->count, 360), h->max_distance);
}

void line_rows(const line *l, double megahertz, const profile *p, line_row *rows) {
    for (size_t k = 0; k < p->count; k++) rows[k] = line_row_of(l, megahertz, &p->points[k]);
}

/* ---- clearances, on a pool ----------------------------------------------------------------------------------------------- */

typedef struct clearing {
    const terrain *terrain;
    work *work;
    const cw_sight *lines;
    size_t n;
    double curvature, megahertz;
    cw_sight_answer *answers;
    clearance *out;
    atomic_size_t done;
    atomic_bool failed;
} clearing;

static bool look_along(const clearing *c, size_t k, profile *p) {
    const cw_sight *s = &c->lines[k];
    const io_place ends[2] = {
        {.x = s->from[0], .y = s->from[1], .z = s->from[2], .absolute = (s->absolute & 1) != 0},
        {.x = s->to[0], .y = s->to[1], .z = s->to[2], .absolute = (s->absolute & 2) != 0},
    };
    cw_sight_answer *a = &c->answers[k];
    line l;
    *a = (cw_sight_answer){.blocked = {NAN, NAN, NAN}, .distance = NAN, .state = CW_SIGHT_NO_GROUND};
    if (!line_find(&l, c->terrain, ends, c->curvature, NULL)) return true;
    a->metres = l.length;
    a->state = l.blocked ? CW_SIGHT_BLOCKED : CW_SIGHT_SEEN;
    if (l.blocked) {
        a->distance = l.block_distance;
        a->blocked[0] = l.block[0];
        a->blocked[1] = l.block[1];
        a->blocked[2] = l.block_height;
    }
    if (!line_profile(&l, p, NULL)) return false;
    line_clearance(&l, c->megahertz, p, &c->out[k]);
    return true;
}

static void look_along_some(void *context, size_t begin, size_t end) {
    clearing *c = context;
    profile p = {0};
    for (; begin < end; begin++) {
        if (!look_along(c, begin, &p)) atomic_store(&c->failed, true);
        if (!work_watch(c->work, (double)(atomic_fetch_add(&c->done, 1) + 1) / (double)c->n)) break;
    }
    cw_profile_free(&p);
}

bool lines_clearance(const terrain *t, work *w, double curvature, double megahertz, const cw_sight *lines, size_t n,
                     cw_sight_answer *answers, clearance *out) {
    clearing c = {t, w, lines, n, curvature, megahertz, answers, out, 0, false};
    cw_pool_run(w->run.pool, n, 64, look_along_some, &c);
    return !atomic_load(&c.failed);
}
