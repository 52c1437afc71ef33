/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that `cellwalk render` makes, and their pixels. */
#ifndef CELLWALK_TESTS_TERRAIN_PICTURE_H
#define CELLWALK_TESTS_TERRAIN_PICTURE_H

#include "check.h"
#include "image.h"
#include "program.h"

#include <math.h>

/* The picture o.pfm of a run without messages. */
static inline io_image picture(program_arguments arguments) {
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0 && r->err[0] == '\0', "exit status %d: %s", r->status, r->err);
    io_image image;
    io_error error;
    check(io_image_read("o.pfm", &image, &error), "%s", error.text);
    return image;
}

/* A colour times light. Colours of the ground are kept as halves, which are off by 2^-11 of themselves; what is computed in floats is
 * smaller. share: how much more the samples of a pixel may differ from its middle, of the colour. */
static inline void check_pixel(const io_image *image, size_t x, size_t y, const double colour[3], double light,
                               double share) {
    const float *rgb = image->rgb + (y * image->width + x) * 3;
    for (int c = 0; c < 3; c++)
        check(fabs((double)rgb[c] - colour[c] * light) <= (6e-4 + share) * colour[c] * light,
              "pixel (%zu, %zu) is (%g, %g, %g), not (%g, %g, %g)", x, y, (double)rgb[0], (double)rgb[1],
              (double)rgb[2], colour[0] * light, colour[1] * light, colour[2] * light);
}

#endif
