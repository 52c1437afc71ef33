/* SPDX-License-Identifier: Apache-2.0 */
/* Products with a number for each sample of the window, which has all of the field's columns but for visibility's. */
#include "call.h"
#include "horizon.h"
#include "insolation.h"
#include "shadow.h"
#include "visibility.h"

#include <math.h>
#include <stdlib.h>

/* ---- the sun ----------------------------------------------------------------------------------------------------- */

cw_status make_shadow(call *c) {
    const call_numbers *n = &c->n;
    const size_t nx = c->field->nx;
    const sunlight_desc d = {.azimuth = n->azimuth,
                             .altitude = n->altitude,
                             .radius = n->disc,
                             .curvature = n->curvature,
                             .hillshade = n->hillshade != 0};
    const bool share = n->share != 0;
    char *out = call_output(c, 0, c->at.ny * nx * (share ? sizeof(float) : 1));
    sunlight *light;
    if (out == NULL) return CW_ERROR_ARGUMENT;
    cw_status status = sunlight_create(&c->field->terrain, &d, &light);
    if (status != CW_OK) return status;
    for (size_t k = 0, some; status == CW_OK && (some = call_rows(c, k, d.radius > 0 ? 16 : 1)) > 0; k += some)
        status = share ? sunlight_share(light, &c->work.run, c->at.j + k, some, (float *)out + k * nx)
                       : sunlight_lit(light, &c->work.run, c->at.j + k, some, (uint8_t *)out + k * nx);
    sunlight_destroy(light);
    return status;
}

/* ---- what goes all round --------------------------------------------------------------------------------------------- */

static horizon_desc horizon_of(const call *c) {
    return (horizon_desc){.start = c->n.start,
                          .count = (size_t)c->n.directions,
                          .max_distance = c->n.max_distance,
                          .curvature = c->n.curvature,
                          .below = c->n.below != 0};
}

typedef cw_status find_some(horizon *h, const cw_run *run, size_t number, size_t row, size_t rows, float *to);

/* Direction by direction: a plane of the first output, and an azimuth of the second. */
static cw_status find_all(call *c, find_some *find) {
    const horizon_desc d = horizon_of(c);
    const size_t nx = c->field->nx, plane = c->at.ny * nx;
    float *out = call_output(c, 0, d.count * plane * sizeof *out);
    double *azimuths = call_output(c, 1, d.count * sizeof *azimuths);
    horizon *h;
    if (out == NULL || azimuths == NULL) return CW_ERROR_ARGUMENT;
    cw_status status = horizon_create(&c->field->terrain, &d, &h);
    for (size_t k = 0; k < d.count && status == CW_OK; k++, out += plane) {
        azimuths[k] = horizon_azimuth(h, k);
        c->begin = (double)k / (double)d.count;
        c->share = 1 / (double)d.count;
        for (size_t r = 0, some; status == CW_OK && (some = call_rows(c, r, 1)) > 0; r += some)
            status = find(h, &c->work.run, k, c->at.j + r, some, out + r * nx);
        for (size_t s = 0; s < plane && status == CW_OK && find == horizon_angles; s++)
            if (out[s] == -90) out[s] = NAN; /* nothing is there: no horizon */
    }
    horizon_destroy(h);
    return status;
}

cw_status make_angles(call *c) { return find_all(c, horizon_angles); }
cw_status make_distances(call *c) { return find_all(c, horizon_distances); }

typedef cw_status sum_some(horizon *h, const cw_run *run, size_t row, size_t rows, float *to,
                           terrain_progress *progress, void *context, bool *done);

/* Sums over directions, times a number, into plane number k of the output. */
static cw_status sum_all(call *c, const horizon_desc *d, sum_some *sum, size_t k, float times) {
    const size_t nx = c->field->nx, plane = c->at.ny * nx;
    float *out = call_output(c, 0, (k + 1) * plane * sizeof *out);
    horizon *h;
    if (out == NULL) return CW_ERROR_ARGUMENT;
    out += k * plane;
    cw_status status = horizon_create(&c->field->terrain, d, &h);
    bool done = true;
    for (size_t r = 0, some; status == CW_OK && done && (some = call_rows(c, r, 1)) > 0; r += some)
        status = sum(h, &c->work.run, c->at.j + r, some, out + r * nx, work_watch, &c->work, &done);
    for (size_t s = 0; s < plane && status == CW_OK && times != 1; s++) out[s] *= times;
    horizon_destroy(h);
    return status;
}

static cw_status make_sum(call *c, sum_some *sum) {
    const horizon_desc d = horizon_of(c);
    return sum_all(c, &d, sum, 0, 1);
}

cw_status make_sky(call *c) { return make_sum(c, horizon_sky_view); }
cw_status make_tilted_sky(call *c) { return make_sum(c, horizon_sky_view_tilted); }
cw_status make_openness(call *c) { return make_sum(c, horizon_openness); }

/* ---- sunlight over days ------------------------------------------------------------------------------------------------ */

/* Input 0: places of the sun. */
static cw_status find_suns(call *c, insolation **sum) {
    size_t count;
    const sun_position *suns = call_input(c, 0, sizeof *suns, &count);
    const insolation_desc d = {.suns = suns,
                               .count = count,
                               .hours = c->n.hours,
                               .linke = c->n.linke,
                               .curvature = c->n.curvature,
                               .directions = (size_t)c->n.directions};
    return insolation_create(&c->field->terrain, &d, sum);
}

typedef cw_status sun_some(insolation *s, const cw_run *run, size_t row, size_t rows, float *to,
                           terrain_progress *progress, void *context, bool *done);

static cw_status add_suns(call *c, insolation *s, sun_some *add) {
    const size_t nx = c->field->nx;
    float *out = call_output(c, 0, c->at.ny * nx * sizeof *out);
    cw_status status = out ? CW_OK : CW_ERROR_ARGUMENT;
    bool done = true;
    for (size_t r = 0, some; status == CW_OK && done && (some = call_rows(c, r, 1)) > 0; r += some)
        status = add(s, &c->work.run, c->at.j + r, some, out + r * nx, work_watch, &c->work, &done);
    return status;
}

cw_status make_hours(call *c) {
    insolation *s;
    cw_status status = find_suns(c, &s);
    if (status == CW_OK) status = add_suns(c, s, insolation_hours);
    insolation_destroy(s);
    return status;
}

/* A plane of direct light and one of diffuse light. */
cw_status make_irradiance(call *c) {
    const horizon_desc sky = {.count = (size_t)c->n.sky, .curvature = c->n.curvature};
    insolation *s;
    cw_status status = find_suns(c, &s);
    c->share = 0.5;
    if (status == CW_OK) status = add_suns(c, s, insolation_direct);
    c->begin = 0.5;
    if (status == CW_OK) status = sum_all(c, &sky, horizon_sky_view_tilted, 1, (float)insolation_diffuse(s));
    insolation_destroy(s);
    return status;
}

/* ---- the ground in sight ------------------------------------------------------------------------------------------- */

/* kind: the answer wanted, as visibility_answers has them. */
cw_status make_visibility(call *c) {
    enum { AREA, SHARE, LONGEST, AZIMUTH };
    const call_numbers *n = &c->n;
    const int kind = (int)n->kind;
    const visibility_desc d = {.directions = (size_t)n->directions,
                               .max_distance = n->max_distance,
                               .eye_height = n->observer_height,
                               .target_height = n->target_height,
                               .curvature = n->curvature,
                               .every = n->every >= 1 ? (size_t)n->every : 1};
    const size_t wide = (c->at.nx + d.every - 1) / d.every, eyes = wide * ((c->at.ny + d.every - 1) / d.every);
    float *out = call_output(c, 0, eyes * sizeof *out),
          *other = kind >= LONGEST ? malloc(eyes * sizeof *other + 1) : NULL;
    if (out == NULL || (kind >= LONGEST && other == NULL)) {
        free(other);
        return out == NULL ? CW_ERROR_ARGUMENT : CW_ERROR_MEMORY;
    }
    const visibility_answers to = {.area = kind == AREA ? out : NULL,
                                   .share = kind == SHARE ? out : NULL,
                                   .farthest = kind == LONGEST ? out : other,
                                   .azimuth = kind == LONGEST   ? other
                                              : kind == AZIMUTH ? out
                                                                : NULL};
    bool done;
    const cw_status status =
        visibility_find(&c->field->terrain, &d, &c->work.run, c->at, &to, work_watch, &c->work, &done);
    free(other);
    return status;
}
