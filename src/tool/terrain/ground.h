/* SPDX-License-Identifier: Apache-2.0 */
/* Common parts of the subcommands for terrain: reading it, places on its map, and writing the value
 * of each sample. */
#ifndef CELLWALK_TOOL_TERRAIN_GROUND_H
#define CELLWALK_TOOL_TERRAIN_GROUND_H

#include "../field_file.h"
#include "../progress.h"
#include "../query_options.h"
#include "../raster_options.h"
#include "place.h"
#include "raster_out.h"
#include "scale.h"
#include "terrain.h"

/* Options of all of them. */
typedef struct ground_options {
    const char *name; /* of the subcommand */
    const char *output;
    int compression; /* io_compression */
    bool cog, plain, quiet;
    option_again creation;
    raster_options raster;
    query_options query;
    /* Of those that take them (pieces.h): the texts, and what they say. */
    const char *window, *memory;
    double extent[4], bytes;
} ground_options;
enum { GROUND_OPTION_COUNT = 6 + RASTER_OPTION_COUNT + 2 };
void ground_rows(ground_options *o, const char *name, option_spec rows[GROUND_OPTION_COUNT]);

/* --curvature of products for which the earth is flat unless it is given. */
option_spec ground_flat_earth_row(double *curvature);

/* The scale of a map, if it has one. */
typedef struct ground_scale_of_map {
    bool known;
    map_scale nodes;
} ground_scale_of_map;

typedef struct ground {
    const char *path;
    const ground_options *options;
    field_file file;
    terrain terrain;
    cw_run query;
    ground_scale_of_map scale;
    progress line;
    double done, part; /* of all, before a block, and by it */
    double start;      /* seconds of the clock */

    /* For the line at the end and for pictures; each may be NULL or 0. */
    const char *counted; /* what samples are whose value is above 0: "in sight" */
    const double *marks; /* places: columns and rows of the whole raster, one after the other */
    size_t mark_count;

    /* pieces.h: */
    io_raster_options reading;
    io_raster about;            /* all of the raster: size, map and place, and samples if the file has no windows */
    terrain whole;              /* the same; no samples */
    cw_rectangle window, piece; /* samples of the product; samples in memory */
    size_t until;               /* the window's row at which the piece is no longer good for a product */
    double map[3][4];           /* of the window */
    size_t pieces, warnings;    /* that were read, and printed since then */
} ground;

/* The parts that are read at the opening. */
typedef enum ground_reading {
    GROUND_SAMPLES,
    GROUND_FIELD, /* samples, and a field of them for rays */
    GROUND_PIECES /* nothing but size, map and place: pieces.h */
} ground_reading;

/* Reads the terrain. Before that it checks that the output can be written with so many
 * bands (0: there is no output). Returns EXIT_SUCCESS, or after a message the exit status; *g then needs no closing. */
int ground_open(ground *g, ground_options *options, const char *path, size_t bands, ground_reading reading);

/* The output is none of the inputs that have been noted; an error if it is. */
bool ground_check_output(const ground *g, io_error *error);

/* Frees the terrain and returns the exit status of the work, after the message in error unless it was good. */
int ground_close(ground *g, bool good, const io_error *error);

/* --sun AZ,ALT; false after a message. */
bool ground_parse_sun(const char *name, const char *text, double sun[2]);

/* The paragraph on places in the help of all subcommands. */
#define GROUND_PLACE_HELP                                                                                              \
    "A place is X,Y,H: coordinates of the map and metres above ground, or X,Y,=Z with\n"                               \
    "an absolute height in metres, which may lie outside the raster. Samples are the\n"                                \
    "pixels' centres, so the surface ends half a pixel inside the raster's edge."

/* ground_parse_place; false after a message. */
bool ground_read_place(const char *name, const char *text, double height, ground_place *p);

/* Where the raster lies. */
const io_georef *ground_georef(const ground *g);

/* The curvature that was given, or if that is NaN the default of lines of sight. */
double ground_curvature(const ground *g, double given);

/* Finds the scale of the whole raster's map, and tells the options' warn if it is not to be had. */
void ground_find_scale(ground_scale_of_map *scale, io_raster *r, const char *path, const io_raster_options *options);

/* The terrain that a file holds; scale must stay. */
bool ground_describe_raster(terrain *t, const io_raster *r, const cw_field *field, const ground_scale_of_map *scale,
                            const char *path, io_error *error);
bool ground_describe(terrain *t, const field_file *file, const ground_scale_of_map *scale, const char *path,
                     io_error *error);

/* Metadata of a product: notes as "NAME=value". All zero: none yet. */
enum { GROUND_NOTES_MOST = 300 };
typedef struct ground_notes {
    size_t count;
    const char *notes[GROUND_NOTES_MOST + 1]; /* up to a NULL */
} ground_notes;

/* Nothing more is noted than fits. */
__attribute__((format(printf, 2, 3))) void ground_note(ground_notes *n, const char *format, ...);
void ground_notes_free(ground_notes *n);

/* The product's size, place and coordinate system. what: the meaning of a sample's number, in one sentence, and the
 * name of a single band. notes get that, the subcommand, the program's version and the surface; both must stay while
 * the product is written. */
io_raster_product ground_product(const ground *g, io_cell cell, size_t bands, const char *const *what,
                                 ground_notes *notes);

/* Fills in rows row to row + rows - 1 of a band, as long as the terrain's. */
typedef bool ground_fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error);

/* Makes a product of int16 of floats that fill fills in: each is the nearest multiple of scale, a power of two. */
void ground_scale(io_raster_product *product, double scale);

/* Makes a product block by block and writes it. passes: how often as much work as one shadow it is. */
bool ground_write(ground *g, const io_raster_product *product, double passes, ground_fill *fill, void *context,
                  io_error *error);

/* Progress of a step that lasts, for terrain_progress: context is the ground. */
bool ground_tell(void *context, double share);
/* The same, of the block that is being filled. */
bool ground_tell_block(void *context, double share);

#endif
