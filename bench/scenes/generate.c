/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-terrain: writes the land, the seas and the images of the project's scenes. All of it comes from integer
 * hashes and arithmetic that IEEE defines to the last bit, and numbers are printed with six places, which the C library
 * rounds correctly: the files are the same everywhere. */

#include "workload/fractal_terrain.h"

#include "image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64, LARGE_SIDE = 1000 };

static float *floats(size_t n) {
    float *room = malloc(n * sizeof *room);
    if (room) return room;
    fputs("cellwalk-terrain: out of memory\n", stderr);
    exit(EXIT_FAILURE);
}

static double square(double x) { return x * x; }

/* 0 below low, 1 above high, smooth between. */
static double smooth_step(double low, double high, double x) {
    const double t = x <= low ? 0 : x >= high ? 1 : (x - low) / (high - low);
    return t * t * (3 - 2 * t);
}

/* Writes heights in cells as a height field over the unit square, one row a line. */
static bool write_field(const char *path, const float *z, size_t side, io_error *error) {
    io_output out;
    if (!io_output_open(&out, path, error)) return false;
    fprintf(out.file, "# Written by cellwalk-terrain.\nShape \"heightfield\" \"integer nu\" %zu \"integer nv\" %zu\n",
            side, side);
    fputs("\"float Pz\" [\n", out.file);
    for (size_t k = 0; k < side * side; k++)
        fprintf(out.file, "%.6f%c", (double)z[k] / (double)(side - 1), (k + 1) % side == 0 ? '\n' : ' ');
    fputs("]\n", out.file);
    return io_output_commit(&out, error);
}

/* Mountains rise towards negative z, where the scenes' cameras have their up; the sea lies at 0. Two bays and an islet
 * come from the fractal, the sea all around from the distance to the middle. */
static bool write_land(const char *path, io_error *error) {
    float *z = floats(SIDE * SIDE);
    terrain_fractal(z, SIDE, SIDE, 2, 1);
    for (size_t j = 0; j < SIDE; j++)
        for (size_t i = 0; i < SIDE; i++) {
            const double x = (double)i / (SIDE - 1) - 0.5, y = (double)j / (SIDE - 1) - 0.5;
            const double shore = smooth_step(0.2, 0.52, sqrt(x * x + y * y));
            const double height = (double)z[j * SIDE + i] / (SIDE - 1);
            z[j * SIDE + i] = (float)((SIDE - 1) * (1.1 * height - 0.12 + 0.7 * shore));
        }
    const bool good = write_field(path, z, SIDE, error);
    free(z);
    return good;
}

/* Every step-th sample of a finer sea, so that waves are that much shorter against the cells. */
static bool write_sea(const char *path, size_t side, size_t step, uint32_t seed, float roughness, io_error *error) {
    const size_t fine = side * step;
    float *z = floats(fine * fine);
    terrain_sea(z, fine, fine, seed, roughness);
    for (size_t j = 0; j < side; j++)
        for (size_t i = 0; i < side; i++) z[j * side + i] = z[j * step * fine + i * step] / (float)step;
    const bool good = write_field(path, z, side, error);
    free(z);
    return good;
}

/* Light of the sky at u around and v down from the zenith, the horizon being at v = 1/2: blue above, warm below, thin
 * clouds, and the sun with its glow a little above the horizon. The sun is much brighter than 1. */
static void sky(double u, double v, float rgb[3]) {
    static const double zenith[3] = {0.35, 0.62, 0.95}, horizon[3] = {1.25, 0.95, 0.7}, below[3] = {0.05, 0.06, 0.08};
    static const double sun[3] = {1, 0.93, 0.78};
    const double rise = smooth_step(0, 1, v * 2), low = square(square(rise));
    /* Distances in radians; the way around is shorter on one of the two sides. */
    double around = fabs(u - 0.19);
    around = (around > 0.5 ? 1 - around : around) * 6.283185307179586;
    const double up = (v - 0.41) * 4, distance = around * around + up * up;
    const double glow = 1.2 / square(1 + distance / 0.09), disc = 44 / square(square(1 + distance / 0.022));
    double cloud = 0, amplitude = 0.5;
    for (uint32_t octave = 0; octave < 5; octave++, amplitude *= 0.5) {
        const double size = (double)(1u << octave);
        /* The seam at u = 0 is hidden by fading from one copy of the noise to the next. */
        const double w = smooth_step(0.8, 1, u);
        cloud += amplitude * ((1 - w) * (double)terrain_noise(90 + octave, u * 8 * size, v * 24 * size) +
                              w * (double)terrain_noise(90 + octave, (u - 1) * 8 * size, v * 24 * size));
    }
    cloud = 0.5 * smooth_step(0.02, 0.45, cloud) * smooth_step(0.1, 0.3, v);
    const double ground = smooth_step(0.5, 0.53, v);
    for (int c = 0; c < 3; c++) {
        double light = zenith[c] + (horizon[c] - zenith[c]) * low;
        light += cloud * (1.5 - light) + (glow + disc) * sun[c];
        rgb[c] = (float)(light + (below[c] - light) * ground);
    }
}

/* Four tinted quarters under a grid of ten by ten dark lines; the origin's corner has a disc. */
static void grid(double u, double v, float rgb[3]) {
    static const double tint[4][3] = {{0.8, 0.5, 0.5}, {0.5, 0.55, 0.85}, {0.5, 0.75, 0.5}, {0.75, 0.75, 0.7}};
    const double *colour = tint[(u > 0.5) + 2 * (v > 0.5)];
    const double x = u * 10 - floor(u * 10), y = v * 10 - floor(v * 10);
    const double to_line = fmin(fmin(x, 1 - x), fmin(y, 1 - y));
    const bool middle = fabs(u - 0.5) < 0.006 || fabs(v - 0.5) < 0.006;
    const bool disc = square(u - 0.05) + square(v - 0.05) < square(0.025);
    for (int c = 0; c < 3; c++) rgb[c] = (float)(middle || disc ? 0.03 : to_line < 0.025 ? 0.15 : colour[c]);
}

/* shade: the colour at u, v in [0, 1], of each pixel's middle. */
static bool write_image(const char *path, size_t width, size_t height, void (*shade)(double, double, float[3]),
                        io_error *error) {
    const io_image image = {.width = width, .height = height, .rgb = floats(width * height * 3)};
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++)
            shade(((double)x + 0.5) / (double)width, ((double)y + 0.5) / (double)height,
                  image.rgb + (y * width + x) * 3);
    io_output out;
    const bool good =
        io_output_open(&out, path, error) && io_image_put(&out, &image, error) && io_output_commit(&out, error);
    io_output_discard(&out);
    free(image.rgb);
    return good;
}

static bool write_one(const char *path, io_error *error) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (strcmp(name, "land.pbrt") == 0) return write_land(path, error);
    if (strcmp(name, "sea.pbrt") == 0) return write_sea(path, SIDE, 4, 3, 3, error);
    if (strcmp(name, "sea-l.pbrt") == 0) return write_sea(path, LARGE_SIDE, 1, 4, 0.4f, error);
    if (strcmp(name, "sky.exr") == 0) return write_image(path, 1024, 512, sky, error);
    if (strcmp(name, "grid.exr") == 0) return write_image(path, 512, 512, grid, error);
    return io_fail(error, "%s: not land.pbrt, sea.pbrt, sea-l.pbrt, sky.exr or grid.exr", path);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fputs("Usage: cellwalk-terrain FILE...\n"
              "Writes what the files are named after: land.pbrt, sea.pbrt, sea-l.pbrt, sky.exr, grid.exr\n",
              stderr);
        return 2;
    }
    for (int k = 1; k < argc; k++) {
        io_error error;
        if (write_one(argv[k], &error)) continue;
        fprintf(stderr, "cellwalk-terrain: %s\n", error.text);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
