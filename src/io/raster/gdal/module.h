/* SPDX-License-Identifier: Apache-2.0 */
/* The interface of the module with GDAL to the program that loads it. GDAL and the hundred libraries that it brings take
 * 40 to 60 ms to load, three quarters of that for finding symbols, so only the module is linked to it, and the module is loaded when a file needs it. */
#ifndef CELLWALK_IO_GDAL_MODULE_H
#define CELLWALK_IO_GDAL_MODULE_H

#include "map_scale.h"
#include "points.h"
#include "raster.h"
#include "raster_out.h"

enum { IO_GDAL_VERSION = 15 };
#define IO_GDAL_SYMBOL "cellwalk_gdal_module"

/* ---- functions of the module, which the program reaches through the table below ------------------------------------------ */

/* Reads a band of a file as heights, scale and offset applied, NaN where there are none, into memory by allocate, which is
 * io_raster_allocate; calls note with names of the files that it is made of. On failure raster must be freed, too. */
bool gdal_raster(const char *path, const io_raster_options *options, bool (*note)(const char *path),
                 bool (*allocate)(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error),
                 io_raster *raster, io_error *error);

/* Gives places from a file of features to add, and names of the files that it is made of to note. */
bool gdal_points(const char *path, const io_points_options *options, io_points *points,
                 bool (*add)(io_points *points, const io_point *point), bool (*note)(const char *path),
                 io_error *error);

/* Sets the bytes of samples inside the polygons of a file of features. */
bool gdal_areas(const char *path, const io_points_options *options, const io_mask *mask, bool (*note)(const char *path),
                io_error *error);

/* False unless GDAL knows these count creation options, "NAME=VALUE", of GeoTIFFs. */
bool gdal_check_creation(const char *const *creation, size_t count, bool cog, io_error *error);
/* Makes a GeoTIFF of the file at path, which is there and empty; of a COG, one that will have all rows until the COG is made of it.
 * writer->state is the module's. */
bool gdal_create(io_raster_writer *writer, const char *path, io_error *error);
bool gdal_write(io_raster_writer *writer, size_t band, const io_raster_window *window, const void *cells,
                io_error *error);
/* Closes the file; false if the data did not reach it. path_of_cog: the COG's, which is there and empty; GDAL makes more files of names that
 * begin with it, and removes them. NULL: none is made. */
bool gdal_finish(io_raster_writer *writer, const char *path_of_cog, io_error *error);

/* Longitude and latitude (WGS 84, degrees) of n places of a coordinate system, or the other way round; in place. */
bool gdal_lon_lat(const char *crs, bool back, size_t n, double *x, double *y, io_error *error);

/* The scale of a projected system over a raster, in metres on its ellipsoid. *sheared: the greatest cosine of the angle between the
 * map's x and y there. */
bool gdal_scale(const char *crs, double map[3][4], size_t nx, size_t ny, map_scale *scale, double *sheared,
                io_error *error);

#define IO_GDAL_FUNCTIONS(F)                                                                                           \
    F(raster) F(points) F(areas) F(check_creation) F(create) F(write) F(finish) F(lon_lat) F(scale)
#define IO_GDAL_FIELD(name) __typeof__(gdal_##name) *name;
typedef struct io_gdal {
    int version; /* IO_GDAL_VERSION as the module was built */
    IO_GDAL_FUNCTIONS(IO_GDAL_FIELD)
} io_gdal;

/* What the module exports under the name IO_GDAL_SYMBOL. host: NULL where the process is not the program's own. */
typedef const io_gdal *io_gdal_entry(const io_gdal_host *host);

/* In the program: loads the module at the first call. NULL, with the reason, if it is not there. */
const io_gdal *io_gdal_load(io_error *error);

#endif
