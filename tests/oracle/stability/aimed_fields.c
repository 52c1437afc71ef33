/* SPDX-License-Identifier: Apache-2.0 */
#include "stability/run.h"
#include "workload/fractal_terrain.h"

#include <math.h>
#include <stdlib.h>

typedef enum shape { LAND, SEA, NOISE, INTEGERS, CLIFFS, SLOPE, SWELL, FLAT, GENTLE, FAINT } shape;

/* amount: the relief of land, the roughness of water. */
static const struct {
    const char *name, *text;
    size_t nx, ny;
    shape shape;
    float amount;
    uint32_t seed;
} fields[AIMED_FIELDS] = {
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
    default:
        return 0.375;
    }
}

bool aimed_field_make(size_t number, workload_field *field) {
    const size_t nx = fields[number].nx, ny = fields[number].ny;
    const shape kind = fields[number].shape;
    float *z = malloc(nx * ny * sizeof *z);
    random_state r = {fields[number].seed};
    *field = (workload_field){fields[number].name, fields[number].text, nx, ny, z};
    if (z && kind == LAND)
        terrain_fractal(z, nx, ny, fields[number].seed, fields[number].amount);
    else if (z && kind == SEA)
        terrain_sea(z, nx, ny, fields[number].seed, fields[number].amount);
    else
        for (size_t k = 0; z && k < nx * ny; k++) z[k] = (float)sample(kind, k % nx, k / nx, &r);
    return z != NULL;
}
