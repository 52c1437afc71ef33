/* SPDX-License-Identifier: Apache-2.0 */
/* A raster whose format NAME tells by its ending; what can be read is made a field. */

#include "raster.h"
#include "cellwalk.h"
#include "files.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    enum { SAMPLES_MAX = 1 << 16 };
    fuzz_enter();
    fuzz_write(NAME, data, size);
    io_raster raster;
    io_error error;
    if (io_raster_read(NAME, NULL, &raster, &error)) {
        cw_field_desc desc = cw_field_desc_default();
        desc.samples = raster.z;
        desc.nx = raster.nx;
        desc.ny = raster.ny;
        memcpy(desc.map, raster.map, sizeof desc.map);
        cw_field *field = NULL;
        if (raster.nx <= SAMPLES_MAX && raster.ny <= SAMPLES_MAX / (raster.nx + 1)) cw_field_create(&desc, &field);
        cw_field_destroy(field);
        io_raster_free(&raster);
    }
    unlink(NAME);
    return 0;
}
