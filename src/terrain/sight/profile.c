/* SPDX-License-Identifier: Apache-2.0 */
#include "profile.h"

#include "error.h"
#include "fpenv.h"
#include "way.h"

#include <stdlib.h>

static bool put(profile *p, double share, double ground) {
    if (p->count == p->room) {
        const size_t room = p->room ? 2 * p->room : 256;
        profile_point *points = realloc(p->points, room * sizeof *points);
        if (points == NULL) return false;
        p->points = points;
        p->room = room;
    }
    p->points[p->count++] = (profile_point){.share = share, .ground = ground};
    return true;
}

/* A part of the way by its shares. A crossing at the border of two parts is in both. */
typedef struct part {
    profile *to;
    double first, last;
    bool failed;
} part;

static bool put_crossing(void *context, const crossing *c) {
    part *p = context;
    /* The way's ends are left out. */
    if (!(c->share > 0 && c->share >= p->first && c->share <= p->last)) return false;
    const double ground = c->height + (c->way->sight->eye[2] + c->share * c->share * c->way->fall);
    return p->failed = !put(p->to, c->share, isfinite(ground) ? ground : NAN);
}

static int compare(const void *a, const void *b) {
    const profile_point *x = a, *y = b;
    if (x->share != y->share) return x->share < y->share ? -1 : 1;
    return isnan(x->ground) - isnan(y->ground);
}

/* Lines that meet in a sample are crossed there by shares that differ by rounding: one of them stays, if possible one
 * with ground. */
static void drop_doubles(profile *p) {
    const double same = 4 * way_share_error;
    size_t kept = 0;
    for (size_t k = 0; k < p->count; k++) {
        profile_point *last = kept > 0 ? &p->points[kept - 1] : NULL;
        if (last && p->points[k].share - last->share <= same) {
            if (isnan(last->ground)) last->ground = p->points[k].ground;
            if (p->points[k].share == 1) last->share = 1;
            continue;
        }
        p->points[kept++] = p->points[k];
    }
    p->count = kept;
}

cw_status cw_profile_add(profile *p, const sight *s, double i, double j, double z, double first, double last) {
    const terrain *t = s->terrain;
    way w = way_to(s, i, j, z, 0);
    w.gaps = true;
    part some = {.to = p, .first = first - 2 * way_share_error, .last = last + 2 * way_share_error};
    bool good = first > 0 || put(p, 0, cw_terrain_level(t, s->eye[0], s->eye[1]));
    if (good && w.length > 0) {
        look_between(&w, 1 - some.last, 1 - some.first, put_crossing, &some);
        good = !some.failed && (last < 1 || put(p, 1, cw_terrain_level(t, i, j)));
    }
    return good ? CW_OK : cw_fail_plainly(CW_ERROR_MEMORY);
}

cw_status cw_profile_make(profile *p, const sight *s, double i, double j, double z) {
    FPENV_HERE;
    p->count = 0;
    const cw_status status = cw_profile_add(p, s, i, j, z, 0, 1);
    if (status == CW_OK) cw_profile_finish(p, s, i, j, z);
    return status;
}

void cw_profile_finish(profile *p, const sight *s, double i, double j, double z) {
    const way w = way_to(s, i, j, z, 0);
    qsort(p->points, p->count, sizeof *p->points, compare);
    drop_doubles(p);
    double steepest = -INFINITY;
    for (size_t k = 0; k < p->count; k++) {
        profile_point *at = &p->points[k];
        const double fall = at->share * at->share * w.fall;
        at->line = s->eye[2] + at->share * w.top + fall;
        if (k == 0) {
            at->seen = !isnan(at->ground); /* the eye's own place */
            continue;
        }
        const double rise = (at->ground - s->eye[2] - fall) / at->share;
        at->seen = rise > steepest;
        if (at->seen) steepest = rise;
    }
}

void cw_profile_free(profile *p) {
    free(p->points);
    *p = (profile){0};
}
