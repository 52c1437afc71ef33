/* SPDX-License-Identifier: Apache-2.0 */
#include "sight.h"

#include "error.h"

#include <math.h>
#include <stdlib.h>

static inline float higher(float z, float h) {
    const float height = z < INFINITY ? z : h;
    return height > h ? height : h;
}

/* The highest of 4 x 4 numbers each, and of `more` rows and columns after them: samples on a node's far borders belong
 * to its closed cells. columns: room for a row. */
static void fold(const float *z, size_t nx, size_t ny, size_t stride, size_t more, float *columns, float *high) {
    const size_t across = (nx - more + 3) / 4, down = (ny - more + 3) / 4, side = 4 + more;
    for (size_t y = 0; y < down; y++, high += across) {
        for (size_t i = 0; i < nx; i++) columns[i] = -INFINITY;
        for (size_t j = 4 * y; j < 4 * y + side && j < ny; j++)
            for (size_t i = 0; i < nx; i++) columns[i] = higher(z[j * stride + i], columns[i]);
        for (size_t x = 0; x < across; x++) {
            high[x] = -INFINITY;
            for (size_t i = 4 * x; i < 4 * x + side && i < nx; i++) high[x] = higher(columns[i], high[x]);
        }
    }
}

static bool bound(const terrain *t, sight_bounds *b) {
    float *columns = malloc(t->nx * sizeof *columns);
    const float *from = t->z;
    size_t nx = t->nx, ny = t->ny, stride = t->stride, more = 1;
    bool good = columns != NULL;
    while (good && b->levels < SIGHT_LEVELS_MOST && (more == 1 || nx > 1 || ny > 1)) {
        const int l = b->levels++;
        b->across[l] = (nx - more + 3) / 4;
        b->down[l] = (ny - more + 3) / 4;
        b->high[l] = malloc(b->across[l] * b->down[l] * sizeof(float));
        good = b->high[l] != NULL;
        if (good) fold(from, nx, ny, stride, more, columns, b->high[l]);
        from = b->high[l];
        nx = stride = b->across[l];
        ny = b->down[l];
        more = 0;
    }
    free(columns);
    return good;
}

cw_status cw_sight_bounds_create(const terrain *t, sight_bounds **bounds) {
    sight_bounds *b = *bounds = calloc(1, sizeof *b);
    if (b && bound(t, b)) return CW_OK;
    cw_sight_bounds_destroy(b);
    *bounds = NULL;
    return cw_fail_plainly(CW_ERROR_MEMORY);
}

void cw_sight_bounds_destroy(sight_bounds *b) {
    if (b == NULL) return;
    for (int l = 0; l < b->levels; l++) free(b->high[l]);
    free(b);
}
