/* SPDX-License-Identifier: Apache-2.0 */
/* Declarations that the module's files share. */
#ifndef CELLWALK_IO_GDAL_PARTS_H
#define CELLWALK_IO_GDAL_PARTS_H

#include "module.h"

#include <gdal.h>
#include <ogr_srs_api.h>

/* Fills error with name, the text what and GDAL's last message, clears that message, and returns false. */
bool gdal_fail(io_error *error, const char *name, const char *what);
/* The same after a failure to read; says why, if it was this module or the program that kept GDAL from it. */
bool gdal_fail_read(io_error *error, const char *path, const char *what);
/* Opens a file to be read; NULL after a failure. kind: GDAL_OF_RASTER or GDAL_OF_VECTOR. */
GDALDatasetH gdal_open_name(const char *path, unsigned kind, io_error *error);
/* Notes the name of each file that a dataset is made of, and those that these name in turn, as a VRT does. False, with
 * the error, if one is such a pipe or device, or for lack of memory. Some names may be none of files. */
bool gdal_note_files(GDALDatasetH file, const char *path, io_error *error);
/* Keeps VRTs from opening the process's memory, in a process of the program's own. */
void gdal_names_close_memory(void);

const io_gdal_program *gdal_program(void);
/* NULL where GDAL is also another's. */
const io_gdal_host *gdal_host(void);
/* Whether one of GDAL's own threads has ever failed. */
bool gdal_thread_failed(void);
/* During a call of GDAL the program's standard streams are hidden; not while GDAL calls the program. */
void gdal_streams(bool shown);

/* Begins each function of the table: until it returns, the settings and messages of this thread are the module's. Not
 * for functions that these call. */
#define GDAL_CALL __attribute__((cleanup(gdal_leave), unused)) const bool entered = gdal_enter()
bool gdal_enter(void);
void gdal_leave(const bool *entered);

/* io_warn while GDAL is at work. */
__attribute__((format(printf, 2, 3))) void gdal_warn(const io_warner *to, const char *format, ...);

/* Fills in the facts of a coordinate system: well-known text, units, ellipsoid, and the unit of heights if it has
 * one. */
void gdal_describe_crs(OGRSpatialReferenceH crs, io_georef *georef);

#endif
