/* SPDX-License-Identifier: Apache-2.0 */
#include "workload/fields.h"

#include "large.h"
#include "workload/fractal_terrain.h"

#include <stdlib.h>
#include <string.h>

static double plane(size_t i, size_t j) { return 0.25 * (double)i + 0.125 * (double)j; }
static double grooves(size_t i, size_t j) { return (void)i, j % 2 ? 0 : 1; }
static double comb(size_t i, size_t j) { return (void)i, j % 8 ? 0 : 1; }
static double checks(size_t i, size_t j) { return (i + j) % 2 ? 0 : 1; }

/* Of water roughness, of other fields the height of a sample. */
static const struct {
    const char *name;
    size_t side;
    float roughness;
    double (*sample)(size_t i, size_t j);
} fields[] = {
    {"sea-calm", 1000, 0.02f, NULL}, {"sea-rough", 1000, 0.5f, NULL}, {"plane", 1025, 0, plane},
    {"grooves", 1025, 0, grooves},   {"comb", 1025, 0, comb},         {"checkerboard", 1025, 0, checks},
};
enum { ALL = sizeof fields / sizeof fields[0] };

/* The side of fractal land of that name; 0: it is none. */
static size_t land_side(const char *name) {
    char *end;
    const size_t side = strtoul(name, &end, 10);
    return *end == '\0' && side >= 2 && side <= 65537 ? side : 0;
}

/* ALL: none of that name. */
static size_t find(const char *name) {
    size_t f = 0;
    while (f < ALL && strcmp(name, fields[f].name) != 0) f++;
    return f;
}

bool workload_field_exists(const char *name) { return land_side(name) > 0 || find(name) < ALL; }

bool workload_field_make(const char *name, workload_field *field) {
    const size_t land = land_side(name), f = find(name);
    *field = (workload_field){0};
    if (!workload_field_exists(name)) return false;
    const size_t side = land ? land : fields[f].side, count = side * side;
    float *z = large_allocate(count * sizeof *z);
    *field = (workload_field){name, side, side, z};
    if (z && land)
        terrain_fractal(z, side, side, 1, 0.1f);
    else if (z && fields[f].sample == NULL)
        terrain_sea(z, side, side, 2, fields[f].roughness);
    else
        for (size_t k = 0; z && k < count; k++) z[k] = (float)fields[f].sample(k % side, k / side);
    return z != NULL;
}

void workload_field_free(workload_field *field) {
    large_release(field->z);
    *field = (workload_field){0};
}

cw_status workload_field_open(const workload_field *samples, cw_field **field) {
    const cw_field_desc desc = {.samples = samples->z, .nx = samples->nx, .ny = samples->ny, .storage = CW_BORROW};
    return cw_field_create(&desc, NULL, field);
}
