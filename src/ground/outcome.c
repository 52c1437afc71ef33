/* SPDX-License-Identifier: Apache-2.0 */
#include "outcome.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Quantiles of a million values are known to a thousandth of their rank. */
enum { KEPT_MOST = 1 << 20 };

bool outcome_begin(outcome *o, size_t values, io_error *error) {
    *o = (outcome){.low = INFINITY, .high = -INFINITY, .step = values / KEPT_MOST + 1};
    o->room = values / o->step + 1;
    o->kept = malloc(o->room * sizeof *o->kept);
    return o->kept != NULL || io_fail(error, "out of memory");
}

void outcome_end(outcome *o) {
    free(o->kept);
    o->kept = NULL;
}

const float *outcome_read(const io_raster_product *p, const void *cells, size_t n, float *values) {
    if (p->cell == IO_CELL_FLOAT32) return cells;
    for (size_t k = 0; k < n; k++) {
        const unsigned value = p->cell == IO_CELL_UINT8 ? ((const uint8_t *)cells)[k] : ((const uint16_t *)cells)[k];
        values[k] = value == p->nodata ? NAN : (float)value;
    }
    return values;
}

void outcome_take(outcome *o, const float *values, size_t n) {
    for (size_t k = 0; k < n; k++) {
        const float value = values[k];
        const bool keeps = o->samples++ % o->step == 0;
        if (isnan(value)) {
            o->holes++;
            continue;
        }
        o->above += value > 0;
        o->low = value < o->low ? value : o->low;
        o->high = value > o->high ? value : o->high;
        if (keeps && o->count < o->room) o->kept[o->count++] = value;
    }
}

bool outcome_count(outcome *o, const io_raster_product *p, const void *cells, size_t n) {
    const uint8_t *bytes = cells, nodata = (uint8_t)p->nodata;
    if (p->cell != IO_CELL_UINT8) return false;
    for (size_t k = 0; k < n; k++) {
        o->holes += bytes[k] == nodata;
        o->above += bytes[k] != nodata && bytes[k] > 0;
    }
    o->samples += n;
    return true;
}

static int compare(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

double outcome_quantile(const outcome *o, double share) {
    if (o->count == 0) return NAN;
    qsort(o->kept, o->count, sizeof *o->kept, compare);
    return (double)o->kept[(size_t)(share * (double)(o->count - 1) + 0.5)];
}

void outcome_text(const outcome *o, const io_raster_product *p, const char *counted, char *text, size_t size) {
    const size_t data = o->samples - o->holes;
    const char *unit = !p->unit ? "" : strcmp(p->unit, "degree") == 0 ? "degrees" : p->unit;
    if (data == 0)
        snprintf(text, size, "no data in %zu samples", o->samples);
    else if (p->cell == IO_CELL_UINT8 || p->cell == IO_CELL_UINT16)
        snprintf(text, size, "%.3g %% of %zu samples %s", 100 * (double)o->above / (double)data, data, counted);
    else
        snprintf(text, size, "%.3g to %.3g%s%s, median %.3g, of %zu samples", (double)o->low, (double)o->high,
                 *unit ? " " : "", unit, outcome_quantile(o, 0.5), data);
}
