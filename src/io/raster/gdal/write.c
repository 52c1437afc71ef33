/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF: tiles, compressed, a band after the other. GDAL makes a COG only from a finished file, since its smaller
 * copies come first: the GeoTIFF then goes to another file, and finish makes the copy. */

#include "parts.h"

#include "cpus.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { ERROR_TEXT = 300 };

/* ---- creation options: the program's, and those that the user passes on ------------------------------------------ */

static GDALDriverH driver_of(bool cog) { return GDALGetDriverByName(cog ? "COG" : "GTiff"); }

static char **list_of(const char *const *creation, size_t count) {
    char **list = NULL;
    for (size_t k = 0; k < count; k++) list = CSLAddString(list, creation[k]);
    return list;
}

bool gdal_check_creation(const char *const *creation, size_t count, bool cog, io_error *error) {
    GDAL_CALL;
    const char *kind = cog ? "--co with --cog" : "--co";
    if (driver_of(cog) == NULL) return io_fail(error, "--cog: GDAL was built without its driver COG");
    for (size_t k = 0; k < count; k++) {
        if (strchr(creation[k], '=') == NULL) return io_fail(error, "%s takes NAME=VALUE, not '%s'", kind, creation[k]);
        /* A world file would have the temporary file's name; the others are lossy. */
        static const char *const refused[] = {"TFW=", "WORLDFILE=", "NBITS=", "COMPRESS=JPEG", "COMPRESS=WEBP"};
        for (size_t r = 0; r < sizeof refused / sizeof *refused; r++)
            if (strncasecmp(creation[k], refused[r], strlen(refused[r])) == 0)
                return io_fail(error, "%s %s: it would change values, or leave a second file", kind, creation[k]);
    }
    char **list = list_of(creation, count);
    CPLErrorReset();
    /* GDAL itself only warns, and writes a file of another kind than the user wanted. */
    const bool good =
        list == NULL || GDALValidateCreationOptions(driver_of(cog), list) || gdal_fail(error, kind, "refused");
    CSLDestroy(list);
    return good;
}

/* Threads that compress. A small file is written before they have started. */
enum { THREADS_MAX = 16 };
static const double bytes_of_a_large_file = 1 << 24;

static unsigned choose_threads(const io_raster_product *p) {
    const double bytes = (double)io_cell_bytes(p->cell) * (double)p->nx * (double)p->ny * (double)p->bands;
    if (p->uncompressed || bytes < bytes_of_a_large_file) return 1;
    const unsigned count = p->threads > 0 ? p->threads : cpus_usable();
    return count < THREADS_MAX ? count : THREADS_MAX;
}

static void *wait_for_end(void *lock) {
    void *block = malloc(1); /* glibc reserves addresses for each thread that allocates */
    pthread_mutex_lock(lock);
    pthread_mutex_unlock(lock);
    free(block);
    return NULL;
}

/* Whether the system lets so many more threads run. Three times as many are tried: those tried count against limits for
 * a moment after they were joined, others of this user start threads too, and stacks must not take the last memory. */
static bool threads_can_start(unsigned wanted) {
    const unsigned count = 3 * wanted;
    pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_t *threads = calloc(count, sizeof *threads);
    unsigned started = 0;
    pthread_mutex_lock(&lock);
    while (threads && started < count && pthread_create(&threads[started], NULL, wait_for_end, &lock) == 0) started++;
    pthread_mutex_unlock(&lock);
    for (unsigned k = 0; k < started; k++) pthread_join(threads[k], NULL);
    free(threads);
    return started == count;
}

/* GDAL starts the threads as soon as it has the options, and waits for ever for one that the system refuses. */
static char **limit_threads(char **options) {
    const char *asked = CSLFetchNameValueDef(options, "NUM_THREADS", "1");
    const long count = strcasecmp(asked, "ALL_CPUS") == 0 ? (long)cpus_usable() : strtol(asked, NULL, 10);
    return count > 1 && !(count <= CPUS_MAX && threads_can_start((unsigned)count))
               ? CSLSetNameValue(options, "NUM_THREADS", "1")
               : options;
}

/* The program's, of which each of the user's takes the place of one; a compression that of all that belongs to it. The
 * GeoTIFF that a COG is copied from has none of the user's. BIGTIFF goes by the size before compression, which is
 * larger as a rule: 2 GB of 4 are enough for what is added then. */
static char **make_options(const io_raster_product *p, bool cog) {
    /* Flags and small counts have long runs, for PackBits. Higher Deflate levels take thrice as long on floats. */
    static const char *const usual[] = {"COMPRESS=PACKBITS", "COMPRESS=DEFLATE ZLEVEL=1 PREDICTOR=2",
                                        "COMPRESS=DEFLATE ZLEVEL=1 PREDICTOR=3",
                                        "COMPRESS=DEFLATE ZLEVEL=1 PREDICTOR=2"};
    char **own = p->cog == cog ? list_of(p->creation, p->creation_count) : NULL;
    const char *compression = cog ? "COMPRESS=DEFLATE LEVEL=1 PREDICTOR=YES" : usual[p->cell];
    char text[300], more[200];
    if (!cog && p->cell == IO_CELL_UINT8 && (CSLFetchNameValue(own, "ZLEVEL") || CSLFetchNameValue(own, "PREDICTOR")))
        compression = "COMPRESS=DEFLATE ZLEVEL=1";
    if (CSLFetchNameValue(own, "COMPRESS")) compression = "";
    if (p->uncompressed) compression = "COMPRESS=NONE";
    if (cog) /* Flags and counts have no mean. GDAL's cubic one leaves the range of the values. */
        snprintf(more, sizeof more, "OVERVIEW_RESAMPLING=%s",
                 p->cell == IO_CELL_UINT8 || p->cell == IO_CELL_UINT16 ? "NEAREST" : "AVERAGE");
    else
        snprintf(more, sizeof more, "TILED=YES BLOCKXSIZE=%zu BLOCKYSIZE=%zu INTERLEAVE=BAND PHOTOMETRIC=MINISBLACK",
                 io_raster_tile_side(p->nx), io_raster_tile_side(p->ny));
    snprintf(text, sizeof text, "%s BIGTIFF=IF_SAFER NUM_THREADS=%u %s", compression, choose_threads(p), more);
    char **options = CSLMerge(CSLTokenizeString(text), own);
    CSLDestroy(own);
    return limit_threads(options);
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

static bool fail_write(const io_raster_writer *w, io_error *error) {
    return gdal_fail(error, w->output.name, "cannot write");
}

static const GDALDataType types[] = {GDT_Byte, GDT_UInt16, GDT_Float32, GDT_Int16}; /* by the kind of cell */

static bool describe(GDALDatasetH file, const io_raster_product *p) {
    const double(*m)[4] = p->map;
    if (p->georef->placed) {
        double g[6] = {m[0][3] - 0.5 * m[0][0] - 0.5 * m[0][1], m[0][0], m[0][1],
                       m[1][3] - 0.5 * m[1][0] - 0.5 * m[1][1], m[1][0], m[1][1]};
        if (GDALSetGeoTransform(file, g) != CE_None) return false;
    }
    if (p->georef->crs != NULL) {
        OGRSpatialReferenceH crs = OSRNewSpatialReference(p->georef->crs);
        if (crs != NULL) OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
        const bool good = crs != NULL && GDALSetSpatialRef(file, crs) == CE_None;
        OSRDestroySpatialReference(crs);
        if (!good) return false;
    }
    char **notes = NULL;
    for (size_t k = 0; p->notes != NULL && p->notes[k] != NULL; k++) notes = CSLAddString(notes, p->notes[k]);
    const bool noted = notes == NULL || GDALSetMetadata(file, notes, NULL) == CE_None;
    CSLDestroy(notes);
    for (size_t b = 0; b < p->bands && noted; b++) {
        GDALRasterBandH band = GDALGetRasterBand(file, (int)b + 1);
        if (p->has_nodata && GDALSetRasterNoDataValue(band, p->nodata) != CE_None) return false;
        if (p->band_names != NULL) GDALSetDescription(band, p->band_names[b]);
        if (p->unit != NULL && GDALSetRasterUnitType(band, p->unit) != CE_None) return false;
    }
    return noted;
}

bool gdal_create(io_raster_writer *w, const char *path, io_error *error) {
    GDAL_CALL;
    const io_raster_product *p = &w->product;
    CPLErrorReset();
    char **options = make_options(p, false);
    w->state = GDALCreate(driver_of(false), path, (int)p->nx, (int)p->ny, (int)p->bands, types[p->cell], options);
    CSLDestroy(options);
    if (w->state != NULL && describe(w->state, p)) return true;
    fail_write(w, error);
    if (w->state != NULL) GDALClose(w->state);
    return false;
}

bool gdal_write(io_raster_writer *w, size_t band, const io_raster_window *at, const void *cells, io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    GDALRasterBandH to = GDALGetRasterBand(w->state, (int)band + 1);
    const int nx = (int)at->nx, ny = (int)at->ny;
    const CPLErr status = GDALRasterIO(to, GF_Write, (int)at->i, (int)at->j, nx, ny, (void *)(uintptr_t)cells, nx, ny,
                                       types[w->product.cell], 0, 0);
    /* Whole tiles go to the threads that compress, while the next ones are computed. */
    const size_t end = at->j + at->ny;
    const bool whole = end % io_raster_tile_side(w->product.ny) == 0 || end == w->product.ny;
    return (status == CE_None && (!whole || GDALFlushRasterCache(to) == CE_None)) || fail_write(w, error);
}

/* Whether GDAL has complained since CPLErrorReset. */
static bool has_failed(void) { return CPLGetLastErrorType() >= CE_Failure || gdal_thread_failed(); }

/* Without memory for a smaller copy of the raster, GDAL leaves it empty, forgets the error and goes on. */
static void CPL_STDCALL keep_error(CPLErr class, CPLErrorNum number, const char *text) {
    char *first = CPLGetErrorHandlerUserData();
    (void)number;
    if (class >= CE_Failure && first[0] == '\0') snprintf(first, ERROR_TEXT, "%s", text);
}

static bool copy_to_cog(const io_raster_writer *w, const char *path, io_error *error) {
    char first[ERROR_TEXT] = "", **options = make_options(&w->product, true);
    CPLErrorReset();
    CPLPushErrorHandlerEx(keep_error, first);
    GDALDatasetH copy = GDALCreateCopy(driver_of(true), path, w->state, FALSE, options, NULL, NULL);
    if (copy != NULL) GDALClose(copy);
    CPLPopErrorHandler();
    CSLDestroy(options);
    if (first[0] != '\0' && !has_failed()) CPLError(CE_Failure, CPLE_AppDefined, "%s", first);
    return (copy != NULL && !has_failed()) || fail_write(w, error);
}

bool gdal_finish(io_raster_writer *w, const char *path_of_cog, io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    GDALFlushCache(w->state);
    bool good = !has_failed() || fail_write(w, error);
    if (good && path_of_cog) good = copy_to_cog(w, path_of_cog, error);
    CPLErrorReset();
    GDALClose(w->state);
    return good && (!has_failed() || fail_write(w, error));
}
