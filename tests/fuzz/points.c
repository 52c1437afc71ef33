/* SPDX-License-Identifier: Apache-2.0 */
/* Places from a table; each that can be read is looked at. */

#include "points.h"
#include "memory.h"

static void pass_over(void *context, const char *text) { (void)context, (void)text; }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    memory_file(0, "points.csv", data, size);
    const io_points_options options = {.warn = pass_over};
    io_points points;
    io_error error;
    if (io_points_read("points.csv", &options, &points, &error)) {
        volatile double sum = 0;
        for (size_t k = 0; k < points.count; k++) {
            const io_point *p = &points.points[k];
            sum = sum + p->x + p->y + p->height + p->weight + (double)p->number;
        }
        io_points_free(&points);
    }
    memory_done();
    return 0;
}
