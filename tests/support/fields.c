/* SPDX-License-Identifier: Apache-2.0 */
#include "fields.h"

#include "cellwalk_expert.h"
#include "check.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

const field_size field_sizes[FIELD_SIZES] = {{2, 2}, {2, 41}, {41, 2}, {17, 17}, {65, 65}, {31, 12}};

static double sample(field_shape shape, size_t i, size_t j, random_state *r) {
    const double x = random_unit(r), y = random_unit(r);
    const double of[FIELD_ALL_SHAPES] = {
        [FIELD_RANDOM] = x,
        [FIELD_FLAT] = 0.375,
        [FIELD_PLANE] = 3 * (double)i - 2 * (double)j,
        [FIELD_CLIFF] = (i + j) / 2 % 2 ? 1e6 : 0,
        [FIELD_SPIKES] = x < 0.1 ? 1000 * y : 0,
        [FIELD_CHECKER] = (double)((i + j) % 2),
        [FIELD_INTEGERS] = floor(5 * x) - 2,
        [FIELD_TINY] = 1e-30 * x,
        [FIELD_HUGE] = 1e30 * x,
        [FIELD_GENTLE] = 5e-5 * (double)i + 3e-5 * (double)j + 1e-7 * x,
        [FIELD_FAINT] = ldexp(x, -136),
        [FIELD_LEAST] = ldexp(floor(5 * x), -149),
        [FIELD_MIXED] = (y < 0.5 ? -1 : 1) * pow(10, 60 * x - 30),
        [FIELD_HOLES] = y < 1.0 / 7 ? (double)NAN : x,
    };
    return of[shape];
}

void field_make(test_field *f, field_shape shape, size_t nx, size_t ny, uint64_t seed) {
    random_state r = {seed};
    check(nx * ny <= FIELD_SAMPLES_MAX, "field of %zu x %zu samples is too large", nx, ny);
    f->shape = shape;
    f->nx = nx;
    f->ny = ny;
    f->low = FLT_MAX;
    f->high = -FLT_MAX;
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) {
            const float z = (float)sample(shape, i, j, &r);
            f->z[j * nx + i] = z;
            if (z < f->low) f->low = z;
            if (z > f->high) f->high = z;
        }
    if (f->low > f->high) f->low = f->high = 0; /* holes only */
}

void field_make_land(test_field *f, size_t nx, size_t ny) {
    field_make(f, FIELD_RANDOM, nx, ny, 3);
    for (size_t k = 0; k < nx * ny; k++) {
        const double x = (double)(k % nx), y = (double)(k / nx);
        f->z[k] = (float)(1000 + 40 * sin(x / 37) * cos(y / 29) + 9 * sin((x + 2 * y) / 11) + (double)f->z[k]);
    }
}

cw_field *field_open(const test_field *f) {
    const cw_field_desc desc = {.samples = f->z, .nx = f->nx, .ny = f->ny, .storage = CW_BORROW};
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    for (size_t k = 0; k < cw_kernel_count(); k++)
        check_status(cw_field_build(field, &(cw_run){.expert.kernel = cw_kernel_at(k)}), CW_OK);
    return field;
}

void field_print(const test_field *f) {
    static const char *const names[FIELD_ALL_SHAPES] = {"random",  "flat",     "plane", "cliff", "spikes",
                                                        "checker", "integers", "tiny",  "huge",  "gentle",
                                                        "mixed",   "holes",    "faint", "least"};
    printf("field %s, %zu x %zu\n", names[f->shape], f->nx, f->ny);
    if (f->nx * f->ny > 64) return;
    for (size_t j = 0; j < f->ny; j++) {
        for (size_t i = 0; i < f->nx; i++) printf(" %a", (double)f->z[j * f->nx + i]);
        printf("\n");
    }
}
