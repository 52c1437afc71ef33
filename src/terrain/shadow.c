/* SPDX-License-Identifier: Apache-2.0 */
/* A sample is in the shadow if the horizon in the direction of the sun is as high as the sun. For the disc, the
 * horizon is found along the middle line of each of several upright strips. The part of the strip above it is exact,
 * so a few strips are as good as hundreds of rays. */

#include "shadow.h"

#include "compass.h"
#include "normal.h"

#include <math.h>
#include <stdlib.h>

enum { STRIPS_USUAL = 16 };

static const double degree = 0.017453292519943295;

typedef struct strip {
    double altitude, half; /* of its middle, and from there to its ends; degrees */
    double share;          /* of the disc */
} strip;

struct sunlight {
    const terrain *terrain;
    sunlight_desc desc;
    size_t strips;
    strip strip[SUNLIGHT_STRIPS_MOST];
    double azimuths[SUNLIGHT_STRIPS_MOST];
    compass compass;
    double towards[3]; /* the sun: east, north, up */
    float *work;       /* for a part of a row block */
    size_t room;
};

/* The middle of a strip from the disc's middle line, as a part of its radius. */
static double strip_aside(size_t k, size_t strips) { return (2 * (double)k + 1) / (double)strips - 1; }

size_t sunlight_azimuths(const sunlight_desc *d, double azimuths[SUNLIGHT_STRIPS_MOST]) {
    const size_t strips = d->radius == 0 ? 1 : d->strips > 0 ? d->strips : STRIPS_USUAL;
    double level, up;
    terrain_sine_cosine(d->altitude, &up, &level);
    /* At the zenith the azimuth of a strip is undefined. */
    for (size_t k = 0; k < strips; k++)
        azimuths[k] = d->azimuth + (level > 0.01 ? strip_aside(k, strips) * d->radius / level : 0);
    return strips;
}

cw_status sunlight_create(const terrain *t, const sunlight_desc *desc, sunlight **light) {
    *light = NULL;
    if (!(fabs(desc->altitude) <= 90 && isfinite(desc->azimuth) && desc->radius >= 0 && desc->radius <= 10))
        return CW_ERROR_ARGUMENT;
    if (desc->strips > SUNLIGHT_STRIPS_MOST) return CW_ERROR_ARGUMENT;
    sunlight *s = calloc(1, sizeof *s);
    if (s == NULL) return CW_ERROR_MEMORY;
    s->terrain = t;
    s->desc = *desc;
    s->strips = sunlight_azimuths(desc, s->azimuths);
    double level, up, area = 0;
    terrain_sine_cosine(desc->altitude, &up, &level);
    for (size_t k = 0; k < s->strips; k++) {
        const double aside = strip_aside(k, s->strips), half = sqrt(1 - aside * aside);
        s->strip[k] = (strip){.altitude = desc->altitude, .half = half * desc->radius, .share = half};
        area += half;
    }
    for (size_t k = 0; k < s->strips; k++) s->strip[k].share /= area;
    double sine, cosine;
    terrain_sine_cosine(desc->azimuth, &sine, &cosine);
    s->towards[0] = sine * level;
    s->towards[1] = cosine * level;
    s->towards[2] = up;
    const cw_status status = compass_create(&s->compass, t, s->azimuths, s->strips, 0, desc->curvature);
    if (status == CW_OK)
        *light = s;
    else
        sunlight_destroy(s);
    return status;
}

void sunlight_destroy(sunlight *s) {
    if (s == NULL) return;
    compass_destroy(&s->compass);
    free(s->work);
    free(s);
}

static float *work(sunlight *s, size_t floats) {
    if (floats <= s->room) return s->work;
    free(s->work);
    s->work = malloc(floats * sizeof *s->work);
    s->room = s->work ? floats : 0;
    return s->work;
}

/* The rise, in a heading's numbers, of a ray at that altitude. */
static float rise(double slope, double altitude) {
    if (altitude >= 90) return INFINITY;
    if (altitude <= -90) return -INFINITY;
    double sine, cosine;
    terrain_sine_cosine(altitude, &sine, &cosine);
    return (float)(sine / cosine * slope);
}

/* Whether the middle of the sun is hidden. */
static cw_status blocked(sunlight *s, const cw_run *query, size_t row, size_t rows, uint8_t *occluded) {
    cw_heading *heading;
    double slope;
    const cw_status status = compass_heading(&s->compass, 0, &heading, &slope);
    if (status != CW_OK) return status;
    return cw_heading_occluded(heading, query, rise(slope, s->desc.altitude),
                               (cw_rectangle){0, row, s->terrain->nx, rows}, occluded);
}

/* At the raster's rim no terrain hides a sun below the level. From a height h over the sea a free horizon has the dip
 * acos(R / (R + h)), so samples up to this height, in their numbers, are dark. */
static double night_limit(const sunlight *s) {
    double sine, cosine, half, unused;
    const double top = s->desc.altitude + s->desc.radius;
    if (!(top < 0)) return -INFINITY;
    terrain_sine_cosine(top, &sine, &cosine);
    terrain_sine_cosine(top / 2, &half, &unused);
    if (!(cosine > 0)) return INFINITY;
    return s->terrain->radius * 2 * half * half / cosine / terrain_metres_of_height(s->terrain);
}

cw_status sunlight_lit(sunlight *s, const cw_run *query, size_t row, size_t rows, uint8_t *lit) {
    const size_t nx = s->terrain->nx, end = row + rows;
    if (s->strips != 1 || s->desc.hillshade) return CW_ERROR_ARGUMENT;
    const double night = night_limit(s);
    for (size_t count; row < end; row += count, lit += count * nx) {
        compass_turn(&s->compass, row, &count);
        count = count < end - row ? count : end - row;
        const cw_status status = blocked(s, query, row, count, lit);
        if (status != CW_OK) return status;
        const float *z = s->terrain->z + row * nx;
        for (size_t k = 0; k < nx * count; k++)
            lit[k] = !isfinite(z[k]) ? 255 : (double)z[k] <= night ? 0 : (uint8_t)(1 - lit[k]);
    }
    return CW_OK;
}

/* Adds the part of a strip that is seen: all of it where the horizon is below its lower end, nothing where it is
 * above its upper one. */
static cw_status add_strip(sunlight *s, const cw_run *query, size_t k, size_t row, size_t rows, float *steepest,
                           float *share) {
    const size_t n = s->terrain->nx * rows;
    const strip *p = &s->strip[k];
    cw_heading *heading;
    double slope;
    cw_status status = compass_heading(&s->compass, k, &heading, &slope);
    if (status != CW_OK) return status;
    const float low = rise(slope, p->altitude - p->half), high = rise(slope, p->altitude + p->half);
    status = cw_heading_steepest(heading, query, low, high, (cw_rectangle){0, row, s->terrain->nx, rows}, steepest);
    if (status != CW_OK) return status;
    /* The tangent of the angle between two directions; as the disc is small, that is the angle. */
    const float per_rise = (float)(1 / slope), top = high * per_rise, whole = (float)p->share;
    const float per_tangent = (float)(1 / (2 * p->half * degree));
    const bool even = top < INFINITY && low > -INFINITY;
    for (size_t m = 0; m < n; m++) {
        const float bottom = steepest[m] * per_rise;
        const float part = even                 ? (top - bottom) / (1 + top * bottom) * per_tangent
                           : steepest[m] < high ? 1
                                                : steepest[m] * 0;
        share[m] += whole * (part > 1 ? 1 : part);
    }
    return CW_OK;
}

static cw_status share_of_disc(sunlight *s, const cw_run *query, size_t row, size_t rows, float *share) {
    const size_t n = s->terrain->nx * rows;
    const float *z = s->terrain->z + row * s->terrain->nx;
    for (size_t m = 0; m < n; m++) share[m] = 0;
    if (s->desc.radius == 0) {
        uint8_t *occluded = (uint8_t *)work(s, (n + 3) / 4);
        if (occluded == NULL) return CW_ERROR_MEMORY;
        const cw_status status = blocked(s, query, row, rows, occluded);
        for (size_t m = 0; m < n && status == CW_OK; m++) share[m] = isfinite(z[m]) ? 1 - (float)occluded[m] : NAN;
        return status;
    }
    float *steepest = work(s, n);
    if (steepest == NULL) return CW_ERROR_MEMORY;
    for (size_t k = 0; k < s->strips; k++) {
        const cw_status status = add_strip(s, query, k, row, rows, steepest, share);
        if (status != CW_OK) return status;
    }
    return CW_OK;
}

/* Rows to shade: the light that their tilted ground receives. */
typedef struct shading {
    const sunlight *light;
    size_t row;
    float *share, *lean;     /* lean: two rows for each of the block's */
    float east[2], north[2]; /* lean along i and j to slope, in metres, eastward and northward */
} shading;

static void shade_rows(void *context, size_t begin, size_t end) {
    const shading *h = context;
    const size_t nx = h->light->terrain->nx;
    const float lx = (float)h->light->towards[0], ly = (float)h->light->towards[1], lz = (float)h->light->towards[2];
    for (size_t j = begin; j < end; j++) {
        float *restrict share = h->share + j * nx, *restrict x = h->lean + 2 * j * nx, *restrict y = x + nx;
        terrain_lean_row(h->light->terrain, h->row + j, x, y);
        for (size_t i = 0; i < nx; i++) {
            const float east = x[i] * h->east[0] + y[i] * h->east[1], north = x[i] * h->north[0] + y[i] * h->north[1];
            const float cosine = (lz - east * lx - north * ly) / sqrtf(1 + east * east + north * north);
            share[i] *= cosine < 0 ? 0 : cosine;
        }
    }
}

static cw_status shade(sunlight *s, const cw_run *query, size_t row, size_t rows, float *share) {
    const terrain *t = s->terrain;
    double metres[2];
    const terrain *whole = terrain_whole(t);
    terrain_metres(whole, 0.5 * (double)(whole->nx - 1), compass_middle(&s->compass), metres);
    shading h = {.light = s, .row = row, .share = share, .lean = work(s, 2 * rows * t->nx)};
    if (h.lean == NULL) return CW_ERROR_MEMORY;
    for (int k = 0; k < 2; k++) {
        h.east[k] = (float)(t->back[k][0] * t->map[2][2] / metres[0]);
        h.north[k] = (float)(t->back[k][1] * t->map[2][2] / metres[1]);
    }
    cw_pool_run(query ? query->pool : NULL, rows, 4, shade_rows, &h);
    return CW_OK;
}

cw_status sunlight_share(sunlight *s, const cw_run *query, size_t row, size_t rows, float *share) {
    const size_t nx = s->terrain->nx, end = row + rows;
    const double night = night_limit(s);
    for (size_t count; row < end; row += count, share += count * nx) {
        compass_turn(&s->compass, row, &count);
        count = count < end - row ? count : end - row;
        cw_status status = share_of_disc(s, query, row, count, share);
        if (status == CW_OK && s->desc.hillshade) status = shade(s, query, row, count, share);
        const float *z = s->terrain->z + row * nx;
        for (size_t k = 0; k < nx * count && night > -INFINITY; k++)
            if ((double)z[k] <= night && isfinite(z[k])) share[k] = 0;
        if (status != CW_OK) return status;
    }
    return CW_OK;
}
