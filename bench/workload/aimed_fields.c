/* SPDX-License-Identifier: Apache-2.0 */
/* Fields for aimed rays: from smooth land to whole numbers and cliffs. */

#include "workload/aimed.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdlib.h>

typedef enum shape { FRACTAL, NOISE, INTEGERS, CLIFFS, SLOPE, SWELL, FLAT, SEA } shape;

static const struct {
    const char *name, *text;
    size_t nx, ny;
} fields[AIMED_FIELDS] = {
    [FRACTAL] = {"fractal", "fractal land, 513 x 513, relief a tenth of the side", 513, 513},
    [NOISE] = {"noise", "uniform in [0, 1), 65 x 65", 65, 65},
    [INTEGERS] = {"integers", "whole numbers from -2 to 2, 64 x 33", 64, 33},
    [CLIFFS] = {"cliffs", "0 beside 10^6, 48 x 48", 48, 48},
    [SLOPE] = {"slope", "one plane, exactly, 129 x 129", 129, 129},
    [SWELL] = {"swell", "a slope of 0.3 with ripples of 10^-4, 257 x 257", 257, 257},
    [FLAT] = {"flat", "one height, 33 x 33", 33, 33},
    [SEA] = {"sea", "waves, 200 x 200", 200, 200},
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
    default:
        return 0.375;
    }
}

bool aimed_field_make(aimed_field *f, size_t number) {
    const shape kind = (shape)number;
    random_state r = {number};
    workload_field s = {.name = fields[number].name, .nx = fields[number].nx, .ny = fields[number].ny};
    s.z = malloc(s.nx * s.ny * sizeof *s.z);
    if (s.z == NULL) return false;
    if (kind == FRACTAL)
        terrain_fractal(s.z, s.nx, s.ny, 5, 0.1f);
    else if (kind == SEA)
        terrain_sea(s.z, s.nx, s.ny, 5, 0.2f);
    else
        for (size_t k = 0; k < s.nx * s.ny; k++) s.z[k] = (float)sample(kind, k % s.nx, k / s.nx, &r);
    *f = aimed_field_of(&s);
    f->text = fields[number].text;
    return true;
}

aimed_field aimed_field_of(const workload_field *samples) {
    aimed_field f = {.samples = *samples, .low = (double)INFINITY, .high = -(double)INFINITY};
    for (size_t k = 0; k < f.samples.nx * f.samples.ny; k++) {
        f.low = fmin(f.low, (double)f.samples.z[k]);
        f.high = fmax(f.high, (double)f.samples.z[k]);
    }
    return f;
}
