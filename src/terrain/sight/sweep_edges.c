/* SPDX-License-Identifier: Apache-2.0 */
#include "sweep_part.h"

#include <string.h>

/* A row that is a column is fetched with those that follow it, since each line of memory holds samples of sixteen. */
const float *cw_sweep_fetch(sweep_part *p, long row) {
    const terrain *t = p->sight->terrain;
    if (!p->swapped) return terrain_row(t, (size_t)row);
    const long first = row - row % SWEEP_COLUMNS;
    const size_t stride = sweep_columns_stride(p);
    if (p->columns_from != first) {
        const long last = first + SWEEP_COLUMNS - 1 < p->rows ? first + SWEEP_COLUMNS - 1 : p->rows - 1;
        const double a = (double)first - p->eye, b = p->eye - (double)last;
        const double near = fmax(fmax(a, b), 0), far = fmax(-a, -b);
        const long left = sweep_clipped(p, floor(p->aside + fmin(near * p->from, far * p->from)) - SWEEP_PAD),
                   right = sweep_clipped(p, ceil(p->aside + fmax(near * p->until, far * p->until)) + SWEEP_PAD);
        if (p->near) {
            float *kept = p->columns + SWEEP_COLUMNS * stride;
            memcpy(kept + p->columns_left, p->near + p->columns_left,
                   (size_t)(p->columns_right - p->columns_left) * sizeof *kept);
            p->near = kept;
        }
        p->columns_from = first;
        p->columns_left = left;
        p->columns_right = right > left ? right : left;
        const size_t count = (size_t)(last - first + 1);
        for (long j = left; j < right; j++) {
            const float *z = terrain_row(t, (size_t)j) + first,
                        *soon = j + SWEEP_AHEAD < right ? z + SWEEP_AHEAD * t->stride : z;
            __builtin_prefetch(soon); /* rows are far apart in memory */
            __builtin_prefetch(soon + count - 1);
            for (size_t c = 0; c < count; c++) p->columns[c * stride + (size_t)j] = z[c];
        }
    }
    return p->columns + (size_t)(row - first) * stride;
}

void cw_sweep_heights(const sweep_part *p, const float *z, long row, long begin, long end, double *h) {
    const sweep_lowering q = sweep_lowering_of(p, row);
    const double eye = p->sight->eye[2], aside = p->aside;
    for (int k = 0; k < (int)(end - begin); k++) {
        const double x = (double)begin + (double)k - aside;
        const double height = (double)z[begin + k] - eye - (q.one + x * (q.two + x * q.three));
        h[begin + k] = height + (height - height);
    }
}

void cw_sweep_lean(sweep_part *p, double r, long begin, long end) {
    const double *n = p->near_height, *f = p->far_height;
    const long a = p->outward > 0 ? 1 : 0, b = 1 - a; /* diagonals go from sample b of a cell to sample a */
    double most_step = 0, most_height = 0;
    bool holes = false;
    for (long i = begin; i < end - 1; i++) {
        const double near = n[i + 1] - n[i], far = f[i + 1] - f[i];
        const double side_a = f[i + a] - n[i + a], side_b = f[i + b] - n[i + b];
        const double front = f[i + a] - near * ((double)(i + a) - p->aside) - side_a * r;
        const double back = f[i + b] - far * ((double)(i + b) - p->aside) - side_b * r;
        p->front[i] = front;
        p->back[i] = back;
        most_step = skyline_larger(fabs(near) + fabs(side_a), skyline_larger(fabs(far) + fabs(side_b), most_step));
        most_height = skyline_larger(fabs(n[i]), skyline_larger(fabs(f[i]), most_height));
        holes |= isnan(front + back);
    }
    const double *fall = p->sight->fall, wide = (r + 2) * (r + 2);
    const double lowered = (fabs(fall[0]) + fabs(fall[1]) + fabs(fall[2])) * wide;
    const double size = most_height + 2 * (fabs(p->sight->eye[2]) + lowered), near = fmax(r - 1, sweep_first_distance);
    p->holes |= holes;
    p->step = fmax(p->step, most_step);
    p->snap = fmax(p->snap, most_step / near);
    p->size = fmax(p->size, size / near);
    p->rise = fmax(p->rise, most_height / near);
    p->margin = 0x1p-24 * p->step * r + 0x1p-46 * size * (r + 16);
}

/* Whether an edge may be the highest on a way from one triangle into another, which lean like that. */
static inline bool is_ridge(const sweep_part *p, double before, double behind) {
    return !(before > p->margin) && !(behind < -p->margin);
}

static inline void add(sweep_part *p, uint32_t start, double x0, double r0, double h0, double x1, double r1,
                       double h1) {
    if (isnan(h0 + h1)) return;
    if (r0 < sweep_first_distance) { /* beyond it */
        const double share = (sweep_first_distance - r0) / (r1 - r0);
        x0 += share * (x1 - x0);
        h0 += share * (h1 - h0);
        r0 = sweep_first_distance;
    }
    cw_skyline_add(&p->line, start, (double[2]){x0 / r0, h0 / r0}, (double[2]){x1 / r1, h1 / r1});
}

void cw_sweep_add_row(sweep_part *p, double r, long begin, long end, uint32_t start) {
    const double near = r - 1, *h = p->near_height;
    const bool all = r <= sweep_close_rows + 1;
    if (near < sweep_first_distance) return;
    uint32_t at = start;
    for (long i = begin; i < end - 1; i++) {
        if (!(all || is_ridge(p, p->back_before[i], p->front[i]))) continue;
        const double x = (double)i - p->aside;
        if (!all) at = skyline_find(&p->line, sweep_start(p, at, i - 3, (x - 3) / near), (x - 3) / near);
        add(p, at, x, near, h[i], x + 1, near, h[i + 1]);
    }
    if (!p->holes) return;
    /* Beside a hole each sample counts alone. */
    for (long i = begin; i < end; i++) {
        const double x = (double)i - p->aside;
        const double planes =
            p->front[i - 1] + p->front[i] + p->back[i - 1] + p->back[i] + p->back_before[i - 1] + p->back_before[i];
        if (isnan(planes)) add(p, start, x, near, h[i], x, near, h[i]);
    }
}

void cw_sweep_add_between(sweep_part *p, double r, long begin, long end, uint32_t start) {
    const double *n = p->near_height, *f = p->far_height;
    const bool all = r <= sweep_close_rows + 1;
    const long a = p->outward > 0 ? 1 : 0, b = 1 - a;
    const double *left_of = a ? p->front : p->back, *right_of = a ? p->back : p->front;
    if (!(r > sweep_first_distance)) return;
    for (long i = begin; i < end; i++) {
        const double x = (double)i - p->aside, left = left_of[i - 1], right = right_of[i];
        const bool side = x != 0 && (all || is_ridge(p, x > 0 ? left : right, x > 0 ? right : left));
        const bool diagonal = i + 1 < end && (all || is_ridge(p, p->front[i], p->back[i]));
        if (!(side || diagonal)) continue;
        if (!all) start = skyline_find(&p->line, sweep_start(p, start, i - 3, (x - 3) / r), (x - 3) / r);
        if (side) add(p, start, x, r - 1, n[i], x, r, f[i]);
        if (diagonal) add(p, start, x + (double)b, r - 1, n[i + b], x + (double)a, r, f[i + a]);
    }
}
