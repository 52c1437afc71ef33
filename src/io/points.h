/* SPDX-License-Identifier: Apache-2.0 */
/* Places from files: rows of a table (.csv) with the columns x, y and, if there, height, weight and name; or the
 * features of any other file, which GDAL reads, with such attributes. */
#ifndef CELLWALK_IO_POINTS_H
#define CELLWALK_IO_POINTS_H

#include "table.h"

#include <stddef.h>
#include <stdint.h>

/* Where a place is from. */
typedef enum io_place_kind { IO_PLACE_TEXT, IO_PLACE_ROW, IO_PLACE_FEATURE } io_place_kind;

typedef struct io_place {
    double x, y, z; /* on the map; z: metres above the ground, or absolute */
    double weight;  /* of an observer there, in a sum of many; 1: not given */
    double along;   /* metres from a line's first corner; NaN: stands at a given place */
    bool absolute;  /* z; in a table "=12" */
    io_place_kind from;
    const char *text; /* as it was given, or the path of the file; must stay */
    size_t number;    /* the line of the table, or the feature, from 0 on, as GDAL counts */
    size_t part;      /* places with the same number here are the corners of one line; 0 for points */
    size_t order;     /* among those that were added */
    char name[48];    /* cut to that; "": none */
} io_place;

/* For messages: the text that was given; else file, line or feature, name, and place, in the caller's memory. */
enum { IO_PLACE_ROOM = 400 };
const char *io_place_text(const io_place *p, char text[IO_PLACE_ROOM]);

/* The place in a row of a table; numbers from its number of columns on are columns that it lacks, and then *p stays. */
bool io_place_take(const io_table *t, size_t row, size_t x, size_t y, size_t height, size_t name, io_place *p,
                   io_error *error);

typedef struct io_points {
    bool has_lines;  /* part counts */
    bool has_weight; /* there is such a column */
    bool has_names;  /* of some */
    size_t count, room;
    io_place *list;
} io_points;

/* The request. */
typedef struct io_points_options {
    double height;     /* of places without one, above the ground */
    const char *layer; /* NULL: the only one */
    const char *crs;   /* well-known text that GDAL's places are brought to, if the file has another; NULL: none */
    io_warner warn;
} io_points_options;

/* path must stay. A file without places is an error. On failure the points need no freeing. */
bool io_points_read(const char *path, const io_points_options *options, io_points *points, io_error *error);
void io_points_free(io_points *points);

/* A byte for each sample, row by row. */
typedef struct io_mask {
    const double (*map)[4]; /* of samples to the map */
    size_t nx, ny;
    uint8_t *inside;
} io_mask;

/* Sets the bytes of samples inside the polygons of a file of features, which GDAL draws; it must hold some. */
bool io_areas_read(const char *path, const io_points_options *options, const io_mask *mask, io_error *error);

/* False if memory is short. */
bool io_points_add(io_points *points, const io_place *place);

#endif
