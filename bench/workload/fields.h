/* SPDX-License-Identifier: Apache-2.0 */
/* The height fields of benchmark and tests, under fixed names and with fixed heights. */
#ifndef CELLWALK_BENCH_WORKLOAD_FIELDS_H
#define CELLWALK_BENCH_WORKLOAD_FIELDS_H

#include "cellwalk.h"

typedef struct workload_field {
    const char *name;
    size_t nx, ny;
    float *z; /* sample (i, j) is z[j * nx + i]; freed by workload_field_free */
} workload_field;

/* "2" to "65537": fractal land of that many samples a side, height range 0.1 of the side.
 * "sea-calm", "sea-rough": 1000 × 1000 samples of water.
 * "plane", "grooves", "comb", "checkerboard": 1025 × 1025 samples for rays beside them. The plane is tilted; of the
 * others every second row, every eighth row or every second sample is 1 high, the rest 0. Timed on request only. */
bool workload_field_exists(const char *name);
/* False if no field has that name (field->name is NULL) or out of memory (it is name). It is name on success too. */
bool workload_field_make(const char *name, workload_field *field);
void workload_field_free(workload_field *field);

/* The field in cells; the samples are borrowed. */
cw_status workload_field_open(const workload_field *samples, cw_field **field);

#endif
