/* SPDX-License-Identifier: Apache-2.0 */
/* Terrains of fields, and what they keep. */
#include "area.h"
#include "fpenv.h"
#include "samples.h"
#include "sight.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* The first thread that needs bounds makes them; of two at once, one throws its own away. */
struct terrain_own {
    sight_bounds *_Atomic bounds;
    map_scale scale;
};

/* In one piece of memory: what is given to callers is its first member. */
typedef struct whole_terrain {
    terrain terrain;
    struct terrain_own own;
} whole_terrain;

_Static_assert((int)MAP_SCALE_ROWS == (int)CW_SCALE_ROWS && (int)MAP_SCALE_COLUMNS == (int)CW_SCALE_COLUMNS, "");

cw_status cw_terrain_bounds(const terrain *t, const sight_bounds **bounds) {
    sight_bounds *there = t->own ? atomic_load(&t->own->bounds) : NULL, *made;
    *bounds = t->bounds ? t->bounds : there;
    if (*bounds) return CW_OK;
    const cw_status status = cw_sight_bounds_create(t, &made);
    if (status != CW_OK) return status;
    *bounds = made;
    if (t->own == NULL || atomic_compare_exchange_strong(&t->own->bounds, &there, made)) return CW_OK;
    cw_sight_bounds_destroy(made);
    *bounds = there;
    return CW_OK;
}

void cw_terrain_bounds_release(const terrain *t, const sight_bounds *bounds) {
    if (t->own == NULL && t->bounds == NULL) cw_sight_bounds_destroy((sight_bounds *)bounds);
}

static cw_status check(const cw_terrain_desc *d, double m[3][4]) {
    if (d->field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    const cw_field_info info = cw_field_describe(d->field);
    memcpy(m, info.map, sizeof info.map);
    cw_status status = cw_check_reserved(d->reserved, 8, d->zero, "cw_terrain_desc");
    if (status == CW_OK && (m[0][2] != 0 || m[1][2] != 0 || m[2][0] != 0 || m[2][1] != 0 || m[2][3] != 0))
        status = cw_fail(CW_ERROR_ARGUMENT,
                         "field: its map leads from z to x or y, or to a height that is no multiple of z");
    if (status == CW_OK) status = cw_check_number("field: height of one in z", m[2][2], DBL_MIN, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("geographic", d->geographic, 0, 1);
    if (status == CW_OK) status = cw_check_number("unit", d->unit, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("semi_major", d->semi_major, 0, DBL_MAX);
    if (status == CW_OK && d->inverse_flattening != 0)
        status = cw_check_number("inverse_flattening", d->inverse_flattening, 1, DBL_MAX);
    if (status == CW_OK && d->scale && d->geographic)
        status = cw_fail(CW_ERROR_ARGUMENT, "scale: given for a map in degrees");
    for (size_t k = 0; status == CW_OK && d->scale && k < 2 * CW_SCALE_ROWS * CW_SCALE_COLUMNS; k++)
        status = cw_check_number("scale", d->scale[k], DBL_MIN, DBL_MAX);
    return status;
}

cw_status cw_terrain_create(const cw_terrain_desc *desc, const cw_run *run, cw_terrain **out) {
    FPENV_HERE;
    if (out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "terrain: NULL");
    *out = NULL;
    if (desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "desc: NULL");
    double map[3][4];
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status == CW_OK) status = check(desc, map);
    if (status != CW_OK) return status;
    whole_terrain *t = calloc(1, sizeof *t);
    if (t == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    const samples s = samples_of(desc->field);
    cw_terrain_desc kept = *desc;
    t->terrain = (terrain){.nx = s.nx, .ny = s.ny, .stride = s.stride, .z = s.z, .own = &t->own};
    if (desc->scale) {
        memcpy(&t->own.scale, desc->scale, sizeof t->own.scale);
        kept.scale = &t->own.scale.metres[0][0][0];
    }
    if (cw_terrain_place(&t->terrain, (const double(*)[4])map, &kept)) {
        *out = &t->terrain;
        return CW_OK;
    }
    free(t);
    return cw_fail(CW_ERROR_ARGUMENT, "field: its map cannot be inverted, or has latitudes beyond 90 degrees");
}

void cw_terrain_destroy(cw_terrain *t) {
    if (t == NULL) return;
    cw_sight_bounds_destroy(atomic_load(&t->own->bounds));
    free(t);
}
