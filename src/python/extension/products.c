/* SPDX-License-Identifier: Apache-2.0 */
/* Products with a number for each sample of the window. */
#include "call.h"
#include "insolation.h"

#include <math.h>
#include <stdlib.h>

static size_t samples_of(const call *c) { return c->at.nx * c->at.ny; }

/* ---- the sun ----------------------------------------------------------------------------------------------------- */

cw_status make_shadow(call *c) {
    const call_numbers *n = &c->n;
    const cw_light light = {.azimuth = n->azimuth,
                            .altitude = n->altitude,
                            .radius = n->disc,
                            .curvature = n->curvature,
                            .hillshade = n->hillshade != 0};
    const bool share = n->share != 0;
    const cw_area area = {c->at, 0};
    void *out = call_output(c, 0, samples_of(c) * (share ? sizeof(float) : 1));
    if (out == NULL) return CW_ERROR_ARGUMENT;
    return share ? cw_sunlight(&c->field->terrain, &c->work.run, &light, area, out)
                 : cw_shadow(&c->field->terrain, &c->work.run, &light, area, out);
}

/* ---- what goes all round --------------------------------------------------------------------------------------------- */

static cw_horizon horizon_of(const call *c, uint32_t flags) {
    return (cw_horizon){.start = c->n.start,
                        .count = (uint32_t)c->n.directions,
                        .max_distance = c->n.max_distance,
                        .curvature = c->n.curvature,
                        .flags = flags};
}

/* Direction by direction: a plane of the output. */
cw_status make_horizon(call *c) {
    const cw_horizon h = horizon_of(c, 0);
    const size_t plane = samples_of(c);
    const bool metres = c->n.metres != 0;
    float *out = call_output(c, 0, h.count * plane * sizeof *out);
    cw_status status = out ? CW_OK : CW_ERROR_ARGUMENT;
    for (uint32_t k = 0; k < h.count && status == CW_OK; k++, out += plane) {
        if (!work_part(&c->work, (double)k / h.count, 1.0 / h.count)) return CW_OK;
        status = cw_horizon_angles(&c->field->terrain, &c->work.run, &h, k, (cw_area){c->at, 0}, metres ? NULL : out,
                                   metres ? out : NULL);
    }
    return status;
}

/* Into plane number k of the output, times a number. */
static cw_status sum_all(call *c, const cw_horizon *h, size_t k, float times) {
    const size_t plane = samples_of(c);
    float *out = call_output(c, 0, (k + 1) * plane * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    out += k * plane;
    const cw_status status = cw_sky_view(&c->field->terrain, &c->work.run, h, (cw_area){c->at, 0}, out);
    for (size_t s = 0; s < plane && status == CW_OK && times != 1; s++) out[s] *= times;
    return status;
}

cw_status make_sky(call *c) {
    const cw_horizon h = horizon_of(c, c->n.tilted != 0 ? CW_HORIZON_TILTED : 0);
    return sum_all(c, &h, 0, 1);
}

cw_status make_openness(call *c) {
    const cw_horizon h = horizon_of(c, c->n.below != 0 ? CW_HORIZON_BELOW : 0);
    float *out = call_output(c, 0, samples_of(c) * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    return cw_openness(&c->field->terrain, &c->work.run, &h, (cw_area){c->at, 0}, out);
}

/* ---- sunlight over days ------------------------------------------------------------------------------------------------ */

/* Inputs: places of the sun and, if they have any, as many weights. */
static cw_status find_suns(call *c, insolation **sum) {
    size_t count, weighted;
    const sun_position *suns = call_input(c, 0, sizeof *suns, &count);
    const double *weights = call_input(c, 1, sizeof *weights, &weighted);
    const insolation_desc d = {.suns = suns,
                               .count = weighted > 0 && weighted < count ? weighted : count,
                               .weights = weights,
                               .hours = c->n.hours,
                               .linke = c->n.linke,
                               .curvature = c->n.curvature,
                               .directions = (size_t)c->n.directions};
    return cw_insolation_create(&c->field->terrain, &d, sum);
}

/* Hours or, with energy, a plane of direct light and without weights one of diffuse light. */
cw_status make_insolation(call *c) {
    const cw_horizon sky = {.count = (uint32_t)c->n.sky, .curvature = c->n.curvature, .flags = CW_HORIZON_TILTED};
    const cw_area area = {c->at, 0};
    const bool energy = c->n.energy != 0, diffuse = energy && c->in_count < 2;
    insolation *s;
    float *out = call_output(c, 0, (diffuse ? 2 : 1) * samples_of(c) * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    cw_status status = find_suns(c, &s);
    bool on = work_part(&c->work, 0, diffuse ? 0.5 : 1);
    if (status == CW_OK && on)
        status = (energy ? cw_insolation_direct : cw_insolation_hours)(s, &c->work.run, area, out);
    on = on && diffuse && work_part(&c->work, 0.5, 0.5);
    if (status == CW_OK && on) status = sum_all(c, &sky, 1, (float)cw_insolation_diffuse(s));
    cw_insolation_destroy(s);
    return status;
}

/* ---- the ground in sight ------------------------------------------------------------------------------------------- */

/* kind: the answer wanted, as visibility_answers has them. */
cw_status make_visibility(call *c) {
    enum { AREA, SHARE, LONGEST, AZIMUTH };
    const call_numbers *n = &c->n;
    const int kind = (int)n->kind;
    const cw_visibility_desc d = {.directions = (uint32_t)n->directions,
                                  .max_distance = n->max_distance,
                                  .height = n->observer_height,
                                  .target = n->target_height,
                                  .curvature = n->curvature,
                                  .every = n->every >= 1 ? (uint32_t)n->every : 1};
    const size_t wide = (c->at.nx + d.every - 1) / d.every, eyes = wide * ((c->at.ny + d.every - 1) / d.every);
    float *out = call_output(c, 0, eyes * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    const cw_visibility_answers to = {.area = kind == AREA ? out : NULL,
                                      .share = kind == SHARE ? out : NULL,
                                      .farthest = kind == LONGEST ? out : NULL,
                                      .azimuth = kind == AZIMUTH ? out : NULL};
    return cw_visibility(&c->field->terrain, &c->work.run, &d, (cw_area){c->at, 0}, &to);
}
