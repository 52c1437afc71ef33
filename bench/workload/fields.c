/* SPDX-License-Identifier: Apache-2.0 */
#include "workload/fields.h"
#include "cellwalk_expert.h"

#include "workload/random.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef enum shape {
    LAND,
    SEA,
    NOISE,
    INTEGERS,
    CLIFFS,
    SLOPE,
    SWELL,
    FLAT,
    GENTLE,
    FAINT,
    PLANE,
    GROOVES,
    COMB,
    CHECKS
} shape;

/* amount: the relief of land, the roughness of water. */
static const struct {
    const char *name, *text;
    size_t nx, ny;
    shape shape;
    float amount;
    uint32_t seed;
} fields[] = {
    {"65", NULL, 65, 65, LAND, 0.1f, 1},
    {"257", NULL, 257, 257, LAND, 0.1f, 1},
    {"1025", NULL, 1025, 1025, LAND, 0.1f, 1},
    {"4097", NULL, 4097, 4097, LAND, 0.1f, 1},
    {"8193", NULL, 8193, 8193, LAND, 0.1f, 1},
    {"sea-calm", NULL, 1000, 1000, SEA, 0.02f, 2},
    {"sea-rough", NULL, 1000, 1000, SEA, 0.5f, 2},
    {"8193x1025", NULL, 8193, 1025, LAND, 0.1f, 1},
    {"plane", NULL, 1025, 1025, PLANE, 0, 0},
    {"grooves", NULL, 1025, 1025, GROOVES, 0, 0},
    {"comb", NULL, 1025, 1025, COMB, 0, 0},
    {"checkerboard", NULL, 1025, 1025, CHECKS, 0, 0},
    {"fractal", "fractal land, 513 x 513, relief a tenth of the side", 513, 513, LAND, 0.1f, 5},
    {"noise", "uniform in [0, 1), 65 x 65", 65, 65, NOISE, 0, 1},
    {"integers", "whole numbers from -2 to 2, 64 x 33", 64, 33, INTEGERS, 0, 2},
    {"cliffs", "0 beside 10^6, 48 x 48", 48, 48, CLIFFS, 0, 0},
    {"slope", "one plane, exactly, 129 x 129", 129, 129, SLOPE, 0, 0},
    {"swell", "a slope of 0.3 with ripples of 10^-4, 257 x 257", 257, 257, SWELL, 0, 5},
    {"flat", "one height, 33 x 33", 33, 33, FLAT, 0, 0},
    {"sea", "waves, 200 x 200", 200, 200, SEA, 0.2f, 5},
    {"gentle", "a plane of slopes 5·10^-5 and 3·10^-5, 257 x 257", 257, 257, GENTLE, 0, 0},
    {"faint", "uniform in [0, 1) times 2^-136, 65 x 65", 65, 65, FAINT, 0, 6},
};
enum { ALL = sizeof fields / sizeof fields[0] };

const char *workload_field_name(size_t number) { return number < WORKLOAD_FIELDS ? fields[number].name : NULL; }
const char *workload_aimed_name(size_t number) {
    return WORKLOAD_FIELDS + number < ALL ? fields[WORKLOAD_FIELDS + number].name : NULL;
}

static double sample(shape kind, size_t i, size_t j, random_state *r) {
    const double x = random_unit(r);
    switch (kind) {
    case NOISE:
        return x;
    case INTEGERS:
        return floor(5 * x) - 2;
    case CLIFFS:
        return (i + j) / 2 % 2 ? 1e6 : 0;
    case SLOPE:
        return 3 * (double)i - 2 * (double)j;
    case SWELL:
        return 0.3 * (double)i + 0.1 * (double)j + 1e-4 * x;
    case GENTLE:
        return 5e-5 * (double)i + 3e-5 * (double)j;
    case FAINT:
        return ldexp(x, -136);
    case PLANE:
        return 0.25 * (double)i + 0.125 * (double)j;
    case GROOVES:
        return j % 2 ? 0 : 1;
    case COMB:
        return j % 8 ? 0 : 1;
    case CHECKS:
        return (i + j) % 2 ? 0 : 1;
    default:
        return 0.375;
    }
}

bool workload_field_make(const char *name, workload_field *field) {
    size_t f = 0;
    *field = (workload_field){0};
    while (f < ALL && strcmp(name, fields[f].name) != 0) f++;
    if (f == ALL) return false;
    const size_t nx = fields[f].nx, ny = fields[f].ny;
    float *z = malloc(nx * ny * sizeof *z);
    random_state r = {fields[f].seed};
    *field = (workload_field){fields[f].name, fields[f].text, nx, ny, z};
    if (z && fields[f].shape == LAND)
        terrain_fractal(z, nx, ny, fields[f].seed, fields[f].amount);
    else if (z && fields[f].shape == SEA)
        terrain_sea(z, nx, ny, fields[f].seed, fields[f].amount);
    else
        for (size_t k = 0; z && k < nx * ny; k++) z[k] = (float)sample(fields[f].shape, k % nx, k / nx, &r);
    return z != NULL;
}

void workload_field_free(workload_field *field) {
    free(field->z);
    *field = (workload_field){0};
}

cw_status workload_field_open(const workload_field *samples, cw_storage storage, bool bare, cw_field **field) {
    cw_field_desc desc = {0};
    desc.samples = samples->z;
    desc.nx = samples->nx;
    desc.ny = samples->ny;
    desc.storage = storage;
    const cw_run nothing = {.expert.kernel = cw_kernel_find("cell")};
    return cw_field_create(&desc, bare ? &nothing : NULL, field);
}
