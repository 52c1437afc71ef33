/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons come from headings: the steepest rise from each sample, found on the way outward in one go. */

#include "area.h"
#include "compass.h"
#include "normal.h"
#include "sight.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS_USUAL = 32, GRAIN = 1 << 14 };

typedef struct horizon {
    const terrain *terrain;
    cw_horizon desc;
    size_t count;
    int kind;
    double *azimuths;
    compass compass;
    size_t number; /* the direction that is looked in, but for sky views */
    float *work;   /* for samples of a block: rises, and slopes eastward and northward if tilted */
    double *sums;  /* of the sky, for them */
    size_t room;
    const sight_bounds *bounds; /* for distances */
    float *turned;              /* samples upside down, of `under` */
    cw_field *field;
    terrain under;
} horizon;

enum { ANGLES, SKY, TILTED_SKY, OPENNESS };

static const double degree = 0.017453292519943295;

/* The same terrain with each height negated. */
static cw_status turn_over(horizon *h, const cw_run *run) {
    const terrain *t = h->terrain;
    h->turned = malloc(t->nx * t->ny * sizeof *h->turned);
    if (h->turned == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    for (size_t j = 0; j < t->ny; j++)
        for (size_t i = 0; i < t->nx; i++) {
            const float z = terrain_row(t, j)[i];
            h->turned[j * t->nx + i] = isfinite(z) ? -z : NAN;
        }
    const cw_field_desc desc = {.samples = h->turned, .nx = t->nx, .ny = t->ny, .storage = CW_BORROW};
    const cw_status status = cw_field_create(&desc, &(cw_run){.pool = run->pool}, &h->field);
    h->under = *t;
    h->under.field = h->field;
    h->under.z = h->turned;
    h->under.stride = t->nx;
    h->under.bounds = NULL;
    h->under.own = NULL;
    h->terrain = &h->under;
    return status;
}

static cw_status check(const cw_horizon *d) {
    cw_status status = cw_check_zeros(d->reserved, 0, "cw_horizon");
    if (status == CW_OK) status = cw_check_number("start", d->start, -0x1p40, 0x1p40);
    if (status == CW_OK) status = cw_check_number("max_distance", d->max_distance, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("count", d->count, 0, COMPASS_MOST);
    if (status == CW_OK) status = cw_check_number("flags", d->flags, 0, CW_HORIZON_TILTED + CW_HORIZON_BELOW);
    if (status == CW_OK && (d->flags & CW_HORIZON_BELOW) != 0 && d->curvature != 0)
        status = cw_fail(CW_ERROR_ARGUMENT, "curvature: %g; with CW_HORIZON_BELOW the earth is flat", d->curvature);
    return status;
}

static void destroy(horizon *h) {
    cw_compass_destroy(&h->compass);
    free(h->azimuths);
    free(h->work);
    free(h->sums);
    cw_field_destroy(h->field);
    free(h->turned);
}

/* To be destroyed also on failure. */
static cw_status create(horizon *h, const terrain *t, const cw_horizon *desc, const cw_run *run, int kind) {
    const cw_status status = check(desc);
    *h = (horizon){.terrain = t, .desc = *desc, .count = desc->count > 0 ? desc->count : DIRECTIONS_USUAL};
    if (status != CW_OK) return status;
    h->kind = kind;
    if ((desc->flags & CW_HORIZON_BELOW) != 0) {
        const cw_status turned = turn_over(h, run);
        if (turned != CW_OK) return turned;
    }
    h->azimuths = calloc(h->count, sizeof *h->azimuths);
    if (h->azimuths == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    for (size_t k = 0; k < h->count; k++) h->azimuths[k] = fmod(desc->start + 360 * (double)k / (double)h->count, 360);
    return cw_compass_create(&h->compass, h->terrain, h->azimuths, h->count, desc->max_distance, desc->curvature);
}

cw_status cw_horizon_azimuths(const cw_terrain *t, const cw_horizon *desc, double *azimuths) {
    if (t == NULL || desc == NULL || azimuths == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", !t ? "terrain" : !desc ? "horizon" : "azimuths");
    horizon h;
    cw_horizon level = *desc;
    level.flags = 0;
    const cw_status status = create(&h, t, &level, NULL, ANGLES);
    for (size_t k = 0; k < h.count && status == CW_OK; k++) azimuths[k] = h.azimuths[k];
    destroy(&h);
    return status;
}

/* A polynomial fitted at Chebyshev's points of [0, 1]; libm's own function takes another way on another CPU. */
float cw_horizon_degrees(float x) {
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
    for (size_t k = begin; k < end; k++)
        t->degrees[k] = t->degrees[k] == -INFINITY ? NAN : cw_horizon_degrees(t->degrees[k] * t->per_rise);
}

/* ---- angles and distances ---------------------------------------------------------------------------------------------- */

typedef struct locating {
    const horizon *horizon;
    cw_rectangle at;
    double dir[2], length; /* a step of the heading: in cells, and in metres */
    float *metres;         /* rises for each step that the heading has found, and then distances */
} locating;

/* Metres to the horizon of a sample, of which the rise is known as a float. With that most of the line of sight is passed over. */
static float locate(const locating *l, size_t i, size_t j, double rise) {
    const terrain *t = l->horizon->terrain;
    const double eye[3] = {(double)i, (double)j, (double)terrain_row(t, j)[i]};
    sight s;
    cw_sight_init(&s, t, l->horizon->bounds, eye, l->horizon->desc.curvature);
    s.at_crossings = true;
    double far = cw_terrain_steps_out(t, eye, l->dir); /* a limit counts as the heading's */
    if (l->horizon->desc.max_distance > 0) far = fmin(far, l->horizon->desc.max_distance / l->length * (1 + 0x1p-20));
    const double to[2] = {eye[0] + far * l->dir[0], eye[1] + far * l->dir[1]};
    const double least = (rise - 0x1p-18 * fabs(rise) - 0x1p-40 * fabs(eye[2])) * far;
    sight_rise r = cw_sight_steepest(&s, to[0], to[1], least);
    if (r.share == 0) r = cw_sight_steepest(&s, to[0], to[1], -INFINITY);
    return r.share > 0 ? (float)(cw_sight_nearest(&s, to[0], to[1], r) * far * l->length) : NAN;
}

static void locate_some(void *context, size_t begin, size_t end) {
    const locating *l = context;
    const cw_rectangle at = l->at;
    for (size_t k = begin; k < end; k++) {
        const double rise = (double)l->metres[k];
        l->metres[k] = isfinite(rise) ? locate(l, at.i + k % at.nx, at.j + k / at.nx, rise) : NAN;
    }
}

/* The angles of a block, or the distances if there are bounds for them. */
static cw_status fill_angles(void *context, const cw_run *run, cw_rectangle at, void *to) {
    enum { FEW = 256 };
    horizon *h = context;
    const terrain *whole = terrain_whole(h->terrain);
    const size_t end = at.j + at.ny, all = at.ny;
    float *out = to;
    for (size_t done = 0; at.j < end; at.j += at.ny, done += at.ny, out += at.nx * at.ny) {
        cw_heading *heading;
        double slope;
        cw_compass_turn(&h->compass, &at, end);
        run_part part = {run, (double)done / (double)all, (double)(done + at.ny) / (double)all};
        run_part rest = {run, part.begin + 0.1 * (part.end - part.begin), part.end};
        if (h->bounds) part.end = rest.begin;
        const cw_run some = cw_run_part_of(&part), far = cw_run_part_of(&rest);
        cw_status status = cw_compass_heading(&h->compass, h->number, &heading, &slope);
        if (status == CW_OK) status = cw_heading_steepest(heading, &some, -INFINITY, INFINITY, at, out);
        if (status != CW_OK) return status;
        if (h->bounds == NULL) {
            turning t = {out, (float)(1 / slope)};
            cw_pool_run(run->pool, at.nx * at.ny, GRAIN, to_degrees, &t);
            continue;
        }
        locating l = {.horizon = h, .at = at, .metres = out};
        l.length = cw_terrain_direction(whole, 0.5 * (double)(whole->nx - 1), cw_compass_middle(&h->compass),
                                        h->azimuths[h->number], l.dir);
        status = cw_run_work(&far, at.nx * at.ny, FEW, FEW, locate_some, &l);
        if (status != CW_OK) return status;
    }
    return CW_OK;
}

cw_status cw_horizon_angles(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, uint32_t number,
                            cw_area area, float *degrees, float *metres) {
    horizon h;
    cw_run how;
    cw_status status = cw_area_begin(t, desc, "horizon", run, &area, &how);
    if (status != CW_OK) return status;
    cw_horizon level = *desc;
    level.flags = 0;
    status = create(&h, t, &level, &how, ANGLES);
    h.number = number;
    if (status == CW_OK) status = cw_check_number("number", number, 0, (double)h.count - 1);
    run_part first = {&how, 0, metres ? 0.1 : 1}, second = {&how, degrees ? 0.1 : 0, 1};
    const cw_run angles = cw_run_part_of(&first), distances = cw_run_part_of(&second);
    if (status == CW_OK && (degrees || !metres))
        status = cw_area_make(area, &angles, sizeof *degrees, fill_angles, &h, degrees, "degrees");
    if (status == CW_OK && metres) {
        status = cw_terrain_bounds(t, &h.bounds);
        if (status == CW_OK) status = cw_area_make(area, &distances, sizeof *metres, fill_angles, &h, metres, "metres");
        cw_terrain_bounds_release(t, h.bounds);
    }
    destroy(&h);
    return status;
}

/* ---- the sky -------------------------------------------------------------------------------------------------------- */

/* One direction more. */
typedef struct adding {
    const float *rises, *east, *north; /* slopes of the ground, of the tilted sky */
    double *sum;
    float *count; /* of directions with terrain, of openness */
    float per_rise;
    float towards[2]; /* the direction: east, north */
} adding;

/* cos² = 1 / (1 + tan²). A hole's NaN stays. */
static void add_sky(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        const float up = a->rises[k] * a->per_rise, tangent = up < 0 ? 0 : up;
        a->sum[k] += (double)(1 / (1 + tangent * tangent));
    }
}

/* The sky over ground that rises by s in that direction, above the horizon's angle a: for a normal of upward part n
 * it is n / π times the integral of (sin x - s cos x) cos x over x from a to π / 2, for each radian of azimuth.
 * Times 2 π it is n (cos² a - s (π / 2 - a - sin a cos a)). */
static void add_tilted_sky(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        const float slope = a->east[k] * a->towards[0] + a->north[k] * a->towards[1];
        const float rise = a->rises[k] * a->per_rise, tangent = rise < slope ? slope : rise; /* NaN stays */
        const float square = 1 / (1 + tangent * tangent);
        const float rest = (float)degree * cw_horizon_degrees(1 / fabsf(tangent)) - tangent * square;
        a->sum[k] += (double)(square - slope * rest);
    }
}

/* Without terrain in that direction, or at a hole, there is no angle. */
static void add_opening(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        if (!isfinite(a->rises[k])) continue;
        a->sum[k] += 90 - (double)cw_horizon_degrees(a->rises[k] * a->per_rise);
        a->count[k]++;
    }
}

/* One direction more, for rows that share their headings. count: NULL for the sky, or of directions with terrain. lean:
 * NULL for level ground, or slopes eastward of the rows' samples and, room samples on, northward. */
static cw_status add_direction(horizon *h, const cw_run *run, size_t k, cw_rectangle at, float *count,
                               const float *lean, double *sum) {
    cw_heading *heading;
    double slope;
    const size_t n = at.nx * at.ny;
    cw_status status = cw_compass_heading(&h->compass, k, &heading, &slope);
    /* Terrain below the level hides nothing of the sky. */
    if (status == CW_OK) status = cw_heading_steepest(heading, run, count ? -INFINITY : 0, INFINITY, at, h->work);
    if (status != CW_OK) return status;
    adding a = {.rises = h->work, .sum = sum, .count = count, .per_rise = (float)(1 / slope)};
    if (lean) {
        double sine, cosine;
        cw_terrain_sine_cosine(h->azimuths[k], &sine, &cosine);
        a.east = lean;
        a.north = lean + h->room;
        a.towards[0] = (float)sine;
        a.towards[1] = (float)cosine;
    }
    cw_pool_run(run->pool, n, GRAIN, count ? add_opening : lean ? add_tilted_sky : add_sky, &a);
    return CW_OK;
}

typedef struct leaning {
    const terrain *terrain;
    cw_rectangle at;
    float *east, *north, *share;
} leaning;

static void find_slopes(void *context, size_t begin, size_t end) {
    const leaning *l = context;
    const size_t nx = l->at.nx;
    for (size_t j = begin; j < end; j++)
        cw_terrain_slope_row(l->terrain, l->at.j + j, l->at.i, nx, l->east + j * nx, l->north + j * nx);
}

/* Times the normal's upward part. */
static void turn_upright(void *context, size_t begin, size_t end) {
    const leaning *l = context;
    for (size_t k = begin; k < end; k++) l->share[k] /= sqrtf(1 + l->east[k] * l->east[k] + l->north[k] * l->north[k]);
}

static bool make_room(horizon *h, size_t n) {
    if (h->room >= n) return true;
    free(h->work);
    free(h->sums);
    h->work = malloc(n * sizeof *h->work * (h->kind == TILTED_SKY ? 3 : 1));
    h->sums = malloc(n * sizeof *h->sums);
    h->room = h->work && h->sums ? n : 0;
    return h->room > 0;
}

static cw_status fill_sky(void *context, const cw_run *run, cw_rectangle at, void *to) {
    horizon *h = context;
    const size_t n = at.nx * at.ny, end = at.j + at.ny, all = at.ny;
    float *share = to;
    if (!make_room(h, n)) return cw_fail_plainly(CW_ERROR_MEMORY);
    leaning lean = {h->terrain, at, h->work + h->room, h->work + 2 * h->room, share};
    if (h->kind == TILTED_SKY) cw_pool_run(run->pool, at.ny, 4, find_slopes, &lean);
    for (size_t k = 0; k < n; k++) h->sums[k] = 0;
    for (size_t k = 0; k < n && h->kind == OPENNESS; k++) share[k] = 0; /* counts of directions at first */
    for (size_t done = 0; at.j < end; at.j += at.ny, done += at.ny) {
        cw_compass_turn(&h->compass, &at, end);
        run_part part = {run, (double)done / (double)all, (double)(done + at.ny) / (double)all};
        const cw_run some = cw_run_part_of(&part);
        for (size_t k = 0; k < h->count; k++) {
            run_part way;
            const cw_run one = cw_run_share(&way, &some, k, h->count);
            const cw_status status =
                add_direction(h, &one, k, at, h->kind == OPENNESS ? share + done * at.nx : NULL,
                              h->kind == TILTED_SKY ? lean.east + done * at.nx : NULL, h->sums + done * at.nx);
            if (status != CW_OK) return status;
        }
    }
    /* Shares of a free sky are 1: a sum of so many of them. */
    for (size_t k = 0; k < n; k++)
        share[k] = (float)(h->sums[k] / (h->kind == OPENNESS ? (double)share[k] : (double)h->count));
    if (h->kind == TILTED_SKY) cw_pool_run(run->pool, n, GRAIN, turn_upright, &lean);
    return CW_OK;
}

static cw_status make_sum(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, int kind,
                          float *to, const char *name) {
    horizon h;
    cw_run how;
    cw_status status = cw_area_begin(t, desc, "horizon", run, &area, &how);
    if (status != CW_OK) return status;
    status = create(&h, t, desc, &how, kind);
    if (status == CW_OK) status = cw_area_make(area, &how, sizeof *to, fill_sky, &h, to, name);
    destroy(&h);
    return status;
}

cw_status cw_sky_view(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, float *share) {
    const bool tilted = desc && (desc->flags & CW_HORIZON_TILTED) != 0;
    if (desc && (desc->flags & CW_HORIZON_BELOW) != 0)
        return cw_fail(CW_ERROR_ARGUMENT, "flags: %u; CW_HORIZON_BELOW goes with cw_openness alone", desc->flags);
    return make_sum(t, run, desc, area, tilted ? TILTED_SKY : SKY, share, "share");
}

cw_status cw_openness(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, float *degrees) {
    return make_sum(t, run, desc, area, OPENNESS, degrees, "degrees");
}
