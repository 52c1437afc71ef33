/* SPDX-License-Identifier: Apache-2.0 */
/* Gives the input as a file to the reader that READER names, and uses all that was read. */

#include "image.h"
#include "npy.h"
#include "points.h"
#include "raster.h"
#include "scene.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Files lie in a folder in memory, and scenes find their own there. */
static char folder[] = "/dev/shm/cellwalk-fuzz-XXXXXX";
static const char *const names[] = {"field.npy", "rays.npy", "points.csv", "a.exr", "scene.pbrt", "a.pbrt", "b.pbrt"};
enum { FIELD, RAYS, POINTS, PICTURE, SCENE, INCLUDED, OTHER, NAMES };
static char paths[NAMES][sizeof folder + 16];

static void remove_all(void) {
    for (int k = 0; k < NAMES; k++) unlink(paths[k]);
    rmdir(folder);
}

static const char *put(int name, const uint8_t *data, size_t size) {
    if (paths[0][0] == '\0') {
        if (mkdtemp(folder) == NULL) abort();
        for (int k = 0; k < NAMES; k++) snprintf(paths[k], sizeof paths[k], "%s/%s", folder, names[k]);
        atexit(remove_all);
    }
    const int fd = open(paths[name], O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size || close(fd) != 0) abort();
    return paths[name];
}

static volatile double sum;

static void pass_over(void *context, const char *text) {}

/* The input's last byte is also what the reader is told beside the file. */
static void read_field(const uint8_t *data, size_t size) {
    const unsigned told = size > 0 ? data[size - 1] : 0;
    const io_raster_options options = {.nodata = &(double){1},
                                       .nodata_count = (told & 16) != 0,
                                       .cellsize = told & 32 ? 2 : 0,
                                       .zscale = told & 64 ? 0.5 : 0,
                                       .band = told & 128 ? 1 : 0,
                                       .warn = {pass_over, NULL}};
    io_raster raster;
    if (!io_raster_read(put(FIELD, data, size), &options, &raster, NULL)) return;
    for (size_t k = 0; k < raster.nx * raster.ny; k++) sum = sum + (double)raster.z[k];
    for (int r = 0; r < 3; r++) sum = sum + raster.map[r][r];
    io_raster_free(&raster);
}

/* As `cellwalk trace` reads rays: by windows of rows. */
static void read_rays(const uint8_t *data, size_t size) {
    enum { ROWS = 3, PASSES_MAX = 1000 };
    io_npy npy;
    io_error error;
    char shape[128];
    if (!io_npy_open(&npy, put(RAYS, data, size), &error)) return;
    io_npy_shape_text(npy.header.rank, npy.header.shape, shape, sizeof shape);
    io_npy_expect_type(&npy, (const char *const[]){"<f4"}, 1, &error);
    const uint64_t rows = npy.header.rank > 0 ? npy.header.shape[0] : 1;
    for (uint64_t first = 0; first < rows && first < ROWS * PASSES_MAX; first += ROWS) {
        const uint64_t count = rows - first < ROWS ? rows - first : ROWS;
        const unsigned char *bytes = io_npy_rows(&npy, first, count, &error);
        for (uint64_t k = 0; bytes && k < count * npy.row_bytes; k++) sum = sum + bytes[k];
    }
    io_npy_close(&npy);
}

static void read_points(const uint8_t *data, size_t size) {
    const io_points_options options = {.warn = {pass_over, NULL}};
    io_points points;
    if (!io_points_read(put(POINTS, data, size), &options, &points, NULL)) return;
    for (size_t k = 0; k < points.count; k++) {
        const io_place *p = &points.list[k];
        sum = sum + p->x + p->y + p->z + p->weight + (double)p->number;
    }
    io_points_free(&points);
}

static void read_picture(const uint8_t *data, size_t size) {
    io_image image;
    if (!io_image_read(put(PICTURE, data, size), IO_IMAGE_PIXELS_MAX, &image, NULL)) return;
    for (size_t k = 0; k < image.width * image.height; k++)
        for (size_t c = 0; c < 4; c++)
            sum = sum + image.halves[4 * (k / image.width * (image.width + 2) + k % image.width + 1) + c];
    io_image_free(&image);
}

/* With all that it includes: bytes 0xff part the input into files. Also read as a file with a height field alone. */
static void read_scene(const uint8_t *data, size_t size) {
    static const int parts[] = {SCENE, INCLUDED, OTHER, PICTURE};
    for (int k = 0; k < 4; k++) {
        const uint8_t *end = size > 0 && k < 3 ? memchr(data, 0xff, size) : NULL;
        const size_t length = end ? (size_t)(end - data) : size;
        put(parts[k], data, length);
        data += length + (end != NULL);
        size -= length + (end != NULL);
    }
    io_error error;
    scene_free(scene_load(paths[SCENE], pass_over, NULL, &error));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static void (*const readers[])(const uint8_t *, size_t) = {[FIELD] = read_field,
                                                               [RAYS] = read_rays,
                                                               [POINTS] = read_points,
                                                               [PICTURE] = read_picture,
                                                               [SCENE] = read_scene};
    readers[READER](data, size);
    return 0;
}
