/* SPDX-License-Identifier: Apache-2.0 */
/* Coarser fields: every factor-th place of a field, as a field. difference.c measures how far the two lie apart.
 *
 * Each height follows from the samples around its place by the same operations in the same order, so the field has the
 * same bits for any number of threads. */

#include "difference.h"

#include "fpenv.h"
#include "large.h"
#include "sister.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Rows [begin, end) of the full field that count for row j of the coarser one; columns alike. */
typedef struct span {
    size_t begin, end;
} span;

/* reach: how many samples away the last one lies that counts. */
static span around(size_t place, size_t reach, size_t n) {
    return (span){place > reach ? place - reach : 0, place + reach + 1 < n ? place + reach + 1 : n};
}

typedef struct maker {
    const samples *full;
    float *z; /* of the coarser field */
    size_t nx, factor;
    int32_t filter;
    atomic_bool out_of_memory;
} maker;

/* The tent's weight, a whole number from 1 to factor. */
static double tent(size_t factor, size_t place, size_t k) {
    return (double)(factor - (k > place ? k - place : place - k));
}

/* sum and weight have an item for each column of the full field. */
static void average_row(const maker *m, size_t j, double *restrict sum, double *restrict weight) {
    const samples *f = m->full;
    const bool holes = f->holes > 0;
    const span rows = around(j * m->factor, m->factor - 1, f->ny);
    memset(sum, 0, f->nx * sizeof *sum);
    if (holes) memset(weight, 0, f->nx * sizeof *weight);
    double all = 0;
    for (size_t y = rows.begin; y < rows.end; y++) {
        const float *restrict z = f->z + y * f->stride;
        const double w = tent(m->factor, j * m->factor, y);
        all += w;
        for (size_t i = 0; i < f->nx && !holes; i++) sum[i] += w * (double)z[i];
        for (size_t i = 0; i < f->nx && holes; i++) {
            const bool some = z[i] == z[i];
            sum[i] += some ? w * (double)z[i] : 0;
            weight[i] += some ? w : 0;
        }
    }
    for (size_t i = 0; i < m->nx; i++) {
        const span columns = around(i * m->factor, m->factor - 1, f->nx);
        double height = 0, there = 0, possible = 0;
        for (size_t x = columns.begin; x < columns.end; x++) {
            const double w = tent(m->factor, i * m->factor, x);
            height += w * sum[x];
            there += w * (holes ? weight[x] : all);
            possible += w * all;
        }
        /* Weights are whole numbers, up to factor 9741 with exact sums. */
        m->z[j * m->nx + i] = 2 * there >= possible ? (float)(height / there) : NAN;
    }
}

/* The higher one, passing over holes; or the lower one, of which a hole is lowest. */
static inline float extreme(bool highest, float a, float b) {
    if (highest) return b > a ? b : a;
    return a <= b || a != a ? a : b;
}

static inline void extreme_row(const maker *m, size_t j, float *restrict column, bool highest) {
    const samples *f = m->full;
    const float none = highest ? -INFINITY : INFINITY;
    const span rows = around(j * m->factor, m->factor, f->ny);
    for (size_t i = 0; i < f->nx; i++) column[i] = none;
    for (size_t y = rows.begin; y < rows.end; y++) {
        const float *restrict z = f->z + y * f->stride;
        for (size_t i = 0; i < f->nx; i++) column[i] = extreme(highest, column[i], z[i]);
    }
    for (size_t i = 0; i < m->nx; i++) {
        const span columns = around(i * m->factor, m->factor, f->nx);
        float z = none;
        for (size_t x = columns.begin; x < columns.end; x++) z = extreme(highest, z, column[x]);
        m->z[j * m->nx + i] = z == none ? NAN : z;
    }
}

static void make_rows(void *context, size_t begin, size_t end) {
    maker *m = context;
    double *columns = malloc(2 * m->full->nx * sizeof *columns);
    if (columns == NULL) {
        atomic_store(&m->out_of_memory, true);
        return;
    }
    for (size_t j = begin; j < end; j++) {
        if (m->filter == CW_FILTER_MEAN)
            average_row(m, j, columns, columns + m->full->nx);
        else if (m->filter == CW_FILTER_HIGHEST)
            extreme_row(m, j, (float *)columns, true);
        else
            extreme_row(m, j, (float *)columns, false);
    }
    free(columns);
}

static cw_status make_samples(maker *m, size_t ny, const cw_run *how) {
    m->z = large_allocate(m->nx * ny * sizeof *m->z);
    if (m->z == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    const size_t grain = COARSER_GRAIN / (m->nx * m->factor * m->factor);
    cw_status status = cw_run_work(how, ny, grain, grain, make_rows, m);
    if (status == CW_OK && atomic_load(&m->out_of_memory)) status = cw_fail_plainly(CW_ERROR_MEMORY);
    return status;
}

/* Shares of the watch: the samples are read once for each of the three. */
static cw_status make(maker *m, const cw_field *full, size_t ny, const cw_run *how, cw_field **coarser,
                      cw_difference *difference) {
    const double made = difference ? 0.4 : 0.8, built = difference ? 0.5 : 1;
    const cw_run sampling = cw_run_part_of(&(run_part){how, 0, made});
    const cw_run building = cw_run_part_of(&(run_part){how, made, built});
    const cw_run measuring = cw_run_part_of(&(run_part){how, built, 1});
    cw_status status = make_samples(m, ny, &sampling);
    cw_field_desc desc = {.samples = m->z, .nx = m->nx, .ny = ny, .storage = CW_COPY};
    const cw_field_info info = cw_field_describe(full); /* whose map ties the field to user space */
    memcpy(desc.map, info.map, sizeof desc.map);
    for (int k = 0; k < 3; k++)
        for (int a = 0; a < 2; a++) desc.map[k][a] *= (double)m->factor;
    if (status == CW_OK) status = cw_field_create(&desc, &building, coarser);
    large_release(m->z);
    if (status != CW_OK || difference == NULL) return status;
    const struct samples z = samples_of(*coarser);
    status = cw_difference_measure(m->full, &z, m->factor, &measuring, difference);
    if (status == CW_OK) return status;
    cw_field_destroy(*coarser);
    *coarser = NULL;
    return status;
}

cw_status cw_field_coarser(const cw_field *field, const cw_run *run, size_t factor, int32_t filter, cw_field **coarser,
                           cw_difference *difference, size_t size) {
    FPENV_HERE;
    if (coarser == NULL) return cw_fail(CW_ERROR_ARGUMENT, "coarser: NULL");
    *coarser = NULL;
    if (field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    if (factor < 2 || factor > CW_SIDE_MAX)
        return cw_fail(CW_ERROR_ARGUMENT, "factor: %zu; it is from 2 to %d", factor, CW_SIDE_MAX);
    if (filter < CW_FILTER_MEAN || filter > CW_FILTER_LOWEST)
        return cw_fail(CW_ERROR_ARGUMENT, "filter: %d; it is from %d to %d", filter, CW_FILTER_MEAN, CW_FILTER_LOWEST);
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status != CW_OK) return status;
    door_pass in;
    if (!cw_field_enter(field, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    const struct samples full = samples_of(field);
    maker m = {.full = &full, .nx = (full.nx - 2) / factor + 2, .factor = factor, .filter = filter};
    cw_difference all;
    status = make(&m, field, (full.ny - 2) / factor + 2, &how, coarser, difference ? &all : NULL);
    cw_field_leave(in);
    if (status != CW_OK || difference == NULL) return status;
    memset(difference, 0, size);
    memcpy(difference, &all, size < sizeof all ? size : sizeof all);
    return status;
}
