/* SPDX-License-Identifier: Apache-2.0 */
/* Places from files: rows of a table (.csv) with the columns x, y and, if there, height, weight and name; or the features of any other
 * file, which GDAL reads, with such attributes. */
#ifndef CELLWALK_IO_POINTS_H
#define CELLWALK_IO_POINTS_H

#include "io_error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct io_point {
    double x, y;   /* on the map */
    double height; /* NaN: not given */
    double weight; /* 1: not given */
    bool absolute; /* the height; in a table "=12" */
    size_t number; /* the line of the table, or the feature, from 0 on, as GDAL counts */
    size_t part;   /* places with the same number here are the corners of one line; 0 for points */
    char name[48]; /* cut to that; "": none */
} io_point;

typedef struct io_points {
    const char *path;
    bool is_table;
    bool has_lines;  /* part counts */
    bool has_weight; /* there is such a column */
    size_t count, room;
    io_point *points;
} io_points;

/* The request. */
typedef struct io_points_options {
    const char *layer; /* NULL: the only one */
    const char *crs;   /* well-known text that GDAL's places are brought to, if the file has another; NULL: none */
    /* NULL, or called with a warning: a sentence without a full stop that names the file. */
    void (*warn)(void *context, const char *text);
    void *context;
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

/* For the readers: false if memory is short. */
bool io_points_add(io_points *points, const io_point *point);

/* For messages: file, line or feature, and name. */
void io_points_name(const io_points *points, size_t k, char *text, size_t size);

#endif
