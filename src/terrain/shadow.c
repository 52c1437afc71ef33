/* SPDX-License-Identifier: Apache-2.0 */
/* A sample is in the shadow if the horizon in the direction of the sun is as high as the sun. For the disc, the
 * horizon is found along the middle line of each of several upright strips. The part of the strip above it is exact,
 * so a few strips are as good as hundreds of rays. */

#include "area.h"
#include "compass.h"
#include "fpenv.h"

#include <math.h>
#include <string.h>

enum { STRIPS_USUAL = 16 };

typedef struct strip {
    double half;  /* from its middle to its ends; degrees */
    double share; /* of the disc */
} strip;

typedef struct sunlight {
    const terrain *terrain;
    cw_light desc;
    strip strip[SUNLIGHT_STRIPS_MOST];
    compass compass;   /* a direction for each strip */
    double towards[3]; /* the sun: east, north, up */
    double night;      /* samples up to this height, in their numbers, are dark */
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

static cw_status check(const cw_light *d) {
    cw_status status = cw_check_reserved(d->reserved, 8, 0, "cw_light");
    if (status == CW_OK) status = cw_check_number("azimuth", d->azimuth, -0x1p40, 0x1p40);
    if (status == CW_OK) status = cw_check_number("altitude", d->altitude, -90, 90);
    if (status == CW_OK) status = cw_check_number("radius", d->radius, 0, 10);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, 1e9);
    if (status == CW_OK) status = cw_check_number("strips", d->strips, 0, SUNLIGHT_STRIPS_MOST);
    if (status == CW_OK) status = cw_check_number("hillshade", d->hillshade, 0, 1);
    return status;
}

/* At the raster's rim no terrain hides a sun below the level, yet samples are dark once all of it is lower than a free
 * horizon. From a height h over the sea a free horizon has the dip acos(R / (R + h)). */
static double night_limit(const sunlight *s) {
    double sine, cosine, half, unused;
    const double top = s->desc.altitude + s->desc.radius;
    if (!(top < 0)) return -INFINITY;
    cw_terrain_sine_cosine(top, &sine, &cosine);
    cw_terrain_sine_cosine(top / 2, &half, &unused);
    if (!(cosine > 0)) return INFINITY;
    return s->terrain->radius * 2 * half * half / cosine / terrain_metres_of_height(s->terrain);
}

/* The angle between two directions whose slopes are these: off by less than x^6 / 7 of itself, x its tangent. */
static inline float angle_between(float slope, float other) {
    const float x = (slope - other) / (1 + slope * other);
    return x * (1 - x * x * (1.0f / 3 - x * x * 0.2f));
}

/* Adds the part of a strip that is seen: all of it where the horizon is below its lower end, nothing where it is
 * above its upper one. A point is all of its strip. */
static cw_status add_strip(sunlight *s, const cw_run *run, size_t k, cw_rectangle at, float *steepest, float *share) {
    const strip *p = &s->strip[k];
    compass_way way;
    cw_status status = cw_compass_look(&s->compass, k, &way);
    if (status != CW_OK) return status;
    const double altitude = s->desc.altitude; /* of all strips' middles */
    const float high = cw_compass_rise(way.slope, altitude + p->half), below = nextafterf(high, -INFINITY),
                low = fminf(cw_compass_rise(way.slope, altitude - p->half), below); /* a tiny disc is a point */
    status = cw_heading_steepest(way.heading, run, low, high, at, steepest);
    if (status != CW_OK) return status;
    const float per_rise = (float)(1 / way.slope), top = high * per_rise, foot = low * per_rise;
    const float per_angle = 1 / angle_between(top, foot), whole = (float)p->share;
    const size_t n = at.nx * at.ny;
    if (!(p->half > 0 && top < INFINITY && low > -INFINITY && foot < top)) { /* all of it is seen or nothing */
        for (size_t m = 0; m < n; m++) share[m] += steepest[m] < high ? whole : isnan(steepest[m]) ? NAN : 0;
        return CW_OK;
    }
    for (size_t m = 0; m < n; m++) {
        const float part = steepest[m] <= low ? 1 : angle_between(top, steepest[m] * per_rise) * per_angle;
        share[m] += whole * (part > 1 ? 1 : part);
    }
    return CW_OK;
}

/* Samples to shade: the light that their tilted ground receives. */
typedef struct shading {
    const double *towards;
    float *share, *east, *north;
} shading;

static void shade(void *context, size_t begin, size_t end) {
    const shading *h = context;
    float *restrict share = h->share;
    const float *restrict east = h->east, *restrict north = h->north;
    const float lx = (float)h->towards[0], ly = (float)h->towards[1], lz = (float)h->towards[2];
    for (size_t k = begin; k < end; k++) {
        const float cosine = (lz - east[k] * lx - north[k] * ly) / sqrtf(1 + east[k] * east[k] + north[k] * north[k]);
        share[k] *= cosine < 0 ? 0 : cosine;
    }
}

/* room: a float a sample, two with hillshade. */
static cw_status fill_share(void *context, const cw_run *run, cw_rectangle at, void *to, void *room) {
    enum { GRAIN = 1 << 14 };
    sunlight *s = context;
    const size_t n = at.nx * at.ny;
    float *share = to, *work = room;
    for (size_t m = 0; m < n; m++) share[m] = 0;
    for (size_t k = 0; k < s->compass.count; k++) {
        const cw_run some = cw_run_share(&(run_part){0}, run, k, k + 1, s->compass.count);
        const cw_status status = add_strip(s, &some, k, at, work, share);
        if (status != CW_OK) return status;
    }
    if (s->desc.hillshade) {
        cw_terrain_slopes(s->terrain, run->pool, s->compass.middle, at, work, work + n);
        cw_pool_run(run->pool, n, GRAIN, shade, &(shading){s->towards, share, work, work + n});
    }
    for (size_t m = 0; m < n && s->night > -INFINITY; m++) {
        const float z = terrain_row(s->terrain, at.j + m / at.nx)[at.i + m % at.nx];
        if ((double)z <= s->night) share[m] = 0;
    }
    return CW_OK;
}

/* Of a point, without hillshade: all is seen or nothing. room: two floats a sample. */
static cw_status fill_lit(void *context, const cw_run *run, cw_rectangle at, void *to, void *room) {
    const size_t n = at.nx * at.ny;
    float *share = room;
    uint8_t *lit = to;
    const cw_status status = fill_share(context, run, at, share, share + n);
    for (size_t m = 0; m < n && status == CW_OK; m++) lit[m] = isnan(share[m]) ? 255 : share[m] > 0;
    return status;
}

static cw_status make(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, size_t bytes,
                      compass_fill *fill, void *out, const char *name) {
    FPENV_HERE;
    cw_run how;
    cw_status status = cw_area_begin(t, light, "light", run, 1, &area, &how);
    if (status == CW_OK) status = check(light);
    if (status != CW_OK) return status;
    sunlight s = {.terrain = t, .desc = *light};
    double azimuths[SUNLIGHT_STRIPS_MOST], level, sine, cosine, disc = 0;
    const size_t strips = cw_light_azimuths(light, azimuths);
    for (size_t k = 0; k < strips; k++) {
        const double aside = strip_aside(k, strips), half = sqrt(1 - aside * aside);
        s.strip[k] = (strip){half * light->radius, half};
        disc += half;
    }
    for (size_t k = 0; k < strips; k++) s.strip[k].share /= disc;
    cw_terrain_sine_cosine(light->altitude, &s.towards[2], &level);
    cw_terrain_sine_cosine(light->azimuth, &sine, &cosine);
    s.towards[0] = sine * level;
    s.towards[1] = cosine * level;
    s.night = night_limit(&s);
    status = cw_compass_create(&s.compass, t, strips, 0, light->curvature);
    if (status == CW_OK) memcpy(s.compass.azimuths, azimuths, strips * sizeof *azimuths);
    if (status == CW_OK)
        status = cw_compass_make(&s.compass, area, &how, bytes, 2 * sizeof(float), fill, &s, out, name);
    cw_compass_destroy(&s.compass);
    return status;
}

cw_status cw_shadow(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, uint8_t *lit) {
    cw_light point = light ? *light : (cw_light){0};
    point.radius = point.hillshade = 0;
    return make(t, run, light ? &point : NULL, area, sizeof *lit, fill_lit, lit, "lit");
}

cw_status cw_sunlight(const cw_terrain *t, const cw_run *run, const cw_light *light, cw_area area, float *share) {
    return make(t, run, light, area, sizeof *share, fill_share, share, "share");
}
