/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters to files: values computed for each sample of a terrain, written row by row. The ending of the name says the
 * format: .tif (GeoTIFF in compressed tiles, with the terrain's coordinate system), .npy (a NumPy array), .png (a
 * picture, with a world file beside it if the terrain has a map). The file is renamed into place when complete. */
#ifndef CELLWALK_IO_RASTER_OUT_H
#define CELLWALK_IO_RASTER_OUT_H

#include "georef.h"
#include "output.h"

typedef enum io_cell { IO_CELL_UINT8, IO_CELL_UINT16, IO_CELL_FLOAT32, IO_CELL_INT16 } io_cell;

/* The raster to write. */
typedef struct io_raster_product {
    size_t nx, ny, bands;
    io_cell cell;
    const double (*map)[4];  /* of the terrain: samples to the coordinates of the file's map */
    const io_georef *georef; /* of the terrain */
    bool has_nodata;
    double nodata;
    /* For GeoTIFF, each may be NULL. */
    const char *const *band_names; /* one for each band */
    const char *unit;              /* of the values */
    const char *const *notes;      /* metadata as "NAME=value", up to a NULL */
    unsigned threads;              /* that may compress, if the file is large; 0: as many as there are CPUs */
    bool uncompressed;
    bool cog; /* Cloud Optimized GeoTIFF: smaller copies within, written in a second pass by io_raster_commit */
    /* GDAL's creation options as "NAME=VALUE"; they replace the program's own. */
    const char *const *creation;
    size_t creation_count;
} io_raster_product;

typedef struct io_raster_writer {
    const struct io_raster_sink *sink; /* the format */
    io_raster_product product;
    io_output output, beside[2]; /* a picture's world file; of a COG the GeoTIFF before it, and its smaller copies */
    size_t band, row;            /* that come next */
    uint64_t left;               /* cells that are still to come */
    void *state;                 /* the format's */
} io_raster_writer;

static inline size_t io_cell_bytes(io_cell cell) {
    static const size_t bytes[] = {1, 2, 4, 2};
    return bytes[cell];
}

/* Whether the name's ending is a raster's, also of a format that this build lacks. */
bool io_raster_is_name(const char *path);
/* Whether it is that of a GeoTIFF. */
bool io_raster_is_tif(const char *path);
/* Whether it is that of a picture. */
bool io_raster_is_png(const char *path);

/* The side of a GeoTIFF's tiles along so many samples: 256 or less, so that the last tile is nearly full too, whose
 * rest is compressed for nothing. To be written fast, rows come in whole tiles. */
static inline size_t io_raster_tile_side(size_t samples) {
    enum { MOST = 256, MULTIPLE = 16 }; /* TIFF requires multiples of 16 */
    const size_t tiles = (samples + MOST - 1) / MOST, side = (samples + tiles - 1) / tiles;
    return (side + MULTIPLE - 1) / MULTIPLE * MULTIPLE;
}

/* True if this build and this machine can write the ending, with so many bands; else error lists those that can be. */
bool io_raster_can_write(const char *path, size_t bands, io_error *error);

/* False if GDAL has no such creation option for GeoTIFFs, or the option no such value. */
bool io_raster_check_creation(const char *const *creation, size_t count, bool cog, io_error *error);

/* On failure writer needs no discard. */
bool io_raster_create(io_raster_writer *writer, const char *path, const io_raster_product *product, io_error *error);
/* The next rows: band after band, each from row 0 on. Of a picture, all at once; cells are three bytes, its colours. */
bool io_raster_write(io_raster_writer *writer, const void *cells, size_t rows, io_error *error);
/* A rectangle of a band, in any order, each cell once; of a GeoTIFF alone. */
bool io_raster_write_window(io_raster_writer *writer, size_t band, const io_raster_window *window, const void *cells,
                            io_error *error);
/* False too if an old file's sidecar (raster_out.c) cannot be removed: then the new file is complete all the same. */
bool io_raster_commit(io_raster_writer *writer, io_error *error);
/* Does nothing on a writer that is all zero, committed or discarded. */
void io_raster_discard(io_raster_writer *writer);

#endif
