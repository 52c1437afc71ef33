/* SPDX-License-Identifier: Apache-2.0 */
#include "survey.h"

#include "error.h"
#include "memory.h"
#include "pyramid.h"

#include <float.h>
#include <math.h>

static cw_status refused(size_t i, size_t j, float z) {
    if (isfinite(z))
        return cw_fail(CW_ERROR_SAMPLE, "sample (%zu, %zu) is %g; heights lie within plus or minus 2^100", i, j,
                       (double)z);
    return cw_fail(CW_ERROR_SAMPLE, "sample (%zu, %zu) is %g; borrowed samples mark holes by NaN alone", i, j,
                   (double)z);
}

cw_status cw_refusal_status(const cw_field *f, cw_refusal *refusal) {
    const uint64_t first = atomic_load(&refusal->first);
    if (first == CW_REFUSED_NONE) return CW_OK;
    const size_t i = first % f->nx, j = first / f->nx;
    return refused(i, j, f->z[j * f->stride + i]);
}

static void refuse(cw_refusal *refusal, uint64_t number) {
    uint64_t first = atomic_load(&refusal->first);
    while (number < first && !atomic_compare_exchange_weak(&refusal->first, &first, number)) continue;
}

bool cw_survey_create(cw_field *f) {
    const size_t across = cw_tiles_across(f), down = cw_tiles_down(f);
    f->tile = cw_memory_clear(&f->memory, (across + 1) * down * sizeof *f->tile);
    f->tile_row = f->tile + across * down;
    return f->tile != NULL;
}

void cw_survey_destroy(cw_field *f) { cw_memory_free(&f->memory, f->tile); }

/* Counts holes and finds refused values in samples that are not all heights. */
static void look_closer(const cw_field *f, size_t begin, size_t end, size_t j, cw_survey *s, cw_refusal *refusal) {
    for (size_t i = begin; i < end; i++) {
        const float h = f->z[j * f->stride + i];
        if (fabsf(h) <= CW_HEIGHT_MAX) continue;
        s->holes += isfinite(h) ? 0 : 1;
        if (!isnan(h)) refuse(refusal, (uint64_t)j * f->nx + i);
    }
}

void cw_survey_tile(cw_field *f, size_t x, size_t y, cw_refusal *refusal) {
    enum { COLUMNS = TILE_SIDE + 1 };
    float low[COLUMNS], high[COLUMNS];
    const size_t across = cw_tiles_across(f), begin = x * TILE_SIDE, end = x + 1 < across ? begin + TILE_SIDE : f->nx;
    const size_t row = y * TILE_SIDE, row_end = y + 1 < cw_tiles_down(f) ? row + TILE_SIDE : f->ny, n = end - begin;
    cw_survey s = {.low = FLT_MAX, .high = -FLT_MAX};
    for (size_t k = 0; k < n; k++) {
        low[k] = FLT_MAX;
        high[k] = -FLT_MAX;
    }
    for (size_t j = row; j < row_end; j++) {
        const float *restrict z = f->z + j * f->stride + begin;
        int32_t odd = 0;
        for (size_t k = 0; k < n; k++) {
            odd |= !(fabsf(z[k]) <= CW_HEIGHT_MAX);
            low[k] = lower(z[k], low[k]);
            high[k] = higher(z[k], high[k]);
        }
        if (odd) look_closer(f, begin, end, j, &s, refusal);
    }
    for (size_t k = 0; k < n; k++) {
        s.low = lower(low[k], s.low);
        s.high = higher(high[k], s.high);
    }
    f->tile[y * across + x] = s;
}

static void add(cw_survey *sum, const cw_survey *s, size_t n) {
    *sum = (cw_survey){.low = FLT_MAX, .high = -FLT_MAX};
    for (size_t k = 0; k < n; k++) {
        sum->low = lower(s[k].low, sum->low);
        sum->high = higher(s[k].high, sum->high);
        sum->holes += s[k].holes;
    }
}

/* From farther away than this, a ray's origin would add more to errors than the field itself does: half a side's
 * length outside the field; and eight times its range of heights above or below, as rays from a camera above should
 * count as near. */
static void set_reach(cw_field *f) {
    const float range = f->high - f->low;
    f->middle[0] = 0.5f * (float)(f->nx - 1);
    f->middle[1] = 0.5f * (float)(f->ny - 1);
    f->middle[2] = range >= 0 ? 0.5f * (f->low + f->high) : 0;
    f->reach[0] = (float)(f->nx - 1);
    f->reach[1] = (float)(f->ny - 1);
    f->reach[2] = range > 0 ? 8 * range : INFINITY; /* on a level field, or none, heights cost no accuracy */
}

void cw_survey_total(cw_field *f, cw_tiles changed) {
    const size_t across = cw_tiles_across(f);
    cw_survey all;
    for (size_t y = changed.y; y <= changed.y_last; y++) add(&f->tile_row[y], f->tile + y * across, across);
    add(&all, f->tile_row, cw_tiles_down(f));
    f->low = all.low + 0.0f; /* which zero is lowest would depend on who looked first */
    f->high = all.high + 0.0f;
    f->holes = all.holes;
    set_reach(f);
}

cw_status cw_survey_check(const float *z, size_t i, size_t j, size_t n, bool infinities) {
    int32_t odd = 0;
    for (size_t k = 0; k < n; k++) odd |= !(fabsf(z[k]) <= CW_HEIGHT_MAX);
    for (size_t k = 0; odd && k < n; k++)
        if (fabsf(z[k]) > CW_HEIGHT_MAX && !(infinities && isinf(z[k]))) return refused(i + k, j, z[k]);
    return CW_OK;
}
