/* SPDX-License-Identifier: Apache-2.0 */
#include "parts.h"

#include "gdal/module.h"
#include "image.h"

io_part io_part_at(size_t number) {
    io_error error;
    switch (number) {
    case 0:
        return (io_part){"GDAL", "GeoTIFF and other rasters", io_gdal_is_there()};
    case 1:
        return (io_part){"libpng", ".png", io_image_can_write("a.png", &error)};
    default:
        return (io_part){"OpenEXR", ".exr", io_image_can_write("a.exr", &error)};
    }
}
