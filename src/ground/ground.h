/* SPDX-License-Identifier: Apache-2.0 */
/* A DEM on its map, of which pieces are read as products need them. */
#ifndef CELLWALK_GROUND_GROUND_H
#define CELLWALK_GROUND_GROUND_H

#include "raster_field.h"
#include "reach.h"
#include "terrain.h"

enum { GROUND_WARNINGS = 4 }; /* of samples: most that are printed */

typedef struct ground {
    const char *path;
    io_raster_options reading;
    ground_coarser coarser;
    ground_watch watch;
    cw_run query;
    double bytes; /* limit on memory */

    io_raster about; /* all of the raster: size, map and place, and samples if the file has no windows */
    map_scale nodes; /* the scale of its map, which the terrains use if it has one */
    terrain whole;   /* the raster, without samples */

    cw_rectangle window; /* the samples that are asked for */
    double map[3][4];    /* of the window */

    raster_field file; /* the piece in memory */
    cw_rectangle piece;
    terrain terrain;
    size_t pieces, warnings; /* that were read, and printed since then */
    char warned[GROUND_WARNINGS][300];
} ground;

/* Reads the raster's size, map and place. path, reading, coarser, watch, query and bytes are set; the window is all of it. */
bool ground_open(ground *g, io_error *error);
void ground_close(ground *g);

/* All of the raster. */
cw_rectangle ground_all(const ground *g);

void ground_set_window(ground *g, cw_rectangle window);
/* The samples from xmin, ymin to xmax, ymax on the map; text is for messages. */
bool ground_find_window(ground *g, const double extent[4], const char *text, io_error *error);

/* Puts a piece, with a field or without, into the place of the one that is in memory. */
bool ground_read(ground *g, cw_rectangle piece, bool field, io_error *error);

/* Puts all of the raster there without a field, or if metres is above 0 the part that a place of the map sees within so many of them. */
bool ground_read_around(ground *g, double x, double y, double metres, io_error *error);

/* Few enough samples to read all of them where many places matter, in place of a piece for each. */
static inline bool ground_is_small(const ground *g) {
    return g->about.z != NULL || g->about.nx * g->about.ny <= (size_t)1 << 25;
}

/* Whether memory has room for a piece with a field or for a result of four bytes a sample; an error if not. more: further bytes a
 * sample. */
bool ground_fits(const ground *g, cw_rectangle piece, double more);
bool ground_check(const ground *g, cw_rectangle piece, double more, io_error *error);

/* Takes the blocks of the window and those that wanted says are of use: all, if it is NULL. */
typedef bool ground_wanted(void *context, cw_rectangle block);
bool ground_survey(ground *g, reach_blocks *blocks, ground_wanted *wanted, void *context, io_error *error);

/* The curvature that was given, or if that is NaN the default of lines of sight. */
double ground_curvature(const ground *g, double given);

#endif
