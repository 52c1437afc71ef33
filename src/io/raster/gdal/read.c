/* SPDX-License-Identifier: Apache-2.0 */
/* One band of any raster file that GDAL reads, as heights. */

#include "parts.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct source {
    GDALDatasetH file;
    GDALRasterBandH band;
    const char *path;
    const io_raster_options *options;
    int i, j, nx; /* the first sample and the length of a row that is read */
    bool direct;  /* samples are floats as they are stored, or exact as floats: read in place */
    bool integer; /* stored as integers: no-data is compared with the stored value */
    double scale, offset;
    bool has_nodata, has_mask;
    double nodata; /* as the file stores it */
    double *row;   /* a row as stored, unless direct */
    unsigned char *mask;
} source;

static double height_unit(const char *name) {
    static const struct {
        const char *names;
        double metres;
    } units[] = {
        {"|m|metre|metres|meter|meters|", 1},
        {"|ft|foot|feet|international foot|", 0.3048},
        {"|us-ft|us survey foot|ftus|ft-us|foot_us|us foot|sft|", 1200.0 / 3937},
        {"|km|", 1000},
        {"|dm|decimetre|decimeter|", 0.1},
        {"|cm|centimetre|centimeter|", 0.01},
        {"|mm|millimetre|millimeter|", 0.001},
    };
    char word[64];
    snprintf(word, sizeof word, "|%s|", name);
    for (size_t k = 0; k < sizeof units / sizeof units[0]; k++)
        if (strcasestr(units[k].names, word) != NULL) return units[k].metres;
    return 0;
}

/* Pixel corners to pixel centres: a sample stands in the middle of its pixel, and GDAL gives corners for files of
 * either convention. */
static void place(const source *s, io_raster *raster) {
    static const double none[6] = {0, 1, 0, 0, 0, 1};
    double g[6];
    if (GDALGetGeoTransform(s->file, g) == CE_None && memcmp(g, none, sizeof g) != 0) {
        const double map[3][4] = {{g[1], g[2], 0, g[0] + 0.5 * g[1] + 0.5 * g[2]},
                                  {g[4], g[5], 0, g[3] + 0.5 * g[4] + 0.5 * g[5]},
                                  {0, 0, 1, 0}};
        memcpy(raster->map, map, sizeof map);
        raster->georef.placed = true;
    } else if (GDALGetGCPCount(s->file) > 0) {
        gdal_warn(&s->options->warn,
                  "%s: is placed by ground control points only, which are passed over; gdalwarp makes a map of it",
                  s->path);
    }
    OGRSpatialReferenceH crs = GDALGetSpatialRef(s->file);
    if (raster->georef.placed) gdal_describe_crs(crs, &raster->georef);
    OGRAxisOrientation way = OAO_Other;
    if (crs != NULL && OSRIsCompound(crs) && OSRGetAxis(crs, "VERT_CS", 0, &way) != NULL && way == OAO_Down)
        gdal_warn(&s->options->warn, "%s: its vertical system counts depths; they are taken as heights, unturned",
                  s->path);
}

static void describe_heights(source *s, io_raster *raster) {
    const char *unit = GDALGetRasterUnitType(s->band);
    if (unit != NULL && unit[0] != '\0') {
        const double metres = height_unit(unit);
        if (metres > 0)
            raster->georef.height_unit = metres;
        else if (s->options->zscale == 0)
            gdal_warn(&s->options->warn,
                      "%s: the unit of heights, '%s', is unknown and read as the map's unit; --zscale gives another",
                      s->path, unit);
    }
    int given = 0;
    s->scale = GDALGetRasterScale(s->band, &given);
    if (!given || s->scale == 0) s->scale = 1;
    s->offset = GDALGetRasterOffset(s->band, &given);
    if (!given) s->offset = 0;
    if (s->scale != 1 || s->offset != 0) {
        raster->georef.scale = s->scale;
        raster->georef.offset = s->offset;
    }
    s->nodata = GDALGetRasterNoDataValue(s->band, &given);
    s->has_nodata = given != 0 && !isnan(s->nodata);
    if (s->has_nodata) {
        raster->georef.has_nodata = true;
        raster->georef.nodata = s->nodata;
    }
    const int flags = GDALGetMaskFlags(s->band);
    s->has_mask = (flags & (GMF_ALL_VALID | GMF_NODATA)) == 0;
}

/* Chooses how samples are read, and makes the buffers. */
static bool prepare(source *s, io_error *error) {
    const GDALDataType type = GDALGetRasterDataType(s->band);
    if (GDALDataTypeIsComplex(type)) return io_fail(error, "%s: holds complex numbers, which are no heights", s->path);
    s->integer = type != GDT_Float32 && type != GDT_Float64;
    const bool exact = type == GDT_Byte || type == GDT_Int16 || type == GDT_UInt16 || type == GDT_Float32;
    s->direct = exact && s->scale == 1 && s->offset == 0;
    if (!s->direct) s->row = malloc((size_t)s->nx * sizeof *s->row);
    if (s->has_mask) s->mask = malloc((size_t)s->nx);
    return ((s->direct || s->row) && (!s->has_mask || s->mask)) || io_fail(error, "%s: out of memory", s->path);
}

static bool choose_band(source *s, io_error *error) {
    const int bands = GDALGetRasterCount(s->file);
    const unsigned wanted = s->options->band;
    if (bands == 0) {
        char **parts = GDALGetMetadata(s->file, "SUBDATASETS");
        const char *first = CSLFetchNameValue(parts, "SUBDATASET_1_NAME");
        return first ? io_fail(error, "%s: holds several rasters; name one of them, such as '%s'", s->path, first)
                     : io_fail(error, "%s: holds no raster", s->path);
    }
    if (wanted > (unsigned)bands)
        return io_fail(error, "%s: has %d band%s, not %u", s->path, bands, bands == 1 ? "" : "s", wanted);
    if (wanted == 0 && bands > 1)
        gdal_warn(&s->options->warn, "%s: has %d bands, and the first is read as heights; --band chooses another",
                  s->path, bands);
    s->band = GDALGetRasterBand(s->file, wanted > 0 ? (int)wanted : 1);
    return s->band != NULL || gdal_fail(error, s->path, "cannot read the band");
}

static bool open_band(source *s, io_raster *raster, io_error *error) {
    const io_raster_window *w = &s->options->window;
    s->file = gdal_open_name(s->path, GDAL_OF_RASTER, error);
    if (s->file == NULL || !choose_band(s, error)) return false;
    raster->nx = (size_t)GDALGetRasterXSize(s->file);
    raster->ny = (size_t)GDALGetRasterYSize(s->file);
    place(s, raster);
    if (!io_raster_cut(s->options, s->path, raster, error)) return false;
    s->i = (int)w->i;
    s->j = (int)w->j;
    s->nx = (int)raster->nx;
    describe_heights(s, raster);
    return prepare(s, error);
}

/* Rows of a GeoTIFF's blocks are read once each, so two are enough to keep: the memory of old blocks serves new ones.
 * Other formats may read a block again, as VRTs do their sources'. GDAL's default is 5 % of the machine's memory. */
static void limit_cache(const source *s, size_t block_rows) {
    static const double least = 1 << 22, most = 1 << 26;
    if (gdal_host() == NULL || CPLGetConfigOption("GDAL_CACHEMAX", NULL) != NULL) return;
    const double sample = GDALGetDataTypeSizeBytes(GDALGetRasterDataType(s->band)) * GDALGetRasterCount(s->file);
    const double bytes = 2 * sample * (double)block_rows * GDALGetRasterXSize(s->file);
    const bool once = strcmp(GDALGetDriverShortName(GDALGetDatasetDriver(s->file)), "GTiff") == 0;
    GDALSetCacheMax64((GIntBig)(once ? fmin(fmax(bytes, least), most) : most));
}

/* Values that mean no data become NaN; value is the one that the file stores. */
static bool is_no_data(const source *s, double value) {
    bool is = s->has_nodata && value == s->nodata;
    for (size_t k = 0; k < s->options->nodata_count; k++) is |= value == s->options->nodata[k];
    return is;
}

/* Drops the file's no-data value, compared as float: headers may spell it so rounded. raster.c drops the caller's. */
static void drop_no_data(const source *s, float *z) {
    const float value = (float)s->nodata;
    for (int i = 0; i < s->nx && s->has_nodata; i++) z[i] = z[i] == value ? NAN : z[i];
}

static bool convert(const source *s, size_t row, float *z, io_error *error) {
    for (size_t i = 0; i < (size_t)s->nx; i++) {
        const double value = s->row[i], height = s->offset + s->scale * value;
        const bool hole = is_no_data(s, value) || (!s->integer && s->has_nodata && (float)value == (float)s->nodata);
        z[i] = hole ? NAN : (float)height;
        if (!hole && isinf(z[i]) && isfinite(value))
            return io_fail(error, "%s: the sample in row %zu, column %zu is %g, beyond the range of float", s->path,
                           row, i, height);
    }
    return true;
}

static bool read_band(const source *s, GDALRasterBandH band, size_t first, size_t count, GDALDataType type, void *to,
                      io_error *error) {
    return GDALRasterIO(band, GF_Read, s->i, s->j + (int)first, s->nx, (int)count, to, s->nx, (int)count, type, 0, 0) ==
               CE_None ||
           gdal_fail_read(error, s->path, band == s->band ? "cannot read" : "cannot read the mask");
}

static bool read_rows(const source *s, size_t first, size_t count, float *z, io_error *error) {
    CPLErrorReset();
    if (s->direct && !read_band(s, s->band, first, count, GDT_Float32, z, error)) return false;
    for (size_t row = first; row < first + count; row++, z += s->nx) {
        if (s->direct)
            drop_no_data(s, z);
        else if (!read_band(s, s->band, row, 1, GDT_Float64, s->row, error) || !convert(s, row, z, error))
            return false;
        if (!s->has_mask) continue;
        if (!read_band(s, GDALGetMaskBand(s->band), row, 1, GDT_Byte, s->mask, error)) return false;
        for (int i = 0; i < s->nx; i++)
            if (s->mask[i] == 0) z[i] = NAN;
    }
    return true;
}

/* Whole rows of blocks, some megabytes of them at a time. */
static bool read_all(const source *s, io_raster *raster, io_error *error) {
    int across = 0, down = 0;
    GDALGetBlockSize(s->band, &across, &down);
    const size_t nx = raster->nx, ny = raster->ny, block = down > 0 ? (size_t)down : 1, room = (size_t)1 << 22,
                 bytes = block * nx * sizeof(float), at_once = block * (bytes < room ? room / bytes : 1);
    limit_cache(s, block);
    for (size_t j = 0; j < ny; j += at_once) {
        gdal_leave(NULL); /* a callable of Python's may use GDAL too */
        const bool on = io_raster_progress(s->options, s->path, (double)j / (double)ny, error);
        gdal_enter();
        if (!on || !read_rows(s, j, ny - j < at_once ? ny - j : at_once, raster->memory + j * nx, error)) return false;
    }
    return true;
}

static bool make_room(const char *path, io_raster *raster, io_error *error) {
    const uint64_t most_samples = (uint64_t)1 << 31; /* a field numbers them by 31 bits */
    if ((uint64_t)raster->nx * raster->ny > most_samples)
        return io_fail(error,
                       "%s: %zu x %zu samples are more than a field can hold; gdal_translate -srcwin cuts a part out",
                       path, raster->nx, raster->ny);
    return gdal_program()->allocate(path, raster, error);
}

bool gdal_raster(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    GDAL_CALL;
    source s = {.path = path, .options = options};
    bool good = open_band(&s, raster, error) && gdal_note_files(s.file, path, error);
    if (!options->no_samples) good = good && make_room(path, raster, error) && read_all(&s, raster, error);
    if (s.file) GDALClose(s.file);
    free(s.row);
    free(s.mask);
    return good;
}
