/* SPDX-License-Identifier: Apache-2.0 */
/* The module's table, and GDAL made ready. */

#include "parts.h"

#include "files.h"
#include "network.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_frmts.h>
#include <string.h>

bool gdal_fail(io_error *error, const char *name, const char *what) {
    const char *words = CPLGetLastErrorMsg();
    const size_t length = strlen(name);
    /* GDAL mostly begins with the file itself. */
    if (strncmp(words, name, length) == 0 && words[length] == ':')
        words += length + 1 + strspn(words + length + 1, " ");
    if (words[0] == '\0')
        io_fail(error, "%s: %s", name, what);
    else
        io_fail(error, "%s: %s (GDAL: %s)", name, what, words);
    CPLErrorReset();
    return false;
}

void gdal_warn(const io_raster_options *options, const char *format, ...) {
    if (options->warn == NULL) return;
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    options->warn(options->context, text);
}

static void set_unless_set(const char *key, const char *value) {
    if (CPLGetConfigOption(key, NULL) == NULL) CPLSetConfigOption(key, value);
}

/* The one symbol that the module exports. */
__attribute__((visibility("default"))) const io_gdal *cellwalk_gdal_module(bool network);
const io_gdal *cellwalk_gdal_module(bool network) {
    static const io_gdal table = {
        .version = IO_GDAL_VERSION,
        .open = gdal_open,
        .read = gdal_read,
        .close = gdal_close,
        .each_file = gdal_each_file,
        .check_creation = gdal_check_creation,
        .points = gdal_points,
        .create = gdal_create,
        .write = gdal_write,
        .finish = gdal_finish,
        .lon_lat = gdal_lon_lat,
        .scales = gdal_scales,
    };
    static bool ready;
    if (ready) return &table;
    ready = true;
    CPLSetErrorHandler(CPLQuietErrorHandler); /* its text goes into the program's messages */
    gdal_files_install();
    gdal_network_close(network);
    GDALRegister_GTiff(); /* most files are GeoTIFF; other drivers are registered when needed */
    set_unless_set("GDAL_NUM_THREADS", "ALL_CPUS"); /* for compressed tiles */
    set_unless_set("GDAL_PAM_ENABLED", "NO");       /* no .aux.xml beside files read and written */
    set_unless_set("GDAL_VRT_ENABLE_PYTHON", "NO"); /* a VRT may hold code */
    /* Rasters are read and written once, from start to end: a row of tiles is all that needs keeping. The default is 5 % of
     * the machine's memory. */
    if (CPLGetConfigOption("GDAL_CACHEMAX", NULL) == NULL) GDALSetCacheMax64((GIntBig)64 << 20);
    return &table;
}
