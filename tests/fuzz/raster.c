/* SPDX-License-Identifier: Apache-2.0 */
/* A raster whose format NAME tells by its ending; each sample of what can be read is looked at. The input's last byte tells
 * what its reader is told beside. */

#include "raster.h"
#include "memory.h"

static void pass_over(void *context, const char *text) { (void)context, (void)text; }

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const unsigned told = size > 0 ? data[size - 1] : 0;
    const io_raster_options options = {.nodata = &(double){1},
                                       .nodata_count = (told & 16) != 0,
                                       .cellsize = told & 32 ? 2 : 0,
                                       .zscale = told & 64 ? 0.5 : 0,
                                       .band = told & 128 ? 1 : 0,
                                       .warn = pass_over};
    memory_file(0, NAME, data, size);
    io_raster raster;
    io_error error;
    if (io_raster_read(NAME, &options, &raster, &error)) {
        volatile float sum = 0;
        for (size_t k = 0; k < raster.nx * raster.ny; k++) sum = sum + raster.z[k];
        for (int r = 0; r < 3; r++) sum = sum + (float)(raster.map[r][r] > 0);
        io_raster_free(&raster);
    }
    memory_done();
    return 0;
}
