/* SPDX-License-Identifier: Apache-2.0 */
#include "curvature.h"

#include <string.h>

bool curvature_lower(io_raster *raster, const sight *s, const char *path, io_raster *lowered, io_error *error) {
    if (!io_raster_allocate(path, raster->nx, raster->ny, lowered, error)) return false;
    float *z = lowered->memory;
    for (size_t j = 0; j < raster->ny; j++)
        for (size_t i = 0; i < raster->nx; i++)
            z[j * raster->nx + i] =
                (float)((double)raster->z[j * raster->nx + i] - sight_fall(s, (double)i, (double)j));
    memcpy(lowered->map, raster->map, sizeof lowered->map);
    lowered->georef = raster->georef;
    raster->georef = (io_georef){0};
    return true;
}
