/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons come from headings: the steepest rise from each sample, found on the way outward in one go. */

#include "horizon.h"

#include "compass.h"
#include "normal.h"
#include "sight.h"

#include <math.h>
#include <stdlib.h>

struct horizon {
    const terrain *terrain;
    double *azimuths;
    compass compass;
    float *work;
    double *sums; /* of the sky */
    size_t room;  /* samples in both */
    bool leans;   /* it has three numbers for each of them */
    double curvature, max_distance;
    sight_bounds *bounds; /* for distances; NULL until they are needed */
    float *turned;        /* samples upside down, of `under` */
    cw_field *field;
    terrain under;
};

static const double degree = 0.017453292519943295;

/* The same terrain with each height negated. */
static cw_status turn_over(horizon *h) {
    const terrain *t = h->terrain;
    h->turned = malloc(t->nx * t->ny * sizeof *h->turned);
    if (h->turned == NULL) return CW_ERROR_MEMORY;
    for (size_t k = 0; k < t->nx * t->ny; k++) h->turned[k] = isfinite(t->z[k]) ? -t->z[k] : NAN;
    const cw_field_desc desc = {.samples = h->turned, .nx = t->nx, .ny = t->ny, .storage = CW_BORROW};
    const cw_status status = cw_field_create(&desc, NULL, &h->field);
    h->under = *t;
    h->under.field = h->field;
    h->under.z = h->turned;
    h->terrain = &h->under;
    return status;
}

cw_status horizon_create(const terrain *t, const horizon_desc *desc, horizon **out) {
    const double start = desc->start;
    const size_t count = desc->count;
    *out = NULL;
    if (count == 0 || count > COMPASS_MOST || !isfinite(start)) return CW_ERROR_ARGUMENT;
    if (desc->below && desc->curvature != 0) return CW_ERROR_ARGUMENT;
    horizon *h = calloc(1, sizeof *h);
    if (h == NULL) return CW_ERROR_MEMORY;
    h->terrain = t;
    h->azimuths = calloc(count, sizeof *h->azimuths);
    for (size_t k = 0; k < count && h->azimuths != NULL; k++)
        h->azimuths[k] = fmod(start + 360 * (double)k / (double)count, 360);
    h->curvature = desc->curvature;
    h->max_distance = desc->max_distance;
    cw_status status = h->azimuths == NULL ? CW_ERROR_MEMORY : CW_OK;
    if (status == CW_OK && desc->below) status = turn_over(h);
    if (status == CW_OK)
        status = compass_create(&h->compass, h->terrain, h->azimuths, count, desc->max_distance, desc->curvature);
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
    free(h->sums);
    cw_field_destroy(h->field);
    free(h->turned);
    if (h->bounds) sight_bounds_destroy(h->bounds);
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

/* The rises of rows from this one on, *rows at most; sets that to how many share a heading; slope as compass_heading sets it. */
static cw_status find_rises(horizon *h, const cw_run *query, size_t number, size_t row, size_t *rows, float *rises,
                            double *slope) {
    size_t alike;
    cw_heading *heading;
    compass_turn(&h->compass, row, &alike);
    if (alike < *rows) *rows = alike;
    const cw_status status = compass_heading(&h->compass, number, &heading, slope);
    if (status != CW_OK) return status;
    const cw_rectangle at = {0, row, h->terrain->nx, *rows};
    return cw_heading_steepest(heading, query, -INFINITY, INFINITY, at, rises);
}

cw_status horizon_angles(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *degrees) {
    const size_t nx = h->terrain->nx, end = row + rows;
    if (number >= h->compass.count) return CW_ERROR_ARGUMENT;
    for (size_t count; row < end; row += count, degrees += count * nx) {
        double slope;
        count = end - row;
        const cw_status status = find_rises(h, query, number, row, &count, degrees, &slope);
        if (status != CW_OK) return status;
        turning t = {degrees, (float)(1 / slope)};
        cw_pool_run(query ? query->pool : NULL, nx * count, GRAIN, to_degrees, &t);
    }
    return CW_OK;
}

/* ---- distances ------------------------------------------------------------------------------------------------------ */

typedef struct locating {
    const horizon *horizon;
    size_t row;
    double dir[2], length; /* a step of the heading: in cells, and in metres */
    float *metres;         /* rises for each step that the heading has found, and then distances */
} locating;

/* Metres to the horizon of a sample, of which the rise is known as a float. With that most of the line of sight is passed over. */
static float locate(const locating *l, size_t i, size_t j, double rise) {
    const terrain *t = l->horizon->terrain;
    const double eye[3] = {(double)i, (double)j, (double)t->z[j * t->nx + i]};
    sight s;
    sight_init(&s, t, l->horizon->bounds, eye, l->horizon->curvature);
    s.at_crossings = true;
    double far = terrain_steps_out(t, eye, l->dir); /* a limit counts as the heading's */
    if (l->horizon->max_distance > 0) far = fmin(far, l->horizon->max_distance / l->length * (1 + 0x1p-20));
    const double to[2] = {eye[0] + far * l->dir[0], eye[1] + far * l->dir[1]};
    const double least = (rise - 0x1p-18 * fabs(rise) - 0x1p-40 * fabs(eye[2])) * far;
    sight_rise r = sight_steepest(&s, to[0], to[1], least);
    if (r.share == 0) r = sight_steepest(&s, to[0], to[1], -INFINITY);
    return r.share > 0 ? (float)(sight_nearest(&s, to[0], to[1], r) * far * l->length) : NAN;
}

static void locate_some(void *context, size_t begin, size_t end) {
    const locating *l = context;
    const size_t nx = l->horizon->terrain->nx;
    for (size_t k = begin; k < end; k++) {
        const double rise = (double)l->metres[k];
        l->metres[k] = isfinite(rise) ? locate(l, k % nx, l->row + k / nx, rise) : NAN;
    }
}

cw_status horizon_distances(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *metres) {
    enum { FEW = 256 };
    const terrain *t = h->terrain, *whole = terrain_whole(t);
    const size_t nx = t->nx, end = row + rows;
    if (number >= h->compass.count) return CW_ERROR_ARGUMENT;
    if (h->bounds == NULL) {
        const cw_status status = sight_bounds_create(t, &h->bounds);
        if (status != CW_OK) return status;
    }
    for (size_t count; row < end; row += count, metres += count * nx) {
        double slope;
        count = end - row;
        const cw_status status = find_rises(h, query, number, row, &count, metres, &slope);
        if (status != CW_OK) return status;
        locating l = {.horizon = h, .row = row, .metres = metres};
        l.length = terrain_direction(whole, 0.5 * (double)(whole->nx - 1), compass_middle(&h->compass),
                                     h->azimuths[number], l.dir);
        cw_pool_run(query ? query->pool : NULL, nx * count, FEW, locate_some, &l);
    }
    return CW_OK;
}

/* ---- the sky -------------------------------------------------------------------------------------------------------- */

typedef struct adding {
    const float *rises;
    double *sum;
    float per_rise;
    double weight;
} adding;

/* cos² = 1 / (1 + tan²). A hole's NaN stays. */
static void add_sky(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        const float up = a->rises[k] * a->per_rise, tangent = up < 0 ? 0 : up;
        a->sum[k] += a->weight * (double)(1 / (1 + tangent * tangent));
    }
}

/* The sky over ground that rises by s in that direction, above the horizon's angle a: for a normal of upward part n
 * it is n / π times the integral of (sin x - s cos x) cos x over x from a to π / 2, for each radian of azimuth.
 * Times 2 π it is n (cos² a - s (π / 2 - a - sin a cos a)). */
typedef struct tilting {
    const float *rises, *east, *north;
    double *sum;
    float per_rise;
    float towards[2]; /* the direction: east, north */
} tilting;

static void add_tilted_sky(void *context, size_t begin, size_t end) {
    const tilting *a = context;
    for (size_t k = begin; k < end; k++) {
        const float slope = a->east[k] * a->towards[0] + a->north[k] * a->towards[1];
        const float rise = a->rises[k] * a->per_rise, tangent = rise < slope ? slope : rise; /* NaN stays */
        const float square = 1 / (1 + tangent * tangent);
        const float rest = (float)degree * horizon_degrees(1 / fabsf(tangent)) - tangent * square;
        a->sum[k] += (double)(square - slope * rest);
    }
}

typedef struct opening {
    const float *rises;
    double *sum;
    float *count, per_rise;
} opening;

/* Without terrain in that direction, or at a hole, there is no angle. */
static void add_opening(void *context, size_t begin, size_t end) {
    const opening *a = context;
    for (size_t k = begin; k < end; k++) {
        if (!isfinite(a->rises[k])) continue;
        a->sum[k] += 90 - (double)horizon_degrees(a->rises[k] * a->per_rise);
        a->count[k]++;
    }
}

/* One direction more, for rows that share their headings. count: NULL for the sky, or of directions with terrain. lean: NULL for level
 * ground, or slopes eastward of the rows' samples and, room samples on, northward. */
static cw_status add_direction(horizon *h, const cw_run *query, size_t k, size_t row, size_t rows, float *count,
                               const float *lean, double *sum) {
    cw_heading *heading;
    double slope;
    const size_t nx = h->terrain->nx;
    cw_status status = compass_heading(&h->compass, k, &heading, &slope);
    /* Terrain below the level hides nothing of the sky. */
    if (status == CW_OK)
        status = cw_heading_steepest(heading, query, count ? -INFINITY : 0, INFINITY, (cw_rectangle){0, row, nx, rows},
                                     h->work);
    if (status != CW_OK) return status;
    cw_pool *pool = query ? query->pool : NULL;
    const float per_rise = (float)(1 / slope);
    if (count) {
        cw_pool_run(pool, nx * rows, GRAIN, add_opening, &(opening){h->work, sum, count, per_rise});
        return CW_OK;
    }
    if (lean == NULL) {
        cw_pool_run(pool, nx * rows, GRAIN, add_sky, &(adding){h->work, sum, per_rise, 1});
        return CW_OK;
    }
    double sine, cosine;
    terrain_sine_cosine(h->azimuths[k], &sine, &cosine);
    tilting a = {h->work, lean, lean + h->room, sum, per_rise, {(float)sine, (float)cosine}};
    cw_pool_run(pool, nx * rows, GRAIN, add_tilted_sky, &a);
    return CW_OK;
}

typedef struct leaning {
    const terrain *terrain;
    size_t row;
    float *east, *north, *share;
} leaning;

static void find_slopes(void *context, size_t begin, size_t end) {
    const leaning *l = context;
    const size_t nx = l->terrain->nx;
    for (size_t j = begin; j < end; j++) terrain_slope_row(l->terrain, l->row + j, l->east + j * nx, l->north + j * nx);
}

/* Times the normal's upward part. */
static void turn_upright(void *context, size_t begin, size_t end) {
    const leaning *l = context;
    for (size_t k = begin; k < end; k++) l->share[k] /= sqrtf(1 + l->east[k] * l->east[k] + l->north[k] * l->north[k]);
}

enum { SKY, TILTED_SKY, OPENNESS };

static cw_status sum_up(horizon *h, const cw_run *query, int kind, size_t row, size_t rows, float *share,
                        terrain_progress *progress, void *context, bool *done) {
    const size_t nx = h->terrain->nx, first = row, end = row + rows;
    cw_pool *pool = query ? query->pool : NULL;
    const bool tilted = kind == TILTED_SKY;
    *done = false;
    if (h->room < nx * rows || (tilted && !h->leans)) {
        free(h->work);
        free(h->sums);
        h->work = malloc(nx * rows * sizeof *h->work * (tilted ? 3 : 1));
        h->sums = malloc(nx * rows * sizeof *h->sums);
        h->room = h->work && h->sums ? nx * rows : 0;
        h->leans = tilted;
        if (h->room == 0) return CW_ERROR_MEMORY;
    }
    leaning lean = {h->terrain, row, h->work + h->room, h->work + 2 * h->room, share};
    if (tilted) cw_pool_run(pool, rows, 4, find_slopes, &lean);
    for (size_t k = 0; k < nx * rows; k++) h->sums[k] = 0;
    for (size_t k = 0; k < nx * rows && kind == OPENNESS; k++) share[k] = 0; /* counts of directions at first */
    for (size_t count; row < end; row += count) {
        compass_turn(&h->compass, row, &count);
        count = count < end - row ? count : end - row;
        const size_t at = (row - first) * nx;
        for (size_t k = 0; k < h->compass.count; k++) {
            const double part = (double)k / (double)h->compass.count;
            if (progress && !progress(context, ((double)(row - first) + part * (double)count) / (double)rows))
                return CW_OK;
            const cw_status status = add_direction(h, query, k, row, count, kind == OPENNESS ? share + at : NULL,
                                                   tilted ? lean.east + at : NULL, h->sums + at);
            if (status != CW_OK) return status;
        }
    }
    /* Shares of a free sky are 1: a sum of so many of them. */
    for (size_t k = 0; k < nx * rows; k++)
        share[k] = (float)(h->sums[k] / (kind == OPENNESS ? (double)share[k] : (double)h->compass.count));
    if (tilted) cw_pool_run(pool, nx * rows, GRAIN, turn_upright, &lean);
    *done = true;
    return CW_OK;
}

cw_status horizon_sky_view(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                           terrain_progress *progress, void *context, bool *done) {
    return sum_up(h, query, SKY, row, rows, share, progress, context, done);
}

cw_status horizon_sky_view_tilted(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                                  terrain_progress *progress, void *context, bool *done) {
    return sum_up(h, query, TILTED_SKY, row, rows, share, progress, context, done);
}

cw_status horizon_openness(horizon *h, const cw_run *query, size_t row, size_t rows, float *degrees,
                           terrain_progress *progress, void *context, bool *done) {
    return sum_up(h, query, OPENNESS, row, rows, degrees, progress, context, done);
}
