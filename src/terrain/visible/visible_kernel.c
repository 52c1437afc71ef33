/* SPDX-License-Identifier: Apache-2.0 */
/* The ground in sight along one direction, from LANES samples at a time (visible_job.h).
 *
 * The walk goes outward and keeps the steepest slope so far. Between two crossings the surface is straight, so the
 * slope up to it from the eye is monotone: of a piece, all, nothing, or one part with an end is in sight. That end is
 * where the piece meets the line of sight over the steepest place before.
 *
 * Invariant: blocks of rows are passed over only if no slope in them, as this code rounds it, exceeds the steepest one
 * of any lane, or if they are level and all of them is in sight. Then the walk would add nothing there, or just as
 * much. So the answers do not depend on width, nor on how blocks lie. papers/numerics.md derives the bounds.
 *
 * Some lane of 16 sees most of the pieces that are scanned, so 16 lanes take no branch around the others: it would be
 * mispredicted too often. Rejected: sums of squared distances where sight begins and ends, which need fewer divisions
 * but are slower, and level blocks of 64 rows, which slow the tests of all blocks down (papers/terrain.md). */

#include "vocabulary.h"

#include "visible_job.h"

#include <math.h>

typedef struct lanes {
    vfloat z;        /* of the eyes */
    vfloat slope;    /* up to the target at the last crossing; NaN: there is no edge */
    vfloat steepest; /* up to the ground, so far */
    vfloat low;      /* KEEPS_LOW: steepest less slope as the last crossing found them, times its distance */
    vdouble area;
    vint more; /* what is to be added to area, in units of the present run of crossings */
    const visible_run *run;
    vfloat farthest;
} lanes;

/* The ground's height over the eye at a crossing. */
CW_INLINE vfloat height_over(const visible_crossing *c, const float *eye, vfloat z) {
    const vfloat a = vf_load(eye + c->first), b = vf_load(eye + c->first + c->second);
    return vf_add(vf_sub(a, z), vf_mul(vf_set(c->fraction), vf_sub(b, a)));
}

/* A flat earth's drop is 0, which changes no bit. */
CW_INLINE vfloat slope_to(const visible_crossing *c, vfloat height) {
    return vf_sub(vf_mul(height, vf_set(c->inverse)), vf_set(c->drop));
}

/* Adds what is in sight of a piece: from share of its length before its end (late) or after its begin. Areas are
 * negated and subtracted: a difference whose second part is in memory takes an instruction less. */
CW_INLINE void add_seen(const visible_job *job, lanes *l, const visible_piece *p, vmask seen, vmask late, vfloat share,
                        unsigned look, bool cut) {
    const vfloat part = vf_mul(vf_set(p->length), share), end = vf_set(p->end);
    vfloat last = end, negated = vf_mul(part, vf_sub(part, vf_set(p->twice)));
    if ((look & VISIBLE_TARGET) || cut) {
        const visible_run *run = l->run;
        const vfloat begin = vf_set(p->begin), large = vf_mul(begin, vf_set(run->scale)),
                     length = vf_mul(part, vf_set(run->inverse));
        const vfloat from_begin = vf_mul(vf_sub(vf_set(0), part), vf_add(vf_add(large, large), part));
        negated = vf_select(late, negated, from_begin);
        last = vf_select(late, end, vf_add(begin, length));
        if (cut) { /* what lies beyond the reach does not count */
            const vfloat first = vf_select(late, vf_sub(end, length), begin), scale = vf_set(run->scale);
            last = vf_min(last, vf_set(job->reach));
            seen = vm_and(seen, vf_lt(first, last));
            negated = vf_mul(vf_mul(vf_sub(first, last), scale), vf_mul(vf_add(last, first), scale));
        }
    }
    if (look & VISIBLE_AREA) l->more = vi_sub(l->more, vi_from_vf(vf_select(seen, negated, vf_set(0))));
    if (look & VISIBLE_FARTHEST) l->farthest = vf_select(seen, last, l->farthest);
}

/* Converting each area to double is slow (papers/terrain.md), and float sums depend on order. So areas are summed as
 * integers over a run of crossings, and runs in double, exactly (papers/numerics.md). Runs count from the eye. */
CW_INLINE void add_run(lanes *l) {
    const vint high = vi_and(l->more, vi_set(0x7fff0000)), low = vi_and(l->more, vi_set(0xffff)); /* are floats */
    const vdouble sum = vd_add(vd_from_vf(vf_from_vi(high)), vd_from_vf(vf_from_vi(low)));
    l->area = vd_add(l->area, vd_mul(sum, vd_set(l->run->unit)));
}

/* Makes the piece's run the present one. */
CW_INLINE void enter_run(lanes *l, size_t piece, unsigned look) {
    if (piece < l->run->until) return;
    if (look & VISIBLE_AREA) add_run(l);
    l->more = vi_set(0);
    while (piece >= l->run->until) l->run++;
}

/* Where a piece comes into sight part of the way, its begin was below the line of sight by just as much as the end of
 * the piece before. Where no branch leaves pieces out, that number is kept and not computed again. */
#define KEEPS_LOW(look) (W == 16 && !((look)&VISIBLE_TARGET))

CW_INLINE vfloat lowness(const lanes *l, vfloat slope, float distance) {
    return vf_mul(vf_sub(l->steepest, slope), vf_set(distance));
}

/* The pieces that end at crossings from `from` to before `end`. cut: they may end beyond the reach. */
CW_INLINE void scan(const visible_job *job, const float *eye, lanes *l, size_t from, size_t end, unsigned look,
                    bool cut) {
    const bool above = look & VISIBLE_TARGET;
    const vfloat target = vf_set(job->target), zero = vf_set(0), one = vf_set(1);
    for (size_t k = from; k < end; k++) {
        const visible_crossing *c = job->crossing + k;
        const vfloat height = height_over(c, eye, l->z);
        const vfloat slope = slope_to(c, above ? vf_add(height, target) : height);
        const vmask late = vf_gt(slope, l->steepest);
        /* Without a target above the ground, the last slope is at most the steepest. */
        const vmask early = above ? vf_gt(l->slope, l->steepest) : vm_set(false);
        if (W == 16 || vm_any(above ? vm_or(late, early) : late)) {
            const visible_piece *p = job->piece + k;
            const vfloat before = KEEPS_LOW(look) ? vf_max(zero, l->low) : lowness(l, l->slope, p->begin);
            const vfloat low = lowness(l, slope, p->end), both = vf_sub(low, before);
            vfloat share = vf_div(above ? vf_select(late, low, vf_sub(zero, before)) : low, both);
            if (above) share = vf_select(vm_and(late, early), one, share);
            vmask seen = above ? vm_and(vm_or(late, early), vf_eq(slope, slope)) : late;
            /* Without holes a ray that has left the land does not come back. */
            if (look & VISIBLE_HOLES) seen = vm_and(seen, vf_eq(l->slope, l->slope));
            add_seen(job, l, p, seen, above ? late : vm_set(true), share, look, cut);
            l->steepest = vf_max(above ? slope_to(c, height) : slope, l->steepest);
            l->low = low;
        }
        l->slope = slope;
    }
}

/* The last piece, which is cut. Not inlined, as it would take registers from the others. */
static __attribute__((noinline)) void scan_last(const visible_job *job, const float *eye, lanes *l, size_t k) {
    scan(job, eye, l, k, k + 1, job->look | VISIBLE_AREA | VISIBLE_FARTHEST | VISIBLE_HOLES, true);
}

/* Lanes in which a slope may exceed the steepest one in the block of rows that begins at row k of the ray. */
CW_INLINE vmask block_is_high(const visible_job *job, ptrdiff_t eyes, size_t row, size_t k, int level, const lanes *l) {
    const size_t length = (size_t)1 << visible_shift(level), after = k + length < job->steps ? k + length : job->steps;
    const float *bound = job->bound[level] + (ptrdiff_t)((row + k) >> visible_shift(level)) * job->stride;
    const visible_crossing *near = job->crossing + job->until[k] - 1, *far = job->crossing + job->until[after] - 1;
    const vfloat up = vf_add(vf_sub(vf_load(bound + eyes + job->entry[k]), l->z), vf_set(job->lift));
    const vfloat most = vf_max(vf_mul(up, vf_set(near->inverse)), vf_mul(up, vf_set(far->inverse)));
    return vf_gt(vf_sub(most, vf_set(near->drop)), l->steepest);
}

/* Adds a level block of 8 rows, such as a lake, as scan() adds it, if each lane sees all of it or nothing; else false.
 * high: lanes that may see some of it. Over level ground slopes rise strictly from crossing to crossing if the eye
 * stands high enough (papers/numerics.md). So if the crossing where the block begins is in sight, all of it is. */
CW_INLINE bool add_level(const visible_job *job, ptrdiff_t eyes, size_t row, size_t k, vmask high, lanes *l,
                         unsigned look) {
    const float *level = job->level + (ptrdiff_t)((row + k) >> visible_shift(0)) * job->stride + eyes + job->entry[k];
    if (isnan(*level)) return false; /* mostly no lane is level where the first is not */
    const size_t from = job->until[k] - 1, to = job->until[k + 8] - 1;
    const vfloat height = vf_sub(vf_load(level), l->z);
    const vmask sees = vf_eq(slope_to(job->crossing + from, height), l->steepest);
    const vmask seen = vm_and(vf_lt(height, vf_set(-job->sunk[k])), sees);
    if (vm_any(vm_andnot(high, seen))) return false;
    if (look & VISIBLE_AREA)
        l->area = vd_add(l->area, vd_select(seen, vd_set(job->whole[to] - job->whole[from]), vd_set(0)));
    if (look & VISIBLE_FARTHEST) l->farthest = vf_select(seen, vf_set(job->piece[to].end), l->farthest);
    l->steepest = vf_select(seen, slope_to(job->crossing + to, height), l->steepest);
    return true;
}

CW_INLINE void walk(const visible_job *job, ptrdiff_t eyes, size_t row, size_t most, float *area, float *farthest,
                    unsigned look) {
    const bool above = look & VISIBLE_TARGET;
    const vfloat none = vf_set(-INFINITY), nothing = vf_set(0);
    const float *eye = job->land + (ptrdiff_t)row * job->stride + eyes;
    const vfloat ground = vf_load(eye);
    lanes l = {.z = vf_add(ground, vf_set(job->eye)), none, none, nothing, vd_set(0), vi_set(0), job->run, nothing};
    size_t steps = job->rows - 1 - row;
    steps = steps < most ? steps : most;
    steps = steps < job->steps ? steps : job->steps;
    const vmask exists = vf_eq(ground, ground);
    if (steps == 0 || !vm_any(exists)) {
        vf_store(area, vf_select(exists, nothing, ground));
        vf_store(farthest, nothing);
        return;
    }
    /* The first piece begins under the eye and is straight: all in sight, or edge-on if nothing is above the ground. */
    const bool whole = job->reach > 0 && job->steps == steps; /* the last crossing may be beyond the reach */
    const size_t until = job->until[steps] - whole;
    const vfloat first = height_over(job->crossing, eye, l.z);
    const vmask higher = above ? exists : vf_gt(l.z, ground);
    l.slope = slope_to(job->crossing, above ? vf_add(first, vf_set(job->target)) : first);
    add_seen(job, &l, job->piece, vm_and(higher, vf_eq(first, first)), vm_set(true), vf_set(1), look, until == 0);
    l.steepest = vf_max(slope_to(job->crossing, first), none);
    bool passed = false;
    for (size_t k = 0; k < steps;) {
        const size_t at = row + k;
        if (k > 0 && (at & 7) == 0) {
            const bool by_64 = (at & 63) == 0 && !vm_any(block_is_high(job, eyes, row, k, 1, &l));
            const vmask high = by_64 ? vm_set(false) : block_is_high(job, eyes, row, k, 0, &l);
            if (!vm_any(high) ||
                ((look & VISIBLE_LEVEL) && k + 8 < steps && add_level(job, eyes, row, k, high, &l, look))) {
                k += by_64 ? 64 : 8;
                passed = true;
                continue;
            }
        }
        const size_t next = (at | 7) + 1 - row, end = next < steps ? next : steps;
        if (passed) { /* the crossing at which the last block ended */
            const visible_crossing *c = job->crossing + job->until[k] - 1;
            const vfloat height = height_over(c, eye, l.z);
            l.slope = slope_to(c, above ? vf_add(height, vf_set(job->target)) : height);
            l.low = lowness(&l, l.slope, job->piece[job->until[k] - 1].end);
            passed = false;
        }
        const size_t to = job->until[end];
        const size_t stop = to < until ? to : until;
        for (size_t from = job->until[k] > 0 ? job->until[k] : 1, next_run; from < stop; from = next_run) {
            enter_run(&l, from, look);
            next_run = l.run->until;
            scan(job, eye, &l, from, stop < next_run ? stop : next_run, look, false);
        }
        k = end;
    }
    if (whole && until > 0 && !passed) {
        enter_run(&l, until, look);
        lanes last = l; /* keeps l in registers */
        scan_last(job, eye, &last, until);
        l = last;
    }
    if (look & VISIBLE_AREA) add_run(&l);
    vf_store(area, vf_select(exists, vf_from_vd(l.area), ground));
    vf_store(farthest, l.farthest);
}

CW_INLINE void walk_all(const visible_job *job, ptrdiff_t eyes, size_t row, size_t step, size_t count, size_t most,
                        float *area, float *farthest, unsigned look) {
    for (size_t k = 0; k < count; k++, row += step)
        for (size_t lane = 0; lane < VISIBLE_GROUP; lane += LANES, area += LANES, farthest += LANES)
            walk(job, eyes + (ptrdiff_t)lane, row, most, area, farthest, look);
}

/* One for each way of looking: what is not asked for takes no time. */
static void walk_group(const visible_job *job, ptrdiff_t eyes, size_t row, size_t step, size_t count, size_t most,
                       float *area, float *farthest) {
#define LOOK(look)                                                                                                     \
    case look:                                                                                                         \
        walk_all(job, eyes, row, step, count, most, area, farthest, look);                                             \
        break;
#define LOOKS(more)                                                                                                    \
    LOOK(VISIBLE_AREA | (more)) LOOK(VISIBLE_FARTHEST | (more)) LOOK(VISIBLE_AREA | VISIBLE_FARTHEST | (more))
    switch (job->look) {
        LOOKS(0)
        LOOKS(VISIBLE_HOLES)
        LOOKS(VISIBLE_TARGET | VISIBLE_HOLES)
        LOOKS(VISIBLE_LEVEL)
        LOOKS(VISIBLE_LEVEL | VISIBLE_HOLES)
    }
#undef LOOKS
#undef LOOK
}

static void bound_row(float *high, float *low, const float *from, const ptrdiff_t *at, size_t count, size_t width) {
    for (size_t k = 0; k < width; k += LANES) {
        vfloat most = vf_load(high + k);
        for (size_t n = 0; n < count; n++) most = vf_max(vf_load(from + (ptrdiff_t)k + at[n]), most);
        vf_store(high + k, most);
    }
    for (size_t k = 0; low && k < width; k += LANES) {
        vfloat least = vf_load(low + k);
        for (size_t n = 0; n < count; n++) {
            const vfloat z = vf_load(from + (ptrdiff_t)k + at[n]);
            least = vf_min(vf_select(vf_eq(z, z), z, vf_set(-INFINITY)), least);
        }
        vf_store(low + k, least);
    }
}

/* cw_visible1, cw_visible4, cw_visible8 or cw_visible16. */
const visible_code CW_CODE(visible) = {walk_group, bound_row};
