/* SPDX-License-Identifier: Apache-2.0 */
#include "curvature.h"

#include "ground.h"

#include <string.h>

option_spec curvature_around_eye_row(double *curvature) {
    option_spec row = ground_flat_earth_row(curvature);
    row.help = "the earth's curvature as a factor: 0 for a flat earth\n(default), 1 without air, 0.857 with usual "
               "refraction;\nterrain is lowered around the eye that --from places, and\nshadows are those of the "
               "lowered terrain";
    return row;
}

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
