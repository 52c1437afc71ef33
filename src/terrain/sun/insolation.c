/* SPDX-License-Identifier: Apache-2.0 */
/* Suns are sorted by the direction from which they cast their shadow. A direction with one sun takes a shadow; one with
 * several takes the horizon between the lowest and the highest of them, once for all. */

#include "insolation.h"

#include "area.h"
#include "compass.h"
#include "normal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct beam {
    double direction; /* degrees: from where the shadow is cast */
    sun_position sun;
    double weight; /* 1: not given */
} beam;

/* Beams first to first + count - 1 share a direction. */
typedef struct sector {
    size_t first, count;
} sector;

struct insolation {
    const terrain *terrain;
    insolation_desc desc;
    bool weighted;
    beam *beams;
    size_t beam_count;
    sector *sectors;
    size_t sector_count;
    double *azimuths; /* a sector's */
    double diffuse;
    bool energy; /* is summed, on the ground as it leans; else hours or weights */
    compass compass;
    void *work;
    size_t room;
};

static int by_direction(const void *one, const void *other) {
    const beam *a = one, *b = other;
    if (a->direction != b->direction) return a->direction < b->direction ? -1 : 1;
    return a->sun.altitude < b->sun.altitude ? -1 : a->sun.altitude > b->sun.altitude;
}

static void take_suns(insolation *s) {
    const insolation_desc *d = &s->desc;
    for (size_t k = 0; k < d->count; k++) {
        const sun_position *p = &d->suns[k];
        if (!(p->altitude > 0)) continue;
        double direction = fmod(fmod(p->azimuth, 360) + 360, 360);
        if (d->directions > 0) {
            const size_t n = (size_t)nearbyint(direction / 360 * (double)d->directions) % d->directions;
            direction = 360 * (double)n / (double)d->directions;
        }
        s->beams[s->beam_count++] = (beam){direction, *p, d->weights ? d->weights[k] : 1};
        s->diffuse += cw_clear_sky_diffuse(d->linke, p->distance, p->altitude - p->refraction) * d->hours;
    }
    qsort(s->beams, s->beam_count, sizeof *s->beams, by_direction);
    for (size_t k = 0; k < s->beam_count; k++) {
        if (k == 0 || s->beams[k].direction != s->beams[k - 1].direction) {
            s->azimuths[s->sector_count] = s->beams[k].direction;
            s->sectors[s->sector_count++] = (sector){k, 0};
        }
        s->sectors[s->sector_count - 1].count++;
    }
    s->weighted = d->weights != NULL;
    if (s->weighted) s->desc.hours = 1;
    s->desc.suns = NULL;
    s->desc.weights = NULL;
}

static bool good_suns(const insolation_desc *d) {
    for (size_t k = 0; k < d->count; k++)
        if (!(isfinite(d->suns[k].azimuth) && fabs(d->suns[k].altitude) <= 90 && d->suns[k].distance > 0) ||
            (d->weights && !isfinite(d->weights[k])))
            return false;
    return true;
}

cw_status cw_insolation_create(const terrain *t, const insolation_desc *desc, insolation **out) {
    *out = NULL;
    cw_status status = cw_check_number("hours", desc->hours, DBL_MIN, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("linke", desc->linke, DBL_MIN, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("curvature", desc->curvature, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("directions", (double)desc->directions, 0, COMPASS_MOST);
    if (status == CW_OK && !good_suns(desc)) status = cw_fail(CW_ERROR_ARGUMENT, "suns: a place is none of a sun");
    if (status != CW_OK) return status;
    insolation *s = calloc(1, sizeof *s);
    if (s == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    const size_t room = desc->count > 0 ? desc->count : 1;
    s->terrain = t;
    s->desc = *desc;
    s->beams = calloc(room, sizeof *s->beams);
    s->sectors = calloc(room, sizeof *s->sectors);
    s->azimuths = calloc(room, sizeof *s->azimuths);
    if (!(s->beams && s->sectors && s->azimuths)) status = cw_fail_plainly(CW_ERROR_MEMORY);
    if (status == CW_OK) {
        take_suns(s);
        status = cw_compass_create(&s->compass, t, s->azimuths, s->sector_count > 0 ? s->sector_count : 1, 0,
                                   desc->curvature);
    }
    if (status == CW_OK)
        *out = s;
    else
        cw_insolation_destroy(s);
    return status;
}

void cw_insolation_destroy(insolation *s) {
    if (s == NULL) return;
    cw_compass_destroy(&s->compass);
    free(s->beams);
    free(s->sectors);
    free(s->azimuths);
    free(s->work);
    free(s);
}

size_t cw_insolation_directions(const insolation *s) { return s->sector_count; }

void cw_insolation_direction(const insolation *s, size_t number, double *azimuth, double *lowest) {
    *azimuth = s->azimuths[number];
    *lowest = s->beams[s->sectors[number].first].sun.altitude;
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
        out->level[k] = s->weighted
                            ? (float)b->weight
                            : (float)cw_clear_sky_direct(s->desc.linke, p->distance, p->altitude, LOWEST + STEP * k);
    double sine, cosine, up, level;
    cw_terrain_sine_cosine(p->azimuth, &sine, &cosine);
    cw_terrain_sine_cosine(p->altitude, &up, &level);
    out->east = (float)(sine * level);
    out->north = (float)(cosine * level);
    out->up = (float)up;
}

/* The numbers of each sample of the rows. */
typedef struct ground_lie {
    float *east, *north, *upright,
        *place; /* slopes; the normal's upward part; the place between the levels of height */
} ground_lie;

typedef struct adding {
    const uint8_t *occluded; /* NULL: rises say it */
    const float *rises;
    float rise; /* the sun's */
    float *count;
    double *energy; /* or weights */
    double weight;
    ground_lie lie;
    const light *light;
} adding;

static bool is_lit(const adding *a, size_t k) { return a->occluded ? a->occluded[k] == 0 : a->rises[k] < a->rise; }

/* Occlusion is 0 or 1. Of rises, that of a hole is NaN, and it is not lit. */
static void add_hours(void *context, size_t begin, size_t end) {
    const adding *a = context;
    float *restrict count = a->count;
    if (a->occluded)
        for (size_t k = begin; k < end; k++) count[k] += (float)(1 - a->occluded[k]);
    else
        for (size_t k = begin; k < end; k++) count[k] += a->rises[k] < a->rise ? 1.0f : 0.0f;
}

static void add_weights(void *context, size_t begin, size_t end) {
    const adding *a = context;
    for (size_t k = begin; k < end; k++)
        if (is_lit(a, k)) a->energy[k] += a->weight;
}

static void add_energy(void *context, size_t begin, size_t end) {
    const adding *a = context;
    const light *l = a->light;
    const ground_lie *g = &a->lie;
    for (size_t k = begin; k < end; k++) {
        const float cosine = (l->up - g->east[k] * l->east - g->north[k] * l->north) * g->upright[k];
        if (!(cosine > 0) || !is_lit(a, k)) continue;
        const int below = (int)g->place[k];
        const float part = g->place[k] - (float)below;
        a->energy[k] += (double)(cosine * (l->level[below] + part * (l->level[below + 1] - l->level[below])));
    }
}

/* ---- all suns ---------------------------------------------------------------------------------------------------- */

enum { GRAIN = 1 << 14, HEADINGS_KEPT = 64 };

typedef struct block {
    insolation *sum;
    const cw_run *run;
    cw_rectangle at;
    float *rises;
    uint8_t *occluded; /* the same memory */
    bool energy;       /* on the ground as it leans */
    adding add;
} block;

static cw_status add_sector(block *b, size_t number) {
    insolation *s = b->sum;
    const sector *of = &s->sectors[number];
    const beam *beams = s->beams + of->first;
    cw_heading *heading;
    double slope;
    cw_status status = cw_compass_heading(&s->compass, number, &heading, &slope);
    if (status != CW_OK) return status;
    const float low = cw_compass_rise(slope, beams->sun.altitude),
                high = cw_compass_rise(slope, beams[of->count - 1].sun.altitude);
    b->add.occluded = of->count == 1 ? b->occluded : NULL;
    b->add.rises = b->rises;
    /* A rise that is cut off at the lower end must be below the lowest sun's. */
    status = of->count == 1 ? cw_heading_occluded(heading, b->run, low, b->at, b->occluded)
                            : cw_heading_steepest(heading, b->run, nextafterf(low, -INFINITY), high, b->at, b->rises);
    if (s->sector_count > HEADINGS_KEPT) cw_compass_release(&s->compass, number);
    for (size_t k = 0; k < of->count && status == CW_OK; k++) {
        light l;
        if (b->energy) make_light(s, beams + k, &l);
        b->add.light = &l;
        b->add.rise = cw_compass_rise(slope, beams[k].sun.altitude);
        b->add.weight = beams[k].weight;
        cw_pool_run(b->run->pool, b->at.nx * b->at.ny, GRAIN,
                    b->energy       ? add_energy
                    : b->add.energy ? add_weights
                                    : add_hours,
                    &b->add);
    }
    return status;
}

/* Slopes and heights of a block. */
typedef struct lying {
    const terrain *terrain;
    cw_rectangle at;
    ground_lie lie;
} lying;

static void find_lie(void *context, size_t begin, size_t end) {
    const lying *l = context;
    const terrain *t = l->terrain;
    const double scale = terrain_metres_of_height(t);
    for (size_t j = begin; j < end; j++) {
        const size_t first = j * l->at.nx;
        const float *row = terrain_row(t, l->at.j + j) + l->at.i;
        float *east = l->lie.east + first, *north = l->lie.north + first;
        cw_terrain_slope_row(t, l->at.j + j, l->at.i, l->at.nx, east, north);
        for (size_t i = 0; i < l->at.nx; i++) {
            const float z = row[i];
            const double height = fmin(fmax((double)z * scale, LOWEST), HIGHEST - 1);
            l->lie.upright[first + i] = 1 / sqrtf(1 + east[i] * east[i] + north[i] * north[i]);
            l->lie.place[first + i] = isfinite(z) ? (float)((height - LOWEST) / STEP) : 0;
        }
    }
}

/* Room for so many floats a sample, and doubles. */
static float *work(insolation *s, size_t samples, size_t floats, size_t doubles, double **out) {
    const size_t bytes = samples * (floats * sizeof(float) + doubles * sizeof(double));
    if (bytes > s->room) {
        free(s->work);
        s->work = malloc(bytes);
        s->room = s->work ? bytes : 0;
    }
    *out = s->work;
    return s->work ? (float *)(*out + samples * doubles) : NULL;
}

static cw_status fill(void *context, const cw_run *run, cw_rectangle at, void *to) {
    insolation *s = context;
    const bool energy = s->energy;
    float *out = to;
    const size_t n = at.nx * at.ny, first = at.j, all = at.ny, end = at.j + at.ny;
    const bool doubles = energy || s->weighted;
    double *energies;
    float *floats = work(s, n, energy ? 5 : 1, doubles, &energies);
    if (floats == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    lying l = {s->terrain, at, {floats + n, floats + 2 * n, floats + 3 * n, floats + 4 * n}};
    if (doubles) memset(energies, 0, n * sizeof *energies);
    if (energy) cw_pool_run(run->pool, at.ny, 4, find_lie, &l);
    memset(out, 0, n * sizeof *out);
    for (; at.j < end; at.j += at.ny) {
        cw_compass_turn(&s->compass, &at, end);
        run_part part = {run, (double)(at.j - first) / (double)all, (double)(at.j + at.ny - first) / (double)all};
        const cw_run some = cw_run_part_of(&part);
        const size_t done = (at.j - first) * at.nx;
        block b = {.sum = s, .at = at, .rises = floats, .occluded = (uint8_t *)floats};
        b.add.count = out + done;
        b.energy = energy;
        b.add.energy = doubles ? energies + done : NULL;
        if (energy)
            b.add.lie = (ground_lie){l.lie.east + done, l.lie.north + done, l.lie.upright + done, l.lie.place + done};
        for (size_t k = 0; k < s->sector_count; k++) {
            run_part way;
            const cw_run one = cw_run_share(&way, &some, k, s->sector_count);
            b.run = &one;
            const cw_status status = add_sector(&b, k);
            if (status != CW_OK) return status;
        }
    }
    for (size_t y = 0; y < all; y++) {
        const float *z = terrain_row(s->terrain, first + y) + at.i;
        for (size_t x = 0, k = y * at.nx; x < at.nx; x++, k++)
            out[k] = !isfinite(z[x]) ? NAN : (float)((doubles ? energies[k] : (double)out[k]) * s->desc.hours);
    }
    return CW_OK;
}

static cw_status make(insolation *s, const cw_run *run, cw_area area, bool energy, float *out, const char *name) {
    cw_run how;
    const cw_status status = cw_area_begin(s->terrain, s, "sum", run, &area, &how);
    s->energy = energy;
    return status == CW_OK ? cw_area_make(area, &how, sizeof *out, fill, s, out, name) : status;
}

cw_status cw_insolation_hours(insolation *s, const cw_run *run, cw_area area, float *hours) {
    return make(s, run, area, false, hours, "hours");
}

cw_status cw_insolation_direct(insolation *s, const cw_run *run, cw_area area, float *energy) {
    return make(s, run, area, true, energy, "energy");
}
