/* SPDX-License-Identifier: Apache-2.0 */
#include "field.h"

#include "affine.h"
#include "clock.h"
#include "fpenv.h"
#include "kernels.h"
#include "memory.h"
#include "to_field.h"
#include "watch.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

cw_field_desc cw_field_desc_default(void) {
    return (cw_field_desc){.storage = CW_COPY, .map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

static cw_status check(const cw_field_desc *d) {
    if (d->samples == NULL) return CW_ERROR_ARGUMENT;
    if (!cw_all_zero(d->reserved)) return CW_ERROR_OPTION;
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

/* Bounds and holes; in a copy an infinite sample becomes NaN, so that kernels meet one kind of hole. */
static cw_status survey(cw_field *f) {
    f->low = FLT_MAX;
    f->high = -FLT_MAX;
    for (size_t j = 0; j < f->ny; j++) {
        for (size_t i = 0; i < f->nx; i++) {
            const float h = f->z[j * f->stride + i];
            if (isfinite(h)) {
                if (fabsf(h) > CW_HEIGHT_MAX) return CW_ERROR_HEIGHT;
                f->low = h < f->low ? h : f->low;
                f->high = h > f->high ? h : f->high;
                continue;
            }
            f->holes++;
            if (isnan(h)) continue;
            if (!f->owned) return CW_ERROR_HOLE;
            f->owned[j * f->stride + i] = NAN;
        }
    }
    return CW_OK;
}

/* From farther away than this, a ray's origin would add more to errors than the field itself does: half a side's length
 * outside the field; and eight times its range of heights above or below, as rays from a camera above should count as near. */
static void set_reach(cw_field *f) {
    const float range = f->high - f->low;
    f->middle[0] = 0.5f * (float)(f->nx - 1);
    f->middle[1] = 0.5f * (float)(f->ny - 1);
    f->middle[2] = range >= 0 ? 0.5f * (f->low + f->high) : 0;
    f->reach[0] = (float)(f->nx - 1);
    f->reach[1] = (float)(f->ny - 1);
    f->reach[2] = range > 0 ? 8 * range : INFINITY; /* on a level field, or none, heights cost no accuracy */
}

static cw_status build(cw_field *f, unsigned needs) {
    const double start = clock_seconds();
    cw_status status = CW_OK;
    if ((needs & CW_NEEDS_GRID3D) && !f->grid3d) status = cw_grid3d_build(f);
    if ((needs & CW_NEEDS_PYRAMID) && !f->pyramid) status = cw_pyramid_build(f);
    f->build_seconds += clock_seconds() - start;
    return status;
}

/* Up to this many cells a side the flat walk is at the end before the pyramid's has begun: packet8 is 1.1 to 1.5 times as
 * fast as pyramid8x2 on shadow, ao and bounce rays of 3² to 33² samples, and 0.8 times on random and grazing ones of 33²;
 * on 65² the pyramid is ahead in all but shadow rays. */
enum { TINY_SIDE = 32 };

static cw_status create(const cw_field_desc *desc, cw_field **field) {
    cw_status status = check(desc);
    if (status != CW_OK) return status;

    cw_field *f = calloc(1, sizeof *f);
    if (f == NULL) return CW_ERROR_MEMORY;
    f->nx = desc->nx;
    f->ny = desc->ny;
    memcpy(f->to_user, desc->map, sizeof f->to_user);
    if (!affine_invert(desc->map, f->to_field)) {
        cw_field_destroy(f);
        return CW_ERROR_MAP;
    }
    memcpy(f->to_normals, f->to_field, sizeof f->to_normals);
    affine_scale(f->to_normals);
    const size_t stride = desc->stride ? desc->stride : desc->nx;
    if (desc->storage == CW_BORROW) {
        f->z = desc->samples;
        f->stride = stride;
    } else {
        f->z = f->owned = cw_memory_allocate(f->nx * f->ny * sizeof(float));
        f->stride = f->nx;
        if (f->owned == NULL) {
            cw_field_destroy(f);
            return CW_ERROR_MEMORY;
        }
        for (size_t j = 0; j < f->ny; j++)
            memcpy(f->owned + j * f->nx, desc->samples + j * stride, f->nx * sizeof(float));
    }
    status = survey(f);
    set_reach(f);
    const bool tiny = f->nx <= TINY_SIDE + 1 && f->ny <= TINY_SIDE + 1;
    if (status == CW_OK && !desc->bare && !tiny) status = build(f, CW_NEEDS_PYRAMID);
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
    cw_memory_free(field->owned);
    free(field);
}

cw_status cw_field_build(cw_field *field, const cw_kernel *kernel) {
    if (field == NULL || kernel == NULL) return CW_ERROR_ARGUMENT;
    if (!cw_kernel_exists(kernel)) return CW_ERROR_KERNEL;
    const fpenv caller = fpenv_enter();
    const cw_status status = build(field, kernel->needs);
    fpenv_leave(caller);
    return status;
}

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
