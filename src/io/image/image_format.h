/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of a picture format, for image.c. */
#ifndef CELLWALK_IO_IMAGE_FORMAT_H
#define CELLWALK_IO_IMAGE_FORMAT_H

#include "image.h"

typedef struct image_format {
    const char *ending; /* ".exr" */
    /* On failure nothing is left to free. NULL: cannot be read. */
    bool (*read)(const char *path, io_image *image, io_error *error);
    bool (*write)(io_output *out, const io_image *image, io_error *error);
} image_format;

/* Both functions NULL where the library was absent when this was built. */
extern const image_format image_exr, image_png;

#endif
