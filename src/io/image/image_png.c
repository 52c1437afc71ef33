/* SPDX-License-Identifier: Apache-2.0 */
/* 8-bit sRGB pictures (IEC 61966-2-1) to look at, through libpng. */

#include "image.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

/* Light outside [0, 1] is cut off; NaN is black. */
static uint8_t srgb(float light) {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    const float code = light <= 0.0031308f ? 12.92f * light : 1.055f * powf(light, 1 / 2.4f) - 0.055f;
    return (uint8_t)(code * 255 + 0.5f);
}

bool io_png_put(io_output *out, const io_image *image, io_error *error) {
    /* Without this libpng accepts at most 10^6 pixels a side. */
    if (image->width > 1000000 || image->height > 1000000)
        return io_fail(error, "%s: %zu x %zu pixels are too many for PNG", out->name, image->width, image->height);
    const size_t n = image->width * image->height * 3;
    uint8_t *code = malloc(n);
    if (code == NULL)
        return io_fail(error, "%s: no memory for %zu x %zu pixels", out->name, image->width, image->height);
    for (size_t k = 0; k < n; k++) code[k] = srgb(image->rgb[k]);

    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)image->width,
                     .height = (png_uint_32)image->height,
                     .format = PNG_FORMAT_RGB};
    errno = 0;
    const bool good = png_image_write_to_stdio(&png, out->file, 0, code, 0, NULL) != 0;
    free(code);
    return good || io_fail(error, "%s: cannot write: %s", out->name, errno != 0 ? strerror(errno) : png.message);
}
