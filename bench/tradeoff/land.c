/* SPDX-License-Identifier: Apache-2.0 */
#include "tradeoff/tradeoff.h"

#include "harness/memory.h"
#include "harness/results.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[] = {"65", "257", "1025", "4097", "8193", "16385", "32769"};

const char *tradeoff_land_name(size_t number) { return number < sizeof names / sizeof *names ? names[number] : NULL; }

bool tradeoff_land_open(const char *name, tradeoff_land *land, bool *skipped, io_error *error) {
    const size_t side = strtoul(name, NULL, 10);
    *land = (tradeoff_land){0};
    /* The land itself, its bounds, and a third of both for coarser ones. */
    *skipped = !run_memory_has(8.5 * (double)side * (double)side, "the land", name);
    if (*skipped) return true;
    land->samples = (workload_field){.name = name, .nx = side, .ny = side, .z = malloc(side * side * sizeof(float))};
    if (land->samples.z == NULL) return io_fail(error, "out of memory for land of %s samples a side", name);
    terrain_fractal(land->samples.z, side, side, 1, 0.1f);
    const cw_status status = workload_field_open(&land->samples, CW_BORROW, false, &land->field);
    if (status == CW_OK) return true;
    tradeoff_land_close(land);
    return io_fail(error, "land of %s samples a side: %s", name, cw_last_error());
}

void tradeoff_land_close(tradeoff_land *land) {
    cw_field_destroy(land->field);
    workload_field_free(&land->samples);
    land->field = NULL;
}

float *tradeoff_samples_of(const cw_field *field) {
    const cw_field_info info = cw_field_describe(field);
    float *z = memory(info.nx * info.ny, sizeof *z);
    for (size_t j = 0; j < info.ny; j++) memcpy(z + j * info.nx, cw_field_row(field, j), info.nx * sizeof *z);
    return z;
}

terrain tradeoff_terrain_of(const cw_field *field, const float *z, size_t factor) {
    const cw_field_info info = cw_field_describe(field);
    const double step = (double)(TRADEOFF_CELL * factor);
    const double map[3][4] = {{step, 0, 0, 0}, {0, step, 0, 0}, {0, 0, TRADEOFF_CELL, 0}};
    const terrain_desc desc = {.field = field, .nx = info.nx, .ny = info.ny, .z = z, .map = map, .unit = 1};
    terrain t;
    terrain_init(&t, &desc);
    return t;
}

tradeoff_spread tradeoff_spread_of(double *errors, size_t count) {
    double sum = 0, squares = 0;
    for (size_t k = 0; k < count; k++) {
        sum += errors[k];
        squares += errors[k] * errors[k];
    }
    if (count == 0) return (tradeoff_spread){0};
    const double median = statistics_of(errors, count).median; /* sorts them */
    return (tradeoff_spread){sum / (double)count, sqrt(squares / (double)count), median,
                             errors[(size_t)(0.99 * (double)(count - 1))], errors[count - 1]};
}

void tradeoff_set_spread(json_t *line, const char *name, const tradeoff_spread *s) {
    char keys[128];
    snprintf(keys, sizeof keys, "%s_mean %s_rms %s_median %s_99 %s_worst", name, name, name, name, name);
    results_set_numbers(line, keys, (double[]){s->mean, s->rms, s->median, s->most, s->worst});
}
