/* SPDX-License-Identifier: Apache-2.0 */
/* A picture from a file, as floats. */
#ifndef CELLWALK_TESTS_READ_PICTURE_H
#define CELLWALK_TESTS_READ_PICTURE_H

#include "check.h"
#include "half.h"
#include "image.h"

#include <stdlib.h>

static inline io_image read_picture(const char *path) {
    io_image image;
    io_error error;
    check(io_image_read(path, &image, &error), "%s", error.text);
    assert_non_null(image.rgb = malloc(image.width * image.height * 3 * sizeof *image.rgb));
    for (size_t k = 0; k < image.width * image.height * 3; k++) {
        const size_t x = k / 3 % image.width, y = k / 3 / image.width;
        image.rgb[k] = half_number(image.halves[((image.width + 2) * y + x + 1) * 4 + k % 3]);
    }
    return image;
}

#endif
