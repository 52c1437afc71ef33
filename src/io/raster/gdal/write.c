/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF: tiles, compressed, a band after the other. */

#include "parts.h"

#include "files.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <stdlib.h>
#include <string.h>

struct io_gdal_target {
    GDALDatasetH file;
    char *name;
    int lent; /* its number among the files lent to GDAL */
    size_t nx, ny, tile_rows;
    GDALDataType type;
    bool failed;
};

/* The system's reason, if it was the system that failed: GDAL's own words name a function. */
static bool fail_write(const io_gdal_target *t, io_error *error) {
    const int reason = gdal_lent_reason(t->lent);
    if (reason == 0) return gdal_fail(error, t->name, "cannot write");
    CPLErrorReset();
    return io_fail(error, "%s: cannot write: %s", t->name, strerror(reason));
}

static void end(io_gdal_target *t) {
    if (t->lent >= 0) gdal_take_back(t->lent);
    free(t->name);
    free(t);
}

static GDALDataType type_of(io_cell cell) {
    return cell == IO_CELL_UINT8 ? GDT_Byte : cell == IO_CELL_UINT16 ? GDT_UInt16 : GDT_Float32;
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

/* Whether GDAL was built with a compression. */
static bool has_compression(GDALDriverH driver, const char *name) {
    const char *list = GDALGetMetadataItem(driver, GDAL_DMD_CREATIONOPTIONLIST, NULL);
    char value[40];
    snprintf(value, sizeof value, "<Value>%s</Value>", name);
    return list != NULL && strstr(list, value) != NULL;
}

static char **compression_options(char **options, const io_raster_product *p) {
    static const char *const names[] = {"DEFLATE", "ZSTD", "NONE"};
    options = CSLSetNameValue(options, "COMPRESS", names[p->compression]);
    if (p->compression == IO_UNCOMPRESSED) return options;
    /* Floats get hardly smaller by more, but take three times as long. */
    options = CSLSetNameValue(options, p->compression == IO_ZSTD ? "ZSTD_LEVEL" : "ZLEVEL", "1");
    return CSLSetNameValue(options, "PREDICTOR",
                           p->cell == IO_CELL_FLOAT32  ? "3"
                           : p->cell == IO_CELL_UINT16 ? "2"
                                                       : "1");
}

io_gdal_target *gdal_create(int fd, const char *name, const io_raster_product *p, io_error *error) {
    CPLErrorReset();
    io_gdal_target *t = calloc(1, sizeof *t);
    if (t == NULL || (t->name = strdup(name)) == NULL) {
        free(t);
        io_fail(error, "%s: out of memory", name);
        return NULL;
    }
    char path[GDAL_LENT_NAME];
    t->lent = gdal_lend(fd, path);
    if (t->lent < 0) {
        io_fail(error, "%s: too many files are written at once", name);
        end(t);
        return NULL;
    }
    char threads[16] = "ALL_CPUS";
    if (p->threads > 0) snprintf(threads, sizeof threads, "%u", p->threads);
    char side[2][24];
    for (int k = 0; k < 2; k++) snprintf(side[k], sizeof side[k], "%zu", io_raster_tile_side(k ? p->ny : p->nx));
    char **options = NULL;
    options = CSLSetNameValue(options, "TILED", "YES");
    options = CSLSetNameValue(options, "BLOCKXSIZE", side[0]);
    options = CSLSetNameValue(options, "BLOCKYSIZE", side[1]);
    options = compression_options(options, p);
    options = CSLSetNameValue(options, "INTERLEAVE", "BAND");
    options = CSLSetNameValue(options, "PHOTOMETRIC", "MINISBLACK");
    options = CSLSetNameValue(options, "BIGTIFF", "IF_SAFER");
    options = CSLSetNameValue(options, "NUM_THREADS", threads);
    t->nx = p->nx;
    t->ny = p->ny;
    t->tile_rows = io_raster_tile_side(p->ny);
    t->type = type_of(p->cell);
    GDALDriverH driver = GDALGetDriverByName("GTiff");
    const bool can = driver != NULL && (p->compression != IO_ZSTD || has_compression(driver, "ZSTD"));
    if (can) t->file = GDALCreate(driver, path, (int)p->nx, (int)p->ny, (int)p->bands, t->type, options);
    CSLDestroy(options);
    if (t->file != NULL && describe(t, p)) return t;
    if (can || driver == NULL)
        fail_write(t, error);
    else
        io_fail(error, "%s: GDAL was built without ZSTD; leave out --compress", name);
    if (t->file != NULL) GDALClose(t->file);
    end(t);
    return NULL;
}

bool gdal_write(io_gdal_target *t, size_t band, size_t first, size_t count, const void *cells, io_error *error) {
    CPLErrorReset();
    GDALRasterBandH to = GDALGetRasterBand(t->file, (int)band + 1);
    /* It takes a pointer that is not const for reading and writing alike. */
    const CPLErr status = GDALRasterIO(to, GF_Write, 0, (int)first, (int)t->nx, (int)count, (void *)(uintptr_t)cells,
                                       (int)t->nx, (int)count, t->type, 0, 0);
    /* Whole tiles go to the threads that compress, while the next ones are computed. */
    const size_t end = first + count;
    const bool whole = end % t->tile_rows == 0 || end == t->ny;
    if (status == CE_None && (!whole || GDALFlushRasterCache(to) == CE_None)) return true;
    t->failed = true;
    return fail_write(t, error);
}

bool gdal_finish(io_gdal_target *t, io_error *error) {
    CPLErrorReset();
    GDALFlushCache(t->file);
    bool good = !t->failed && CPLGetLastErrorType() < CE_Failure && gdal_lent_reason(t->lent) == 0;
    if (!good && !t->failed) fail_write(t, error);
    CPLErrorReset();
    GDALClose(t->file);
    if (good && (CPLGetLastErrorType() >= CE_Failure || gdal_lent_reason(t->lent) != 0)) good = fail_write(t, error);
    end(t);
    return good;
}
