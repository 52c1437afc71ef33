/* SPDX-License-Identifier: Apache-2.0 */
/* How far a coarser field's surface lies above and below the full one, for every point of both.
 *
 * Samples of the coarser field stand at samples of the full one, factor apart, and cells are split along the same
 * diagonal. So the lines of its triangulation, x = factor · i, y = factor · j and x - y = factor · k, are lines of
 * the full one, and each of the full field's triangles lies within one of the coarser field's. Both surfaces are
 * planes there. Their difference is linear, hence largest and smallest at the triangle's vertices: to look at each
 * of the full field's samples is enough.
 *
 * Rounding. At a sample of height z in a triangle with corners h0, h1, h2 the difference, times factor, is D = w0
 * (h0 - z) + w1 (h1 - z) + w2 (h2 - z), with whole weights of the sum factor. Let u = 2^-53. Each term is off by two
 * roundings, their sum by two more: D by at most 4 u (1 + 4 u) S, where S is the sum of the terms' sizes; S by that
 * share of itself. Adding 2^-50 S = 8 u S to D, which rounds once more (u S), and dividing by factor (u S), leaves
 * the result no lower than the exact difference. Where all samples are equal S is 0, and where one surface touches
 * the other from one side all terms have one sign: nothing is added to zeros. */

#include "difference.h"
#include "fpenv.h"
#include "sister.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#define ROUNDING 0x1p-50

/* Sums are made lane by lane, in one order for any compiler and instruction set. */
enum { LANES = 8 };

/* Of one row of coarser cells; times factor, squares times its square. */
typedef struct row_sums {
    double above, below, squares; /* squares: of each triangle, 12 times their integral */
    uint64_t both, lost, made;    /* triangles that both fields have, or one of them alone */
} row_sums;

typedef struct measure {
    const samples *full, *coarser;
    size_t factor;
    row_sums *rows;
    atomic_bool out_of_memory;
} measure;

typedef struct extremes {
    double above[LANES], below[LANES];
} extremes;

/* Times factor, at (along, down) in a cell; spread: S above. p is the third corner, on the side of the diagonal that
 * counts. */
static inline double difference_at(double factor, double along, double down, double z, double p00, double p, double p11,
                                   double *spread) {
    const double far = along > down ? along : down, near = along > down ? down : along;
    const double a = (factor - far) * (p00 - z), b = (far - near) * (p - z), c = near * (p11 - z);
    *spread = fabs(a) + fabs(b) + fabs(c);
    return a + b + c;
}

static inline void note(extremes *e, size_t lane, double d, double spread) {
    const double above = d + ROUNDING * spread, below = ROUNDING * spread - d;
    e->above[lane] = above > e->above[lane] ? above : e->above[lane];
    e->below[lane] = below > e->below[lane] ? below : e->below[lane];
}

/* Differences in row j of the full field, cell by cell of a coarser row. The last column belongs to the cell before. */
static void difference_row(const measure *m, size_t row, size_t j, double *restrict here, extremes *e) {
    const samples *f = m->full, *g = m->coarser;
    const double factor = (double)m->factor, down = (double)(j - row * m->factor);
    const float *restrict z = f->z + j * f->stride, *p = g->z + row * g->stride;
    for (size_t first = 0; first + 1 < f->nx; first += m->factor, p++) {
        const double p00 = (double)p[0], p01 = (double)p[1], p10 = (double)p[g->stride], p11 = (double)p[g->stride + 1];
        const size_t end = first + m->factor + 1 < f->nx ? first + m->factor : f->nx;
        for (size_t i = first; i < end; i++) {
            double spread;
            const double along = (double)(i - first);
            here[i] = difference_at(factor, along, down, (double)z[i], p00, along > down ? p01 : p10, p11, &spread);
            note(e, i % LANES, here[i], spread);
        }
    }
}

/* Twelve times the integral over half a unit square of the square of a linear function with these values at the
 * corners. */
static inline double squares(double a, double b, double c) { return a * a + b * b + c * c + a * b + b * c + c * a; }

/* The triangles between two rows of samples, without holes. */
static double squares_between(const double *restrict up, const double *restrict low, size_t cells) {
    double sums[LANES] = {0}, sum = 0;
    size_t i = 0;
    for (; i + LANES <= cells; i += LANES)
        for (size_t k = 0; k < LANES; k++)
            sums[k] +=
                squares(up[i + k], up[i + k + 1], low[i + k + 1]) + squares(up[i + k], low[i + k + 1], low[i + k]);
    for (; i < cells; i++) sums[0] += squares(up[i], up[i + 1], low[i + 1]) + squares(up[i], low[i + 1], low[i]);
    for (size_t k = 0; k < LANES; k++) sum += sums[k];
    return sum;
}

/* One triangle of cell (i, j) of the full field, whose first corner lies (along, down) in coarser cell (x, y). */
static void look_at_triangle(const measure *m, size_t i, size_t j, size_t x, size_t y, bool lower, extremes *e,
                             row_sums *s) {
    const samples *f = m->full, *g = m->coarser;
    const size_t along = i - x * m->factor, down = j - y * m->factor;
    const float *z = f->z + j * f->stride + i, *h = g->z + y * g->stride + x;
    const float corner[3] = {z[0], lower ? z[f->stride] : z[1], z[f->stride + 1]};
    const size_t beside[3][2] = {{0, 0}, {lower ? 0 : 1, lower ? 1 : 0}, {1, 1}};
    /* On the diagonal of the coarser cell the triangle's side decides; elsewhere the cell's. */
    const bool below = down > along || (down == along && lower);
    const double p[3] = {(double)h[0], (double)(below ? h[g->stride] : h[1]), (double)h[g->stride + 1]};
    const bool full = !isnan(corner[0] + corner[1] + corner[2]), coarse = !isnan(p[0] + p[1] + p[2]);
    s->both += full && coarse;
    s->lost += full && !coarse;
    s->made += coarse && !full;
    if (!full || !coarse) return;
    double d[3], spread;
    for (int k = 0; k < 3; k++) {
        d[k] = difference_at((double)m->factor, (double)(along + beside[k][0]), (double)(down + beside[k][1]),
                             (double)corner[k], p[0], p[1], p[2], &spread);
        note(e, 0, d[k], spread);
    }
    s->squares += squares(d[0], d[1], d[2]);
}

static bool has_hole(const samples *f, size_t row, size_t rows) {
    if (f->holes == 0) return false;
    for (size_t j = row; j < row + rows; j++) {
        int32_t odd = 0;
        for (size_t i = 0; i < f->nx; i++) odd |= isnan(f->z[j * f->stride + i]);
        if (odd) return true;
    }
    return false;
}

/* room: for differences in two rows of samples. */
static row_sums measure_row(const measure *m, size_t row, double *room) {
    const size_t first = row * m->factor, left = m->full->ny - 1 - first, rows = m->factor < left ? m->factor : left;
    row_sums s = {0};
    extremes e = {{0}, {0}};
    if (has_hole(m->full, first, rows + 1) || has_hole(m->coarser, row, 2)) {
        for (size_t j = first; j < first + rows; j++)
            for (size_t i = 0; i + 1 < m->full->nx; i++)
                for (int lower = 0; lower < 2; lower++) look_at_triangle(m, i, j, i / m->factor, row, lower, &e, &s);
    } else {
        for (size_t j = 0; j <= rows; j++) {
            double *const here = room + j % 2 * m->full->nx, *const before = room + (j + 1) % 2 * m->full->nx;
            difference_row(m, row, first + j, here, &e);
            if (j > 0) s.squares += squares_between(before, here, m->full->nx - 1);
        }
        s.both = (uint64_t)rows * 2 * (m->full->nx - 1);
    }
    for (size_t k = 0; k < LANES; k++) {
        s.above = fmax(s.above, e.above[k]);
        s.below = fmax(s.below, e.below[k]);
    }
    return s;
}

static void measure_rows(void *context, size_t begin, size_t end) {
    measure *m = context;
    double *room = malloc(2 * m->full->nx * sizeof *room);
    if (room == NULL) {
        atomic_store(&m->out_of_memory, true);
        return;
    }
    for (size_t row = begin; row < end; row++) m->rows[row] = measure_row(m, row, room);
    free(room);
}

static cw_difference total(const measure *m, size_t rows) {
    row_sums sum = {0};
    for (size_t k = 0; k < rows; k++) {
        sum.above = fmax(sum.above, m->rows[k].above);
        sum.below = fmax(sum.below, m->rows[k].below);
        sum.squares += m->rows[k].squares;
        sum.both += m->rows[k].both;
        sum.lost += m->rows[k].lost;
        sum.made += m->rows[k].made;
    }
    const double factor = (double)m->factor;
    return (cw_difference){
        .above = sum.above / factor,
        .below = sum.below / factor,
        .rms = sum.both ? sqrt(sum.squares / (6 * (double)sum.both)) / factor : 0,
        .lost = sum.lost,
        .made = sum.made,
    };
}

cw_status cw_difference_measure(const samples *full, const samples *coarser, size_t factor, const cw_run *run,
                                cw_difference *difference) {
    const size_t rows = coarser->ny - 1, grain = COARSER_GRAIN / (full->nx * factor);
    measure m = {.full = full, .coarser = coarser, .factor = factor, .rows = calloc(rows, sizeof *m.rows)};
    cw_status status =
        m.rows ? cw_run_work(run, rows, grain, grain, measure_rows, &m) : cw_fail_plainly(CW_ERROR_MEMORY);
    if (status == CW_OK && atomic_load(&m.out_of_memory)) status = cw_fail_plainly(CW_ERROR_MEMORY);
    if (status == CW_OK) *difference = total(&m, rows);
    free(m.rows);
    return status;
}
