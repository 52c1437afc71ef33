/* SPDX-License-Identifier: Apache-2.0 */
#include "field.h"

#include "affine.h"
#include "clock.h"
#include "fpenv.h"
#include "kernels.h"
#include "memory.h"
#include "pyramid.h"
#include "survey.h"
#include "to_field.h"
#include "watch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

cw_field_desc cw_field_desc_default(void) {
    return (cw_field_desc){.storage = CW_COPY, .map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

static cw_status check(const cw_field_desc *d) {
    if (d->samples == NULL) return CW_ERROR_ARGUMENT;
    if (d->reserved[0] != 0) return CW_ERROR_OPTION;
    if (d->storage != CW_COPY && d->storage != CW_BORROW) return CW_ERROR_OPTION;
    if (d->nx < 2 || d->ny < 2 || d->nx > CW_SIDE_MAX || d->ny > CW_SIDE_MAX) return CW_ERROR_SIZE;
    if (d->nx * d->ny > INT32_MAX) return CW_ERROR_SIZE; /* no overflow: each factor is below 2^24 */
    if (d->stride == 0) return CW_OK;
    if (d->stride < d->nx || d->stride > (SIZE_MAX / sizeof(float) - d->nx) / (d->ny - 1)) return CW_ERROR_STRIDE;
    /* Kernels number borrowed samples in place by 31 bits. */
    if (d->storage == CW_BORROW && d->stride * (d->ny - 1) + d->nx > INT32_MAX) return CW_ERROR_SIZE;
    return CW_OK;
}

/* The same with the map that it stands for: one filled in by hand may leave it at zero. */
static cw_field_desc with_map(const cw_field_desc *desc) {
    cw_field_desc d = *desc;
    bool given = false;
    for (int k = 0; k < 12; k++) given = given || d.map[k / 4][k % 4] != 0; /* NaN is given */
    for (int k = 0; k < 3 && !given; k++) d.map[k][k] = 1;
    return d;
}

/* ---- samples --------------------------------------------------------------------------------------------------------- */

typedef struct samples {
    cw_field *f;
    const float *from;              /* rows stride apart */
    size_t stride, column, row, nx; /* where they go, and how many in a row */
    cw_refusal refusal;
} samples;

/* In a copy an infinite sample becomes NaN, so that kernels meet one kind of hole. */
static void copy_rows(void *context, size_t begin, size_t end) {
    const samples *s = context;
    for (size_t j = begin; j < end; j++) {
        const float *restrict from = s->from + j * s->stride;
        float *restrict to = s->f->owned + (s->row + j) * s->f->stride + s->column;
        for (size_t i = 0; i < s->nx; i++) to[i] = fabsf(from[i]) == INFINITY ? NAN : from[i];
    }
}

static void look_at_tiles(void *context, size_t begin, size_t end) {
    samples *s = context;
    const size_t across = cw_tiles_across(s->f);
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++) cw_survey_tile(s->f, k % across, k / across, &s->refusal);
    fpenv_leave(caller);
}

static cw_tiles all_tiles(const cw_field *f) { return (cw_tiles){0, 0, cw_tiles_across(f) - 1, cw_tiles_down(f) - 1}; }

/* Samples that a thread takes at a time, more or less. */
enum { GRAIN = 1 << 16 };

static cw_status survey(cw_field *f, const cw_query *how) {
    samples s = {.f = f, .refusal = {CW_REFUSED_NONE}};
    const size_t n = cw_tiles_across(f) * cw_tiles_down(f), grain = GRAIN / (TILE_SIDE * TILE_SIDE);
    cw_status status = cw_watch_run(how, n, grain, grain, look_at_tiles, &s);
    if (status == CW_OK) status = cw_refusal_status(&s.refusal);
    if (status == CW_OK) cw_survey_total(f, all_tiles(f));
    return status;
}

/* ---- making it ------------------------------------------------------------------------------------------------------- */

static cw_status build(cw_field *f, unsigned needs, const cw_query *how, bool surveyed) {
    const double start = clock_seconds();
    cw_status status = CW_OK;
    if ((needs & CW_NEEDS_GRID3D) && !f->grid3d) status = cw_grid3d_build(f);
    if ((needs & CW_NEEDS_PYRAMID) && !f->pyramid) status = cw_pyramid_build(f, how, !surveyed);
    f->build_seconds += clock_seconds() - start;
    return status;
}

/* Up to this many cells a side the flat walk is at the end before the pyramid's has begun: packet8 is 1.1 to 1.5 times as
 * fast as pyramid8x2 on shadow, ao and bounce rays of 3² to 33² samples, and 0.8 times on random and grazing ones of 33²;
 * on 65² the pyramid is ahead in all but shadow rays. */
enum { TINY_SIDE = 32 };

/* Several rows at a time; the watch is asked in between. */
static cw_status copy(cw_field *f, const cw_field_desc *desc, const cw_query *how) {
    f->owned = cw_memory_allocate(f->nx * f->ny * sizeof(float));
    if (f->owned == NULL) return CW_ERROR_MEMORY;
    f->z = f->owned;
    f->stride = f->nx;
    samples s = {.f = f, .from = desc->samples, .stride = desc->stride ? desc->stride : desc->nx, .nx = f->nx};
    return cw_watch_run(how, f->ny, GRAIN / f->nx, GRAIN / f->nx, copy_rows, &s);
}

static cw_status fill(cw_field *f, const cw_field_desc *desc) {
    const bool borrowed = desc->storage == CW_BORROW, tiny = f->nx <= TINY_SIDE + 1 && f->ny <= TINY_SIDE + 1;
    const cw_query whole = {.pool = desc->pool, .watch = desc->watch, .watch_context = desc->watch_context};
    watch_part part = {&whole, 0, borrowed ? 1 : 0.4};
    const cw_query first = cw_watch_part_of(&part);
    cw_status status = cw_survey_create(f) ? CW_OK : CW_ERROR_MEMORY;
    if (borrowed) {
        f->z = desc->samples;
        f->stride = desc->stride ? desc->stride : desc->nx;
    } else if (status == CW_OK) {
        status = copy(f, desc, &first);
        part = (watch_part){&whole, part.end, 1};
    }
    if (status != CW_OK) return status;
    return desc->bare || tiny ? survey(f, &first) : build(f, CW_NEEDS_PYRAMID, &first, false);
}

static cw_status create(const cw_field_desc *desc, cw_field **field) {
    cw_status status = check(desc);
    if (status != CW_OK) return status;

    cw_field *f = cw_memory_allocate(sizeof *f);
    if (f == NULL) return CW_ERROR_MEMORY;
    memset(f, 0, sizeof *f);
    f->nx = desc->nx;
    f->ny = desc->ny;
    memcpy(f->to_user, desc->map, sizeof f->to_user);
    status = affine_invert(desc->map, f->to_field) ? CW_OK : CW_ERROR_MAP;
    if (status == CW_OK) {
        memcpy(f->to_normals, f->to_field, sizeof f->to_normals);
        affine_scale(f->to_normals);
        status = fill(f, desc);
    }
    if (status != CW_OK) {
        cw_field_destroy(f);
        return status;
    }
    *field = f;
    return CW_OK;
}

/* In the environment in which queries will run: to a caller's denormals-are-zero, small samples would all be equal. */
cw_status cw_field_create(const cw_field_desc *desc, cw_field **field) {
    if (field == NULL) return CW_ERROR_ARGUMENT;
    *field = NULL;
    if (desc == NULL) return CW_ERROR_ARGUMENT;
    const fpenv caller = fpenv_enter();
    const cw_field_desc whole = with_map(desc);
    const cw_status status = create(&whole, field);
    fpenv_leave(caller);
    return status;
}

void cw_field_destroy(cw_field *field) {
    if (field == NULL) return;
    cw_grid3d_destroy(field->grid3d);
    cw_pyramid_destroy(field->pyramid);
    cw_survey_destroy(field);
    cw_memory_free(field->owned);
    cw_memory_free(field);
}

cw_status cw_field_build(cw_field *field, const cw_kernel *kernel) {
    return kernel == NULL ? CW_ERROR_ARGUMENT : cw_field_build_for(field, &(cw_query){.kernel = kernel});
}

cw_status cw_field_build_for(cw_field *field, const cw_query *query) {
    if (field == NULL) return CW_ERROR_ARGUMENT;
    const cw_query how = query ? *query : cw_query_default();
    const cw_kernel *kernel = cw_query_kernel(field, &how);
    if (!cw_kernel_exists(kernel)) return CW_ERROR_KERNEL;
    if (!cw_all_zero(how.reserved)) return CW_ERROR_OPTION;
    const fpenv caller = fpenv_enter();
    const cw_status status = build(field, kernel->needs, &how, true);
    fpenv_leave(caller);
    return status;
}

/* ---- changing it ----------------------------------------------------------------------------------------------------- */

static cw_status check_update(const cw_field *f, const cw_update *u) {
    if (!cw_all_zero(u->reserved)) return CW_ERROR_OPTION;
    if ((u->samples == NULL) != (f->owned == NULL)) return CW_ERROR_ARGUMENT;
    if (u->i > f->nx || u->nx > f->nx - u->i || u->j > f->ny || u->ny > f->ny - u->j) return CW_ERROR_RECTANGLE;
    if (u->stride != 0 && u->stride < u->nx) return CW_ERROR_STRIDE;
    return CW_OK;
}

/* Tiles that have some of the rectangle's samples, be it on the border. */
static cw_tiles tiles_of(const cw_field *f, const cw_update *u) {
    const cw_tiles all = all_tiles(f);
    const size_t x = (u->i + u->nx - 1) / TILE_SIDE, y = (u->j + u->ny - 1) / TILE_SIDE;
    return (cw_tiles){(u->i > 0 ? u->i - 1 : 0) / TILE_SIDE, (u->j > 0 ? u->j - 1 : 0) / TILE_SIDE,
                      x < all.x_last ? x : all.x_last, y < all.y_last ? y : all.y_last};
}

/* It serves for comparisons, and is made anew at the price of being made. */
static void drop_grid3d(cw_field *f) {
    if (f->grid3d == NULL) return;
    cw_grid3d_destroy(f->grid3d);
    f->grid3d = NULL;
    f->bytes_built = f->pyramid ? sizeof *f->pyramid + f->pyramid->bytes : 0;
}

static cw_status update(cw_field *f, const cw_update *u) {
    const bool borrowed = f->owned == NULL;
    samples s = {.f = f, .column = u->i, .row = u->j, .nx = u->nx};
    s.from = borrowed ? f->z + u->j * f->stride + u->i : u->samples;
    s.stride = borrowed ? f->stride : u->stride ? u->stride : u->nx;
    for (size_t j = 0; j < u->ny; j++) {
        const cw_status status = cw_survey_check(s.from + j * s.stride, u->nx, !borrowed);
        if (status != CW_OK) return status;
    }
    if (!borrowed) cw_pool_run(u->pool, u->ny, GRAIN / u->nx, copy_rows, &s);
    const cw_tiles changed = tiles_of(f, u);
    drop_grid3d(f);
    if (f->pyramid) {
        cw_pyramid_update(f, changed, u->pool);
        return CW_OK;
    }
    for (size_t y = changed.y; y <= changed.y_last; y++)
        for (size_t x = changed.x; x <= changed.x_last; x++) cw_survey_tile(f, x, y, &s.refusal);
    cw_survey_total(f, changed);
    return CW_OK;
}

cw_status cw_field_update(cw_field *field, const cw_update *u) {
    if (field == NULL || u == NULL) return CW_ERROR_ARGUMENT;
    cw_status status = check_update(field, u);
    if (status != CW_OK || u->nx == 0 || u->ny == 0) return status;
    if (!door_close(&field->door)) return CW_ERROR_BUSY;
    const fpenv caller = fpenv_enter();
    status = update(field, u);
    fpenv_leave(caller);
    door_open(&field->door);
    return status;
}

/* ---- looking at it --------------------------------------------------------------------------------------------------- */

cw_field_info cw_field_describe(const cw_field *field) {
    return (cw_field_info){
        .nx = field->nx,
        .ny = field->ny,
        .low = field->low,
        .high = field->high,
        .holes = field->holes,
        .bytes_samples = field->owned ? field->nx * field->ny * sizeof(float) : 0,
        .bytes_built = field->bytes_built,
        .build_seconds = field->build_seconds,
    };
}

float cw_field_sample(const cw_field *field, size_t i, size_t j) {
    return i < field->nx && j < field->ny ? field->z[j * field->stride + i] : NAN;
}

static void to_field(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out) {
    for (size_t k = 0; k < n; k++) {
        double org[3], dir[3];
        affine_point_back(m, in[k].org, org);
        affine_vector(m, in[k].dir, dir);
        out[k] = (cw_ray){
            .org = {(float)org[0], (float)org[1], (float)org[2]},
            .tmin = (float)in[k].tmin,
            .dir = {(float)dir[0], (float)dir[1], (float)dir[2]},
            .tmax = (float)in[k].tmax,
        };
    }
}

void cw_rays_to_field(const cw_field *field, const cw_user_ray *in, size_t n, cw_ray *out) {
    const fpenv caller = fpenv_enter();
#if CELLWALK_SIMD
    if (cw_isa_best() >= CW_ISA_AVX2)
        cw_to_field_avx2(field->to_field, in, n, out);
    else
#endif
        to_field(field->to_field, in, n, out);
    fpenv_leave(caller);
}
