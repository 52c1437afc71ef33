/* SPDX-License-Identifier: Apache-2.0 */
#include "field.h"

#include "affine.h"
#include "fpenv.h"
#include "kernels.h"
#include "memory.h"
#include "pyramid.h"
#include "run.h"
#include "sister.h"

#include <math.h>
#include <string.h>

static cw_status check_side(const char *name, size_t side) {
    if (side >= 2 && side <= CW_SIDE_MAX) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "%s: %zu samples; a field has 2 to %d a side", name, side, CW_SIDE_MAX);
}

/* Rows stride floats apart, 0 for nx. */
static cw_status check_stride(size_t stride, size_t nx, size_t ny) {
    if (stride == 0) return CW_OK;
    if (stride < nx)
        return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu floats, fewer than a row's %zu samples", stride, nx);
    /* No array is larger than PTRDIFF_MAX bytes. */
    if (ny > 1 && stride > (PTRDIFF_MAX / sizeof(float) - nx) / (ny - 1))
        return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu floats; no array holds %zu such rows", stride, ny);
    return CW_OK;
}

static cw_status check(const cw_field_desc *d) {
    if (d->samples == NULL) return cw_fail(CW_ERROR_ARGUMENT, "samples: NULL");
    cw_status status = cw_check_reserved(d->reserved, 8, d->zero, "cw_field_desc");
    if (status == CW_OK) status = check_side("nx", d->nx);
    if (status == CW_OK) status = check_side("ny", d->ny);
    if (status == CW_OK) status = check_stride(d->stride, d->nx, d->ny);
    if (status != CW_OK) return status;
    if (d->storage != CW_COPY && d->storage != CW_BORROW)
        return cw_fail(CW_ERROR_ARGUMENT, "storage: %d is neither CW_COPY nor CW_BORROW", d->storage);
    status = cw_check_allocator(d->allocator);
    if (status != CW_OK) return status;
    /* Kernels number samples by 31 bits, borrowed ones in place. */
    const size_t row = d->storage == CW_BORROW && d->stride ? d->stride : d->nx;
    if (row > INT32_MAX || row * (d->ny - 1) + d->nx > INT32_MAX)
        return cw_fail(CW_ERROR_ARGUMENT, "samples: %zu rows of %zu; a field has fewer than 2147483648 in all%s", d->ny,
                       row, row > d->nx ? ", with the gaps between borrowed rows" : "");
    return CW_OK;
}

typedef struct maps {
    double to_user[3][4], to_field[3][4];
} maps;

/* All zero: the identity. NaN is not zero. */
static cw_status make_maps(maps *m, const double map[3][4]) {
    static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    bool given = false;
    for (int k = 0; k < 12; k++) given = given || map[k / 4][k % 4] != 0;
    const double(*to_user)[4] = given ? map : identity;
    memcpy(m->to_user, to_user, sizeof m->to_user);
    if (affine_invert(to_user, m->to_field)) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "map: not finite, or it cannot be inverted");
}

static void set_maps(cw_field *f, const maps *m) {
    memcpy(f->to_user, m->to_user, sizeof f->to_user);
    memcpy(f->to_field, m->to_field, sizeof f->to_field);
    memcpy(f->to_normals, m->to_field, sizeof f->to_normals);
    affine_scale(f->to_normals);
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

typedef struct samples {
    cw_field *f;
    const float *from;              /* rows stride apart */
    size_t stride, column, row, nx; /* where they go, and how many in a row */
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

/* Samples that a thread takes at a time, more or less. */
enum { GRAIN = 1 << 16 };

/* ---- making it --------------------------------------------------------------------------------------------------- */

/* Several rows at a time; the watch is called in between. */
static cw_status copy(cw_field *f, const cw_field_desc *desc, const cw_run *how) {
    f->owned = cw_memory_allocate(&f->memory, f->nx * f->ny * sizeof(float));
    if (f->owned == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    f->z = f->owned;
    f->stride = f->nx;
    samples s = {.f = f, .from = desc->samples, .stride = desc->stride ? desc->stride : desc->nx, .nx = f->nx};
    return cw_run_work(how, f->ny, GRAIN / f->nx, GRAIN / f->nx, copy_rows, &s);
}

/* What run's kernel needs beside the bounds. */
static cw_status build_guest(cw_field *f, const cw_run *how) {
    if (how->expert.kernel == NULL || how->expert.kernel->build == NULL || f->guest.structure != NULL) return CW_OK;
    return how->expert.kernel->build(f);
}

static void destroy_guest(cw_field *f) {
    if (f->guest.structure != NULL) f->guest.destroy(&f->memory, f->guest.structure);
    f->guest = (cw_guest){0};
}

static cw_status fill(cw_field *f, const cw_field_desc *desc, const cw_run *whole) {
    const bool borrowed = desc->storage == CW_BORROW;
    run_part part = {whole, 0, borrowed ? 1 : 0.4};
    const cw_run share = cw_run_part_of(&part); /* of which part is at the time */
    cw_status status = CW_OK;
    if (borrowed) {
        f->z = desc->samples;
        f->stride = desc->stride ? desc->stride : desc->nx;
    } else {
        status = copy(f, desc, &share);
        part = (run_part){whole, part.end, 1};
    }
    if (status != CW_OK) return status;
    status = cw_pyramid_build(f, &share);
    return status == CW_OK ? build_guest(f, whole) : status;
}

static cw_status create(const cw_field_desc *desc, const cw_run *how, cw_field **field) {
    maps m;
    cw_status status = check(desc);
    if (status == CW_OK) status = make_maps(&m, desc->map);
    if (status != CW_OK) return status;

    const cw_allocator *memory = desc->allocator ? desc->allocator : &cw_memory_own;
    cw_field *f = cw_process_follow_forks() ? cw_memory_clear(memory, sizeof *f) : NULL;
    if (f == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    f->memory = *memory;
    f->nx = desc->nx;
    f->ny = desc->ny;
    if (!cw_door_make(&f->door)) {
        cw_memory_free(memory, f);
        return cw_fail_plainly(CW_ERROR_MEMORY);
    }
    set_maps(f, &m);
    status = fill(f, desc, how);
    if (status != CW_OK) {
        cw_field_destroy(f);
        return status;
    }
    *field = f;
    return CW_OK;
}

/* Checks how, of which a kernel that does not exist is no request for the default one. */
static cw_status begin(const cw_run *run, cw_run *how) {
    const cw_status status = cw_run_begin(run, how);
    if (status == CW_OK && how->expert.kernel && !cw_kernel_exists(how->expert.kernel))
        return cw_fail(CW_ERROR_KERNEL, "kernel: there is no kernel of that name");
    return status;
}

/* In the environment in which queries will run: to a caller's denormals-are-zero, small samples would all be equal. */
cw_status cw_field_create(const cw_field_desc *desc, const cw_run *run, cw_field **field) {
    if (field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    *field = NULL;
    if (desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "desc: NULL");
    cw_run how;
    FPENV_HERE;
    const cw_status status = begin(run, &how);
    return status == CW_OK ? create(desc, &how, field) : status;
}

bool cw_field_enter(const cw_field *field, door_pass *pass) {
    *pass = door_enter(&field->door);
    return pass->entry != NULL;
}

void cw_field_leave(door_pass pass) { door_leave(pass); }

void cw_field_destroy(cw_field *field) {
    if (field == NULL) return;
    destroy_guest(field);
    cw_pyramid_destroy(field, field->pyramid);
    cw_door_destroy(&field->door);
    const cw_allocator memory = field->memory;
    cw_memory_free(&memory, field->owned);
    cw_memory_free(&memory, field);
}

cw_status cw_field_build(cw_field *field, const cw_run *run) {
    if (field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    FPENV_HERE;
    cw_run how;
    const cw_status status = begin(run, &how);
    return status == CW_OK ? build_guest(field, &how) : status;
}

/* ---- changing it ------------------------------------------------------------------------------------------------- */

static cw_status check_update(const cw_field *f, const cw_update *u) {
    const cw_status status = cw_check_reserved(u->reserved, 7, u->zero, "cw_update");
    if (status != CW_OK) return status;
    if (u->wait > 1) return cw_fail(CW_ERROR_ARGUMENT, "wait: %u is neither 0 nor 1", u->wait);
    if (u->samples != NULL && f->owned == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "samples: given to a field that borrows; change its samples in place");
    if (u->samples == NULL && f->owned != NULL && u->at.nx > 0 && u->at.ny > 0)
        return cw_fail(CW_ERROR_ARGUMENT, "samples: NULL");
    if (f->owned != NULL && (uintptr_t)u->samples - (uintptr_t)f->owned < f->nx * f->ny * sizeof(float))
        return cw_fail(CW_ERROR_ARGUMENT, "samples: the field's own; give a copy of them");
    const cw_status in = cw_check_rectangle(f, &u->at);
    return in == CW_OK ? check_stride(u->stride, u->at.nx, u->at.ny) : in;
}

static cw_status update(cw_field *f, const cw_update *u, cw_pool *pool) {
    const bool borrowed = f->owned == NULL;
    const size_t stride = borrowed ? f->stride : u->stride ? u->stride : u->at.nx;
    samples s = {f, borrowed ? f->z + u->at.j * f->stride + u->at.i : u->samples, stride, u->at.i, u->at.j, u->at.nx};
    for (size_t j = 0; j < u->at.ny; j++) {
        const cw_status status = cw_check_samples(s.from + j * s.stride, u->at.i, u->at.j + j, u->at.nx, !borrowed);
        if (status != CW_OK) return status;
    }
    if (!borrowed) cw_pool_run(pool, u->at.ny, GRAIN / u->at.nx, copy_rows, &s);
    destroy_guest(f);
    cw_pyramid_update(f, &u->at, pool);
    return CW_OK;
}

cw_status cw_field_update(cw_field *field, const cw_run *run, const cw_update *u) {
    if (field == NULL || u == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", field ? "update" : "field");
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status == CW_OK) status = check_update(field, u);
    if (status != CW_OK || u->at.nx == 0 || u->at.ny == 0) return status;
    if (!cw_door_close(&field->door, u->wait)) return cw_fail_plainly(CW_ERROR_BUSY);
    FPENV_HERE;
    status = update(field, u, how.pool);
    cw_door_open(&field->door, u->wait);
    return status;
}

cw_status cw_field_move(cw_field *field, const double map[3][4], uint32_t wait) {
    if (field == NULL || map == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", field ? "map" : "field");
    if (wait > 1) return cw_fail(CW_ERROR_ARGUMENT, "wait: %u is neither 0 nor 1", wait);
    FPENV_HERE;
    maps m;
    const cw_status status = make_maps(&m, map);
    if (status != CW_OK) return status;
    if (!cw_door_close(&field->door, wait)) return cw_fail_plainly(CW_ERROR_BUSY);
    set_maps(field, &m);
    cw_door_open(&field->door, wait);
    return CW_OK;
}

/* ---- looking at it ----------------------------------------------------------------------------------------------- */

void cw_field_describe_into(const cw_field *field, cw_field_info *info, size_t size) {
    cw_field_info all = {
        .nx = field->nx,
        .ny = field->ny,
        .low = field->low,
        .high = field->high,
        .holes = field->holes,
        .bytes_samples = field->owned ? field->nx * field->ny * sizeof(float) : 0,
        .bytes_built = sizeof *field->pyramid + field->pyramid->bytes + field->guest.bytes,
    };
    memcpy(all.map, field->to_user, sizeof all.map);
    cw_fill(info, size, &all, sizeof all);
}

const float *cw_field_row(const cw_field *field, size_t j) {
    return j < field->ny ? field->z + j * field->stride : NULL;
}
