/* SPDX-License-Identifier: Apache-2.0 */
/* The creation options of GeoTIFFs: the program's, and those that the user passes on. */

#include "parts.h"

#include "cpus.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal_frmts.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static GDALDriverH driver_of(bool cog) {
    if (cog) GDALRegister_COG();
    return GDALGetDriverByName(cog ? "COG" : "GTiff");
}

bool gdal_check_creation(const char *const *creation, size_t count, bool cog, io_error *error) {
    GDAL_CALL;
    GDALDriverH driver = driver_of(cog);
    const char *kind = cog ? "--co with --cog" : "--co";
    if (driver == NULL) return io_fail(error, "--cog: GDAL was built without its driver COG");
    char **list = NULL;
    bool good = true;
    for (size_t k = 0; k < count && good; k++) {
        good = strchr(creation[k], '=') != NULL;
        if (!good) io_fail(error, "%s takes NAME=VALUE, not '%s'", kind, creation[k]);
        list = CSLAddString(list, creation[k]);
    }
    CPLErrorReset();
    /* GDAL itself only warns, and writes a file of another kind than the user wanted. */
    if (good && list != NULL)
        good = GDALValidateCreationOptions(driver, list) != 0 || gdal_fail(error, kind, "refused");
    CSLDestroy(list);
    return good;
}

/* Each of the user's takes the place of one of the program's; a compression that of all that belongs to it. */
static char **replace(char **options, const io_raster_product *p) {
    static const char *const compression[] = {"LEVEL", "ZLEVEL", "PREDICTOR"};
    for (size_t k = 0; k < p->creation_count; k++)
        if (strncasecmp(p->creation[k], "COMPRESS=", 9) == 0)
            for (size_t c = 0; c < sizeof compression / sizeof compression[0]; c++)
                options = CSLSetNameValue(options, compression[c], NULL);
    for (size_t k = 0; k < p->creation_count; k++) {
        char *name = NULL;
        const char *value = CPLParseNameValue(p->creation[k], &name);
        if (name != NULL) options = CSLSetNameValue(options, name, value);
        CPLFree(name);
    }
    return options;
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

/* Whether the system lets so many threads run beside those that there are. Three times as many are tried: those tried count against
 * limits for a moment after they were joined, others of this user start threads as well, and stacks must not take the last memory. */
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

/* Those of all files, and more. BIGTIFF goes by the size before compression, which is larger as a rule: 2 GB of 4 are enough for
 * what is added then. */
static char **make_options(const io_raster_product *p, const char *more) {
    char text[300];
    snprintf(text, sizeof text, "COMPRESS=%s BIGTIFF=IF_SAFER NUM_THREADS=%u %s", p->uncompressed ? "NONE" : "DEFLATE",
             choose_threads(p), more);
    return CSLTokenizeString(text);
}

char **gdal_tiff_options(const io_raster_product *p, const size_t side[2]) {
    static const char *const predictors[] = {"1", "2", "3", "2"}; /* by the kind of cell */
    char text[200];
    /* Floats get hardly smaller by higher levels, but take three times as long. */
    snprintf(text, sizeof text, "TILED=YES BLOCKXSIZE=%zu BLOCKYSIZE=%zu INTERLEAVE=BAND PHOTOMETRIC=MINISBLACK %s%s",
             side[0], side[1],
             p->uncompressed ? "" : "ZLEVEL=1 PREDICTOR=", p->uncompressed ? "" : predictors[p->cell]);
    char **options = make_options(p, text);
    return limit_threads(p->cog ? options : replace(options, p)); /* those of the user are for the COG */
}

char **gdal_cog_options(const io_raster_product *p) {
    /* Flags and counts have no mean. GDAL's cubic one leaves the range of the values. */
    const bool counts = p->cell == IO_CELL_UINT8 || p->cell == IO_CELL_UINT16;
    char text[80];
    snprintf(text, sizeof text, "%sOVERVIEW_RESAMPLING=%s", p->uncompressed ? "" : "LEVEL=1 PREDICTOR=YES ",
             counts ? "NEAREST" : "AVERAGE");
    return limit_threads(replace(make_options(p, text), p));
}
