/* SPDX-License-Identifier: Apache-2.0 */
/* Linear RGB pictures in memory and on disk. */
#ifndef CELLWALK_IO_IMAGE_H
#define CELLWALK_IO_IMAGE_H

#include "output.h"

#include <stddef.h>
#include <stdint.h>

/* The most pixels that a picture is rendered with, and a scene's images have together: 3 GiB of floats. */
enum { IO_IMAGE_PIXELS_MAX = 1 << 28 };
/* No compression packs pictures closer, be they of one colour: blocks of 8 x 8 pixels become one value, and zlib packs
 * such values by 1032 to 1 at best. A file of a few bytes can claim any number of pixels. */
enum { IO_EXR_PIXELS_PER_BYTE_MAX = 1 << 16 };
enum { IO_IMAGE_ROOM = 64 };

/* A picture that is written: rgb[(y * width + x) * 3 + c], row 0 at the top, linear light. One that was read: four
 * half-precision floats a pixel, the last of them 0: halves[((width + 2) * y + x + 1) * 4 + c]. The extra pixel on each
 * side of a row is free for the caller's border. Behind the last row there is room for as many pixels again and
 * IO_IMAGE_ROOM more, for smaller copies of the picture; memory that is not touched costs nothing. */
typedef struct io_image {
    size_t width, height;
    float *rgb;
    uint16_t *halves;
} io_image;

/* Writes into an output, which stays open. The format follows from the ending of its name: .exr (half RGBA, alpha 1) or
 * .png (8 bit, sRGB). */
bool io_image_put(io_output *out, const io_image *image, io_error *error);

/* Reads .exr (any channel types, R G B or Y) of at most that many pixels. The caller frees them with io_image_free. */
bool io_image_read(const char *path, size_t most, io_image *image, io_error *error);
/* Allocates a picture's halves; false, with error, if they are too many or memory is short. Nothing is set. path: the
 * name in the error message. */
bool io_image_allocate(io_image *image, size_t width, size_t height, size_t most, const char *path, io_error *error);
void io_image_free(io_image *image);

/* True if the ending is one that this build can write; else error lists those that it can. */
bool io_image_can_write(const char *path, io_error *error);

/* The formats, each behind its library. On failure there is nothing to free. */
bool io_exr_read(const char *path, size_t most, io_image *image, io_error *error);
bool io_exr_put(io_output *out, const io_image *image, io_error *error);
bool io_png_put(io_output *out, const io_image *image, io_error *error);

/* Pixels of three bytes each. */
bool io_png_put_bytes(io_output *out, size_t width, size_t height, const uint8_t *rgb, io_error *error);

#endif
