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
    switch (shape) {
    case FIELD_FLAT:
        return 0.375;
    case FIELD_PLANE:
        return 3 * (double)i - 2 * (double)j;
    case FIELD_CLIFF:
        return (i + j) / 2 % 2 ? 1e6 : 0;
    case FIELD_SPIKES:
        return x < 0.1 ? 1000 * y : 0;
    case FIELD_CHECKER:
        return (double)((i + j) % 2);
    case FIELD_INTEGERS:
        return floor(5 * x) - 2;
    case FIELD_TINY:
        return 1e-30 * x;
    case FIELD_HUGE:
        return 1e30 * x;
    case FIELD_GENTLE:
        return 5e-5 * (double)i + 3e-5 * (double)j + 1e-7 * x;
    case FIELD_FAINT:
        return ldexp(x, -136);
    case FIELD_LEAST:
        return ldexp(floor(5 * x), -149);
    case FIELD_MIXED:
        return (y < 0.5 ? -1 : 1) * pow(10, 60 * x - 30);
    case FIELD_HOLES:
        return y < 1.0 / 7 ? (double)NAN : x;
    case FIELD_RANDOM:
    default:
        return x;
    }
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
    cw_field_desc desc = {.samples = f->z, .nx = f->nx, .ny = f->ny, .storage = CW_BORROW};
    cw_field *field;
    for (size_t k = 0; k < f->nx * f->ny; k++)
        if (isinf(f->z[k])) desc.storage = CW_COPY;
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
