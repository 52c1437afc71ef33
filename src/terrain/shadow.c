/* SPDX-License-Identifier: Apache-2.0 */
/* A sample is in the shadow if the horizon in the direction of the sun is as high as the sun. For the disc, the
 * horizon is found along the middle line of each of several upright strips. The part of the strip above it is exact,
 * so a few strips are as good as hundreds of rays. */

#include "area.h"
#include "compass.h"
#include "normal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { STRIPS_USUAL = 16 };

typedef struct strip {
    double altitude, half; /* of its middle, and from there to its ends; degrees */
    double share;          /* of the disc */
} strip;

typedef struct sunlight {
    const terrain *terrain;
    cw_light desc;
    size_t strips;
    strip strip[SUNLIGHT_STRIPS_MOST];
    double azimuths[SUNLIGHT_STRIPS_MOST];
    compass compass;
    double towards[3]; /* the sun: east, north, up */
    float *work;       /* for a part of a row block */
    size_t room;
} sunlight;

/* The middle of a strip from the disc's middle line, as a part of its radius. */
static double strip_aside(size_t k, size_t strips) { return (2 * (double)k + 1) / (double)strips - 1; }

size_t cw_light_azimuths(const cw_light *d, double azimuths[SUNLIGHT_STRIPS_MOST]) {
    const size_t strips = d->radius == 0 ? 1 : d->strips > 0 ? d->strips : STRIPS_USUAL;
    double level, up;
    cw_terrain_sine_cosine(d->altitude, &up, &level);
    /* At the zenith the azimuth of a strip is undefined. */
    for (size_t k = 0; k < strips; k++)
        azimuths[k] = d->azimuth + (level > 0.01 ? strip_aside(k, strips) * d->radius / level : 0);
    return strips;
}

static void destroy(sunlight *s) {
    cw_compass_destroy(&s->compass);
    free(s->work);
}

static cw_status check(const cw_light *d) {
    cw_status status = cw_check_zeros(d->reserved, 0, "cw_light");
    if (status == CW_OK) status = cw_check_number("azimuth", d->azimuth, -0x1p40, 0x1p40);
    if (status == CW_OK) status = cw_check_number("altitude", d->altitude, -90, 90);
    if (status == CW_OK) status = cw_check_number("radius", d->radius, 0, 10);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("strips", d->strips, 0, SUNLIGHT_STRIPS_MOST);
    if (status == CW_OK) status = cw_check_number("hillshade", d->hillshade, 0, 1);
    return status;
}

static cw_status create(sunlight *s, const terrain *t, const cw_light *desc) {
    const cw_status status = check(desc);
    *s = (sunlight){.terrain = t, .desc = *desc};
    if (status != CW_OK) return status;
    s->strips = cw_light_azimuths(desc, s->azimuths);
    double level, up, area = 0;
    cw_terrain_sine_cosine(desc->altitude, &up, &level);
    for (size_t k = 0; k < s->strips; k++) {
        const double aside = strip_aside(k, s->strips), half = sqrt(1 - aside * aside);
        s->strip[k] = (strip){.altitude = desc->altitude, .half = half * desc->radius, .share = half};
        area += half;
    }
    for (size_t k = 0; k < s->strips; k++) s->strip[k].share /= area;
    double sine, cosine;
    cw_terrain_sine_cosine(desc->azimuth, &sine, &cosine);
    s->towards[0] = sine * level;
    s->towards[1] = cosine * level;
    s->towards[2] = up;
    return cw_compass_create(&s->compass, t, s->azimuths, s->strips, 0, desc->curvature);
}

static float *work(sunlight *s, size_t floats) {
    if (floats <= s->room) return s->work;
    free(s->work);
    s->work = malloc(floats * sizeof *s->work);
    s->room = s->work ? floats : 0;
    return s->work;
}

/* Whether the middle of the sun is hidden. */
static cw_status blocked(sunlight *s, const cw_run *run, cw_rectangle at, uint8_t *occluded) {
    cw_heading *heading;
    double slope;
    const cw_status status = cw_compass_heading(&s->compass, 0, &heading, &slope);
    if (status != CW_OK) return status;
    return cw_heading_occluded(heading, run, cw_compass_rise(slope, s->desc.altitude), at, occluded);
}

/* At the raster's rim no terrain hides a sun below the level, yet samples are dark once all of it is lower than a free
 * horizon. From a height h over the sea a free horizon has the dip acos(R / (R + h)), so samples up to this height, in
 * their numbers, are dark. */
static double night_limit(const sunlight *s) {
    double sine, cosine, half, unused;
    const double top = s->desc.altitude + s->desc.radius;
    if (!(top < 0)) return -INFINITY;
    cw_terrain_sine_cosine(top, &sine, &cosine);
    cw_terrain_sine_cosine(top / 2, &half, &unused);
    if (!(cosine > 0)) return INFINITY;
    return s->terrain->radius * 2 * half * half / cosine / terrain_metres_of_height(s->terrain);
}

static cw_status fill_lit(void *context, const cw_run *run, cw_rectangle at, void *to) {
    sunlight *s = context;
    const size_t end = at.j + at.ny, all = at.ny;
    const double night = night_limit(s);
    uint8_t *lit = to;
    for (size_t done = 0; at.j < end; at.j += at.ny, done += at.ny) {
        cw_compass_turn(&s->compass, &at, end);
        run_part part = {run, (double)done / (double)all, (double)(done + at.ny) / (double)all};
        const cw_run some = cw_run_part_of(&part);
        const cw_status status = blocked(s, &some, at, lit);
        if (status != CW_OK) return status;
        for (size_t j = at.j; j < at.j + at.ny; j++, lit += at.nx) {
            const float *z = terrain_row(s->terrain, j) + at.i;
            for (size_t k = 0; k < at.nx; k++)
                lit[k] = !isfinite(z[k]) ? 255 : (double)z[k] <= night ? 0 : (uint8_t)(1 - lit[k]);
        }
    }
    return CW_OK;
}

/* The angle between two directions whose slopes are these: off by less than x^6 / 7 of itself, x its tangent. */
static inline float angle_between(float slope, float other) {
    const float x = (slope - other) / (1 + slope * other);
    return x * (1 - x * x * (1.0f / 3 - x * x * 0.2f));
}

/* Adds the part of a strip that is seen: all of it where the horizon is below its lower end, nothing where it is
 * above its upper one. */
static cw_status add_strip(sunlight *s, const cw_run *run, size_t k, cw_rectangle at, float *steepest, float *share) {
    const strip *p = &s->strip[k];
    cw_heading *heading;
    double slope;
    cw_status status = cw_compass_heading(&s->compass, k, &heading, &slope);
    if (status != CW_OK) return status;
    const float high = cw_compass_rise(slope, p->altitude + p->half), below = nextafterf(high, -INFINITY),
                low = fminf(cw_compass_rise(slope, p->altitude - p->half), below); /* a tiny disc is a point */
    status = cw_heading_steepest(heading, run, low, high, at, steepest);
    if (status != CW_OK) return status;
    const float per_rise = (float)(1 / slope), top = high * per_rise, foot = low * per_rise, whole = (float)p->share;
    const float per_angle = 1 / angle_between(top, foot);
    const bool even = top < INFINITY && low > -INFINITY && foot < top; /* else all of a strip is seen or none of it */
    for (size_t m = 0; m < at.nx * at.ny; m++) {
        const float part = steepest[m] <= low   ? 1
                           : even               ? angle_between(top, steepest[m] * per_rise) * per_angle
                           : steepest[m] < high ? 1
                                                : steepest[m] * 0;
        share[m] += whole * (part > 1 ? 1 : part);
    }
    return CW_OK;
}

static cw_status share_of_disc(sunlight *s, const cw_run *run, cw_rectangle at, float *share) {
    const size_t n = at.nx * at.ny;
    const bool point = s->desc.radius == 0;
    for (size_t m = 0; m < n; m++) share[m] = 0;
    float *room = work(s, n);
    if (room == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    if (point) {
        const cw_status status = blocked(s, run, at, (uint8_t *)room);
        for (size_t m = 0; m < n && status == CW_OK; m++) {
            const float z = terrain_row(s->terrain, at.j + m / at.nx)[at.i + m % at.nx];
            share[m] = isfinite(z) ? 1 - (float)((uint8_t *)room)[m] : NAN;
        }
        return status;
    }
    for (size_t k = 0; k < s->strips; k++) {
        run_part part;
        const cw_run some = cw_run_share(&part, run, k, s->strips);
        const cw_status status = add_strip(s, &some, k, at, room, share);
        if (status != CW_OK) return status;
    }
    return CW_OK;
}

/* Rows to shade: the light that their tilted ground receives. */
typedef struct shading {
    const sunlight *light;
    cw_rectangle at;
    float *share, *slopes; /* two rows for each of the block's: eastward, northward */
    double middle;         /* of the rows that share headings */
} shading;

static void shade_rows(void *context, size_t begin, size_t end) {
    const shading *h = context;
    const size_t nx = h->at.nx;
    const float lx = (float)h->light->towards[0], ly = (float)h->light->towards[1], lz = (float)h->light->towards[2];
    for (size_t j = begin; j < end; j++) {
        float *restrict share = h->share + j * nx, *restrict east = h->slopes + 2 * j * nx, *restrict north = east + nx;
        cw_terrain_slope_row_as(h->light->terrain, h->middle, h->at.j + j, h->at.i, nx, east, north);
        for (size_t i = 0; i < nx; i++) {
            const float cosine =
                (lz - east[i] * lx - north[i] * ly) / sqrtf(1 + east[i] * east[i] + north[i] * north[i]);
            share[i] *= cosine < 0 ? 0 : cosine;
        }
    }
}

static cw_status shade(sunlight *s, const cw_run *run, cw_rectangle at, float *share) {
    shading h = {s, at, share, work(s, 2 * at.nx * at.ny), cw_compass_middle(&s->compass)};
    if (h.slopes == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    cw_pool_run(run->pool, at.ny, 4, shade_rows, &h);
    return CW_OK;
}

static cw_status fill_share(void *context, const cw_run *run, cw_rectangle at, void *to) {
    sunlight *s = context;
    const size_t end = at.j + at.ny, all = at.ny;
    const double night = night_limit(s);
    float *share = to;
    for (size_t done = 0; at.j < end; at.j += at.ny, done += at.ny) {
        cw_compass_turn(&s->compass, &at, end);
        run_part part = {run, (double)done / (double)all, (double)(done + at.ny) / (double)all};
        const cw_run some = cw_run_part_of(&part);
        cw_status status = share_of_disc(s, &some, at, share);
        if (status == CW_OK && s->desc.hillshade) status = shade(s, &some, at, share);
        if (status != CW_OK) return status;
        for (size_t j = at.j; j < at.j + at.ny; j++, share += at.nx) {
            const float *z = terrain_row(s->terrain, j) + at.i;
            for (size_t k = 0; k < at.nx && night > -INFINITY; k++)
                if ((double)z[k] <= night && isfinite(z[k])) share[k] = 0;
        }
    }
    return CW_OK;
}

static cw_status make(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, size_t bytes,
                      cw_area_fill *fill, void *out, const char *name) {
    sunlight s;
    cw_run how;
    cw_status status = cw_area_begin(t, light, "light", run, &area, &how);
    if (status != CW_OK) return status;
    status = create(&s, t, light);
    if (status == CW_OK) status = cw_area_make(area, &how, bytes, fill, &s, out, name);
    destroy(&s);
    return status;
}

cw_status cw_shadow(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, uint8_t *lit) {
    cw_light point;
    if (light) point = *light;
    if (light) point.radius = point.hillshade = 0;
    return make(t, run, light ? &point : NULL, area, sizeof *lit, fill_lit, lit, "lit");
}

cw_status cw_sunlight(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, float *share) {
    return make(t, run, light, area, sizeof *share, fill_share, share, "share");
}
