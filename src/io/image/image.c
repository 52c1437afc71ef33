/* SPDX-License-Identifier: Apache-2.0 */
/* Which format a picture has: by the ending of its file name. */

#include "image.h"
#include "large.h"

#include <stdlib.h>

typedef struct image_format {
    const char *ending;
    bool (*read)(const char *path, size_t most, io_image *image, io_error *error);
    bool (*write)(io_output *out, const io_image *image, io_error *error);
} image_format;

/* Those whose library was there when this was built. */
static const image_format formats[] = {
#ifdef CELLWALK_OPENEXR
    {".exr", io_exr_read, io_exr_put},
#endif
#ifdef CELLWALK_PNG
    {".png", NULL, io_png_put},
#endif
    {"", NULL, NULL}};
enum { FORMATS = sizeof formats / sizeof formats[0] - 1 };

/* Else lists those that this build can write or read; NULL. */
static const image_format *format_of(const char *path, bool writing, io_error *error) {
    char able[32] = "";
    for (int k = 0; k < FORMATS; k++) {
        if (writing ? formats[k].write == NULL : formats[k].read == NULL) continue;
        if (io_name_ends(path, formats[k].ending)) return &formats[k];
        strcat(strcat(able, " "), formats[k].ending);
    }
    io_fail(error, "%s: unknown kind of picture, or this build has no library for it; it can %s%s", path,
            writing ? "write" : "read", able[0] != '\0' ? able : " none");
    return NULL;
}

bool io_image_can_write(const char *path, io_error *error) { return format_of(path, true, error) != NULL; }

bool io_image_put(io_output *out, const io_image *image, io_error *error) {
    const image_format *format = format_of(out->name, true, error);
    return format != NULL && format->write(out, image, error);
}

bool io_image_read(const char *path, size_t most, io_image *image, io_error *error) {
    *image = (io_image){0};
    const image_format *format = format_of(path, false, error);
    return format != NULL && format->read(path, most, image, error);
}

bool io_image_allocate(io_image *image, size_t width, size_t height, size_t most, const char *path, io_error *error) {
    *image = (io_image){.width = width, .height = height};
    if (width != 0 && height > most / width)
        return io_fail(error, "%s: %zu x %zu pixels are more than %zu, for which there is room", path, width, height,
                       most);
    image->halves = large_allocate((2 * (width + 2) * height + IO_IMAGE_ROOM) * 4 * sizeof *image->halves);
    return image->halves != NULL || io_fail(error, "%s: no memory for %zu x %zu pixels", path, width, height);
}

void io_image_free(io_image *image) {
    free(image->rgb);
    large_release(image->halves);
    *image = (io_image){0};
}
