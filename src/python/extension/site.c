/* SPDX-License-Identifier: Apache-2.0 */
#include "site.h"

#include <string.h>

bool site_take_map(const Py_buffer *buffer, double map[3][4]) {
    enum { BYTES = 12 * sizeof(double) };
    if (buffer->len == BYTES) {
        memcpy(map, buffer->buf, BYTES);
        return true;
    }
    PyErr_Format(PyExc_ValueError, "map: a buffer of %zd bytes, where %d are needed", buffer->len, (int)BYTES);
    return false;
}

bool site_take_scale(const Py_buffer *buffer, map_scale *to, terrain *t) {
    if (buffer->obj == NULL) return true;
    if (buffer->len != sizeof *to) {
        PyErr_SetString(PyExc_ValueError, "scale: a buffer of another size");
        return false;
    }
    memcpy(to, buffer->buf, sizeof *to);
    if (!t->geographic) t->scale = to;
    return true;
}

bool site_init(terrain *t, const site *g, const cw_field *field, size_t nx, size_t ny, const float *z) {
    /* Without a map, a picture's: the first row is in the north. A coarser field's samples stand more than 1 apart. */
    const double apart = g->map[0][0];
    const double picture[3][4] = {{apart, 0, 0, 0}, {0, -apart, 0, apart * (double)(ny - 1)}, {0, 0, g->map[2][2], 0}};
    const terrain_desc desc = {
        .field = field,
        .nx = nx,
        .ny = ny,
        .z = z,
        .map = g->north_up ? picture : (const double(*)[4])g->map,
        .geographic = g->geographic,
        .unit = g->unit,
        .semi_major = g->semi_major,
        .inverse_flattening = g->inverse_flattening,
    };
    return cw_terrain_init(t, &desc);
}

double site_northward(const site *g, const terrain *t, double y) {
    return g->north_up ? g->map[0][0] * (double)(terrain_whole(t)->ny - 1) - y : y;
}
