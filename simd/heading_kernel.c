/* SPDX-License-Identifier: Apache-2.0 */
/* Rays of one heading, from 16 × 4 samples at a time. All of them cross the same borders at the same fractions
 * (src/core/heading.h), so loads are of neighbours and everything else is the same for all lanes. We know of no
 * paper.
 *
 * The walk goes from the start outward. It skips a stretch if the highest sample near it, seen from the nearest of
 * its crossings (the farthest if that sample is below the start), would not be steeper than each ray's steepest
 * slope so far.
 *
 * Invariant: skipping never changes an answer, since the computed height between two samples exceeds the higher one
 * by at most job->pad. So the answer is the maximum over all crossings, for any width. On a curved earth each
 * crossing is less steep by its drop, and a stretch by the least drop in it. Subtracting more never gives more, also
 * after rounding.
 *
 * Rejected: rays of other kernels, by bisection of the angle, of which a horizon would need a dozen for each
 * direction. */

#include "vocabulary.h"

#include "heading.h"

#include <math.h>

enum { VECTORS = GROUP_SAMPLES / (int)W, AT_ONCE = 4, PROBES = 4 };

typedef struct group {
    const cw_heading *heading;
    int32_t i, j;              /* of the first sample */
    float z[GROUP_SAMPLES];    /* heights at which the rays start; infinity: no ray */
    float best[GROUP_SAMPLES]; /* the steepest slope so far */
    float pad;                 /* of the job */
    float least;               /* lower bound of the answers: slopes up to it count as it */
    float enough;              /* slopes above it need not be compared further */
    int32_t found[PROBES]; /* stretches of level 0 in which some rays of the group before saw their steepest slope */
} group;

typedef enum reach { INSIDE, PARTLY, OUTSIDE } reach;

/* Whether all, some or none of the samples of a stretch lie inside the field, for the whole group. */
static inline reach stretch_reach(const group *g, const cw_stretch *s) {
    const int32_t nx = (int32_t)g->heading->field->nx, ny = (int32_t)g->heading->field->ny;
    const int32_t left = g->i + s->i_low, right = g->i + s->i_high, top = g->j + s->j_low, bottom = g->j + s->j_high;
    const int32_t across = GROUP_COLUMNS - 1, down = GROUP_ROWS - 1;
    if (left >= 0 && right + across < nx && top >= 0 && bottom + down < ny) return INSIDE;
    return left >= nx || right + across < 0 || top >= ny || bottom + down < 0 ? OUTSIDE : PARTLY;
}

/* The highest sample that the group may meet on the stretch, or a higher one nearby; -infinity if there are none. */
static inline float stretch_high(const group *g, const cw_stretch *s, int level) {
    const cw_field *f = g->heading->field;
    if (level >= f->pyramid->levels) return f->high;
    const cw_pyramid_level *l = &f->pyramid->level[level];
    const int shift = 2 * level + 2;
    const int32_t last_i = (int32_t)f->nx - 1, last_j = (int32_t)f->ny - 1;
    int32_t left = g->i + s->i_low, right = g->i + s->i_high + GROUP_COLUMNS - 1;
    int32_t top = g->j + s->j_low, bottom = g->j + s->j_high + GROUP_ROWS - 1;
    left = left > 0 ? left : 0;
    top = top > 0 ? top : 0;
    right = right < last_i ? right : last_i;
    bottom = bottom < last_j ? bottom : last_j;
    if (left > right) return -INFINITY; /* a stretch without crossings */
    /* Two by two nodes: a stretch and the group's four rows reach into three at most, its 16 columns into more at level
     * 0. A sample on the border of two nodes belongs to both, so the first of them is enough. */
    const int32_t last_x = (right > left ? right - 1 : right) >> shift;
    const int32_t y = top >> shift, last_y = (bottom > top ? bottom - 1 : bottom) >> shift;
    const ptrdiff_t in_row = 4 * (ptrdiff_t)l->across + 1;
    const float *first_row = l->ahead + (y < last_y ? y + 1 : y) * in_row, *last_row = l->ahead + last_y * in_row;
    float high = -INFINITY;
    for (int32_t x = left >> shift; x <= last_x; x += 2) {
        const int32_t k = x < last_x ? x + 1 : x;
        high = higher(first_row[k], higher(last_row[k], high));
    }
    return high;
}

/* True if no ray of the group can find a steeper slope on the stretch than it has. */
static inline bool stretch_is_low(const group *g, const cw_stretch *s, int level) {
    const vfloat high = vf_set(stretch_high(g, s, level)), pad = vf_set(g->pad);
    const vfloat near = vf_set(s->inverse_most), far = vf_set(s->inverse_least);
    const vfloat drop = vf_set(s->drop);
    for (int k = 0; k < GROUP_SAMPLES; k += (int)W) {
        /* At the height of the start, as on a lake, rounding puts nothing above it: if a <= b <= z, then b - a,
         * rounded, is at most z - a, rounded, and a fraction of it at most that. */
        const vfloat exact = vf_sub(high, vf_load(g->z + k));
        const vfloat up = vf_select(vf_eq(exact, vf_set(0)), exact, vf_add(exact, pad));
        const vfloat most = vf_sub(vf_max(vf_mul(up, near), vf_mul(up, far)), drop);
        if (vm_any(vm_not(vf_le(most, vf_load(g->best + k))))) return false;
    }
    return true;
}

/* drop: that of the crossing, if the earth is curved. */
static inline vfloat slope_up(const cw_crossing *c, vfloat z, vfloat first, vfloat second, const float *drop) {
    const vfloat step = vf_mul(vf_set(c->fraction), vf_sub(second, first));
    const vfloat up = vf_mul(vf_add(vf_sub(first, z), step), vf_set(c->inverse));
    return drop ? vf_sub(up, vf_set(*drop)) : up;
}

/* Scans the crossings from `from` to before `end`. All of them are inside the field for all rays. */
CW_INLINE void scan(group *g, const cw_crossing *from, const cw_crossing *end, bool curved) {
    const cw_heading *h = g->heading;
    const size_t stride = g->heading->field->stride;
    const float *start = g->heading->field->z + (size_t)g->j * stride + (size_t)g->i;
    for (int k = 0; k < VECTORS; k += AT_ONCE) {
        vfloat z[AT_ONCE], best[AT_ONCE];
        ptrdiff_t place[AT_ONCE];
        for (int m = 0; m < AT_ONCE; m++) {
            const int lane = (k + m) * (int)W;
            z[m] = vf_load(g->z + lane);
            best[m] = vf_load(g->best + lane);
            place[m] = lane / GROUP_COLUMNS * (ptrdiff_t)stride + lane % GROUP_COLUMNS;
        }
        for (const cw_crossing *c = from; c < end; c++) {
            const float *a = start + (ptrdiff_t)c->j * (ptrdiff_t)stride + (c->i_kind >> 2);
            const float *b = a + (c->i_kind & 1) + (c->i_kind >> 1 & 1) * (ptrdiff_t)stride; /* the second sample */
            for (int m = 0; m < AT_ONCE; m++)
                best[m] = vf_max(slope_up(c, z[m], vf_load(a + place[m]), vf_load(b + place[m]),
                                          curved ? h->drop + (c - h->crossing) : NULL),
                                 best[m]);
        }
        for (int m = 0; m < AT_ONCE; m++) vf_store(g->best + (k + m) * (int)W, best[m]);
    }
}

/* W samples of row j from column i on, outside it any numbers. Gaps between rows belong to others and are not read. */
static inline vfloat load_around(const cw_field *f, int32_t j, int32_t i) {
    const ptrdiff_t gaps = (ptrdiff_t)(f->stride - f->nx), nx = (ptrdiff_t)f->nx,
                    end = gaps ? nx : nx * ((ptrdiff_t)f->ny - j);
    const float *row = f->z + (size_t)j * f->stride;
    if (i >= (gaps ? 0 : -j * nx) && i + (ptrdiff_t)W <= end) return vf_load(row + i);
    float z[W];
    for (int32_t m = 0; m < (int32_t)W; m++) z[m] = i + m >= 0 && i + m < nx ? row[i + m] : 0;
    return vf_load(z);
}

/* The same as scan, without crossings outside the field. */
static void scan_partly(group *g, const cw_crossing *from, const cw_crossing *end) {
    const cw_heading *h = g->heading;
    const cw_field *f = g->heading->field;
    float columns[W];
    for (unsigned m = 0; m < W; m++) columns[m] = (float)m;
    const vfloat column = vf_load(columns), none = vf_set(-INFINITY);
    for (int k = 0; k < GROUP_SAMPLES; k += (int)W) {
        const vfloat z = vf_load(g->z + k);
        vfloat best = vf_load(g->best + k);
        const int32_t i0 = g->i + k % GROUP_COLUMNS, j0 = g->j + k / GROUP_COLUMNS;
        for (const cw_crossing *c = from; c < end; c++) {
            const int32_t i = i0 + (c->i_kind >> 2), j = j0 + c->j;
            if (j < 0 || j + (c->i_kind >> 1 & 1) >= (int32_t)f->ny) continue;
            /* Lanes from the first whose first sample lies in the row to the last whose second one does. */
            const vfloat low = vf_set((float)-i), high = vf_set((float)((int32_t)f->nx - 1 - (c->i_kind & 1) - i));
            const vmask inside = vm_and(vf_ge(column, low), vf_le(column, high));
            if (!vm_any(inside)) continue;
            const vfloat first = load_around(f, j, i),
                         second = load_around(f, j + (c->i_kind >> 1 & 1), i + (c->i_kind & 1));
            const vfloat up = slope_up(c, z, first, second, h->drop ? h->drop + (c - h->crossing) : NULL);
            best = vf_max(vf_select(inside, up, none), best);
        }
        vf_store(g->best + k, best);
    }
}

static inline void scan_stretch(group *g, uint32_t number, reach r) {
    const cw_stretch *s = &g->heading->stretch[0][number];
    const cw_crossing *from = g->heading->crossing + s[0].first, *end = g->heading->crossing + s[1].first;
    if (r != INSIDE)
        scan_partly(g, from, end);
    else if (g->heading->drop != NULL)
        scan(g, from, end, true);
    else
        scan(g, from, end, false);
}

/* Excludes rays steeper than enough from further comparisons; true if no others are left. */
static inline bool all_settled(group *g) {
    const vfloat enough = vf_set(g->enough), settled = vf_set(INFINITY);
    bool all = true;
    for (int k = 0; k < GROUP_SAMPLES; k += (int)W) {
        const vfloat best = vf_load(g->best + k);
        const vmask done = vf_gt(best, enough);
        all = all && !vm_any(vm_not(done));
        vf_store(g->best + k, vf_select(done, settled, best));
    }
    return all;
}

/* Remembers the stretch for each probe ray that improved on it: its neighbours are likely to improve there too. */
static inline void remember(group *g, const float before[PROBES], uint32_t number, int32_t found[PROBES]) {
    for (int p = 0; p < PROBES; p++)
        if (g->best[p * (GROUP_SAMPLES / PROBES + 1)] > before[p]) found[p] = (int32_t)number;
}

static inline void probe(const group *g, float best[PROBES]) {
    for (int p = 0; p < PROBES; p++) best[p] = g->best[p * (GROUP_SAMPLES / PROBES + 1)];
}

/* True if the stretch was scanned before the walk began. */
static inline bool is_done(const int32_t done[PROBES], uint32_t number) {
    for (int p = 0; p < PROBES; p++)
        if (done[p] == (int32_t)number) return true;
    return false;
}

static inline void walk(group *g, bool guess, bool ends) {
    const cw_heading *h = g->heading;
    int32_t done[PROBES], found[PROBES];
    float before[PROBES];
    for (int p = 0; p < PROBES; p++) done[p] = found[p] = -1;
    /* Stretches that were steepest for the group before are likely to be steep for this one. Scanned first, they let
     * the walk skip more. */
    for (int p = 0; p < PROBES && guess; p++) {
        const int32_t number = g->found[p];
        if (number < 0 || is_done(done, (uint32_t)number)) continue;
        if (stretch_reach(g, &h->stretch[0][number]) != INSIDE) continue;
        probe(g, before);
        scan_stretch(g, (uint32_t)number, INSIDE);
        remember(g, before, (uint32_t)number, found);
        done[p] = number;
    }
    int level = 0;
    for (uint32_t u = 0; u < h->stretches[0];) {
        const uint32_t length = (uint32_t)1 << 2 * level;
        const cw_stretch *s = &h->stretch[level][u >> 2 * level];
        const reach r = stretch_reach(g, s);
        if (r == OUTSIDE) break;
        if (stretch_is_low(g, s, level)) {
            u += length;
            if (level + 1 < h->levels && u % (length << 2) == 0) level++;
            continue;
        }
        if (level > 0) {
            level--;
            continue;
        }
        if (!is_done(done, u)) {
            probe(g, before);
            scan_stretch(g, u, r);
            if (ends && all_settled(g)) break;
            remember(g, before, u, found);
        }
        u++;
        if (h->levels > 1 && u % 4 == 0) level = 1;
    }
    for (int p = 0; p < PROBES; p++) g->found[p] = found[p];
}

/* Sets the group to the samples from (i, j) on. Lanes outside the field count as holes. */
static inline void start(group *g, int32_t i, int32_t j, bool ends) {
    const cw_field *f = g->heading->field;
    const vfloat none = vf_set(INFINITY), least = vf_set(g->least);
    g->i = i;
    g->j = j;
    const bool inside = (size_t)i + GROUP_COLUMNS <= f->nx && (size_t)j + GROUP_ROWS <= f->ny;
    for (int k = 0; k < GROUP_SAMPLES && !inside; k++) {
        const size_t x = (size_t)(i + k % GROUP_COLUMNS), y = (size_t)(j + k / GROUP_COLUMNS);
        g->z[k] = x < f->nx && y < f->ny ? f->z[y * f->stride + x] : NAN;
    }
    for (int k = 0; k < GROUP_SAMPLES; k += (int)W) {
        const size_t at = (size_t)(j + k / GROUP_COLUMNS) * f->stride + (size_t)(i + k % GROUP_COLUMNS);
        const vfloat z = vf_load(inside ? f->z + at : g->z + k);
        const vmask some = vf_eq(z, z);
        vf_store(g->z + k, vf_select(some, z, none));
        vf_store(g->best + k, ends ? vf_select(some, least, none) : least);
    }
}

/* Writes the answers for samples from (i0, j0) up to (i1, j1). */
static inline void finish(const group *g, const cw_heading_job *job, size_t i0, size_t i1, size_t j0, size_t j1,
                          bool any) {
    for (size_t j = j0; j < j1; j++) {
        const size_t k = (j - (size_t)g->j) * GROUP_COLUMNS + (i0 - (size_t)g->i), n = i1 - i0;
        const size_t to = (j - job->j) * job->nx + (i0 - job->i);
        const float *restrict z = g->z + k, *restrict best = g->best + k;
        if (any)
            for (size_t m = 0; m < n; m++) job->occluded[to + m] = (z[m] < INFINITY) & (best[m] > g->enough);
        else
            for (size_t m = 0; m < n; m++)
                job->steepest[to + m] = z[m] < INFINITY ? (best[m] < job->high ? best[m] : job->high) : NAN;
    }
}

/* cw_heading1, cw_heading4, cw_heading8 or cw_heading16. Rejected: a copy of the walk for each kind of query, which is
 * three times the text and no faster. */
void CW_CODE(heading)(const cw_heading_job *job, size_t i_begin, size_t i_end, size_t j_begin, size_t j_end) {
    const bool any = job->occluded != NULL, ends = any || job->high < INFINITY;
    const cw_heading *h = job->heading;
    const size_t nx = h->field->nx, ny = h->field->ny;
    group g = {.heading = h, .pad = job->pad, .least = job->low, .enough = job->high};
    if (any) g.least = g.enough = nextafterf(job->high, -INFINITY); /* as steep as that is a hit */
    for (int p = 0; p < PROBES; p++) g.found[p] = -1;
    for (size_t j = j_begin; j < j_end; j += GROUP_ROWS)
        for (size_t i = i_begin; i < i_end; i += GROUP_COLUMNS) {
            const size_t i_next = i + GROUP_COLUMNS < i_end ? i + GROUP_COLUMNS : i_end;
            const size_t j_next = j + GROUP_ROWS < j_end ? j + GROUP_ROWS : j_end;
            /* At the far borders the group moves back if the field is large enough, so that all its rays start
             * inside. */
            const size_t i_from = i + GROUP_COLUMNS <= nx || nx < GROUP_COLUMNS ? i : nx - GROUP_COLUMNS;
            const size_t j_from = j + GROUP_ROWS <= ny || ny < GROUP_ROWS ? j : ny - GROUP_ROWS;
            start(&g, (int32_t)i_from, (int32_t)j_from, ends);
            walk(&g, !any, ends);
            finish(&g, job, i, i_next, j, j_next, any);
        }
}
