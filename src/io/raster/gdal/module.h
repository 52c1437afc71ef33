/* SPDX-License-Identifier: Apache-2.0 */
/* The interface of the module with GDAL to the program that loads it. GDAL and the hundred libraries that it brings
 * take long to load, three quarters of that for finding symbols, so only the module is linked to it, and the module is
 * loaded when a file needs it. */
#ifndef CELLWALK_IO_GDAL_MODULE_H
#define CELLWALK_IO_GDAL_MODULE_H

#include "inputs.h"
#include "map_scale.h"
#include "points.h"
#include "raster.h"
#include "raster_out.h"

/* The program's functions that the module calls; it is not linked to them. */
typedef struct io_gdal_program {
    const io_gdal_host *host; /* NULL where the process is not the program's own */
    __typeof__(io_inputs_note_path) *note;
    __typeof__(io_raster_allocate) *allocate;
    __typeof__(io_points_add) *add;
} io_gdal_program;

/* ---- functions of the module, which the program reaches through the table below ---------------------------------- */

/* Before any other. program must stay. */
void gdal_start(const io_gdal_program *program);

/* io_raster_read_gdal, io_points_read and io_areas_read of files that GDAL reads. All files of a raster are noted. */
bool gdal_raster(const char *path, const io_raster_options *options, io_raster *raster, io_error *error);
bool gdal_points(const char *path, const io_points_options *options, io_points *points, io_error *error);
bool gdal_areas(const char *path, const io_points_options *options, const io_mask *mask, io_error *error);

/* io_raster_check_creation. */
bool gdal_check_creation(const char *const *creation, size_t count, bool cog, io_error *error);
/* Makes a GeoTIFF of the file at path, which is there and empty; of a COG, one that will have all rows until the COG is
 * made of it. writer->state is the module's. */
bool gdal_create(io_raster_writer *writer, const char *path, io_error *error);
bool gdal_write(io_raster_writer *writer, size_t band, const io_raster_window *window, const void *cells,
                io_error *error);
/* Closes the file; false if the data did not reach it. path_of_cog: the COG's, which is there and empty; GDAL makes
 * more files of names that begin with it, and removes them. NULL: none is made. */
bool gdal_finish(io_raster_writer *writer, const char *path_of_cog, io_error *error);

/* Longitude and latitude (WGS 84, degrees) of n places of a coordinate system, or the other way round; in place. */
bool gdal_lon_lat(const char *crs, bool back, size_t n, double *x, double *y, io_error *error);

/* The scale of a projected system over a raster, in metres on its ellipsoid. *sheared: the greatest cosine of the angle
 * between the map's x and y there. */
bool gdal_scale(const char *crs, double map[3][4], size_t nx, size_t ny, map_scale *scale, double *sheared,
                io_error *error);

#define IO_GDAL_FUNCTIONS(F)                                                                                           \
    F(start) F(raster) F(points) F(areas) F(check_creation) F(create) F(write) F(finish) F(lon_lat) F(scale)
#define IO_GDAL_FIELD(name) __typeof__(gdal_##name) *name;
typedef struct io_gdal {
    IO_GDAL_FUNCTIONS(IO_GDAL_FIELD)
} io_gdal;

/* The one symbol that the module exports. Its name ends in the version of this interface. */
#define IO_GDAL_SYMBOL "cellwalk_gdal_17"
extern const io_gdal cellwalk_gdal_17;

/* In the program: loads the module at the first call. NULL, with the reason, if it is not there. */
const io_gdal *io_gdal_load(io_error *error);

#endif
