/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF, .hgt, VRT, PGM, Erdas, NetCDF and all others that GDAL reads: loads the module with GDAL. */

#include "gdal/module.h"
#include "inputs.h"
#include "linux.h"
#include "raster.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *const module_name = "cellwalk_gdal.so";

/* Whether the module lies in the folder of a file, or a way from there. */
static bool is_beside(const char *file, const char *way, char path[PATH_MAX]) {
    const char *slash = strrchr(file, '/');
    return slash != NULL &&
           snprintf(path, PATH_MAX, "%.*s%s/%s", (int)(slash - file), file, way, module_name) < PATH_MAX &&
           access(path, R_OK) == 0;
}

/* Where the module may lie: where CELLWALK_MODULES says; beside the shared object that this code is in, as in Python's
 * package; beside the program, as it is built; and where it is installed, a way from the program's folder that moves
 * with it. Without Linux's /proc the program is not known. */
static bool find_module(char path[PATH_MAX]) {
    static const char here;
    char program[PATH_MAX] = "";
    const char *given = getenv("CELLWALK_MODULES");
    if (given != NULL)
        return snprintf(path, PATH_MAX, "%s/%s", given, module_name) < PATH_MAX && access(path, R_OK) == 0;
#if CELLWALK_LINUX
    if (readlink("/proc/self/exe", program, sizeof program - 1) < 0) program[0] = '\0'; /* no /proc here */
#endif
    Dl_info object;
    return (dladdr(&here, &object) != 0 && is_beside(object.dli_fname, "", path)) || is_beside(program, "", path) ||
           is_beside(program, "/" CELLWALK_MODULES_FROM_PROGRAM, path);
}

static io_gdal_program program = {NULL, io_inputs_note_path, io_raster_allocate, io_points_add};

void io_raster_host(const io_gdal_host *host) { program.host = host; }

const io_gdal *io_gdal_load(io_error *error) {
    static const io_gdal *loaded;
    if (loaded != NULL) return loaded;
    char path[PATH_MAX];
    if (!find_module(path)) {
        io_fail(error,
                "cellwalk was built without GDAL (Debian: libgdal-dev), or its module %s is not where it belongs",
                module_name);
        return NULL;
    }
    if (program.host && !program.host->prepare(program.host->network, error)) return NULL;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const io_gdal *module = library ? dlsym(library, IO_GDAL_SYMBOL) : NULL;
    if (module == NULL) {
        const char *reason = library ? "its module belongs to another version of cellwalk" : dlerror();
        io_fail(error, "cannot load GDAL: %s", reason ? reason : path);
        if (library) dlclose(library);
        return NULL;
    }
    module->start(&program);
    return loaded = module;
}

bool io_raster_read_gdal(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    io_error reason;
    const io_gdal *gdal = io_gdal_load(&reason);
    if (gdal == NULL)
        return io_fail(error,
                       "%s: only .npy is read without GDAL; GeoTIFF, ASCII grids and all other rasters need it: %s",
                       path, reason.text);
    return gdal->raster(path, options, raster, error);
}
