/* SPDX-License-Identifier: Apache-2.0 */
/* A raster that GDAL reads, by the way that the program takes: what it would load is linked to this program, and the file lies
 * in GDAL's own memory. Only GDAL's drivers for GeoTIFF, VRT and ASCII grids are asked, so that an input is not shown to two
 * hundred others first. A VRT may name the input as its own source, and another file beside it. */

#include "gdal/module.h"
#include "raster.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *count, char ***arguments);
io_gdal_entry cellwalk_gdal_module;

/* Where the program loads the module from: here, it has it. AddressSanitizer also calls this, before it is at work. */
static char own;
static bool asked;
#define BEFORE_ALL __attribute__((no_sanitize("address", "undefined", "coverage")))

BEFORE_ALL void *__wrap_dlopen(const char *path, int mode);
void *__real_dlopen(const char *path, int mode);
void *__wrap_dlopen(const char *path, int mode) { return asked ? &own : __real_dlopen(path, mode); }

BEFORE_ALL void *__wrap_dlsym(void *handle, const char *name);
void *__real_dlsym(void *handle, const char *name);
void *__wrap_dlsym(void *handle, const char *name) {
    return handle == &own ? (void *)(uintptr_t)&cellwalk_gdal_module : __real_dlsym(handle, name);
}

int __wrap_access(const char *path, int mode); /* it is looked for before it is loaded */
int __real_access(const char *path, int mode);
int __wrap_access(const char *path, int mode) { return asked ? 0 : __real_access(path, mode); }

/* Few bytes may ask for as many samples as a field can hold, and rightly: no data, told briefly. Here that takes time alone. */
bool __real_io_raster_allocate(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error);
bool __wrap_io_raster_allocate(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error);
bool __wrap_io_raster_allocate(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error) {
    enum { SAMPLES_MAX = 1 << 14 };
    *raster = (io_raster){0};
    if (nx > 0 && ny > SAMPLES_MAX / nx) return io_fail(error, "%s: too large", path);
    return __real_io_raster_allocate(path, nx, ny, raster, error);
}

static bool prepare(bool network, io_error *error) { return (void)error, !network; }
static void leave_streams(void) {}

int LLVMFuzzerInitialize(int *count, char ***arguments) {
    static const io_gdal_host host = {.prepare = prepare, .hide_streams = leave_streams, .show_streams = leave_streams};
    static const char *const kept[] = {"GTiff", "VRT", "AAIGrid"};
    (void)count, (void)arguments;
    io_raster_host(&host);
    io_error error;
    asked = true;
    if (io_gdal_load(&error) == NULL) abort();
    asked = false;
    GDALSetCacheMax(1 << 20);
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "none"); /* a VRT may name files of other machines */
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
    for (int k = GDALGetDriverCount(); k-- > 0;) {
        GDALDriverH driver = GDALGetDriver(k);
        bool keep = false;
        for (size_t n = 0; n < sizeof kept / sizeof kept[0]; n++)
            keep = keep || strcmp(GDALGetDriverShortName(driver), kept[n]) == 0;
        if (keep) continue;
        GDALDeregisterDriver(driver);
        GDALDestroyDriver(driver);
    }
    return 0;
}

static void pass_over(void *context, const char *text) { (void)context, (void)text; }

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
        .band = told & 3, .nodata = &(double){1}, .nodata_count = (told & 4) != 0, .warn = pass_over};
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
