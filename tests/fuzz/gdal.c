/* SPDX-License-Identifier: Apache-2.0 */
/* A raster that GDAL reads, by the way that the program takes: the module that it would load is linked in, and the file
 * lies in GDAL's own memory. Only GDAL's drivers for GeoTIFF, VRT and ASCII grids are asked, so that an input is not
 * shown to two hundred others first. A VRT may name the input as its own source, and another file beside it. */

#include "gdal/module.h"
#include "inputs.h"
#include "raster.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <string.h>

/* Few bytes may rightly ask for as many samples as a field can hold: no data, told briefly. Here it only takes time. */
static bool allocate_few(const char *path, io_raster *raster, io_error *error) {
    enum { SAMPLES_MAX = 1 << 14 };
    if (raster->nx > 0 && raster->ny > SAMPLES_MAX / raster->nx) return io_fail(error, "%s: too large", path);
    return io_raster_allocate(path, raster, error);
}

/* In place of src/io/raster/raster_gdal.c. */
const io_gdal *io_gdal_load(io_error *error) { return &cellwalk_gdal_17; }

bool io_raster_read_gdal(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    return gdal_raster(path, options, raster, error);
}

static void leave_streams(void) {}

int LLVMFuzzerInitialize(int *count, char ***arguments) {
    static const io_gdal_host host = {.hide_streams = leave_streams, .show_streams = leave_streams};
    static const io_gdal_program program = {&host, io_inputs_note_path, allocate_few, io_points_add};
    gdal_start(&program);
    GDALSetCacheMax(1 << 20);
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "none"); /* a VRT may name files of other machines */
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
    for (int k = GDALGetDriverCount(); k-- > 0;) {
        GDALDriverH driver = GDALGetDriver(k);
        const char *name = GDALGetDriverShortName(driver);
        if (strcmp(name, "GTiff") == 0 || strcmp(name, "VRT") == 0 || strcmp(name, "AAIGrid") == 0) continue;
        GDALDeregisterDriver(driver);
        GDALDestroyDriver(driver);
    }
    return 0;
}

static void pass_over(void *context, const char *text) {}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char name[] = "/vsimem/f", other[] = "/vsimem/g";
    static uint8_t grid[] = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n";
    /* The VRT driver may write where it reads, so it gets a copy. */
    uint8_t *copy = VSIMalloc(size + 1);
    if (copy == NULL) return 0;
    if (size > 0) memcpy(copy, data, size);
    VSIFCloseL(VSIFileFromMemBuffer(name, copy, size, TRUE));
    VSIFCloseL(VSIFileFromMemBuffer(other, grid, sizeof grid - 1, FALSE));
    const unsigned told = size > 0 ? data[size / 2] : 0;
    const io_raster_options options = {
        .band = told & 3, .nodata = &(double){1}, .nodata_count = (told & 4) != 0, .warn = {pass_over, NULL}};
    io_raster raster;
    io_error error;
    if (io_raster_read(name, &options, &raster, &error)) {
        volatile float sum = 0;
        for (size_t k = 0; k < raster.nx * raster.ny; k++) sum = sum + raster.z[k];
        io_raster_free(&raster);
    }
    VSIUnlink(name);
    VSIUnlink(other);
    return 0;
}
