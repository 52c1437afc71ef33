/* SPDX-License-Identifier: Apache-2.0 */
#include "workload/fields.h"
#include "cellwalk_expert.h"

#include "workload/fractal_terrain.h"

#include <stdlib.h>
#include <string.h>

typedef enum shape { LAND, SEA, PLANE, GROOVES, COMB, CHECKS } shape;

/* amount: the relief of land, the roughness of water. */
static const struct {
    const char *name;
    size_t nx, ny;
    shape shape;
    float amount;
    uint32_t seed;
} fields[] = {
    {"65", 65, 65, LAND, 0.1f, 1},           {"257", 257, 257, LAND, 0.1f, 1},
    {"1025", 1025, 1025, LAND, 0.1f, 1},     {"4097", 4097, 4097, LAND, 0.1f, 1},
    {"8193", 8193, 8193, LAND, 0.1f, 1},     {"sea-calm", 1000, 1000, SEA, 0.02f, 2},
    {"sea-rough", 1000, 1000, SEA, 0.5f, 2}, {"8193x1025", 8193, 1025, LAND, 0.1f, 1},
    {"plane", 1025, 1025, PLANE, 0, 0},      {"grooves", 1025, 1025, GROOVES, 0, 0},
    {"comb", 1025, 1025, COMB, 0, 0},        {"checkerboard", 1025, 1025, CHECKS, 0, 0},
};
enum { ALL = sizeof fields / sizeof fields[0] };

static double sample(shape kind, size_t i, size_t j) {
    switch (kind) {
    case PLANE:
        return 0.25 * (double)i + 0.125 * (double)j;
    case GROOVES:
        return j % 2 ? 0 : 1;
    case COMB:
        return j % 8 ? 0 : 1;
    default:
        return (i + j) % 2 ? 0 : 1;
    }
}

bool workload_field_make(const char *name, workload_field *field) {
    size_t f = 0;
    *field = (workload_field){0};
    while (f < ALL && strcmp(name, fields[f].name) != 0) f++;
    if (f == ALL) return false;
    const size_t nx = fields[f].nx, ny = fields[f].ny;
    float *z = malloc(nx * ny * sizeof *z);
    *field = (workload_field){fields[f].name, NULL, nx, ny, z};
    if (z && fields[f].shape == LAND)
        terrain_fractal(z, nx, ny, fields[f].seed, fields[f].amount);
    else if (z && fields[f].shape == SEA)
        terrain_sea(z, nx, ny, fields[f].seed, fields[f].amount);
    else
        for (size_t k = 0; z && k < nx * ny; k++) z[k] = (float)sample(fields[f].shape, k % nx, k / nx);
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
