/* SPDX-License-Identifier: Apache-2.0 */
#include "compass.h"

#include "sister.h"

#include <math.h>
#include <stdlib.h>

cw_status cw_compass_create(compass *c, const terrain *t, const double *azimuths, size_t count, double reach,
                            double curvature) {
    *c = (compass){.terrain = t, .count = count, .azimuths = azimuths, .reach = reach, .curvature = curvature};
    if (!(reach >= 0 && curvature >= 0 && isfinite(reach) && isfinite(curvature)))
        return cw_fail(CW_ERROR_ARGUMENT, "max_distance, curvature: %g, %g; finite and not negative", reach, curvature);
    c->headings = calloc(count, sizeof(cw_heading *));
    return c->headings ? CW_OK : cw_fail_plainly(CW_ERROR_MEMORY);
}

static void forget(compass *c) {
    for (size_t k = 0; k < c->count && c->headings != NULL; k++) {
        cw_heading_destroy(c->headings[k]);
        c->headings[k] = NULL;
    }
}

void cw_compass_destroy(compass *c) {
    forget(c);
    free(c->headings);
    *c = (compass){0};
}

void cw_compass_turn(compass *c, cw_rectangle *at, size_t end) {
    const terrain *whole = terrain_whole(c->terrain);
    const size_t row = at->j + c->terrain->row;
    if (row < c->from || row >= c->until) {
        forget(c);
        if (row < c->from) c->until = 0;
        do {
            c->from = c->until;
            c->until = c->from + cw_terrain_rows_alike(whole, c->from);
        } while (row >= c->until);
    }
    at->ny = c->until - row < end - at->j ? c->until - row : end - at->j;
}

void cw_compass_release(compass *c, size_t k) {
    cw_heading_destroy(c->headings[k]);
    c->headings[k] = NULL;
}

double cw_compass_middle(const compass *c) { return 0.5 * (double)(c->from + c->until - 1); }

cw_status cw_compass_heading(compass *c, size_t k, cw_heading **heading, double *slope) {
    const terrain *t = c->terrain, *whole = terrain_whole(t);
    double dir[2];
    const double metres =
        cw_terrain_direction(whole, 0.5 * (double)(whole->nx - 1), cw_compass_middle(c), c->azimuths[k], dir);
    *slope = metres / t->map[2][2];
    cw_status status = CW_OK;
    /* The ground d metres away is lower by curvature d² / 2 R; dir is `metres` metres long. */
    const cw_heading_desc desc = {.dir = {dir[0], dir[1]},
                                  .reach = c->reach / metres,
                                  .drop = c->curvature * metres * metres / (2 * t->radius * t->map[2][2])};
    if (c->headings[k] == NULL) status = cw_heading_create(t->field, &desc, &c->headings[k]);
    *heading = c->headings[k];
    return status;
}

float cw_compass_rise(double slope, double altitude) {
    if (altitude >= 90) return INFINITY;
    if (altitude <= -90) return -INFINITY;
    double sine, cosine;
    cw_terrain_sine_cosine(altitude, &sine, &cosine);
    return (float)(sine / cosine * slope);
}
