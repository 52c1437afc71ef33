/* SPDX-License-Identifier: Apache-2.0 */
/* How much of a raster matters to a part of it, by src/ground/ground_plan.h. The rectangle goes to the output as row, column, rows and
 * columns. */
#include "call.h"
#include "ground_plan.h"

#include <stdlib.h>

static cw_status answer(call *c, cw_rectangle r) {
    double *out = call_output(c, 0, 4 * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    out[0] = (double)r.j;
    out[1] = (double)r.i;
    out[2] = (double)r.ny;
    out[3] = (double)r.nx;
    return CW_OK;
}

static cw_status answer_plan(call *c, ground_plan *plan) {
    cw_rectangle piece;
    const cw_status status = ground_plan_around(plan, c->at, &piece);
    return status == CW_OK ? answer(c, piece) : status;
}

/* The window and all within max_distance of it. */
cw_status make_beside(call *c) {
    ground_plan plan = {.by = {.distance = c->n.max_distance}, .whole = &c->field->terrain};
    return answer_plan(c, &plan);
}

/* With so many rows and columns more, and at least 2 of each. */
cw_status make_grown(call *c) { return answer(c, cw_reach_grow(&c->field->terrain, c->at, 0)); }

/* The part that a viewshed from a place of the map examines; no rows if there is none. */
cw_status make_around(call *c) {
    const py_field *f = c->field;
    double at[2];
    if (!cw_terrain_find_place(&f->terrain, c->n.x, northward(f, c->n.y), at))
        return call_fail(c, "x, y: an observer is too far away from the terrain");
    return answer(c, cw_reach_around(&f->terrain, at, c->n.max_distance));
}

static size_t blocks_along(size_t samples) { return (samples + REACH_BLOCK - 1) / REACH_BLOCK; }

/* The window and all that can throw a shadow on it. Inputs: lowest and highest samples of all blocks, row by row; azimuth, altitude,
 * radius and curvature of each light. */
cw_status make_sunward(call *c) {
    const terrain *t = &c->field->terrain;
    reach_blocks blocks = {
        .whole = t, .across = blocks_along(t->nx), .down = blocks_along(t->ny), .highest = (float)c->n.highest};
    size_t lows, highs, count;
    /* The plan reads them alone. */
    blocks.low = (float *)(uintptr_t)call_input(c, 0, sizeof(float), &lows);
    blocks.high = (float *)(uintptr_t)call_input(c, 1, sizeof(float), &highs);
    const double(*given)[4] = call_input(c, 2, sizeof *given, &count);
    if (lows < blocks.across * blocks.down || highs < lows)
        return call_fail(c, "low, high: fewer than there are blocks");
    cw_light *lights = calloc(count + 1, sizeof *lights);
    if (lights == NULL) return CW_ERROR_MEMORY;
    for (size_t k = 0; k < count; k++)
        lights[k] = (cw_light){
            .azimuth = given[k][0], .altitude = given[k][1], .radius = given[k][2], .curvature = given[k][3]};
    ground_plan plan = {.by = {.suns = lights, .sun_count = count}, .whole = t, .blocks = blocks};
    const cw_status status = answer_plan(c, &plan);
    free(lights);
    return status;
}
