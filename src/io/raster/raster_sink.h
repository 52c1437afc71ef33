/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of an output format, for raster_out.c. */
#ifndef CELLWALK_IO_RASTER_SINK_H
#define CELLWALK_IO_RASTER_SINK_H

#include "raster_out.h"

typedef struct io_raster_sink {
    const char *ending; /* ".tif" */
    const char *what;
    size_t bands_most; /* 0: any number */
    /* writer->output is open; on failure nothing is left but that. NULL: this build has no library for it. */
    bool (*create)(io_raster_writer *writer, io_error *error);
    /* rows rows of band writer->band from row writer->row on. */
    bool (*write)(io_raster_writer *writer, const void *cells, size_t rows, io_error *error);
    /* Ends the file, which is whole if so it says, and frees writer->state. */
    bool (*finish)(io_raster_writer *writer, bool whole, io_error *error);
} io_raster_sink;

extern const io_raster_sink io_sink_npy, io_sink_png, io_sink_tif;

#endif
