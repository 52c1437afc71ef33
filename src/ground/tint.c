/* SPDX-License-Identifier: Apache-2.0 */
#include "tint.h"

#include "half.h"

#include <math.h>

/* Texels a side at most: heights change slowly enough for as many. */
enum { SIDE_MOST = 2048 };

/* Linear light at even steps of height. */
enum { STEPS = 4 };
static const float tints[STEPS + 1][3] = {
    {0.10f, 0.24f, 0.08f}, {0.34f, 0.40f, 0.14f}, {0.50f, 0.37f, 0.18f}, {0.38f, 0.30f, 0.25f}, {0.92f, 0.92f, 0.95f}};

static void tint(double height, double low, double high, uint16_t rgba[4]) {
    const double x = high > low && height > low ? fmin((height - low) / (high - low), 1) * STEPS : 0;
    const int step = x < STEPS ? (int)x : STEPS - 1;
    const float part = (float)(x - step);
    for (int c = 0; c < 3; c++)
        rgba[c] = half_from_float(tints[step][c] + part * (tints[step + 1][c] - tints[step][c]));
    rgba[3] = 0;
}

/* The place in the field that a texel shows. */
static double place(size_t texel, size_t texels, size_t samples) {
    return ((double)texel + 0.5) / (double)texels * (double)(samples - 1);
}

bool tint_heights(io_image *colours, const terrain *t, io_error *error) {
    const cw_field_info info = cw_field_describe(t->field);
    const double metres = terrain_metres_of_height(t);
    const double low = (double)info.low * metres, high = (double)info.high * metres;
    const size_t columns = t->nx - 1 < SIDE_MOST ? t->nx - 1 : SIDE_MOST;
    const size_t rows = t->ny - 1 < SIDE_MOST ? t->ny - 1 : SIDE_MOST;
    if (!io_image_allocate(colours, columns, rows, "the field's colours", error)) return false;
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < columns; x++)
            tint(cw_terrain_height(t, place(x, columns, t->nx), place(y, rows, t->ny)), low, high,
                 colours->halves + ((columns + 2) * y + x + 1) * 4);
    return true;
}
