/* SPDX-License-Identifier: Apache-2.0 */
/* Small .npy files for tests of the program, written without the project's own writer. */
#ifndef CELLWALK_TESTS_TOOL_FILES_H
#define CELLWALK_TESTS_TOOL_FILES_H

#include "check.h"
#include "scratch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline void npy_file(const char *name, const char *type, const char *shape, const void *data, size_t size) {
    char *bytes = malloc(size + 256);
    assert_non_null(bytes);
    const int length = snprintf(bytes + 10, 240, "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", type, shape);
    memcpy(bytes, "\x93NUMPY\x01\x00", 8);
    /* Blanks up to a multiple of 64, as NumPy has them. */
    size_t start = 10 + (size_t)length;
    while ((start + 1) % 64 != 0) bytes[start++] = ' ';
    bytes[start++] = '\n';
    bytes[8] = (char)((start - 10) & 0xff);
    bytes[9] = (char)((start - 10) >> 8);
    if (size > 0) memcpy(bytes + start, data, size);
    scratch_write(name, bytes, start + size);
    free(bytes);
}

static inline void rays_file(const char *name, const cw_ray *rays, size_t n) {
    char shape[64];
    snprintf(shape, sizeof shape, "(%zu, 8)", n);
    npy_file(name, "<f4", shape, rays, n * sizeof *rays);
}

static inline void field_file(const char *name, const float *z, size_t nx, size_t ny) {
    char shape[64];
    snprintf(shape, sizeof shape, "(%zu, %zu)", ny, nx);
    npy_file(name, "<f4", shape, z, nx * ny * sizeof *z);
}

#endif
