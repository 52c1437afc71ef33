/* SPDX-License-Identifier: Apache-2.0 */
/* Products with a number for each sample of the window, and what of a raster matters to a window. */
#include "extension.h"
#include "ground.h"
#include "insolation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t samples_of(const call *c) { return c->at.nx * c->at.ny; }

/* ---- the sun ----------------------------------------------------------------------------------------------------- */

/* Input: times. Output: a sun_position for each, azimuths from the map's north, which is turned from the true one toward the west. */
cw_status make_suns(call *c) {
    size_t count;
    const double *times = call_input(c, 0, sizeof *times, &count);
    sun_position *out = call_output(c, 0, count * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    for (size_t k = 0; k < count; k++) {
        out[k] = cw_sun_at(times[k], c->n.longitude, c->n.latitude);
        out[k].azimuth = fmod(out[k].azimuth + c->n.turned + 360, 360);
    }
    return CW_OK;
}

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

typedef cw_status sum_all(const cw_terrain *t, const cw_run *run, const cw_horizon *h, cw_area area, float *sums);

/* Into plane number k of the output, times a number. */
static cw_status add_up(call *c, sum_all *sum, const cw_horizon *h, size_t k, float times) {
    const size_t plane = samples_of(c);
    float *out = call_output(c, 0, (k + 1) * plane * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    out += k * plane;
    const cw_status status = sum(&c->field->terrain, &c->work.run, h, (cw_area){c->at, 0}, out);
    for (size_t s = 0; s < plane && status == CW_OK && times != 1; s++) out[s] *= times;
    return status;
}

cw_status make_sky(call *c) {
    const cw_horizon h = horizon_of(c, c->n.tilted != 0 ? CW_HORIZON_TILTED : 0);
    return add_up(c, cw_sky_view, &h, 0, 1);
}

cw_status make_openness(call *c) {
    const cw_horizon h = horizon_of(c, c->n.below != 0 ? CW_HORIZON_BELOW : 0);
    return add_up(c, cw_openness, &h, 0, 1);
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
    if (status == CW_OK && on) status = add_up(c, cw_sky_view, &sky, 1, (float)cw_insolation_diffuse(s));
    cw_insolation_destroy(s);
    return status;
}

/* ---- the ground in sight ------------------------------------------------------------------------------------------- */

/* kind: which of the answers. */
cw_status make_visibility(call *c) {
    const call_numbers *n = &c->n;
    const cw_visibility_desc d = {.directions = (uint32_t)n->directions,
                                  .max_distance = n->max_distance,
                                  .height = n->observer_height,
                                  .target = n->target_height,
                                  .curvature = n->curvature,
                                  .every = n->every >= 1 ? (uint32_t)n->every : 1};
    const size_t wide = (c->at.nx + d.every - 1) / d.every, eyes = wide * ((c->at.ny + d.every - 1) / d.every);
    float *to[4] = {NULL}, *out = call_output(c, 0, eyes * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    to[(size_t)n->kind % 4] = out;
    const cw_visibility_answers answers = {.area = to[0], .share = to[1], .farthest = to[2], .azimuth = to[3]};
    return cw_visibility(&c->field->terrain, &c->work.run, &d, (cw_area){c->at, 0}, &answers);
}

/* ---- how much of a raster matters to a part of it -------------------------------------------------------------------- */

/* The rectangle goes to the output as row, column, rows and columns. */
static cw_status answer(call *c, cw_rectangle r) {
    double *out = call_output(c, 0, 4 * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    const double numbers[] = {(double)r.j, (double)r.i, (double)r.ny, (double)r.nx};
    memcpy(out, numbers, sizeof numbers);
    return CW_OK;
}

/* The window, with at least 2 rows and columns. */
cw_status make_grown(call *c) { return answer(c, cw_reach_grow(&c->field->terrain, c->at, 0)); }

/* The part that a viewshed from a place of the map examines; no rows if there is none. */
cw_status make_around(call *c) {
    const terrain *t = &c->field->terrain;
    double at[2];
    if (!cw_terrain_find_place(t, c->n.x, northward(c->field, c->n.y), at))
        return call_fail(c, "x, y: an observer is too far away from the terrain");
    return answer(c, cw_reach_around(t, at, c->n.max_distance));
}

static size_t blocks_along(size_t samples) { return (samples + REACH_BLOCK - 1) / REACH_BLOCK; }

/* The window and all within max_distance of it. Or, with inputs, all that can throw a shadow on it: lowest and highest samples of all
 * blocks, row by row, and azimuth, altitude, radius and curvature of each light. */
cw_status make_reach(call *c) {
    const terrain *t = &c->field->terrain;
    ground_plan plan = {.by = {.distance = c->n.max_distance}, .whole = t};
    reach_blocks b = {t, blocks_along(t->nx), blocks_along(t->ny), .highest = (float)c->n.highest};
    size_t lows, highs, count;
    /* The plan only reads them. */
    b.low = (float *)(uintptr_t)call_input(c, 0, sizeof(float), &lows);
    b.high = (float *)(uintptr_t)call_input(c, 1, sizeof(float), &highs);
    const double(*given)[4] = call_input(c, 2, sizeof *given, &count);
    cw_light *lights = calloc(count + 1, sizeof *lights);
    if (lights == NULL) return CW_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++)
        lights[k] = (cw_light){
            .azimuth = given[k][0], .altitude = given[k][1], .radius = given[k][2], .curvature = given[k][3]};
    if (c->in_count > 0) {
        plan.by.suns = lights;
        plan.by.sun_count = count;
        plan.blocks = b;
    }
    cw_rectangle piece;
    cw_status status = c->in_count > 0 && (lows < b.across * b.down || highs < lows)
                           ? call_fail(c, "low, high: fewer than there are blocks")
                           : ground_plan_around(&plan, c->at, &piece);
    free(lights);
    return status == CW_OK ? answer(c, piece) : status;
}
