/* SPDX-License-Identifier: Apache-2.0 */
#include "survey.h"

#include "error.h"

#include <math.h>

static cw_status refused(size_t i, size_t j, float z) {
    return cw_fail(CW_ERROR_SAMPLE, "sample (%zu, %zu) is %g; %s", i, j, (double)z,
                   isfinite(z) ? "heights lie within plus or minus 2^100" : "borrowed samples mark holes by NaN alone");
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

/* Counts holes and finds refused values in samples that are not all heights. */
static uint32_t look_closer(const cw_field *f, size_t begin, size_t end, size_t j, cw_refusal *refusal) {
    uint32_t holes = 0;
    for (size_t i = begin; i < end; i++) {
        const float h = f->z[j * f->stride + i];
        if (fabsf(h) <= CW_HEIGHT_MAX) continue;
        holes += isfinite(h) ? 0 : 1;
        if (!isnan(h)) refuse(refusal, (uint64_t)j * f->nx + i);
    }
    return holes;
}

/* True if one of n samples is no height. Without a branch, so that compilers vectorize it. */
static bool some_odd(const float *z, size_t n) {
    int32_t odd = 0;
    for (size_t k = 0; k < n; k++) odd |= !(fabsf(z[k]) <= CW_HEIGHT_MAX);
    return odd != 0;
}

uint32_t cw_count_holes(const cw_field *f, size_t x, size_t y, cw_refusal *refusal) {
    const size_t begin = x * TILE_SIDE, end = x + 1 < cw_tiles_across(f) ? begin + TILE_SIDE : f->nx;
    const size_t row = y * TILE_SIDE, row_end = y + 1 < cw_tiles_down(f) ? row + TILE_SIDE : f->ny;
    uint32_t holes = 0;
    for (size_t j = row; j < row_end; j++)
        if (some_odd(f->z + j * f->stride + begin, end - begin)) holes += look_closer(f, begin, end, j, refusal);
    return holes;
}

/* From farther away than this, a ray's origin would add more to errors than the field itself does: half a side's
 * length outside the field; and eight times its range of heights above or below, as rays from a camera above should
 * count as near. */
void cw_set_reach(cw_field *f) {
    const float range = f->high - f->low;
    f->middle[0] = 0.5f * (float)(f->nx - 1);
    f->middle[1] = 0.5f * (float)(f->ny - 1);
    f->middle[2] = range >= 0 ? 0.5f * (f->low + f->high) : 0;
    f->reach[0] = (float)(f->nx - 1);
    f->reach[1] = (float)(f->ny - 1);
    f->reach[2] = range > 0 ? 8 * range : INFINITY; /* on a level field, or none, heights cost no accuracy */
}

cw_status cw_survey_check(const float *z, size_t i, size_t j, size_t n, bool infinities) {
    const bool odd = some_odd(z, n);
    for (size_t k = 0; odd && k < n; k++)
        if (fabsf(z[k]) > CW_HEIGHT_MAX && !(infinities && isinf(z[k]))) return refused(i + k, j, z[k]);
    return CW_OK;
}
