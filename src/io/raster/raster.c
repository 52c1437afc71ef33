/* SPDX-License-Identifier: Apache-2.0 */
/* The table of raster formats.
 *
 * The formats have readers of their own, against the habit of leaving formats to a well-kept library. GDAL reads all of
 * them, but (GDAL 3.6.2) it takes a word in an ASCII grid for 0, lowers 1e99 to the largest float and overlooks numbers
 * that are too many, all without an error; and linking it makes a program start in 59 ms that starts in 1 ms without. */

#include "raster.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>

static const io_raster_format *const formats[] = {&io_raster_npy, &io_raster_pgm, &io_raster_asc};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

static bool has_ending(const char *path, const io_raster_format *format) {
    const char *ending = strrchr(path, '.');
    if (ending == NULL) return false;
    const size_t length = strlen(ending);
    for (const char *e = format->endings; *e; e += strspn(e, " ")) {
        const size_t n = strcspn(e, " ");
        if (n == length && strncasecmp(e, ending, n) == 0) return true;
        e += n;
    }
    return false;
}

bool io_raster_read(const char *path, io_raster *raster, io_error *error) {
    *raster = (io_raster){0};
    char list[256] = "";
    size_t used = 0;
    for (size_t k = 0; k < FORMAT_COUNT; k++) {
        if (has_ending(path, formats[k])) return formats[k]->read(path, raster, error);
        if (used < sizeof list)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%s (%s)", k ? ", " : "", formats[k]->endings,
                                     formats[k]->name);
    }
    return io_fail(error, "%s: the name's ending tells no raster format; known are %s", path, list);
}

bool io_raster_allocate(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error) {
    *raster = (io_raster){.nx = nx, .ny = ny, .map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    if (ny == 0 || nx <= SIZE_MAX / sizeof(float) / ny) {
        const size_t bytes = nx * ny * sizeof(float);
        raster->memory = malloc(bytes > 0 ? bytes : 1);
    }
    raster->z = raster->memory;
    return raster->memory != NULL || io_fail(error, "%s: out of memory for %zu x %zu samples", path, nx, ny);
}

void io_raster_free(io_raster *raster) {
    if (raster->mapped_bytes > 0)
        munmap(raster->memory, raster->mapped_bytes);
    else
        free(raster->memory);
    *raster = (io_raster){0};
}
