/* SPDX-License-Identifier: Apache-2.0 */
/* PNG of 8 bits a colour, by libpng's functions for whole pictures in memory. */

#include "image.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

bool io_png_put_bytes(io_output *out, size_t width, size_t height, const uint8_t *rgb, io_error *error) {
    enum { SIDE_MAX = 1000000 }; /* libpng's */
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)width,
                     .height = (png_uint_32)height,
                     .format = PNG_FORMAT_RGB};
    if (width > SIDE_MAX || height > SIDE_MAX)
        return io_fail(error, "%s: %zu x %zu pixels are too many for PNG", out->name, width, height);
    errno = 0;
    /* Of a file libpng says only that it failed. */
    return png_image_write_to_stdio(&png, out->file, 0, rgb, 0, NULL) ||
           io_fail(error, "%s: cannot write: %s", out->name, errno != 0 ? strerror(errno) : png.message);
}

/* IEC 61966-2-1. Light outside [0, 1] is cut off; NaN is black. */
static uint8_t srgb(float light) {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    const float code = light <= 0.0031308f ? 12.92f * light : 1.055f * powf(light, 1 / 2.4f) - 0.055f;
    return (uint8_t)(code * 255 + 0.5f);
}

bool io_png_put(io_output *out, const io_image *image, io_error *error) {
    const size_t n = 3 * image->width * image->height;
    uint8_t *rgb = malloc(n);
    if (rgb == NULL) return io_fail(error, "%s: out of memory", out->name);
    for (size_t k = 0; k < n; k++) rgb[k] = srgb(image->rgb[k]);
    const bool good = io_png_put_bytes(out, image->width, image->height, rgb, error);
    free(rgb);
    return good;
}
