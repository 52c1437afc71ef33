/* SPDX-License-Identifier: Apache-2.0 */
/* Products of a part of a raster, and of rasters that memory does not hold: bands of rows, each from a piece of the raster that
 * has all that matters to it. */
#ifndef CELLWALK_TOOL_TERRAIN_PIECES_H
#define CELLWALK_TOOL_TERRAIN_PIECES_H

#include "ground.h"
#include "reach.h"

/* Options of subcommands that run with GROUND_PIECES. */
enum { PIECES_OPTION_COUNT = 2 };
void pieces_rows(ground_options *o, option_spec rows[PIECES_OPTION_COUNT]);

/* Checks these options' values; false after a message. */
bool pieces_resolve(ground_options *o);

/* For ground.c: the raster's size and map, and the window that is asked for. */
bool pieces_describe(ground *g, io_error *error);

/* Makes the window that rectangle of the raster. */
void pieces_set_window(ground *g, cw_rectangle window);

/* All of the raster. */
cw_rectangle pieces_all(const ground *g);

/* Puts a piece into the place of the one that is in memory. */
bool pieces_read(ground *g, cw_rectangle piece, bool field, io_error *error);

/* Whether memory has room for a piece with a field or for a result of four bytes a sample; an error if not. more: further bytes a
 * sample. */
bool pieces_fit(const ground *g, cw_rectangle piece);
bool pieces_check(const ground *g, cw_rectangle piece, double more, io_error *error);

/* Takes the blocks of the window and those that wanted says are of use: all, if it is NULL. */
typedef bool pieces_wanted(void *context, cw_rectangle block);
bool pieces_survey(ground *g, reach_blocks *blocks, pieces_wanted *wanted, void *context, io_error *error);

/* How a product is made. */
typedef struct pieces_maker {
    ground_fill *fill; /* rows are those of the piece, and as long */
    /* The samples that matter to a part of the window. Not called if all of the raster is asked for, and fits. */
    bool (*around)(void *context, cw_rectangle part, cw_rectangle *piece, io_error *error);
    bool (*enter)(void *context, io_error *error); /* the ground's terrain is another piece, with a field */
    double more;                                   /* bytes that fill needs for each sample of a piece */
    /* 0: the product has the window's samples. Otherwise it has every so many columns and rows of them, and fill writes the
     * product's columns alone; its rows are the product's. */
    size_t every;
} pieces_maker;

/* As ground_write. NULL for around and enter: the piece that is in memory has the window. */
bool pieces_write(ground *g, const io_raster_product *product, double passes, const pieces_maker *maker, void *context,
                  io_error *error);

#endif
