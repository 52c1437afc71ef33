/* SPDX-License-Identifier: Apache-2.0 */
/* Suns are sorted by the direction from which they cast their shadow. In each of them the horizon is found once,
 * between the lowest and the highest sun. */

#include "insolation.h"

#include "area.h"
#include "compass.h"
#include "fpenv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct beam {
    double direction; /* degrees: from where the shadow is cast */
    sun_position sun;
    double weight; /* 1: not given */
} beam;

struct insolation {
    const terrain *terrain;
    double hours, linke; /* of the description; hours 1 with weights */
    bool weighted;
    beam *beams;
    size_t *first; /* beam of each direction of the compass; the next one's first beam ends it */
    double diffuse;
    bool energy; /* is summed, on the ground as it leans; else hours or weights */
    compass compass;
};

static int by_direction(const void *one, const void *other) {
    const beam *a = one, *b = other;
    if (a->direction != b->direction) return a->direction < b->direction ? -1 : 1;
    return a->sun.altitude < b->sun.altitude ? -1 : a->sun.altitude > b->sun.altitude;
}

static void take_suns(insolation *s, const insolation_desc *d) {
    compass *c = &s->compass;
    size_t beams = 0;
    for (size_t k = 0; k < d->count; k++) {
        const sun_position *p = &d->suns[k];
        if (!(p->altitude > 0)) continue;
        double direction = fmod(fmod(p->azimuth, 360) + 360, 360);
        if (d->directions > 0) {
            const size_t n = (size_t)nearbyint(direction / 360 * (double)d->directions) % d->directions;
            direction = 360 * (double)n / (double)d->directions;
        }
        s->beams[beams++] = (beam){direction, *p, d->weights ? d->weights[k] : 1};
        s->diffuse += cw_clear_sky_diffuse(d->linke, p->distance, p->altitude - p->refraction) * d->hours;
    }
    qsort(s->beams, beams, sizeof *s->beams, by_direction);
    c->count = 0;
    for (size_t k = 0; k < beams; k++) {
        if (k > 0 && s->beams[k].direction == s->beams[k - 1].direction) continue;
        c->azimuths[c->count] = s->beams[k].direction;
        s->first[c->count++] = k;
    }
    s->first[c->count] = beams;
}

cw_status cw_insolation_create(const terrain *t, const insolation_desc *d, insolation **out) {
    FPENV_HERE;
    insolation *s = *out = calloc(1, sizeof *s);
    if (s == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    const size_t room = d->count > 0 ? d->count : 1;
    *s = (insolation){
        .terrain = t, .hours = d->weights ? 1 : d->hours, .linke = d->linke, .weighted = d->weights != NULL};
    s->beams = calloc(room, sizeof *s->beams);
    s->first = calloc(room + 1, sizeof *s->first);
    cw_status status = cw_compass_create(&s->compass, t, room, 0, d->curvature);
    if (status == CW_OK && !(s->beams && s->first)) status = cw_fail_plainly(CW_ERROR_MEMORY);
    if (status == CW_OK) {
        take_suns(s, d);
        return CW_OK;
    }
    cw_insolation_destroy(s);
    *out = NULL;
    return status;
}

void cw_insolation_destroy(insolation *s) {
    if (s == NULL) return;
    cw_compass_destroy(&s->compass);
    free(s->beams);
    free(s->first);
    free(s);
}

size_t cw_insolation_directions(const insolation *s) { return s->compass.count; }

void cw_insolation_direction(const insolation *s, size_t number, double *azimuth, double *lowest) {
    *azimuth = s->compass.azimuths[number];
    *lowest = s->beams[s->first[number]].sun.altitude;
}

double cw_insolation_diffuse(const insolation *s) { return s->diffuse; }

/* ---- one sun on a block of rows ---------------------------------------------------------------------------------- */

/* Direct light on a surface that faces the sun, at even steps of height. Between two it is a straight line, which is
 * off by at most step² / 8 times the second derivative. Light is that outside the atmosphere times e^-x. The air's
 * thickness x is a concave function of the air mass, which falls as e^(-height / 8434.5 m), so neither derivative of
 * x is more than x over 8434.5 m, once or twice. With (x² + x) e^-x < 0.9 and 1414 W/m² outside, the error is below
 * 0.006 W/m². */
enum { STEP = 50, LOWEST = -1000, HIGHEST = 10000, LEVELS = (HIGHEST - LOWEST) / STEP + 1 };

typedef struct light {
    float level[LEVELS];
    float east, north, up; /* towards the sun */
} light;

static void make_light(const insolation *s, const beam *b, light *out) {
    const sun_position *p = &b->sun;
    for (int k = 0; k < LEVELS; k++)
        out->level[k] = s->weighted ? (float)b->weight
                                    : (float)cw_clear_sky_direct(s->linke, p->distance, p->altitude, LOWEST + STEP * k);
    double sine, cosine, up, level;
    cw_terrain_sine_cosine(p->azimuth, &sine, &cosine);
    cw_terrain_sine_cosine(p->altitude, &up, &level);
    out->east = (float)(sine * level);
    out->north = (float)(cosine * level);
    out->up = (float)up;
}

/* Sums over suns for the samples of a block. */
typedef struct adding {
    const insolation *sun;
    cw_rectangle at;
    float *rises, *count; /* count: of suns without weights */
    double *sum;
    /* For energy: slopes, the normal's upward part, and the place between the levels of height. */
    float *east, *north, *upright, *place;
    /* Of the present sun: */
    float rise;
    double weight;
    light light;
} adding;

/* The rise of a hole is NaN, and it is not lit. */
static void add_hours(void *context, size_t begin, size_t end) {
    const adding *a = context;
    const float *restrict rises = a->rises, rise = a->rise;
    float *restrict count = a->count;
    for (size_t k = begin; k < end; k++) count[k] += rises[k] < rise ? 1.0f : 0.0f;
}

static void add_weights(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++)
        if (a->rises[k] < a->rise) a->sum[k] += a->weight;
}

static void add_energy(void *context, size_t begin, size_t end) {
    const adding *a = context;
    const light *l = &a->light;
    for (size_t k = begin; k < end; k++) {
        const float cosine = (l->up - a->east[k] * l->east - a->north[k] * l->north) * a->upright[k];
        if (!(cosine > 0) || !(a->rises[k] < a->rise)) continue;
        const int below = (int)a->place[k];
        const float part = a->place[k] - (float)below;
        a->sum[k] += (double)(cosine * (l->level[below] + part * (l->level[below + 1] - l->level[below])));
    }
}

static float height_at(const adding *a, size_t k) {
    return terrain_row(a->sun->terrain, a->at.j + k / a->at.nx)[a->at.i + k % a->at.nx];
}

static void find_lie(void *context, size_t begin, size_t end) {
    const adding *a = context;
    const double scale = terrain_metres_of_height(a->sun->terrain);
    for (size_t k = begin; k < end; k++) {
        const float z = height_at(a, k);
        const double height = fmin(fmax((double)z * scale, LOWEST), HIGHEST - 1);
        a->upright[k] = 1 / sqrtf(1 + a->east[k] * a->east[k] + a->north[k] * a->north[k]);
        a->place[k] = isfinite(z) ? (float)((height - LOWEST) / STEP) : 0;
    }
}

/* ---- all suns ---------------------------------------------------------------------------------------------------- */

enum { GRAIN = 1 << 14, HEADINGS_KEPT = 64 };

static cw_status add_sector(insolation *s, const cw_run *run, size_t number, adding *a) {
    const beam *first = s->beams + s->first[number], *end = s->beams + s->first[number + 1];
    compass_way way;
    cw_status status = cw_compass_look(&s->compass, number, &way);
    if (status != CW_OK) return status;
    const float low = cw_compass_rise(way.slope, first->sun.altitude),
                high = cw_compass_rise(way.slope, end[-1].sun.altitude);
    /* A rise that is cut off at the lower end must be below the lowest sun's. */
    status = cw_heading_steepest(way.heading, run, nextafterf(low, -INFINITY), high, a->at, a->rises);
    if (s->compass.count > HEADINGS_KEPT) cw_compass_release(&s->compass, number);
    cw_work_fn *const add = s->energy ? add_energy : s->weighted ? add_weights : add_hours;
    for (const beam *b = first; b < end && status == CW_OK; b++) {
        if (s->energy) make_light(s, b, &a->light);
        a->rise = cw_compass_rise(way.slope, b->sun.altitude);
        a->weight = b->weight;
        cw_pool_run(run->pool, a->at.nx * a->at.ny, GRAIN, add, a);
    }
    return status;
}

/* room: of a double a sample and a float, or for energy five. */
static cw_status fill(void *context, const cw_run *run, cw_rectangle at, void *to, void *room) {
    insolation *s = context;
    const size_t n = at.nx * at.ny;
    const bool sums = s->energy || s->weighted;
    float *out = to, *floats = (float *)((double *)room + n);
    adding a = {.sun = s, .at = at, .rises = floats, .count = out, .sum = room};
    if (sums) memset(a.sum, 0, n * sizeof *a.sum);
    memset(out, 0, n * sizeof *out);
    if (s->energy) {
        a.east = floats + n;
        a.north = floats + 2 * n;
        a.upright = floats + 3 * n;
        a.place = floats + 4 * n;
        cw_terrain_slopes(s->terrain, run->pool, NAN, at, a.east, a.north);
        cw_pool_run(run->pool, n, GRAIN, find_lie, &a);
    }
    for (size_t k = 0; k < s->compass.count; k++) {
        const cw_run one = cw_run_share(&(run_part){0}, run, k, k + 1, s->compass.count);
        const cw_status status = add_sector(s, &one, k, &a);
        if (status != CW_OK) return status;
    }
    for (size_t k = 0; k < n; k++) {
        const bool answers = isfinite(height_at(&a, k)) && !(s->energy && isnan(a.upright[k]));
        out[k] = answers ? (float)((sums ? a.sum[k] : (double)out[k]) * s->hours) : NAN;
    }
    return CW_OK;
}

static cw_status make(insolation *s, const cw_run *run, cw_area area, bool energy, float *out, const char *name) {
    FPENV_HERE;
    cw_run how;
    const cw_status status = cw_area_begin(s->terrain, s, "sum", run, 1, &area, &how);
    if (status != CW_OK) return status;
    s->energy = energy;
    const size_t room = sizeof(double) + (energy ? 5 : 1) * sizeof(float);
    return cw_compass_make(&s->compass, area, &how, sizeof *out, room, fill, s, out, name);
}

cw_status cw_insolation_hours(insolation *s, const cw_run *run, cw_area area, float *hours) {
    return make(s, run, area, false, hours, "hours");
}

cw_status cw_insolation_direct(insolation *s, const cw_run *run, cw_area area, float *energy) {
    return make(s, run, area, true, energy, "energy");
}
