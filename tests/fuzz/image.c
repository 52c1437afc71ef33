/* SPDX-License-Identifier: Apache-2.0 */
/* A picture whose format NAME tells by its ending; each pixel of what can be read is looked at. */

#include "image.h"
#include "memory.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    memory_file(0, NAME, data, size);
    io_image image;
    io_error error;
    if (io_image_read(NAME, &image, &error)) {
        volatile unsigned sum = 0;
        for (size_t k = 0; k < image.width * image.height; k++)
            for (size_t c = 0; c < 4; c++)
                sum = sum + image.halves[4 * (k / image.width * (image.width + 2) + k % image.width + 1) + c];
        io_image_free(&image);
    }
    memory_done();
    return 0;
}
