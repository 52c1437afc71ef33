/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons come from headings: the steepest rise from each sample, found on the way outward in one go. */

#include "horizon.h"

#include "compass.h"

#include <math.h>
#include <stdlib.h>

struct horizon {
    const terrain *terrain;
    double *azimuths;
    compass compass;
    float *work;
    size_t room;
};

cw_status horizon_create(const terrain *t, const horizon_desc *desc, horizon **out) {
    const double start = desc->start;
    const size_t count = desc->count;
    *out = NULL;
    if (count == 0 || count > COMPASS_MOST || !isfinite(start)) return CW_ERROR_ARGUMENT;
    horizon *h = calloc(1, sizeof *h);
    if (h == NULL) return CW_ERROR_MEMORY;
    h->terrain = t;
    h->azimuths = calloc(count, sizeof *h->azimuths);
    for (size_t k = 0; k < count && h->azimuths != NULL; k++)
        h->azimuths[k] = fmod(start + 360 * (double)k / (double)count, 360);
    const cw_status status =
        h->azimuths ? compass_create(&h->compass, t, h->azimuths, count, desc->max_distance, desc->curvature)
                    : CW_ERROR_MEMORY;
    if (status == CW_OK)
        *out = h;
    else
        horizon_destroy(h);
    return status;
}

void horizon_destroy(horizon *h) {
    if (h == NULL) return;
    compass_destroy(&h->compass);
    free(h->azimuths);
    free(h->work);
    free(h);
}

double horizon_azimuth(const horizon *h, size_t number) { return h->azimuths[number]; }

/* A polynomial fitted at Chebyshev's points of [0, 1]; libm's own function takes another way on another CPU. */
float horizon_degrees(float x) {
    static const float c[9] = {57.29578f,   -19.098423f, 11.454499f,   -8.134739f, 6.083878f,
                               -4.2724633f, 2.414308f,   -0.90133417f, 0.15849637f};
    const float size = fabsf(x), low = size > 1 ? 1 / size : size, u = low * low;
    float sum = c[8];
    for (int k = 7; k >= 0; k--) sum = sum * u + c[k];
    const float angle = size > 1 ? 90 - low * sum : low * sum;
    return x < 0 ? -angle : angle;
}

typedef struct turning {
    float *degrees;
    float per_rise;
} turning;

static void to_degrees(void *context, size_t begin, size_t end) {
    const turning *t = context;
    for (size_t k = begin; k < end; k++) t->degrees[k] = horizon_degrees(t->degrees[k] * t->per_rise);
}

enum { GRAIN = 1 << 14 };

cw_status horizon_angles(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *degrees) {
    const size_t nx = h->terrain->nx, end = row + rows;
    if (number >= h->compass.count) return CW_ERROR_ARGUMENT;
    for (size_t count; row < end; row += count, degrees += count * nx) {
        compass_turn(&h->compass, row, &count);
        count = count < end - row ? count : end - row;
        cw_heading *heading;
        double slope;
        cw_status status = compass_heading(&h->compass, number, &heading, &slope);
        if (status != CW_OK) return status;
        status = cw_heading_steepest(heading, query, -INFINITY, INFINITY, (cw_rectangle){0, row, nx, count}, degrees);
        if (status != CW_OK) return status;
        turning t = {degrees, (float)(1 / slope)};
        cw_pool_run(query ? query->pool : NULL, nx * count, GRAIN, to_degrees, &t);
    }
    return CW_OK;
}

typedef struct adding {
    const float *rises;
    float *share;
    float per_rise, weight;
} adding;

/* cos² = 1 / (1 + tan²). A hole's NaN stays. */
static void add_sky(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        const float tangent = a->rises[k] * a->per_rise;
        a->share[k] += a->weight / (1 + tangent * tangent);
    }
}

/* One direction more, for rows that share their headings. */
static cw_status add_direction(horizon *h, const cw_run *query, size_t k, size_t row, size_t rows, float *share) {
    cw_heading *heading;
    double slope;
    const size_t nx = h->terrain->nx;
    cw_status status = compass_heading(&h->compass, k, &heading, &slope);
    /* What lies below the level hides nothing of the sky. */
    if (status == CW_OK)
        status = cw_heading_steepest(heading, query, 0, INFINITY, (cw_rectangle){0, row, nx, rows}, h->work);
    if (status != CW_OK) return status;
    adding a = {h->work, share, (float)(1 / slope), 1 / (float)h->compass.count};
    cw_pool_run(query ? query->pool : NULL, nx * rows, GRAIN, add_sky, &a);
    return CW_OK;
}

cw_status horizon_sky_view(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                           terrain_progress *progress, void *context, bool *done) {
    const size_t nx = h->terrain->nx, first = row, end = row + rows;
    *done = false;
    if (h->room < nx * rows) {
        free(h->work);
        h->work = malloc(nx * rows * sizeof *h->work);
        h->room = h->work ? nx * rows : 0;
        if (h->work == NULL) return CW_ERROR_MEMORY;
    }
    for (size_t k = 0; k < nx * rows; k++) share[k] = 0;
    for (size_t count; row < end; row += count, share += count * nx) {
        compass_turn(&h->compass, row, &count);
        count = count < end - row ? count : end - row;
        for (size_t k = 0; k < h->compass.count; k++) {
            const double part = (double)k / (double)h->compass.count;
            if (progress && !progress(context, ((double)(row - first) + part * (double)count) / (double)rows))
                return CW_OK;
            const cw_status status = add_direction(h, query, k, row, count, share);
            if (status != CW_OK) return status;
        }
    }
    *done = true;
    return CW_OK;
}
