/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons come from headings: the steepest rise from each sample, found on the way outward in one go. */

#include "horizon.h"

#include "compass.h"
#include "grid_horizon.h"
#include "normal.h"
#include "sight.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct horizon {
    const terrain *terrain;
    double *azimuths;
    compass compass;
    float *work;
    double *sums; /* of the sky */
    size_t room;  /* samples in both */
    bool leans;   /* it has three numbers for each of them */
    bool grid;
    double curvature, max_distance;
    grid_direction *directions;
    float *rises; /* of the whole terrain, in direction number in_rises; NULL until there is one */
    size_t in_rises;
    float *sky;           /* of the whole terrain; NULL until it is known */
    sight_bounds *bounds; /* for distances; NULL until they are needed */
};

static const double degree = 0.017453292519943295;

/* Metres eastward and northward of a step from sample to sample, in the middle of a row. */
static void step_metres(const terrain *t, grid_direction d, double row, double metres[2]) {
    double scale[2];
    terrain_metres(t, 0.5 * (double)(t->nx - 1), row, scale);
    for (int k = 0; k < 2; k++) metres[k] = scale[k] * (t->map[k][0] * d.dx + t->map[k][1] * d.dy);
}

static double middle_row(const terrain *t) { return 0.5 * (double)(t->ny - 1); }

static double step_azimuth(const terrain *t, grid_direction d) {
    double metres[2];
    step_metres(t, d, middle_row(t), metres);
    const double azimuth = atan2(metres[0], metres[1]) / degree;
    return azimuth < 0 ? azimuth + 360 : azimuth;
}

bool horizon_has_grid(const terrain *t) {
    double middle[2], end[2];
    if (t->geographic) return false;
    terrain_metres(t, 0.5 * (double)(t->nx - 1), middle_row(t), middle);
    for (int e = 0; e < 2; e++) {
        terrain_metres(t, 0.5 * (double)(t->nx - 1), e ? (double)(t->ny - 1) : 0, end);
        for (int k = 0; k < 2; k++)
            if (!(fabs(end[k] / middle[k] - 1) <= 0.01)) return false;
    }
    return true;
}

/* Directions in the order of their azimuths. */
static cw_status make_grid(horizon *h, const horizon_desc *desc) {
    const size_t count = desc->count;
    if (!horizon_has_grid(h->terrain) || desc->max_distance > 0) return CW_ERROR_ARGUMENT;
    h->directions = malloc(GRID_DIRECTIONS_MOST * sizeof *h->directions);
    if (h->directions == NULL) return CW_ERROR_MEMORY;
    if (!grid_directions(count, h->directions)) return CW_ERROR_ARGUMENT;
    for (size_t k = 0; k < count; k++) {
        const grid_direction d = h->directions[k];
        const double azimuth = step_azimuth(h->terrain, d);
        size_t to = k;
        for (; to > 0 && h->azimuths[to - 1] > azimuth; to--) {
            h->azimuths[to] = h->azimuths[to - 1];
            h->directions[to] = h->directions[to - 1];
        }
        h->azimuths[to] = azimuth;
        h->directions[to] = d;
    }
    return CW_OK;
}

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
    h->grid = desc->grid;
    h->curvature = desc->curvature;
    h->max_distance = desc->max_distance;
    cw_status status = h->azimuths == NULL ? CW_ERROR_MEMORY : h->grid ? make_grid(h, desc) : CW_OK;
    if (status == CW_OK)
        status = compass_create(&h->compass, t, h->azimuths, count, desc->max_distance, desc->curvature);
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
    free(h->directions);
    free(h->rises);
    free(h->sky);
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

/* 1 / slope, as compass_heading sets that, of a direction of the grid in the rows that the compass is turned to. */
static float grid_per_rise(const horizon *h, size_t number) {
    double metres[2];
    step_metres(h->terrain, h->directions[number], compass_middle(&h->compass), metres);
    const double slope = hypot(metres[0], metres[1]) / h->terrain->map[2][2];
    return (float)(1 / slope);
}

/* Of the whole terrain in a direction of the grid. The earth falls away by the square of a step in the middle. */
static cw_status make_rises(horizon *h, const cw_run *query, size_t number) {
    const terrain *t = h->terrain;
    double metres[2];
    step_metres(t, h->directions[number], middle_row(t), metres);
    const double length = hypot(metres[0], metres[1]);
    if (h->rises != NULL && h->in_rises == number) return CW_OK;
    if (h->rises == NULL) h->rises = malloc(t->nx * t->ny * sizeof *h->rises);
    if (h->rises == NULL) return CW_ERROR_MEMORY;
    const double drop = h->curvature * length * length / (2 * t->radius * t->map[2][2]);
    h->in_rises = number;
    return grid_rises(t, h->directions[number], drop, query, h->rises);
}

static cw_status grid_angles(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *degrees) {
    const size_t nx = h->terrain->nx, end = row + rows;
    const cw_status status = make_rises(h, query, number);
    if (status != CW_OK) return status;
    memcpy(degrees, h->rises + row * nx, rows * nx * sizeof *degrees);
    for (size_t count; row < end; row += count, degrees += count * nx) {
        compass_turn(&h->compass, row, &count);
        turning t = {degrees, grid_per_rise(h, number)};
        count = count < end - row ? count : end - row;
        cw_pool_run(query ? query->pool : NULL, nx * count, GRAIN, to_degrees, &t);
    }
    return CW_OK;
}

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
    if (h->grid) return grid_angles(h, query, number, row, rows, degrees);
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
    if (number >= h->compass.count || h->grid) return CW_ERROR_ARGUMENT;
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

/* One direction more, for rows that share their headings. lean: NULL for level ground, or slopes eastward of the
 * rows' samples and, room samples on, northward. */
static cw_status add_direction(horizon *h, const cw_run *query, size_t k, size_t row, size_t rows, const float *lean,
                               double *sum) {
    cw_heading *heading;
    double slope;
    const size_t nx = h->terrain->nx;
    cw_status status = compass_heading(&h->compass, k, &heading, &slope);
    /* Terrain below the level hides nothing of the sky. */
    if (status == CW_OK)
        status = cw_heading_steepest(heading, query, 0, INFINITY, (cw_rectangle){0, row, nx, rows}, h->work);
    if (status != CW_OK) return status;
    cw_pool *pool = query ? query->pool : NULL;
    const float per_rise = (float)(1 / slope);
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

static cw_status sky_view(horizon *h, const cw_run *query, bool tilted, size_t row, size_t rows, float *share,
                          terrain_progress *progress, void *context, bool *done) {
    const size_t nx = h->terrain->nx, first = row, end = row + rows;
    cw_pool *pool = query ? query->pool : NULL;
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
    for (size_t count; row < end; row += count) {
        compass_turn(&h->compass, row, &count);
        count = count < end - row ? count : end - row;
        const size_t at = (row - first) * nx;
        for (size_t k = 0; k < h->compass.count; k++) {
            const double part = (double)k / (double)h->compass.count;
            if (progress && !progress(context, ((double)(row - first) + part * (double)count) / (double)rows))
                return CW_OK;
            const cw_status status =
                add_direction(h, query, k, row, count, tilted ? lean.east + at : NULL, h->sums + at);
            if (status != CW_OK) return status;
        }
    }
    /* Shares of a free sky are 1: a sum of so many of them. */
    for (size_t k = 0; k < nx * rows; k++) share[k] = (float)(h->sums[k] / (double)h->compass.count);
    if (tilted) cw_pool_run(pool, nx * rows, GRAIN, turn_upright, &lean);
    *done = true;
    return CW_OK;
}

/* A direction stands for half the angles to its neighbours. */
static double share_of_turn(const horizon *h, size_t k) {
    const size_t count = h->compass.count;
    const double before = k > 0 ? h->azimuths[k - 1] : h->azimuths[count - 1] - 360;
    const double after = k + 1 < count ? h->azimuths[k + 1] : h->azimuths[0] + 360;
    return (after - before) / 720;
}

/* Of the whole terrain, direction by direction. */
static cw_status grid_sky(horizon *h, const cw_run *query, terrain_progress *progress, void *context, bool *done) {
    const size_t n = h->terrain->nx * h->terrain->ny;
    double *sum = calloc(n, sizeof *sum);
    cw_status status = sum ? CW_OK : CW_ERROR_MEMORY;
    for (size_t k = 0; k < h->compass.count && status == CW_OK; k++) {
        if (progress && !progress(context, (double)k / (double)h->compass.count)) {
            free(sum);
            return CW_OK;
        }
        status = make_rises(h, query, k);
        for (size_t row = 0, count; row < h->terrain->ny && status == CW_OK; row += count) {
            compass_turn(&h->compass, row, &count);
            const size_t nx = h->terrain->nx, at = row * nx;
            adding a = {h->rises + at, sum + at, grid_per_rise(h, k), share_of_turn(h, k)};
            cw_pool_run(query ? query->pool : NULL, nx * count, GRAIN, add_sky, &a);
        }
    }
    if (status == CW_OK) h->sky = malloc(n * sizeof *h->sky);
    if (status == CW_OK && h->sky == NULL) status = CW_ERROR_MEMORY;
    *done = status == CW_OK;
    for (size_t k = 0; *done && k < n; k++) h->sky[k] = (float)sum[k];
    free(sum);
    return status;
}

cw_status horizon_sky_view(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                           terrain_progress *progress, void *context, bool *done) {
    *done = h->grid && h->sky != NULL;
    if (h->grid) {
        const cw_status status = *done ? CW_OK : grid_sky(h, query, progress, context, done);
        if (*done) memcpy(share, h->sky + row * h->terrain->nx, rows * h->terrain->nx * sizeof *share);
        return status;
    }
    return sky_view(h, query, false, row, rows, share, progress, context, done);
}

cw_status horizon_sky_view_tilted(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                                  terrain_progress *progress, void *context, bool *done) {
    if (h->grid) return CW_ERROR_ARGUMENT;
    return sky_view(h, query, true, row, rows, share, progress, context, done);
}
