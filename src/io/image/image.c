/* SPDX-License-Identifier: Apache-2.0 */
/* Which format a picture has: by the ending of its file name. */

#include "image_format.h"
#include "large.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#ifndef CELLWALK_OPENEXR
const image_format image_exr = {".exr", NULL, NULL};
#endif
#ifndef CELLWALK_PNG
const image_format image_png = {".png", NULL, NULL};
#endif

static const image_format *const formats[] = {&image_exr, &image_png};
enum { FORMATS = sizeof formats / sizeof formats[0] };

static const image_format *format_of(const char *path) {
    const size_t length = strlen(path);
    for (int k = 0; k < FORMATS; k++) {
        const size_t ending = strlen(formats[k]->ending);
        if (length > ending && strcasecmp(path + length - ending, formats[k]->ending) == 0) return formats[k];
    }
    return NULL;
}

/* Lists the formats that this build can write (or read). */
static bool refuse(const char *path, const image_format *format, bool writing, io_error *error) {
    char able[32] = "";
    for (int k = 0; k < FORMATS; k++) {
        if (writing ? formats[k]->write == NULL : formats[k]->read == NULL) continue;
        if (able[0] != '\0') strcat(able, " ");
        strcat(able, formats[k]->ending);
    }
    return io_fail(error, "%s: %s; this build can %s %s", path,
                   format ? "this build has no library for that format" : "unknown kind of picture",
                   writing ? "write" : "read", able);
}

bool io_image_can_write(const char *path, io_error *error) {
    const image_format *format = format_of(path);
    return (format != NULL && format->write != NULL) || refuse(path, format, true, error);
}

bool io_image_put(io_output *out, const io_image *image, io_error *error) {
    return io_image_can_write(out->name, error) && format_of(out->name)->write(out, image, error);
}

bool io_image_write(const char *path, const io_image *image, io_error *error) {
    if (!io_image_can_write(path, error)) return false;
    io_output out;
    if (!io_output_open(&out, path, error)) return false;
    if (io_image_put(&out, image, error)) return io_output_commit(&out, error);
    io_output_discard(&out);
    return false;
}

bool io_image_read(const char *path, io_image *image, io_error *error) {
    *image = (io_image){0};
    const image_format *format = format_of(path);
    if (format == NULL || format->read == NULL) return refuse(path, format, false, error);
    return format->read(path, image, error);
}

bool io_image_allocate(io_image *image, size_t width, size_t height, const char *path, io_error *error) {
    *image = (io_image){.width = width, .height = height};
    if (width != 0 && height > IO_IMAGE_PIXELS_MAX / width)
        return io_fail(error, "%s: %zu x %zu pixels are more than %d, the most that are read", path, width, height,
                       IO_IMAGE_PIXELS_MAX);
    image->halves = large_allocate((2 * (width + 2) * height + IO_IMAGE_ROOM) * 4 * sizeof *image->halves);
    return image->halves != NULL || io_fail(error, "%s: no memory for %zu x %zu pixels", path, width, height);
}

void io_image_free(io_image *image) {
    free(image->rgb);
    free(image->halves);
    *image = (io_image){0};
}
