/* SPDX-License-Identifier: Apache-2.0 */
/* What the subcommands that ask something of a terrain have in common: reading it, places on its map, and writing what was
 * found for each sample. */
#ifndef CELLWALK_TOOL_TERRAIN_GROUND_H
#define CELLWALK_TOOL_TERRAIN_GROUND_H

#include "../field_file.h"
#include "../progress.h"
#include "../query_options.h"
#include "../raster_options.h"
#include "raster_out.h"
#include "terrain.h"

/* Options of all of them. */
typedef struct ground_options {
    const char *name; /* of the subcommand */
    const char *output;
    int compression; /* io_compression */
    raster_options raster;
    query_options query;
} ground_options;
enum { GROUND_OPTION_COUNT = 2 + RASTER_OPTION_COUNT + 2 };
void ground_rows(ground_options *o, const char *name, option_spec rows[GROUND_OPTION_COUNT]);

typedef struct ground {
    const char *path;
    const ground_options *options;
    field_file file;
    terrain terrain;
    cw_run query;
    progress line;
} ground;

/* What a subcommand does with its terrain. */
typedef bool ground_work(ground *g, void *context, io_error *error);

/* Reads the terrain, with a field if rays are to be asked of it, does the work and cleans up. An output that cannot be written
 * with so many bands (0: there is none) is refused before. Returns the exit status, after a message if it is no success. */
int ground_run(ground_options *options, const char *path, size_t bands, bool field, ground_work *work, void *context);

/* Numbers with commas between them: least to most of them; how many there are, or 0. */
size_t ground_numbers(const char *text, double *numbers, size_t least, size_t most);

/* A place on the map; over_ground: its height is that above the ground. */
typedef struct ground_place {
    double x, y, z;
    bool over_ground;
} ground_place;

/* X,Y,Z or X,Y,+HEIGHT, or X,Y, which is so much above ground. False after a message. */
bool ground_parse_place(const char *name, const char *text, double height, ground_place *p);
/* Field coordinates, and the height in the samples' numbers. */
bool ground_find_place(const terrain *t, const ground_place *p, double at[3], io_error *error);

/* The terrain that a file holds. */
bool ground_describe(terrain *t, const field_file *file, const char *path, io_error *error);

/* The product's size, place and coordinate system. */
io_raster_product ground_product(const ground *g, io_cell cell, size_t bands);

/* Fills in rows row to row + rows - 1 of a band. */
typedef bool ground_fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error);

/* Makes a product block by block and writes it. passes: how often as much work as one shadow it is. */
bool ground_write(ground *g, const io_raster_product *product, double passes, ground_fill *fill, void *context,
                  io_error *error);

/* Progress of a step that lasts, for terrain_progress: context is the ground. */
bool ground_tell(void *context, double share);

#endif
