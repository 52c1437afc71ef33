/* SPDX-License-Identifier: Apache-2.0 */
/* Position, coordinate system, units and scale of a raster. */
#ifndef CELLWALK_IO_GEOREF_H
#define CELLWALK_IO_GEOREF_H

#include "io_error.h"
#include "map_scale.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct io_georef {
    bool placed;        /* the map is the file's, or follows from a cell size that was given; else it is the identity */
    bool geographic;    /* map x is longitude and y latitude */
    double unit;        /* metres in one of map x and y, or radians if it is geographic; 0: not known */
    double height_unit; /* metres in one of the file's heights; 0: not known */
    double semi_major, inverse_flattening; /* of a geographic map's ellipsoid, the first in metres; 0 of a sphere */
    char *crs;                             /* the coordinate system as well-known text (WKT); NULL: not known */
    bool has_nodata;
    double nodata;        /* the value that means no data in the file */
    double scale, offset; /* heights are offset + scale times the file's numbers; scale 0: they are these numbers */
} io_georef;

/* Samples from (i, j) on. */
typedef struct io_raster_window {
    size_t i, j, nx, ny;
} io_raster_window;

void io_georef_free(io_georef *georef);

/* The name that the coordinate system has in its well-known text, cut to size; "" if it has none. */
void io_georef_name(const io_georef *georef, char *name, size_t size);

/* A unit of so many metres, as "US survey ft" or "x 0.5 m"; "" if that is not above 0. text has room
 * for a byte more, so that a blank can be put before it. */
enum { IO_UNIT_NAME = 40 };
void io_unit_name(double metres, char *text);

/* Fills in crs, geographic, unit and ellipsoid from well-known text, of which it reads only these parts. For the
 * Python module, which gets the text from others; with files GDAL reads it. False if it is not well-known text. */
bool io_georef_from_wkt(io_georef *georef, const char *wkt);

/* Fills in the scale over nx × ny samples of a projected map. False if the map is no projected one, or its scale cannot
 * be had. Warns, by a sentence without a full stop that begins with name, where that matters: if the scale is not
 * known, and if it differs by direction or along a row by more than 1 %, which a map_scale does not have. */
bool io_scale_find(const io_georef *georef, double map[3][4], size_t nx, size_t ny, const char *name,
                   const io_warner *warn, map_scale *scale);

#endif
