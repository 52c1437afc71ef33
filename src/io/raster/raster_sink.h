/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of an output format, for raster_out.c. */
#ifndef CELLWALK_IO_RASTER_SINK_H
#define CELLWALK_IO_RASTER_SINK_H

#include "raster_out.h"

/* Files beside a raster that programs read as part of it: statistics, smaller copies, masks, world files. Those of a file that is
 * replaced would be wrong for the new one, and are removed with it. Up to a NULL: ".ovr" is added to the raster's name, "*.tfw" takes
 * the place of its ending. */
typedef const char *const *io_sidecar_list;

typedef struct io_raster_sink {
    const char *ending; /* ".tif" */
    const char *what;
    size_t bands_most; /* 0: any number */
    io_sidecar_list sidecars;
    /* writer->output is open; on failure nothing is left but that. NULL: this build has no library for it. */
    bool (*create)(io_raster_writer *writer, io_error *error);
    /* Rows from band 0 and row 0 on, or for GeoTIFF any windows. */
    bool (*write)(io_raster_writer *writer, size_t band, const io_raster_window *window, const void *cells,
                  io_error *error);
    /* Ends the file, which is whole if so it says, and frees writer->state. */
    bool (*finish)(io_raster_writer *writer, bool whole, io_error *error);
} io_raster_sink;

extern const io_raster_sink io_sink_npy, io_sink_png, io_sink_tif;

#endif
