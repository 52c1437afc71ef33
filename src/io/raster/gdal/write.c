/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF: tiles, compressed, a band after the other. GDAL makes a COG only as a copy of another raster, since its smaller
 * copies come first in the file: then the GeoTIFF goes to another file, and finish makes the copy. */

#include "parts.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <stdlib.h>
#include <string.h>

enum { ERROR_TEXT = 300 };

struct io_gdal_target {
    GDALDatasetH file;
    char *name;
    char *path_of_cog; /* the GeoTIFF's, if that is a copy of this file; NULL: none */
    char **cog_options;
    size_t nx, ny, tile_rows;
    GDALDataType type;
    bool failed;
};

static bool fail_write(const io_gdal_target *t, io_error *error) { return gdal_fail(error, t->name, "cannot write"); }

static void end(io_gdal_target *t) {
    CSLDestroy(t->cog_options);
    free(t->path_of_cog);
    free(t->name);
    free(t);
}

static GDALDataType type_of(io_cell cell) {
    static const GDALDataType types[] = {GDT_Byte, GDT_UInt16, GDT_Float32, GDT_Int16};
    return types[cell];
}

static bool describe(io_gdal_target *t, const io_raster_product *p) {
    const double(*m)[4] = p->map;
    if (p->georef->placed) {
        double g[6] = {m[0][3] - 0.5 * m[0][0] - 0.5 * m[0][1], m[0][0], m[0][1],
                       m[1][3] - 0.5 * m[1][0] - 0.5 * m[1][1], m[1][0], m[1][1]};
        if (GDALSetGeoTransform(t->file, g) != CE_None) return false;
    }
    if (p->georef->crs != NULL) {
        OGRSpatialReferenceH crs = OSRNewSpatialReference(p->georef->crs);
        if (crs != NULL) OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
        const bool good = crs != NULL && GDALSetSpatialRef(t->file, crs) == CE_None;
        if (crs != NULL) OSRDestroySpatialReference(crs);
        if (!good) return false;
    }
    char **notes = NULL;
    for (size_t k = 0; p->notes != NULL && p->notes[k] != NULL; k++) notes = CSLAddString(notes, p->notes[k]);
    const bool noted = notes == NULL || GDALSetMetadata(t->file, notes, NULL) == CE_None;
    CSLDestroy(notes);
    if (!noted) return false;
    for (size_t b = 0; b < p->bands; b++) {
        GDALRasterBandH band = GDALGetRasterBand(t->file, (int)b + 1);
        if (p->has_nodata && GDALSetRasterNoDataValue(band, p->nodata) != CE_None) return false;
        if (p->band_names != NULL) GDALSetDescription(band, p->band_names[b]);
        if (p->unit != NULL && GDALSetRasterUnitType(band, p->unit) != CE_None) return false;
    }
    return true;
}

static bool create(io_gdal_target *t, const char *path, const io_raster_product *p, io_error *error) {
    const size_t side[2] = {io_raster_tile_side(p->nx), io_raster_tile_side(p->ny)};
    char **options = gdal_tiff_options(p, side);
    t->file = GDALCreate(GDALGetDriverByName("GTiff"), path, (int)p->nx, (int)p->ny, (int)p->bands, t->type, options);
    CSLDestroy(options);
    return (t->file != NULL && describe(t, p)) || fail_write(t, error);
}

io_gdal_target *gdal_create(const char *path, const char *full, const char *name, const io_raster_product *p,
                            io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    io_gdal_target *t = calloc(1, sizeof *t);
    if (t == NULL) {
        io_fail(error, "%s: out of memory", name);
        return NULL;
    }
    *t = (io_gdal_target){.name = strdup(name),
                          .path_of_cog = full ? strdup(path) : NULL,
                          .nx = p->nx,
                          .ny = p->ny,
                          .tile_rows = io_raster_tile_side(p->ny),
                          .type = type_of(p->cell)};
    const bool named = (t->name && (t->path_of_cog || !full)) || io_fail(error, "%s: out of memory", name);
    if (named && create(t, full ? full : path, p, error)) {
        if (full) t->cog_options = gdal_cog_options(p);
        return t;
    }
    if (t->file != NULL) GDALClose(t->file);
    end(t);
    return NULL;
}

bool gdal_write(io_gdal_target *t, size_t band, const io_raster_window *w, const void *cells, io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    GDALRasterBandH to = GDALGetRasterBand(t->file, (int)band + 1);
    /* It takes a pointer that is not const for reading and writing alike. */
    const CPLErr status = GDALRasterIO(to, GF_Write, (int)w->i, (int)w->j, (int)w->nx, (int)w->ny,
                                       (void *)(uintptr_t)cells, (int)w->nx, (int)w->ny, t->type, 0, 0);
    /* Whole tiles go to the threads that compress, while the next ones are computed. */
    const size_t end = w->j + w->ny;
    const bool whole = end % t->tile_rows == 0 || end == t->ny;
    if (status == CE_None && (!whole || GDALFlushRasterCache(to) == CE_None)) return true;
    t->failed = true;
    return fail_write(t, error);
}

/* Whether GDAL has complained since CPLErrorReset. */
static bool has_failed(void) { return CPLGetLastErrorType() >= CE_Failure || gdal_thread_failed(); }

/* Without memory for a smaller copy of the raster, GDAL leaves it empty, forgets the error and goes on. */
static void CPL_STDCALL keep_error(CPLErr class, CPLErrorNum number, const char *text) {
    char *first = CPLGetErrorHandlerUserData();
    (void)number;
    if (class >= CE_Failure && first[0] == '\0') snprintf(first, ERROR_TEXT, "%s", text);
}

static bool copy_to_cog(io_gdal_target *t, io_error *error) {
    char first[ERROR_TEXT] = "";
    CPLErrorReset();
    CPLPushErrorHandlerEx(keep_error, first);
    GDALDatasetH copy =
        GDALCreateCopy(GDALGetDriverByName("COG"), t->path_of_cog, t->file, FALSE, t->cog_options, NULL, NULL);
    if (copy != NULL) GDALClose(copy);
    CPLPopErrorHandler();
    if (first[0] != '\0' && !has_failed()) CPLError(CE_Failure, CPLE_AppDefined, "%s", first);
    return (copy != NULL && !has_failed()) || fail_write(t, error);
}

bool gdal_finish(io_gdal_target *t, bool whole, io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    GDALFlushCache(t->file);
    bool good = !t->failed && !has_failed();
    if (!good && !t->failed) fail_write(t, error);
    if (good && whole && t->path_of_cog) good = copy_to_cog(t, error);
    CPLErrorReset();
    GDALClose(t->file);
    if (good && has_failed()) good = fail_write(t, error);
    end(t);
    return good;
}
