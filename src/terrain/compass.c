/* SPDX-License-Identifier: Apache-2.0 */
#include "compass.h"

#include "area.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

cw_status cw_compass_create(compass *c, const terrain *t, size_t count, double reach, double curvature) {
    *c = (compass){.terrain = t, .count = count, .reach = reach, .curvature = curvature};
    c->azimuths = calloc(count, sizeof *c->azimuths);
    c->headings = calloc(count, sizeof *c->headings);
    return c->azimuths && c->headings ? CW_OK : cw_fail_plainly(CW_ERROR_MEMORY);
}

void cw_compass_release(compass *c, size_t k) {
    cw_heading_destroy(c->headings[k]);
    c->headings[k] = NULL;
}

void cw_compass_destroy(compass *c) {
    for (size_t k = 0; k < c->count && c->headings; k++) cw_compass_release(c, k);
    free(c->headings);
    free(c->azimuths);
    *c = (compass){0};
}

/* Turns to the rectangle's first row, and ends it where headings do: the same rows of the whole raster share headings,
 * wherever a rectangle begins. */
static void turn(compass *c, cw_rectangle *at) {
    const terrain *whole = terrain_whole(c->terrain);
    const size_t row = at->j + c->terrain->row;
    if (row < c->from || row >= c->until) {
        for (size_t k = 0; k < c->count; k++) cw_compass_release(c, k);
        if (row < c->from) c->until = 0;
        do {
            c->from = c->until;
            c->until = c->from + cw_terrain_rows_alike(whole, c->from);
        } while (row >= c->until);
        c->middle = 0.5 * (double)(c->from + c->until - 1);
    }
    if (at->ny > c->until - row) at->ny = c->until - row;
}

cw_status cw_compass_look(compass *c, size_t k, compass_way *way) {
    const terrain *t = c->terrain, *whole = terrain_whole(t);
    const double metres =
        cw_terrain_direction(whole, 0.5 * (double)(whole->nx - 1), c->middle, c->azimuths[k], way->dir);
    way->length = metres;
    way->slope = metres / t->map[2][2];
    /* The ground d metres away is lower by curvature d² / 2 R; dir is `metres` metres long. */
    const cw_heading_desc desc = {.dir = {way->dir[0], way->dir[1]},
                                  .reach = c->reach > 0 ? fmin(fmax(c->reach / metres, DBL_MIN), 0x1p30) : 0,
                                  .drop = c->curvature * metres * metres / (2 * t->radius * t->map[2][2])};
    const cw_status status = c->headings[k] ? CW_OK : cw_heading_create(t->field, &desc, &c->headings[k]);
    way->heading = c->headings[k];
    return status;
}

cw_status cw_compass_make(compass *c, cw_area area, const cw_run *how, size_t bytes, size_t room, compass_fill *fill,
                          void *context, void *out, const char *name) {
    enum { SAMPLES_AT_ONCE = 1 << 20 };
    const cw_rectangle all = area.at;
    if (all.nx == 0 || all.ny == 0) return CW_OK;
    if (out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", name);
    const size_t few = all.nx < SAMPLES_AT_ONCE ? SAMPLES_AT_ONCE / all.nx : 1, most = few < all.ny ? few : all.ny;
    const size_t row = all.nx * bytes, gap = area.stride * bytes;
    char *memory = malloc(most * all.nx * (room + bytes));
    if (memory == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    cw_status status = CW_OK;
    char *packed = memory + most * all.nx * room;
    for (size_t y = 0; y < all.ny && status == CW_OK;) {
        cw_rectangle at = {all.i, all.j + y, all.nx, most < all.ny - y ? most : all.ny - y};
        turn(c, &at);
        const cw_run run = cw_run_share(&(run_part){0}, how, y, y + at.ny, all.ny);
        char *to = (char *)out + y * gap;
        status = fill(context, &run, at, gap > row ? packed : to, memory);
        for (size_t k = 0; k < at.ny && gap > row && status == CW_OK; k++) memcpy(to + k * gap, packed + k * row, row);
        y += at.ny;
    }
    free(memory);
    return status;
}

float cw_compass_rise(double slope, double altitude) {
    if (altitude >= 90) return INFINITY;
    if (altitude <= -90) return -INFINITY;
    double sine, cosine;
    cw_terrain_sine_cosine(altitude, &sine, &cosine);
    return (float)(sine / cosine * slope);
}
