/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons come from headings: the steepest rise from each sample, found on the way outward in one go. */

#include "area.h"
#include "compass.h"
#include "fpenv.h"
#include "sight.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS_USUAL = 32, GRAIN = 1 << 14 };

typedef struct horizon {
    const terrain *terrain;
    cw_horizon desc;
    bool opens; /* openness is summed, else sky */
    compass compass;
    size_t number;              /* the direction that is looked in, but for sums */
    const sight_bounds *bounds; /* for distances */
    float *turned;              /* samples upside down, of `under` */
    cw_field *field;
    terrain under;
} horizon;

static const double degree = 0.017453292519943295;

/* The same terrain with each height negated. */
static cw_status turn_over(horizon *h, const cw_run *run) {
    const terrain *t = h->terrain;
    h->turned = malloc(t->nx * t->ny * sizeof *h->turned);
    if (h->turned == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    door_pass in;
    if (!cw_terrain_enter(t, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    for (size_t k = 0; k < t->nx * t->ny; k++) h->turned[k] = -terrain_row(t, k / t->nx)[k % t->nx];
    cw_field_leave(in);
    const cw_field_desc desc = {.samples = h->turned, .nx = t->nx, .ny = t->ny, .storage = CW_BORROW};
    const cw_status status = cw_field_create(&desc, &(cw_run){.pool = run->pool}, &h->field);
    h->under = *t;
    h->under.field = h->field;
    h->under.z = h->turned;
    h->under.stride = t->nx;
    h->terrain = &h->under;
    return status;
}

static cw_status check(const cw_horizon *d) {
    cw_status status = cw_check_reserved(d->reserved, 8, 0, "cw_horizon");
    if (status == CW_OK) status = cw_check_number("start", d->start, -0x1p40, 0x1p40);
    if (status == CW_OK) status = cw_check_number("max_distance", d->max_distance, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, 1e9);
    if (status == CW_OK) status = cw_check_number("count", d->count, 0, COMPASS_MOST);
    return status;
}

static size_t count_of(const cw_horizon *d) { return d->count > 0 ? d->count : DIRECTIONS_USUAL; }

static void fill_azimuths(const cw_horizon *d, double *azimuths) {
    for (size_t k = 0; k < count_of(d); k++) azimuths[k] = fmod(d->start + 360 * (double)k / (double)count_of(d), 360);
}

cw_status cw_horizon_azimuths(const cw_terrain *t, const cw_horizon *desc, double *azimuths) {
    FPENV_HERE;
    if (t == NULL || desc == NULL || azimuths == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", !t ? "terrain" : !desc ? "horizon" : "azimuths");
    const cw_status status = check(desc);
    if (status == CW_OK) fill_azimuths(desc, azimuths);
    return status;
}

/* Of h->terrain, which turn_over may have replaced. */
static cw_status make_compass(horizon *h) {
    const cw_horizon *d = &h->desc;
    const cw_status status = cw_compass_create(&h->compass, h->terrain, count_of(d), d->max_distance, d->curvature);
    if (status == CW_OK) fill_azimuths(d, h->compass.azimuths);
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

/* ---- angles and distances ---------------------------------------------------------------------------------------- */

typedef struct locating {
    const horizon *horizon;
    cw_rectangle at;
    const compass_way *way;
    float *metres; /* rises for each step that the heading has found, and then distances */
} locating;

/* Metres to a sample's horizon, whose rise is known as a float. With that most of the line of sight is passed over. */
static float locate(const locating *l, size_t i, size_t j, double rise) {
    const terrain *t = l->horizon->terrain;
    const compass_way *way = l->way;
    const double eye[3] = {(double)i, (double)j, (double)terrain_row(t, j)[i]};
    sight s;
    cw_sight_init(&s, t, l->horizon->bounds, eye, l->horizon->desc.curvature);
    s.at_crossings = true;
    double far = cw_terrain_steps_out(t, eye, way->dir);
    if (l->horizon->desc.max_distance > 0) far = fmin(far, l->horizon->desc.max_distance / way->length + SIGHT_END);
    double to[2]; /* so many bits that its distance from the sample is the same in any window */
    for (int a = 0; a < 2; a++) to[a] = eye[a] + rint(far * way->dir[a] * 0x1p28) * 0x1p-28;
    const double least = (rise - 0x1p-18 * fabs(rise) - 0x1p-40 * fabs(eye[2])) * far;
    sight_rise r = cw_sight_steepest(&s, to[0], to[1], least);
    if (r.share == 0) r = cw_sight_steepest(&s, to[0], to[1], -INFINITY);
    return r.share > 0 ? (float)(cw_sight_nearest(&s, to[0], to[1], r) * far * way->length) : NAN;
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
static cw_status fill_angles(void *context, const cw_run *run, cw_rectangle at, void *to, void *room) {
    enum { FEW = 256 };
    horizon *h = context;
    (void)room;
    compass_way way;
    const cw_run some = cw_run_part_of(&(run_part){run, 0, h->bounds ? 0.1 : 1});
    cw_status status = cw_compass_look(&h->compass, h->number, &way);
    if (status == CW_OK) status = cw_heading_steepest(way.heading, &some, -INFINITY, INFINITY, at, to);
    if (status != CW_OK) return status;
    if (h->bounds) {
        door_pass in;
        if (!cw_terrain_enter(h->terrain, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
        const cw_run rest = cw_run_part_of(&(run_part){run, 0.1, 1});
        status = cw_run_work(&rest, at.nx * at.ny, FEW, FEW, locate_some, &(locating){h, at, &way, to});
        cw_field_leave(in);
        return status;
    }
    cw_pool_run(run->pool, at.nx * at.ny, GRAIN, to_degrees, &(turning){to, (float)(1 / way.slope)});
    return CW_OK;
}

cw_status cw_horizon_angles(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, uint32_t number,
                            cw_area area, float *degrees, float *metres) {
    FPENV_HERE;
    cw_run how;
    cw_status status = cw_area_begin(t, desc, "horizon", run, 1, &area, &how);
    if (status == CW_OK) status = check(desc);
    if (status == CW_OK) status = cw_check_number("number", number, 0, (double)count_of(desc) - 1);
    if (status != CW_OK) return status;
    horizon h = {.terrain = t, .desc = *desc, .number = number};
    status = make_compass(&h);
    run_part first = {&how, 0, metres ? 0.1 : 1}, second = {&how, degrees ? 0.1 : 0, 1};
    const cw_run angles = cw_run_part_of(&first), distances = cw_run_part_of(&second);
    if (status == CW_OK && (degrees || !metres))
        status = cw_compass_make(&h.compass, area, &angles, sizeof *degrees, 0, fill_angles, &h, degrees, "degrees");
    if (status == CW_OK && metres) {
        door_pass in;
        status = cw_terrain_enter(t, &in) ? cw_terrain_bounds(t, &h.bounds) : cw_fail_plainly(CW_ERROR_BUSY);
        cw_field_leave(in);
        if (status == CW_OK)
            status =
                cw_compass_make(&h.compass, area, &distances, sizeof *metres, 0, fill_angles, &h, metres, "metres");
        cw_terrain_bounds_release(t, h.bounds);
    }
    cw_compass_destroy(&h.compass);
    return status;
}

/* ---- the sky ----------------------------------------------------------------------------------------------------- */

/* Sums over directions for the samples of a block. */
typedef struct adding {
    float *share;
    double *sum;
    float *rises, *east, *north; /* of the present direction; slopes of the ground, if it leans */
    float per_rise;
    float towards[2]; /* the direction: east, north */
    double count;     /* of directions, or 0: share has how many count */
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
        a->share[k]++;
    }
}

static bool leans(const horizon *h) { return !h->opens && (h->desc.flags & CW_HORIZON_TILTED) != 0; }

/* Shares of a free sky are 1: a sum of so many. On leaning ground that counts times the normal's upward part. */
static void finish(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++) {
        a->share[k] = (float)(a->sum[k] / (a->count > 0 ? a->count : (double)a->share[k]));
        if (a->east) a->share[k] /= sqrtf(1 + a->east[k] * a->east[k] + a->north[k] * a->north[k]);
    }
}

/* room: of a double a sample, a float, and two more if the ground leans. */
static cw_status fill_sum(void *context, const cw_run *run, cw_rectangle at, void *to, void *room) {
    horizon *h = context;
    const size_t n = at.nx * at.ny, directions = h->compass.count;
    adding a = {.share = to, .sum = room, .rises = (float *)((double *)room + n)};
    if (!h->opens) a.count = (double)directions;
    if (leans(h)) {
        a.east = a.rises + n;
        a.north = a.east + n;
        cw_terrain_slopes(h->terrain, run->pool, NAN, at, a.east, a.north);
    }
    memset(a.share, 0, n * sizeof *a.share);
    memset(a.sum, 0, n * sizeof *a.sum);
    for (size_t k = 0; k < directions; k++) {
        compass_way way;
        const cw_run one = cw_run_share(&(run_part){0}, run, k, k + 1, directions);
        cw_status status = cw_compass_look(&h->compass, k, &way);
        /* Terrain below the level hides nothing of the sky. */
        const float low = h->opens ? -INFINITY : 0;
        if (status == CW_OK) status = cw_heading_steepest(way.heading, &one, low, INFINITY, at, a.rises);
        if (status != CW_OK) return status;
        double sine, cosine;
        cw_terrain_sine_cosine(h->compass.azimuths[k], &sine, &cosine);
        a.per_rise = (float)(1 / way.slope);
        a.towards[0] = (float)sine;
        a.towards[1] = (float)cosine;
        cw_pool_run(run->pool, n, GRAIN, h->opens ? add_opening : a.east ? add_tilted_sky : add_sky, &a);
    }
    cw_pool_run(run->pool, n, GRAIN, finish, &a);
    return CW_OK;
}

static cw_status make_sum(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, bool opens,
                          float *to, const char *name) {
    FPENV_HERE;
    cw_run how;
    cw_status status = cw_area_begin(t, desc, "horizon", run, 1, &area, &how);
    if (status == CW_OK) status = check(desc);
    if (status == CW_OK) status = cw_check_number("flags", desc->flags, 0, CW_HORIZON_TILTED + CW_HORIZON_BELOW);
    const bool below = status == CW_OK && (desc->flags & CW_HORIZON_BELOW) != 0;
    if (below && desc->curvature != 0)
        status = cw_fail(CW_ERROR_ARGUMENT, "curvature: %g; with CW_HORIZON_BELOW the earth is flat", desc->curvature);
    if (status != CW_OK) return status;
    horizon h = {.terrain = t, .desc = *desc, .opens = opens};
    if (below) status = turn_over(&h, &how);
    if (status == CW_OK) status = make_compass(&h);
    const size_t room = sizeof(double) + (leans(&h) ? 3 : 1) * sizeof(float);
    if (status == CW_OK) status = cw_compass_make(&h.compass, area, &how, sizeof *to, room, fill_sum, &h, to, name);
    cw_compass_destroy(&h.compass);
    cw_field_destroy(h.field);
    free(h.turned);
    return status;
}

cw_status cw_sky_view(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, float *share) {
    if (desc && (desc->flags & CW_HORIZON_BELOW) != 0)
        return cw_fail(CW_ERROR_ARGUMENT, "flags: %u; CW_HORIZON_BELOW goes with cw_openness alone", desc->flags);
    return make_sum(t, run, desc, area, false, share, "share");
}

cw_status cw_openness(const cw_terrain *t, const cw_run *run, const cw_horizon *desc, cw_area area, float *degrees) {
    return make_sum(t, run, desc, area, true, degrees, "degrees");
}
