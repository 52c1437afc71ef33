/* SPDX-License-Identifier: Apache-2.0 */
/* Gradient noise in octaves (Perlin 1985, with the fifth-degree blend of Perlin 2002; fractal sum after Musgrave 1989).
 * Along a row the noise between two lattice columns is a blend of two straight lines, whose coefficients are computed
 * once for each column. The 67 million samples of an 8193 × 8193 field take seconds and no further memory. */

#include "workload/fractal_terrain.h"

#include <math.h>

uint32_t terrain_hash(uint32_t seed, uint32_t a, uint32_t b) {
    uint32_t h = seed * 0x9e3779b1u;
    h = (h ^ a) * 0x85ebca6bu;
    h ^= h >> 15;
    h = (h ^ b) * 0xc2b2ae35u;
    h ^= h >> 16;
    h *= 0x7feb352du;
    h ^= h >> 15;
    h *= 0x846ca68bu;
    return h ^ h >> 16;
}

/* Zero slope and curvature at 0 and 1, so that lattice lines do not show. */
static float fade(float x) { return x * x * x * (x * (x * 6 - 15) + 10); }

/* Height over a lattice column at a given row: rest + slope * dx, dx being the distance from the column. */
typedef struct line {
    float rest, slope;
} line;

/* The gradients of the lattice points above and below the row, blended by the row's place dy between them. */
static line blended(uint32_t seed, uint32_t column, uint32_t row, float dy) {
    const uint32_t above = terrain_hash(seed, column, row), below = terrain_hash(seed, column, row + 1);
    const float unit = 1.0f / 32768, w = fade(dy);
    const float ax = (float)(above & 0xffff) * unit - 1, ay = (float)(above >> 16) * unit - 1;
    const float bx = (float)(below & 0xffff) * unit - 1, by = (float)(below >> 16) * unit - 1;
    return (line){(1 - w) * (ay * dy) + w * (by * (dy - 1)), (1 - w) * ax + w * bx};
}

static float between(line left, line right, float dx) {
    const float w = fade(dx);
    return (1 - w) * (left.rest + left.slope * dx) + w * (right.rest + right.slope * (dx - 1));
}

float terrain_noise(uint32_t seed, double x, double y) {
    const double column = floor(x), row = floor(y);
    const uint32_t c = (uint32_t)(int64_t)column, r = (uint32_t)(int64_t)row;
    const float dy = (float)(y - row);
    return between(blended(seed, c, r, dy), blended(seed, c + 1, r, dy), (float)(x - column));
}

/* Noise with lattice points every 2^log2_x by 2^log2_y samples, moved by fractions of a sample (in 256ths) that differ
 * between octaves: noise is 0 at its lattice points, and no sample should lie on those of all octaves. */
typedef struct octave {
    uint32_t seed;
    unsigned log2_x, log2_y;
    float amplitude;
} octave;

static void add_row(float *z, size_t nx, size_t j, const octave *o) {
    const unsigned shift_x = o->log2_x + 8, shift_y = o->log2_y + 8;
    const uint64_t size_x = (uint64_t)1 << shift_x, size_y = (uint64_t)1 << shift_y;
    const uint64_t start = terrain_hash(o->seed, 1, 0) & (size_x - 1);
    const uint64_t y = (uint64_t)j * 256 + (terrain_hash(o->seed, 2, 0) & (size_y - 1));
    const uint32_t row = (uint32_t)(y >> shift_y);
    const float dy = (float)(y & (size_y - 1)) / (float)size_y, unit = 1 / (float)size_x;

    uint32_t column = (uint32_t)(start >> shift_x);
    line right = blended(o->seed, column, row, dy);
    for (size_t i = 0; i < nx;) {
        const line left = right;
        const uint64_t border = (uint64_t)(column + 1) << shift_x, origin = (uint64_t)column << shift_x;
        right = blended(o->seed, column + 1, row, dy);
        uint64_t end = (border - start + 255) / 256;
        if (end > nx) end = nx;
        /* Columns are at most 2^30 256ths of a sample apart: log2_x <= 22. */
        const int32_t first = (int32_t)((uint64_t)i * 256 + start - origin), count = (int32_t)((size_t)end - i);
        for (int32_t k = 0; k < count; k++)
            z[i + (size_t)k] += o->amplitude * between(left, right, (float)(first + k * 256) * unit);
        i = (size_t)end;
        column++;
    }
}

static void fill(float *z, size_t nx, size_t ny, const octave *octaves, unsigned count) {
    for (size_t j = 0; j < ny; j++) {
        float *row = z + j * nx;
        for (size_t i = 0; i < nx; i++) row[i] = 0;
        for (unsigned k = 0; k < count; k++) add_row(row, nx, j, &octaves[k]);
    }
}

void terrain_fractal(float *z, size_t nx, size_t ny, uint32_t seed, float relief) {
    enum { MOST = 22 };
    const size_t side = (nx > ny ? nx : ny) - 1;
    unsigned top = 1;
    while (top < MOST && (size_t)4 << top <= side) top++;

    /* Halving the wavelength takes the amplitude down by 2^-0.9: a little rougher than self-similar slopes, as eroded
     * land is (Hurst exponent 0.9). */
    octave octaves[MOST];
    float amplitude = 1;
    for (unsigned k = 0; k < top; k++) {
        octaves[k] = (octave){terrain_hash(seed, k, 77), top - k, top - k, amplitude};
        amplitude *= 0.535886731f;
    }
    fill(z, nx, ny, octaves, top);

    float low = z[0], high = z[0];
    for (size_t k = 1; k < nx * ny; k++) {
        low = z[k] < low ? z[k] : low;
        high = z[k] > high ? z[k] : high;
    }
    const float range = relief * (float)side, scale = high > low ? range / (high - low) : 0;
    for (size_t k = 0; k < nx * ny; k++) z[k] = (z[k] - low) * scale - range / 2;
}

void terrain_sea(float *z, size_t nx, size_t ny, uint32_t seed, float roughness) {
    /* Crests are twice as long as waves; most of the slope lies in waves of 16 to 32 cells. */
    const octave octaves[] = {
        {terrain_hash(seed, 0, 78), 6, 7, 0.5f},    {terrain_hash(seed, 1, 78), 5, 6, 1},
        {terrain_hash(seed, 2, 78), 5, 5, 0.8f},    {terrain_hash(seed, 3, 78), 4, 5, 0.7f},
        {terrain_hash(seed, 4, 78), 4, 4, 0.4f},    {terrain_hash(seed, 5, 78), 3, 3, 0.15f},
        {terrain_hash(seed, 6, 78), 2, 2, 0.0375f},
    };
    fill(z, nx, ny, octaves, sizeof octaves / sizeof octaves[0]);

    double sum = 0;
    for (size_t j = 0; j + 1 < ny; j++)
        for (size_t i = 0; i + 1 < nx; i++) {
            const float *p = z + j * nx + i;
            const double dx = (double)(p[1] - p[0]), dy = (double)(p[nx] - p[0]);
            sum += dx * dx + dy * dy;
        }
    const double slope = sqrt(sum / ((double)(nx - 1) * (double)(ny - 1)));
    const float scale = slope > 0 ? (float)((double)roughness / slope) : 0;
    for (size_t k = 0; k < nx * ny; k++) z[k] *= scale;
}
