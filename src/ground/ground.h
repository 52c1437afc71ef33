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
    size_t pieces, warnings; /* pieces read, and warnings of samples printed, so far */
    char warned[GROUND_WARNINGS][300];
} ground;

/* Reads the raster's size, map and place. path, reading, coarser, watch, query and bytes are set; the window is all. */
bool ground_open(ground *g, io_error *error);
void ground_close(ground *g);

/* All of the raster. */
cw_rectangle ground_all(const ground *g);

/* The least and greatest x and y of the samples. */
void ground_extent(const terrain *t, double low[2], double high[2]);

void ground_set_window(ground *g, cw_rectangle window);
/* The samples from xmin, ymin to xmax, ymax on the map; text is for messages. */
bool ground_find_window(ground *g, const double extent[4], const char *text, io_error *error);

/* Puts a piece, with a field or without, into the place of the one that is in memory. */
bool ground_read(ground *g, cw_rectangle piece, bool field, io_error *error);

/* Puts all of the raster there without a field, or if metres > 0 the part that a place of the map sees within them. */
bool ground_read_around(ground *g, double x, double y, double metres, io_error *error);

/* Few enough samples to read all of them where many places matter, in place of a piece for each. */
static inline bool ground_is_small(const ground *g) {
    return g->about.z != NULL || g->about.nx * g->about.ny <= (size_t)1 << 25;
}

/* Whether memory has room for a piece with a field or for a result of four bytes a sample; an error if not. more:
 * further bytes a sample. */
bool ground_fits(const ground *g, cw_rectangle piece, double more);
bool ground_check(const ground *g, cw_rectangle piece, double more, io_error *error);

/* The curvature that was given, or if that is NaN the default of lines of sight. */
double ground_curvature(const ground *g, double given);

/* ---- which samples matter to a part of a product: the rectangle to read for a band of rows, or for a Dask chunk -- */

/* What decides it. All zero: all of the raster matters. */
typedef struct ground_matters {
    double distance;      /* metres: nothing farther away; 0: no limit */
    const cw_light *suns; /* all that throws a shadow from one of these places; they must stay */
    size_t sun_count;
    bool horizons, above_level; /* all that may be a horizon, or only what is above a sample's level */
    double curvature;           /* of horizons */
} ground_matters;

typedef struct ground_plan {
    ground_matters by;
    const terrain *whole;
    cw_rectangle window;  /* of the product */
    reach_blocks blocks;  /* to be surveyed before parts are asked for, if the plan has any */
    reach_sunward toward; /* from the window, if there is one sun */
    reach_horizons reach;
    bool begun;
} ground_plan;

cw_status ground_plan_create(ground_plan *p, const ground_matters *by, const terrain *whole, cw_rectangle window);
void ground_plan_destroy(ground_plan *p);

/* Takes the lowest and highest samples of blocks, if they must be known: the window's and others of use to it. */
bool ground_plan_survey(ground_plan *p, ground *g, io_error *error);

/* The rectangle that matters to a part of the window. */
cw_status ground_plan_around(ground_plan *p, cw_rectangle part, cw_rectangle *piece);

#endif
