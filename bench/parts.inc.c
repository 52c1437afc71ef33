/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, each in a loop of its own. Nothing of a kernel is repeated here: a stub includes a vocabulary, names
 * PARTS_RUN, and this body includes the kernels' own, compiled with the kernels' flags. */

#include "pyramid.inc.c"

#include "parts.h"

enum { VECTORS = PARTS_RAYS / W, CASES = PARTS_AIMED / W, STEPS = 12 };

/* Made once, so that a loop runs what it is named after alone. */
typedef struct leaf_case {
    vray r;
    vcell c;
    vmask gate;
} leaf_case;
static leaf_case cases[CASES];
static stream_queue waiting[PARTS_RAYS / BATCH];
static size_t waiting_count;
static bool ready;

static void make_cases(const parts_work *w) {
    const vfloat one = vf_set(1);
    for (size_t k = 0; k < CASES; k++) {
        vray *r = &cases[k].r;
        vcell *c = &cases[k].c;
        const vmask alive = make_rays(r, w->field, w->aimed + k * W);
        const vint i = vi_load(w->cell_i + k * W), j = vi_load(w->cell_j + k * W);
        const vint sample = vi_add(vi_mul(j, vi_set((int32_t)w->field->stride)), i);
        c->i = vf_from_vi(i);
        c->j = vf_from_vi(j);
        c->x_in = crossing(&r->x, vf_select(r->x.up, c->i, vf_add(c->i, one)));
        c->x_out = crossing(&r->x, vf_select(r->x.up, vf_add(c->i, one), c->i));
        c->y_in = crossing(&r->y, vf_select(r->y.up, c->j, vf_add(c->j, one)));
        c->y_out = crossing(&r->y, vf_select(r->y.up, vf_add(c->j, one), c->j));
        c->t0 = vf_max(vf_max(c->x_in, c->y_in), r->begin);
        c->t1 = vf_min(vf_min(c->x_out, c->y_out), r->end);
        vf_gather_pairs(w->field->z, sample, alive, &c->h00, &c->h10);
        vf_gather_pairs(w->field->z + w->field->stride, sample, alive, &c->h01, &c->h11);
        cases[k].gate = vm_and(alive, cell_gate(r, c));
    }
}

static void make_queue(const parts_work *w) {
    for (size_t k = 0; k < VECTORS; k++) {
        stream_queue *q = &waiting[k * W / BATCH];
        const size_t part = k % (BATCH / W);
        vray r;
        const unsigned alive = vm_bits(make_rays(&r, w->field, w->rays + k * W));
        mirror_rays(&q->ready[part], &r, w->field, CW_LEAF_WATERTIGHT);
        enqueue(q, part, alive, r.from, w->field->pyramid->levels);
    }
    for (size_t k = 0; k < PARTS_RAYS / BATCH; k++) waiting_count += waiting[k].n -= waiting[k].n % W;
}

static float total(vfloat a) {
    float all[W], sum = 0;
    vf_store(all, a);
    for (size_t k = 0; k < W; k++) sum += all[k];
    return sum;
}

static uint64_t run_prepare(parts_work *w) {
    vfloat sum = vf_set(0);
    unsigned alive = 0;
    for (size_t k = 0; k < VECTORS; k++) {
        vray r;
        alive += vm_bits(make_rays(&r, w->field, w->rays + k * W));
        sum = vf_add(sum, vf_add(vf_add(r.from, r.until), vf_add(r.begin, r.end)));
    }
    w->sink = total(sum) + (float)alive;
    return PARTS_RAYS;
}

CW_INLINE uint64_t run_leaf(parts_work *w, cw_leaf leaf) {
    vfloat sum = vf_set(0);
    size_t hits = 0;
    for (size_t k = 0; k < CASES; k++) {
        const leaf_case *l = &cases[k];
        vhit h;
        const vmask found =
            leaf == CW_LEAF_WATERTIGHT ? wt_cell(&l->r, &l->c, l->gate, false, &h) : mt_cell(&l->r, &l->c, l->gate, &h);
        hits += (size_t)__builtin_popcount(vm_bits(found));
        sum = vf_add(sum, vf_select(found, vf_add(h.t, vf_add(h.u, h.v)), sum));
    }
    w->hits = hits;
    w->sink = total(sum);
    return PARTS_AIMED;
}

CW_INLINE stream_state refill(stream_lanes *l, const stream_queue *q, size_t from) {
    for (size_t lane = 0; lane < W; lane++) refill_lane(l, lane, q, &q->rays[from + lane], CW_LEAF_WATERTIGHT, false);
    l->living = (1u << W) - 1;
    return load_lanes(l);
}

static uint64_t run_refill(parts_work *w) {
    stream_lanes l;
    stream_clear(&l);
    vfloat sum = vf_set(0);
    for (const stream_queue *q = waiting; q < waiting + PARTS_RAYS / BATCH; q++)
        for (size_t k = 0; k < q->n; k += W) {
            const stream_state s = refill(&l, q, k);
            w->keep(&l); /* a single lane would else never be written */
            sum = vf_add(sum, vf_add(s.t, vf_from_vi(s.x)));
        }
    w->sink = total(sum);
    return waiting_count;
}

/* The first steps of a walk; to be divided by the steps from node to node that the counting twin finds among them. The
 * refill before is in it: PART_REFILL says what it takes. */
static uint64_t run_node(parts_work *w) {
    static cw_hit hits[BATCH];
    stream_lanes l;
    stream_clear(&l);
    vfloat sum = vf_set(0);
    for (const stream_queue *q = waiting; q < waiting + PARTS_RAYS / BATCH; q++)
        for (size_t k = 0; k < q->n; k += W) {
            stream_state s = refill(&l, q, k);
            for (int step = 0; step < STEPS && vm_any(s.alive); step++)
                stream_step(&s, &l, w->field, CW_LEAF_WATERTIGHT, NULL, false, hits, NULL);
            sum = vf_add(sum, s.t);
        }
    w->sink = total(sum) + hits[0].t;
    return 0;
}

/* What is read is added to one of four sums, so that no addition waits for the one before. */
CW_INLINE uint64_t run_reads(parts_work *w, part_kind kind) {
    const vmask all = vm_set(true);
    const vfloat zero = vf_set(0);
    vfloat sum[4] = {zero, zero, zero, zero};
    for (size_t k = 0; k < w->place_count; k += 4 * W)
        for (size_t m = 0; m < 4; m++) {
            const int32_t *place = w->places + k + m * W;
            vfloat a, b;
            if (kind == PART_PAIRS) {
                vf_gather_pairs(w->table, vi_load(place), all, &a, &b);
                a = vf_add(a, b);
            } else if (kind == PART_GATHER) {
                a = vf_gather(w->table, vi_load(place), all);
            } else {
                a = kind == PART_LOAD ? vf_load(w->table + *place) : vf_set(w->table[*place]);
            }
            sum[m] = vf_add(sum[m], a);
        }
    w->sink = total(vf_add(vf_add(sum[0], sum[1]), vf_add(sum[2], sum[3])));
    return kind == PART_PAIRS ? 2 * w->place_count : w->place_count;
}

uint64_t PARTS_RUN(part_kind kind, parts_work *work) {
    if (!ready) {
        make_cases(work);
        make_queue(work);
        ready = true;
    }
    switch (kind) {
    case PART_PREPARE:
        return run_prepare(work);
    case PART_LEAF_WATERTIGHT:
        return run_leaf(work, CW_LEAF_WATERTIGHT);
    case PART_LEAF_MOLLER_TRUMBORE:
        return run_leaf(work, CW_LEAF_MOLLER_TRUMBORE);
    case PART_NODE:
        return run_node(work);
    case PART_REFILL:
        return run_refill(work);
    case PART_GATHER:
        return run_reads(work, PART_GATHER);
    case PART_PAIRS:
        return run_reads(work, PART_PAIRS);
    case PART_LOAD:
        return run_reads(work, PART_LOAD);
    case PART_BROADCAST:
        return run_reads(work, PART_BROADCAST);
    case PART_COUNT:
        break;
    }
    return 0;
}
