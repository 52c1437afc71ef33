/* SPDX-License-Identifier: Apache-2.0 */
/* Synthetic height fields for scenes, benchmark and tests: the same numbers on every machine, from integer hashes and
 * plain IEEE arithmetic (no function of libm but the square root, which IEEE rounds correctly), at any size. */
#ifndef CELLWALK_BENCH_WORKLOAD_FRACTAL_TERRAIN_H
#define CELLWALK_BENCH_WORKLOAD_FRACTAL_TERRAIN_H

#include <stddef.h>
#include <stdint.h>

/* All heights are in cells: with unit cells they have the proportions of a landscape. z holds nx × ny samples, (i, j)
 * at z[j * nx + i]; nx, ny >= 2. */

/* Fractal land with mountains of all sizes from half of the longer side down to single cells. Heights span exactly
 * [-relief, relief] / 2 of the longer side's cells: relief 0.1 on 1025 samples gives -51.2 to 51.2. */
void terrain_fractal(float *z, size_t nx, size_t ny, uint32_t seed, float relief);

/* Water: ripples and waves of 4 to 64 cells around height 0. roughness is the root mean square of the slope along x and
 * along y together, in cells of height per cell: 0.02 is calm, 0.5 is rough. */
void terrain_sea(float *z, size_t nx, size_t ny, uint32_t seed, float roughness);

/* 32 well-mixed bits from a seed and two numbers. */
uint32_t terrain_hash(uint32_t seed, uint32_t a, uint32_t b);

/* One sample of gradient noise (Perlin 2002) in [-1, 1], lattice points at whole x and y. */
float terrain_noise(uint32_t seed, double x, double y);

#endif
