/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that `cellwalk render` makes, and their pixels. */
#ifndef CELLWALK_TESTS_TERRAIN_PICTURE_H
#define CELLWALK_TESTS_TERRAIN_PICTURE_H

#include "cellwalk.h"
#include "check.h"
#include "half.h"
#include "image.h"
#include "program.h"
#include "scratch.h"

#include <math.h>
#include <string.h>

/* The picture o.exr of a run without messages. */
static inline io_image picture(program_arguments arguments) {
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0 && r->err[0] == '\0', "exit status %d: %s", r->status, r->err);
    io_image image;
    io_error error;
    check(io_image_read("o.exr", &image, &error), "%s", error.text);
    return image;
}

/* As a picture's file holds it. */
static inline float as_half(double value) { return half_number(half_from_float((float)value)); }

/* A colour times light. Colours of the ground are kept as halves, which are off by 2^-11 of themselves; what is computed in floats is
 * smaller. share: how much more the samples of a pixel may differ from its middle, of the colour. The file's rounding to halves is
 * monotone: what is between two bounds stays between these rounded. */
static inline void check_pixel(const io_image *image, size_t x, size_t y, const double colour[3], double light,
                               double share) {
    const float *rgb = image->rgb + (y * image->width + x) * 3;
    for (int c = 0; c < 3; c++) {
        const double wanted = colour[c] * light, off = (6e-4 + share) * wanted;
        check(rgb[c] >= as_half(wanted - off) && rgb[c] <= as_half(wanted + off),
              "pixel (%zu, %zu) is (%g, %g, %g), not (%g, %g, %g)", x, y, (double)rgb[0], (double)rgb[1],
              (double)rgb[2], colour[0] * light, colour[1] * light, colour[2] * light);
    }
}

/* Each instruction set and number of threads makes the same picture of wall.npy with these options. */
static inline void check_same_bits(program_arguments more) {
    char *first = NULL;
    size_t size = 0;
    for (cw_isa isa = CW_ISA_SCALAR; isa <= cw_isa_best(); isa++) {
        const char *arguments[PROGRAM_ARGUMENTS_MAX] = {"render",  "wall.npy",  "--cellsize",        "10", "--size",
                                                        "300x200", "--threads", isa % 2 ? "3" : "1", "-o", "o.exr"};
        for (size_t n = 0; more[n]; n++) arguments[10 + n] = more[n];
        const program_result *r = program_run(&(program_setting){.isa = cw_isa_name(isa)}, arguments);
        check(r->status == 0, "%s", r->err);
        size_t length;
        char *bytes = scratch_read("o.exr", &length);
        check(first == NULL || (length == size && memcmp(bytes, first, size) == 0), "another picture with %s",
              cw_isa_name(isa));
        free(first);
        first = bytes;
        size = length;
    }
    free(first);
}

#endif
