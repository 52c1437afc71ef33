/* SPDX-License-Identifier: Apache-2.0 */
/* Subcommands that make a raster of one terrain. They all run the same way: options, opening, pieces of the raster one
 * after the other, each filling its rows, the output, the line at the end. */
#ifndef CELLWALK_TOOL_TERRAIN_PRODUCT_H
#define CELLWALK_TOOL_TERRAIN_PRODUCT_H

#include "../field_options.h"
#include "ground.h"
#include "outcome.h"
#include "place.h"
#include "raster_out.h"

enum { PRODUCT_NOTES_MOST = 300, PRODUCT_TEXT = 300 };

/* Rows of a band to fill. */
typedef struct product_block {
    size_t band, row, rows; /* of the result */
    cw_area area;           /* of the piece in memory; with every > 0 it only begins there */
    cw_run run;             /* under a watch that shows progress */
} product_block;

typedef struct product {
    /* What the subcommand is; fill and what follows may be NULL. */
    void *context;
    /* Checks the command line. False after a message. *bands, 1 at first: how many the raster has; 0: none is written,
     * and begin reads the samples that it needs. */
    bool (*check)(void *context, size_t *bands);
    /* Describes the result in all fields down to the options. */
    bool (*begin)(struct product *p, io_error *error);
    bool (*fill)(struct product *p, const product_block *block, void *cells, io_error *error);
    bool (*enter)(struct product *p, io_error *error);  /* the piece in memory is another one, with a field */
    void (*leave)(void *context);                       /* it goes, and with it what enter made; also before end */
    bool (*finish)(struct product *p, io_error *error); /* the raster is written */
    void (*end)(void *context);                         /* always, if begin was called */

    /* The result. */
    io_raster_product raster; /* product_describe begins it */
    const char *what;
    size_t note_count;
    const char *notes[PRODUCT_NOTES_MOST + 1]; /* "NAME=value", up to a NULL */
    char note_texts[PRODUCT_NOTES_MOST][PRODUCT_TEXT];
    const char **band_names; /* by product_name_band; freed */
    bool in_memory;          /* begin has read all that matters */
    ground_matters matters;
    double more;         /* bytes that fill needs for each sample of a piece, beside the field and the result */
    double passes;       /* how often as much work as one shadow a row is */
    size_t every;        /* 0, or it has every so many columns and rows of the window */
    const char *counted; /* what samples are whose value is above 0: "in sight" */
    double *marks;       /* places for a picture: columns and rows of the whole raster; freed */
    size_t mark_count;

    /* Options. */
    const char *name; /* of the subcommand */
    const char *output, *window, *memory;
    bool cog, quiet;
    option_again creation;
    field_options fields;
    double extent[4]; /* of window */

    /* The work. */
    ground ground;
    size_t until;      /* the window's row at which the piece is no longer good */
    double done, part; /* of all work, before a block and by it */
    double start;      /* seconds of the clock */
} product;

/* Runs with usage's options, then the shared ones, and the operand DEM. Returns the exit status. */
int product_run(product *p, const options_usage *usage, int argc, char **argv);

/* Opens the raster, by p->fields. Returns EXIT_SUCCESS, or after a message the exit status; there is
 * then nothing to close. */
int product_open(product *p, const char *path, size_t bands);
/* Returns the exit status of the work, after the message in error unless it was good. */
int product_close(product *p, bool good, const io_error *error);

/* The path, or NULL, that an option names for a table is not a raster's; an error if it is. */
bool product_check_table(const char *path, const char *option, io_error *error);

/* The output is none of the inputs that have been noted; an error if it is. */
bool product_check_output(const product *p, io_error *error);

/* The result's size, place and coordinate system. what: the meaning of a sample's number, in one sentence, and the name
 * of a single band; it must stay. */
void product_describe(product *p, io_cell cell, size_t bands, const char *what);
/* Notes more of what was done. No more than fits. */
__attribute__((format(printf, 2, 3))) void product_note(product *p, const char *format, ...);
/* Names a band of the described result. All must get a name. */
__attribute__((format(printf, 4, 5))) bool product_name_band(product *p, size_t band, io_error *error,
                                                             const char *format, ...);

/* For product_run: makes all blocks and writes them. */
bool product_write(product *p, io_error *error);

/* Shows progress. */
void product_tell(const product *p, double share);
/* For the end of a fill: false, with the reason, unless the status is CW_OK. */
bool product_good(cw_status status, io_error *error);

/* --curvature of products for which the earth is flat unless it is given, and of lines of sight: at first NaN. */
option_spec product_flat_earth_row(double *curvature);
option_spec product_round_earth_row(double *curvature);

/* Either --sun AZ,ALT or --time, the other one being NULL; or a place. False after a message. */
bool product_parse_sun(const char *name, const char *sun, const char *time, double at[2], double *seconds);
bool product_parse_place(const char *name, const char *text, double height, io_place *p);

/* The paragraph on places in the help of all subcommands. */
#define PRODUCT_PLACE_HELP                                                                                             \
    "A place is X,Y,H: coordinates of the map and metres above ground, or X,Y,=Z with\n"                               \
    "an absolute height in metres, which may lie outside the raster. Samples are the\n"                                \
    "pixels' centres, so the surface ends half a pixel inside the raster's edge."

#endif
