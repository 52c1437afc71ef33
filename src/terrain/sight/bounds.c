/* SPDX-License-Identifier: Apache-2.0 */
#include "sight.h"

#include <math.h>
#include <stdlib.h>

static inline float higher(float z, float h) {
    const float height = z < INFINITY ? z : h;
    return height > h ? height : h;
}

/* Samples of a node's closed cells: including those on its far borders. columns: the row of nodes, sample by sample. */
static void bound_row(const terrain *t, size_t y, float *columns, float *high, size_t across) {
    const size_t first = y << SIGHT_FIRST_SHIFT,
                 last = first + (1 << SIGHT_FIRST_SHIFT) < t->ny - 1 ? first + (1 << SIGHT_FIRST_SHIFT) : t->ny - 1;
    for (size_t i = 0; i < t->nx; i++) columns[i] = -INFINITY;
    for (size_t j = first; j <= last; j++) {
        const float *z = terrain_row(t, j);
        for (size_t i = 0; i < t->nx; i++) columns[i] = higher(z[i], columns[i]);
    }
    for (size_t x = 0; x < across; x++) {
        const size_t begin = x << SIGHT_FIRST_SHIFT,
                     end = begin + (1 << SIGHT_FIRST_SHIFT) < t->nx - 1 ? begin + (1 << SIGHT_FIRST_SHIFT) : t->nx - 1;
        high[x] = -INFINITY;
        for (size_t i = begin; i <= end; i++) high[x] = columns[i] > high[x] ? columns[i] : high[x];
    }
}

static bool bound(const terrain *t, sight_bounds *b) {
    float *columns = malloc(t->nx * sizeof *columns);
    if (columns == NULL) return false;
    size_t across = (t->nx + 2) >> SIGHT_FIRST_SHIFT, down = (t->ny + 2) >> SIGHT_FIRST_SHIFT;
    for (;; across = (across + 3) / 4, down = (down + 3) / 4) {
        const int l = b->levels;
        b->across[l] = across;
        b->down[l] = down;
        b->high[l] = malloc(across * down * sizeof(float));
        if (b->high[l] == NULL) break;
        b->levels++;
        for (size_t y = 0; y < down; y++) {
            float *row = b->high[l] + y * across;
            if (l == 0) {
                bound_row(t, y, columns, row, across);
                continue;
            }
            const size_t fine = b->across[l - 1], last = 4 * y + 4 < b->down[l - 1] ? 4 * y + 4 : b->down[l - 1];
            for (size_t x = 0; x < across; x++) row[x] = -INFINITY;
            for (size_t v = 4 * y; v < last; v++)
                for (size_t u = 0; u < fine; u++) {
                    const float h = b->high[l - 1][v * fine + u];
                    row[u / 4] = h > row[u / 4] ? h : row[u / 4];
                }
        }
        if ((across == 1 && down == 1) || b->levels == SIGHT_LEVELS_MOST) {
            free(columns);
            return true;
        }
    }
    free(columns);
    return false;
}

cw_status cw_sight_bounds_create(const terrain *t, sight_bounds **bounds) {
    sight_bounds *b = *bounds = calloc(1, sizeof *b);
    if (b && bound(t, b)) return CW_OK;
    cw_sight_bounds_destroy(b);
    *bounds = NULL;
    return CW_ERROR_MEMORY;
}

void cw_sight_bounds_destroy(sight_bounds *b) {
    if (b == NULL) return;
    for (int l = 0; l < b->levels; l++) free(b->high[l]);
    free(b);
}
