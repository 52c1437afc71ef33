/* SPDX-License-Identifier: Apache-2.0 */
#include "workload/fields.h"

#include "workload/terrain.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct definition {
    const char *name;
    size_t side;
    float roughness; /* of water; 0 is land */
} definition;

static const definition definitions[] = {
    {"65", 65, 0},     {"257", 257, 0},           {"1025", 1025, 0},         {"4097", 4097, 0},
    {"8193", 8193, 0}, {"sea-calm", 1000, 0.02f}, {"sea-rough", 1000, 0.5f},
};
enum { DEFINITION_COUNT = sizeof definitions / sizeof definitions[0] };

static const float land_relief = 0.1f;
static const uint32_t land_seed = 1, sea_seed = 2;

size_t workload_field_count(void) { return DEFINITION_COUNT; }

const char *workload_field_name(size_t number) { return number < DEFINITION_COUNT ? definitions[number].name : NULL; }

bool workload_field_make(const char *name, workload_field *field) {
    *field = (workload_field){0};
    for (size_t k = 0; k < DEFINITION_COUNT; k++) {
        const definition *d = &definitions[k];
        if (strcmp(name, d->name) != 0) continue;
        *field = (workload_field){.name = d->name, .nx = d->side, .ny = d->side};
        field->z = malloc(d->side * d->side * sizeof *field->z);
        if (field->z == NULL) return false;
        if (d->roughness > 0)
            terrain_sea(field->z, d->side, d->side, sea_seed, d->roughness);
        else
            terrain_fractal(field->z, d->side, d->side, land_seed, land_relief);
        return true;
    }
    return false;
}

void workload_field_free(workload_field *field) {
    free(field->z);
    *field = (workload_field){0};
}

cw_status workload_field_open(const workload_field *samples, cw_storage storage, bool bare, cw_field **field) {
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples->z;
    desc.nx = samples->nx;
    desc.ny = samples->ny;
    desc.storage = storage;
    desc.bare = bare;
    return cw_field_create(&desc, field);
}
