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

/* Each lane has its greatest: where there may be NaN, compilers make vectors of that, and not of one number for all. */
enum { LANES = 16 };
typedef struct greatest {
    double step[LANES], height[LANES], hole[LANES];
} greatest;

/* Samples from x on, `count` of them; n, f: of the near row and the far one; a: as in cw_sweep_lean. */
static inline void lean(const double *restrict n, const double *restrict f, int a, double x, double aside, double r,
                        int count, double *restrict front, double *restrict back, greatest *restrict most) {
    const int b = 1 - a;
    for (int k = 0; k < count; k++) {
        const double near = n[k + 1] - n[k], far = f[k + 1] - f[k];
        const double side_a = f[k + a] - n[k + a], side_b = f[k + b] - n[k + b];
        front[k] = f[k + a] - near * (x + (double)(k + a) - aside) - side_a * r;
        back[k] = f[k + b] - far * (x + (double)(k + b) - aside) - side_b * r;
        const double one = fabs(near) + fabs(side_a), other = fabs(far) + fabs(side_b), hole = front[k] + back[k];
        most->step[k] = skyline_larger(one, skyline_larger(other, most->step[k]));
        most->height[k] = skyline_larger(fabs(n[k]), skyline_larger(fabs(f[k]), most->height[k]));
        most->hole[k] = hole == hole ? most->hole[k] : 1;
    }
}

/* `edge` if an edge may be the highest on a way from one triangle into another, which lean like that; else 0. */
static inline double ridge(double before, double behind, double margin, double edge) {
    const double faces = before > margin ? 0 : edge;
    return behind < -margin ? 0 : faces;
}

/* before_side, behind_side: of the triangles beside a sample's edge to the far row, in the order in which ways out from
 * the eye meet them. */
static inline void find_ridges(const sweep_part *p, const double *before_side, const double *behind_side, long begin,
                               long end) {
    const double margin = p->margin, *front = p->front, *back = p->back, *back_before = p->back_before;
    double *restrict edges = p->edges;
    for (long i = begin; i < end; i++)
        edges[i] = ridge(back_before[i], front[i], margin, SWEEP_ROW) +
                   ridge(front[i], back[i], margin, SWEEP_DIAGONAL) +
                   ridge(before_side[i], behind_side[i], margin, SWEEP_SIDE);
}

/* Takes no branch a sample: one edge in eight matters, at places that could not be foreseen. */
static inline void list_edges(sweep_part *p, long begin, long end) {
    size_t along = 0, between = 0;
    for (long i = begin; i < end; i++) {
        const int edges = (int)p->edges[i];
        p->along[along] = p->between[between] = (uint32_t)i;
        along += (edges & SWEEP_ROW) != 0;
        between += (edges & (SWEEP_SIDE | SWEEP_DIAGONAL)) != 0;
    }
    p->along_count = along;
    p->between_count = between;
}

void cw_sweep_lean(sweep_part *p, double r, long begin, long end) {
    const int a = p->outward > 0 ? 1 : 0; /* diagonals go from sample 1 - a of a cell to sample a */
    greatest most = {0};
    for (long i = begin; i < end - 1; i += LANES)
        lean(p->near_height + i, p->far_height + i, a, (double)i, p->aside, r,
             end - 1 - i < LANES ? (int)(end - 1 - i) : LANES, p->front + i, p->back + i, &most);
    double most_step = 0, most_height = 0, hole = 0;
    for (int k = 0; k < LANES; k++) {
        most_step = skyline_larger(most.step[k], most_step);
        most_height = skyline_larger(most.height[k], most_height);
        hole += most.hole[k];
    }
    const double *fall = p->sight->fall, wide = (r + 2) * (r + 2);
    const double lowered = (fabs(fall[0]) + fabs(fall[1]) + fabs(fall[2])) * wide;
    const double size = most_height + 2 * (fabs(p->sight->eye[2]) + lowered), near = fmax(r - 1, sweep_first_distance);
    p->holes |= hole > 0;
    p->step = fmax(p->step, most_step);
    p->snap = fmax(p->snap, most_step / near);
    p->size = fmax(p->size, size / near);
    p->rise = fmax(p->rise, most_height / near);
    p->margin = 0x1p-24 * p->step * r + 0x1p-46 * size * (r + 16);
    /* On the left of a sample, and on its right. Ways on the left of the eye go to the left. */
    const double *left = (a ? p->front : p->back) - 1, *right = a ? p->back : p->front;
    const long before = sweep_clipped(p, p->aside), ahead = before + !((double)before > p->aside),
               middle = ahead < begin ? begin
                        : ahead < end ? ahead
                                      : end;
    find_ridges(p, right, left, begin, middle);
    find_ridges(p, left, right, middle, end);
    for (long i = begin; i < end && r <= sweep_close_rows + 1; i++)
        p->edges[i] = SWEEP_ROW + SWEEP_SIDE + SWEEP_DIAGONAL;
    p->edges[end - 1] = (int)p->edges[end - 1] & SWEEP_SIDE; /* the others lead beyond */
    list_edges(p, begin, end);
}

/* A piece that begins before an edge whose left end is in direction u, and before what a narrow one gains there. Sample
 * i is in that direction or left of it. */
static inline uint32_t start_at(const sweep_part *p, uint32_t at, long i, double u) {
    const skyline_piece *s = p->line.pieces;
    const uint32_t start = p->starts[i];
    const bool later = s[start].from <= u - SKYLINE_BLUR && s[start].from > s[at].from; /* and not gone */
    return skyline_find(&p->line, later ? start : at, u - SKYLINE_BLUR);
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
    for (size_t k = 0; k < p->along_count; k++) {
        const long i = (long)p->along[k];
        const double x = (double)i - p->aside;
        if (!all) at = start_at(p, at, i, x / near);
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

void cw_sweep_add_between(sweep_part *p, double r, uint32_t start) {
    const double *n = p->near_height, *f = p->far_height;
    const bool all = r <= sweep_close_rows + 1;
    const long a = p->outward > 0 ? 1 : 0, b = 1 - a;
    if (!(r > sweep_first_distance)) return;
    for (size_t k = 0; k < p->between_count; k++) {
        const long i = (long)p->between[k];
        const int edges = (int)p->edges[i];
        const double x = (double)i - p->aside;
        if (!all) start = start_at(p, start, x > 0 ? i : i - 1, x / (x > 0 ? r : r - 1));
        if (edges & SWEEP_SIDE && x != 0) add(p, start, x, r - 1, n[i], x, r, f[i]);
        if (edges & SWEEP_DIAGONAL) add(p, start, x + (double)b, r - 1, n[i + b], x + (double)a, r, f[i + a]);
    }
}
