/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFF and the like: what GDAL, asked directly, writes into files comes out as heights at the right places, and what is
 * written is found by GDAL again. */

#include "check.h"
#include "gdal/module.h"
#include "raster.h"
#include "raster_out.h"
#include "scratch.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NX = 5, NY = 4, N = NX * NY };

/* A file for a test: all zero is a GeoTIFF of one band of floats, 10 m apart, in UTM. */
typedef struct source {
    const char *name;
    GDALDataType type;
    int bands;
    const char *crs; /* "": none */
    const double *transform;
    const double *nodata;
    double scale, offset;
    const char *unit, *point;
    bool mask;
    int nx, ny;
} source;

static const double utm[6] = {600000, 10, 0, 5200000, 0, -10};

static double value(int band, size_t k) { return 100.0 * band + (double)k; }

static void make(const source *s) {
    GDALAllRegister();
    const int bands = s->bands ? s->bands : 1, nx = s->nx ? s->nx : NX, ny = s->ny ? s->ny : NY;
    const GDALDataType type = s->type != GDT_Unknown ? s->type : GDT_Float32;
    char **options = s->nx > 100 ? CSLSetNameValue(NULL, "TILED", "YES") : NULL;
    GDALDatasetH file = GDALCreate(GDALGetDriverByName("GTiff"), s->name, nx, ny, bands, type, options);
    CSLDestroy(options);
    assert_non_null(file);
    GDALSetGeoTransform(file, (double *)(uintptr_t)(s->transform ? s->transform : utm));
    const char *system = s->crs ? s->crs : "EPSG:32632";
    if (system[0] != '\0') {
        OGRSpatialReferenceH crs = OSRNewSpatialReference(NULL);
        assert_int_equal(OSRSetFromUserInput(crs, system), OGRERR_NONE);
        GDALSetSpatialRef(file, crs);
        OSRDestroySpatialReference(crs);
    }
    if (s->point) GDALSetMetadataItem(file, "AREA_OR_POINT", s->point, NULL);
    CPLSetConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    if (s->mask) assert_int_equal(GDALCreateDatasetMaskBand(file, GMF_PER_DATASET), CE_None);
    for (int b = 1; b <= bands; b++) {
        GDALRasterBandH band = GDALGetRasterBand(file, b);
        if (s->nodata) GDALSetRasterNoDataValue(band, *s->nodata);
        if (s->scale != 0) GDALSetRasterScale(band, s->scale);
        if (s->offset != 0) GDALSetRasterOffset(band, s->offset);
        if (s->unit) GDALSetRasterUnitType(band, s->unit);
        for (int j = 0; j < ny; j++)
            for (int i = 0; i < nx; i++) {
                double v = value(b, (size_t)j * (size_t)nx + (size_t)i);
                unsigned char kept = i == 2 ? 0 : 255;
                assert_int_equal(GDALRasterIO(band, GF_Write, i, j, 1, 1, &v, 1, 1, GDT_Float64, 0, 0), CE_None);
                if (s->mask)
                    assert_int_equal(
                        GDALRasterIO(GDALGetMaskBand(band), GF_Write, i, j, 1, 1, &kept, 1, 1, GDT_Byte, 0, 0),
                        CE_None);
            }
    }
    GDALClose(file);
}

typedef struct words {
    char text[2048];
} words;

static void hear(void *context, const char *text) {
    words *w = context;
    strncat(w->text, text, sizeof w->text - strlen(w->text) - 2);
    strcat(w->text, "\n");
}

static io_raster read_well(const char *name, const io_raster_options *options) {
    io_raster r;
    io_error error = {""};
    check(io_raster_read(name, options, &r, &error), "%s", error.text);
    return r;
}

static void check_map(const io_raster *r, const double wanted[3][4]) {
    for (int k = 0; k < 12; k++)
        check(fabs(r->map[k / 4][k % 4] - wanted[k / 4][k % 4]) <= 1e-12 * fabs(wanted[k / 4][k % 4]),
              "map[%d][%d] is %.17g, not %.17g", k / 4, k % 4, r->map[k / 4][k % 4], wanted[k / 4][k % 4]);
}

static void check_refused(const char *name, const io_raster_options *options, const char *part) {
    io_raster r;
    io_error error = {""};
    check(!io_raster_read(name, options, &r, &error), "%s was taken for a raster", name);
    check(strstr(error.text, name) != NULL, "%s is not named in '%s'", name, error.text);
    check(strstr(error.text, part) != NULL, "'%s' is not in '%s'", part, error.text);
}

/* Before anything else loads the module. */
static void without_the_module(void **state) {
    (void)state;
    char *modules = strdup(getenv("CELLWALK_MODULES"));
    setenv("CELLWALK_MODULES", "/nonexistent", 1);
    make(&(source){.name = "a.tif"});
    check_refused("a.tif", NULL, "libgdal-dev");
    check_refused("a.tif", NULL, "only .npy is read without GDAL");
    io_error error;
    assert_false(io_raster_can_write("out.tif", 1, &error));
    check(strstr(error.text, ".npy and .png do without") != NULL, "%s", error.text);
    setenv("CELLWALK_MODULES", modules, 1);
    free(modules);
}

static void samples_stand_at_pixel_centres(void **state) {
    (void)state;
    static const double map[3][4] = {{10, 0, 0, 600005}, {0, -10, 0, 5199995}, {0, 0, 1, 0}};
    make(&(source){.name = "area.tif"});
    make(&(source){.name = "point.tif", .point = "Point"});
    static const char *const names[] = {"area.tif", "point.tif"};
    for (size_t f = 0; f < 2; f++) {
        io_raster r = read_well(names[f], NULL);
        assert_int_equal(r.nx, NX);
        assert_int_equal(r.ny, NY);
        for (size_t k = 0; k < N; k++) assert_true(r.z[k] == (float)value(1, k));
        check_map(&r, map);
        assert_true(r.georef.placed && !r.georef.geographic && r.georef.unit == 1);
        char name[64];
        io_georef_name(&r.georef, name, sizeof name);
        assert_string_equal(name, "WGS 84 / UTM zone 32N");
        io_raster_free(&r);
    }
    static const double turned[6] = {1000, 3, 4, 2000, 4, -3};
    static const double turned_map[3][4] = {{3, 4, 0, 1003.5}, {4, -3, 0, 2000.5}, {0, 0, 1, 0}};
    make(&(source){.name = "turned.tif", .transform = turned, .crs = ""});
    io_raster r = read_well("turned.tif", NULL);
    check_map(&r, turned_map);
    assert_true(r.georef.placed && r.georef.crs == NULL && r.georef.unit == 0);
    io_raster_free(&r);
}

static void values_become_heights(void **state) {
    (void)state;
    static const double none = 107;
    static const GDALDataType types[] = {GDT_Byte,  GDT_UInt16,  GDT_Int16,  GDT_UInt32,
                                         GDT_Int32, GDT_Float32, GDT_Float64};
    for (size_t t = 0; t < sizeof types / sizeof types[0]; t++)
        for (int scaled = 0; scaled < 2; scaled++) {
            make(&(source){.name = "v.tif",
                           .type = types[t],
                           .nodata = &none,
                           .scale = scaled ? 0.25 : 0,
                           .offset = scaled ? -3 : 0});
            const io_raster_options options = {.nodata = (const double[]){109, 108}, .nodata_count = 2};
            io_raster r = read_well("v.tif", &options);
            for (size_t k = 0; k < N; k++) {
                const double v = value(1, k), wanted = scaled ? 0.25 * v - 3 : v;
                check(k >= 7 && k <= 9 ? isnan(r.z[k]) : r.z[k] == (float)wanted, "type %d: sample %zu is %g",
                      (int)types[t], k, (double)r.z[k]);
            }
            assert_true(r.georef.has_nodata);
            io_raster_free(&r);
        }
    /* The lowest float is written in headers with more digits than a float has. */
    static const double lowest = -3.4028234663852886e38;
    make(&(source){.name = "low.tif", .nodata = &lowest});
    GDALDatasetH file = GDALOpen("low.tif", GA_Update);
    float z = -3.4028234663852886e38f;
    assert_int_equal(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 1, 1, 1, 1, &z, 1, 1, GDT_Float32, 0, 0),
                     CE_None);
    GDALClose(file);
    io_raster r = read_well("low.tif", NULL);
    assert_true(isnan(r.z[NX + 1]) && !isnan(r.z[0]));
    io_raster_free(&r);

    make(&(source){.name = "masked.tif", .mask = true});
    r = read_well("masked.tif", NULL);
    for (size_t k = 0; k < N; k++) assert_true(isnan(r.z[k]) == (k % NX == 2));
    io_raster_free(&r);
}

/* Pixels of 10 by 10 with the lower left corner at (100, 200): the first sample, of the northern row, is a pixel's centre. GDAL is
 * told to expect fractions behind however many whole numbers. */
static void ascii_grids(void **state) {
    (void)state;
    enum { SIDE = 300 };
    static const double map[3][4] = {{10, 0, 0, 105}, {0, -10, 0, 195 + 10.0 * SIDE}, {0, 0, 1, 0}};
    static const char *const heads[] = {"xllcorner 100\nyllcorner 200\ncellsize 10",
                                        "XLLCENTER 105\nYLLCENTER 205\nCELLSIZE 10",
                                        "xllcorner 100\nyllcorner 200\ndx 10\ndy 10"};
    char *text = calloc(1, 4 * SIDE * SIDE + 200);
    for (size_t k = 0; k < 3; k++) {
        int used = sprintf(text, "ncols %d\nnrows %d\n%s\nNODATA_value -9999\n-9999 ", SIDE, SIDE, heads[k]);
        for (int s = 1; s < SIDE * SIDE - 1; s++) used += sprintf(text + used, "%d ", s % 9 + 1);
        used += sprintf(text + used, "1.25e1\n");
        scratch_write("a.asc", text, (size_t)used);
        io_raster r = read_well("a.asc", NULL);
        check_map(&r, map);
        assert_true(isnan(r.z[0]) && r.z[1] == 2 && r.z[SIDE * SIDE - 1] == 12.5f);
        io_raster_free(&r);
        sprintf(text + used - 7, "1e99\n");
        scratch_write("a.asc", text, (size_t)used - 2);
        check_refused("a.asc", NULL, "beyond the range of float");
        scratch_write("a.asc", text, (size_t)used / 2);
        check_refused("a.asc", NULL, "cannot read");
    }
    free(text);
}

static void bands_are_chosen(void **state) {
    (void)state;
    words w = {""};
    make(&(source){.name = "bands.tif", .bands = 3});
    io_raster_options options = {.band = 2, .warn = hear, .context = &w};
    io_raster r = read_well("bands.tif", &options);
    assert_true(r.z[3] == (float)value(2, 3));
    assert_string_equal(w.text, "");
    io_raster_free(&r);
    options.band = 0;
    r = read_well("bands.tif", &options);
    assert_true(r.z[3] == (float)value(1, 3));
    check(strstr(w.text, "has 3 bands") != NULL, "%s", w.text);
    io_raster_free(&r);
    options.band = 4;
    check_refused("bands.tif", &options, "3 bands, not 4");
    make(&(source){.name = "complex.tif", .type = GDT_CFloat32});
    check_refused("complex.tif", NULL, "complex");
}

static void units_are_known(void **state) {
    (void)state;
    /* Metres over metres, feet over metres, feet of a survey over the same feet, metres over degrees. */
    static const struct {
        const char *crs, *unit;
        double zscale, metres, map_unit;
    } cases[] = {{"EPSG:32632", "m", 1, 1, 1},
                 {"EPSG:32632", "ft", 0.3048, 0.3048, 1},
                 {"EPSG:2263", "US survey foot", 1, 1200.0 / 3937, 1200.0 / 3937},
                 {"EPSG:2263", NULL, 1, 0, 1200.0 / 3937},
                 {"EPSG:2263", "metre", 3937.0 / 1200, 1, 1200.0 / 3937},
                 {"EPSG:4326", "Foot", 0.3048, 0.3048, 0.017453292519943295},
                 {"EPSG:4326", NULL, 1, 0, 0.017453292519943295},
                 /* Heights in feet, as a compound system says. */
                 {"EPSG:26918+6360", NULL, 1200.0 / 3937, 1200.0 / 3937, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        make(&(source){.name = "unit.tif", .crs = cases[k].crs, .unit = cases[k].unit});
        io_raster r = read_well("unit.tif", NULL);
        check(fabs(r.map[2][2] - cases[k].zscale) < 1e-12, "case %zu: zscale %.17g", k, r.map[2][2]);
        check(fabs(r.georef.height_unit - cases[k].metres) < 1e-12, "case %zu: metres %g", k, r.georef.height_unit);
        check(fabs(r.georef.unit - cases[k].map_unit) < 1e-12, "case %zu: unit %g", k, r.georef.unit);
        assert_true(r.georef.geographic == (k == 5 || k == 6));
        if (r.georef.geographic)
            assert_true(r.georef.semi_major == 6378137 && fabs(r.georef.inverse_flattening - 298.257223563) < 1e-9);
        io_raster_free(&r);
    }
    /* A GeoTIFF passes the vertical unit of its system off as the band's; other formats do not. */
    static const char vrt[] =
        "<VRTDataset rasterXSize='5' rasterYSize='4'><SRS>EPSG:26918+6360</SRS>"
        "<GeoTransform>0, 1, 0, 0, 0, -1</GeoTransform><VRTRasterBand dataType='Float32' band='1'>"
        "<SimpleSource><SourceFilename relativeToVRT='1'>unit.tif</SourceFilename></SimpleSource>"
        "</VRTRasterBand></VRTDataset>";
    scratch_write("unit.vrt", vrt, sizeof vrt - 1);
    io_raster v = read_well("unit.vrt", NULL);
    assert_true(fabs(v.map[2][2] - 1200.0 / 3937) < 1e-12 && v.z[4] == (float)value(1, 4));
    io_raster_free(&v);

    words w = {""};
    io_raster_options options = {.warn = hear, .context = &w};
    make(&(source){.name = "unit.tif", .unit = "fathom"});
    io_raster r = read_well("unit.tif", &options);
    check(strstr(w.text, "'fathom'") != NULL, "%s", w.text);
    io_raster_free(&r);
    w.text[0] = '\0';
    options.zscale = 1.8288;
    r = read_well("unit.tif", &options);
    assert_true(r.map[2][2] == 1.8288);
    assert_string_equal(w.text, "");
    io_raster_free(&r);
    options.cellsize = 5;
    check_refused("unit.tif", &options, "the file gives the distance");
}

static bool stop(void *context, double share) {
    ++*(int *)context;
    return share < 0.5;
}

static void large_files_come_in_pieces(void **state) {
    (void)state;
    enum { LARGE = 2000 };
    make(&(source){.name = "large.tif", .nx = LARGE, .ny = LARGE, .type = GDT_Float64});
    io_raster r = read_well("large.tif", NULL);
    for (size_t k = 0; k < (size_t)LARGE * LARGE; k++) assert_true(r.z[k] == (float)value(1, k));
    io_raster_free(&r);
    int calls = 0;
    const io_raster_options options = {.progress = stop, .context = &calls};
    check_refused("large.tif", &options, "interrupted");
    check(calls > 1, "%d calls", calls);

    /* Cut short. */
    size_t size;
    char *bytes = scratch_read("large.tif", &size);
    scratch_write("short.tif", bytes, size / 2);
    free(bytes);
    check_refused("short.tif", NULL, "short.tif");
    scratch_write("text.tif", "no picture at all", 17);
    check_refused("text.tif", NULL, "cannot read");
    check_refused("absent.tif", NULL, "No such file");
}

static void what_smells_is_said(void **state) {
    (void)state;
    words w = {""};
    const io_raster_options options = {.warn = hear, .context = &w};
    const short deep = -32768;
    make(&(source){.name = "void.tif", .type = GDT_Int16});
    GDALDatasetH file = GDALOpen("void.tif", GA_Update);
    assert_int_equal(
        GDALRasterIO(GDALGetRasterBand(file, 1), GF_Write, 1, 1, 1, 1, (void *)(uintptr_t)&deep, 1, 1, GDT_Int16, 0, 0),
        CE_None);
    GDALClose(file);
    io_raster r = read_well("void.tif", &options);
    assert_true(r.z[NX + 1] == -32768);
    check(strstr(w.text, "1 samples are -32768") != NULL && strstr(w.text, "--nodata -32768") != NULL, "%s", w.text);
    io_raster_free(&r);
    w.text[0] = '\0';
    const io_raster_options told = {.warn = hear, .context = &w, .nodata = &(double){-32768}, .nodata_count = 1};
    r = read_well("void.tif", &told);
    assert_true(isnan(r.z[NX + 1]));
    assert_string_equal(w.text, "");
    io_raster_free(&r);
    static const double degrees[6] = {7, 0.001, 0, 46, 0, -0.001};
    make(&(source){.name = "degrees.tif", .crs = "", .transform = degrees});
    r = read_well("degrees.tif", &options);
    check(strstr(w.text, "looks like degrees") != NULL, "%s", w.text);
    io_raster_free(&r);
}

static const io_raster nowhere = {.map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/* Floats where that raster lies. */
static io_raster_product product_at(const io_raster *r, size_t nx, size_t ny, size_t bands) {
    return (io_raster_product){.nx = nx,
                               .ny = ny,
                               .bands = bands,
                               .map = (const double(*)[4])r->map,
                               .georef = &r->georef,
                               .cell = IO_CELL_FLOAT32};
}

enum { SIDE = 300, BANDS = 2 };
static float large[BANDS][SIDE][SIDE];

/* In two bands, with no data and a unit. */
static io_raster_product large_product(io_raster *r) {
    make(&(source){.name = "dem.tif", .nx = SIDE, .ny = SIDE});
    *r = read_well("dem.tif", NULL);
    for (size_t k = 0; k < (size_t)BANDS * SIDE * SIDE; k++)
        large[k / (SIDE * SIDE)][k / SIDE % SIDE][k % SIDE] = (float)k * 0.5f;
    io_raster_product product = product_at(r, SIDE, SIDE, BANDS);
    product.has_nodata = true;
    product.nodata = -1;
    product.unit = "degree";
    return product;
}

/* What GDAL finds in a file: where it lies, and all that was written. */
static GDALDatasetH open_well(const char *name, const double place[6]) {
    GDALDatasetH file = GDALOpen(name, GA_ReadOnly);
    assert_non_null(file);
    double transform[6];
    assert_int_equal(GDALGetGeoTransform(file, transform), CE_None);
    for (int k = 0; k < 6; k++) assert_true(transform[k] == place[k]);
    return file;
}

static GDALDatasetH open_large(const char *name, const char *compression) {
    static float back[SIDE][SIDE];
    GDALDatasetH file = open_well(name, utm);
    assert_int_equal(GDALGetRasterCount(file), BANDS);
    for (int b = 0; b < BANDS; b++) {
        GDALRasterBandH band = GDALGetRasterBand(file, b + 1);
        assert_int_equal(GDALRasterIO(band, GF_Read, 0, 0, SIDE, SIDE, back, SIDE, SIDE, GDT_Float32, 0, 0), CE_None);
        assert_memory_equal(back, large[b], sizeof back);
        assert_true(GDALGetRasterNoDataValue(band, NULL) == -1);
        assert_string_equal(GDALGetRasterUnitType(band), "degree");
    }
    const char *found = GDALGetMetadataItem(file, "COMPRESSION", "IMAGE_STRUCTURE");
    check(compression ? strcmp(found, compression) == 0 : found == NULL, "%s: %s", name, found);
    return file;
}

/* A product in bands, checked by GDAL. */
static void results_are_whole(void **state) {
    (void)state;
    io_raster r;
    io_raster_product product = large_product(&r);
    product.band_names = (const char *const[]){"first", "second"};
    product.notes = (const char *const[]){"SUN_AZIMUTH=225", "TIFFTAG_SOFTWARE=cellwalk", NULL};
    static const char *const outputs[] = {"out.tif", "out.npy", "plain.TIFF"};
    for (size_t o = 0; o < 3; o++) {
        product.uncompressed = o == 2;
        assert_true(io_raster_is_tif(outputs[o]) == (o != 1));
        io_raster_writer w;
        io_error error = {""};
        check(io_raster_create(&w, outputs[o], &product, &error), "%s", error.text);
        for (size_t b = 0; b < BANDS; b++)
            for (size_t j = 0; j < SIDE; j += 128) {
                const size_t rows = SIDE - j < 128 ? SIDE - j : 128;
                check(io_raster_write(&w, large[b][j], rows, &error), "%s", error.text);
                assert_int_not_equal(access(outputs[o], F_OK), 0);
            }
        check(io_raster_commit(&w, &error), "%s", error.text);
        assert_int_equal(access(outputs[o], F_OK), 0);
    }
    io_raster_free(&r);
    GDALClose(open_large("plain.TIFF", NULL));
    GDALDatasetH file = open_large("out.tif", "DEFLATE");
    assert_string_equal(OSRGetName(GDALGetSpatialRef(file)), "WGS 84 / UTM zone 32N");
    assert_string_equal(GDALGetDescription(GDALGetRasterBand(file, 2)), "second");
    assert_string_equal(GDALGetMetadataItem(file, "SUN_AZIMUTH", NULL), "225");
    assert_string_equal(GDALGetMetadataItem(file, "TIFFTAG_SOFTWARE", NULL), "cellwalk");
    int across, down;
    GDALGetBlockSize(GDALGetRasterBand(file, 1), &across, &down);
    assert_true(across == 160 && down == 160); /* twice that is more than 300, by less than two tiles of 256 are */
    GDALClose(file);
    size_t size;
    char *npy = scratch_read("out.npy", &size);
    check(strstr(npy + 10, "'shape': (2, 300, 300)") != NULL, "%s", npy + 10);
    assert_memory_equal(npy + size - sizeof large, large, sizeof large);
    free(npy);
}

/* A COG has smaller copies that come first; it is made beside scratch files, which go. */
static void results_are_cogs(void **state) {
    (void)state;
    io_raster r;
    io_raster_product product = large_product(&r);
    static const char *const creation[] = {"BLOCKSIZE=128", "COMPRESS=LZW", "PREDICTOR=NO"};
    product.cog = true;
    product.creation = creation;
    io_error error = {""};
    const size_t entries = scratch_entries();
    for (size_t c = 0; c < 4; c += 3) {
        product.creation_count = c;
        check(io_raster_check_creation(creation, c, true, &error), "%s", error.text);
        io_raster_writer w;
        check(io_raster_create(&w, "cog.tif", &product, &error), "%s", error.text);
        for (size_t b = 0; b < BANDS; b++) check(io_raster_write(&w, large[b], SIDE, &error), "%s", error.text);
        check(io_raster_commit(&w, &error), "%s", error.text);
        assert_int_equal(scratch_entries(), entries + 1);
        GDALDatasetH file = open_large("cog.tif", c ? "LZW" : "DEFLATE");
        assert_string_equal(GDALGetMetadataItem(file, "LAYOUT", "IMAGE_STRUCTURE"), "COG");
        assert_int_equal(GDALGetOverviewCount(GDALGetRasterBand(file, 2)), c ? 2 : 0);
        GDALClose(file);
        assert_int_equal(unlink("cog.tif"), 0);
    }
    /* Rows that are missing leave nothing. */
    io_raster_writer w;
    check(io_raster_create(&w, "cog.tif", &product, &error), "%s", error.text);
    assert_true(io_raster_write(&w, large[0], SIDE, &error));
    assert_false(io_raster_commit(&w, &error));
    assert_int_equal(scratch_entries(), entries);
    io_raster_free(&r);
}

/* What may grow beyond 4 GB has the large header from the beginning. */
static void large_files_are_bigtiff(void **state) {
    (void)state;
    static const size_t sides[] = {1000, 40000};
    for (size_t k = 0; k < 2; k++) {
        /* GDAL would fill in what is not written. */
        static const char *const creation[] = {"SPARSE_OK=TRUE"};
        io_raster_product product = product_at(&nowhere, sides[k], sides[k], 1);
        product.creation = creation;
        product.creation_count = 1;
        io_raster_writer w;
        io_error error = {""};
        check(io_raster_create(&w, "large.tif", &product, &error), "%s", error.text);
        const size_t rows = io_raster_tile_side(sides[k]);
        float *cells = calloc(rows * sides[k], sizeof *cells);
        assert_non_null(cells);
        check(io_raster_write(&w, cells, rows, &error), "%s", error.text);
        free(cells);
        const int copy = dup(fileno(w.output.file));
        io_raster_discard(&w);
        char header[4];
        assert_int_equal(pread(copy, header, 4, 0), 4);
        close(copy);
        assert_int_equal(header[2], k == 0 ? 42 : 43);
    }
}

/* A picture of a terrain with a map has a world file, which appears and fails with it. */
static void pictures_have_a_place(void **state) {
    (void)state;
    static const unsigned char cells[3 * N] = {1};
    static const double turned[6] = {1000, 3, 4, 2000, 4, -3};
    make(&(source){.name = "turned.tif", .transform = turned});
    io_raster r = read_well("turned.tif", NULL);
    io_raster_product product = product_at(&r, NX, NY, 1);
    product.cell = IO_CELL_UINT8;
    io_raster_writer w;
    io_error error = {""};
    check(io_raster_create(&w, "out.png", &product, &error), "%s", error.text);
    check(io_raster_write(&w, cells, NY, &error), "%s", error.text);
    assert_true(access("out.png", F_OK) != 0 && access("out.pgw", F_OK) != 0);
    check(io_raster_commit(&w, &error), "%s", error.text);
    GDALClose(open_well("out.png", turned));
    /* Rows that are missing leave what was there. */
    const size_t entries = scratch_entries();
    scratch_write("out.pgw", "old", 3);
    check(io_raster_create(&w, "out.png", &product, &error), "%s", error.text);
    assert_false(io_raster_commit(&w, &error));
    size_t size;
    char *old = scratch_read("out.pgw", &size);
    assert_true(size == 3 && memcmp(old, "old", 3) == 0);
    free(old);
    /* A world file that cannot be written is an error from the beginning on, and there is no picture. */
    assert_int_equal(mkdir("no.pgw", 0700), 0);
    assert_false(io_raster_create(&w, "no.png", &product, &error));
    check(strstr(error.text, "no.pgw") != NULL, "%s", error.text);
    assert_int_equal(scratch_entries(), entries + 1);
    io_raster_free(&r);
}

static void results_are_pictures(void **state) {
    (void)state;
    unsigned char cells[4 * N], found[3 * N]; /* enough for floats, too */
    for (size_t k = 0; k < sizeof cells; k++) cells[k] = (unsigned char)(7 * k);
    io_raster_product product = product_at(&nowhere, NX, NY, 1);
    io_raster_writer w;
    io_error error = {""};
    check(io_raster_create(&w, "out.png", &product, &error), "%s", error.text);
    check(io_raster_write(&w, cells, NY, &error) && io_raster_commit(&w, &error), "%s", error.text);
    GDALDatasetH file = GDALOpen("out.png", GA_ReadOnly);
    assert_non_null(file);
    assert_int_equal(GDALDatasetRasterIO(file, GF_Read, 0, 0, NX, NY, found, NX, NY, GDT_Byte, 3, NULL, 3, 3 * NX, 1),
                     CE_None);
    assert_memory_equal(found, cells, sizeof found);
    GDALClose(file);
    assert_false(io_raster_can_write("out.png", 2, &error));
    assert_false(io_raster_can_write("out.gif", 1, &error));
    check(strstr(error.text, ".tif") != NULL, "%s", error.text);
    /* Rows that are missing leave nothing. */
    static const char *const outputs[] = {"less.png", "less.npy", "less.tif"};
    for (size_t o = 0; o < 3; o++) {
        check(io_raster_create(&w, outputs[o], &product, &error), "%s", error.text);
        check(io_raster_write(&w, cells, NY - 1, &error), "%s", error.text);
        assert_false(io_raster_commit(&w, &error));
        check(strstr(error.text, "missing") != NULL, "%s", error.text);
        assert_int_not_equal(access(outputs[o], F_OK), 0);
    }
}

/* The grid of Luxembourg that Debian's r-cran-terra has in its examples. */
static void a_real_terrain(void **state) {
    (void)state;
    static const char path[] = "/usr/lib/R/site-library/terra/ex/elev.tif";
    FILE *there = fopen(path, "rb");
    if (there == NULL) skip();
    fclose(there);
    io_raster r = read_well(path, NULL);
    assert_true(r.nx == 95 && r.ny == 90 && r.georef.geographic);
    size_t holes = 0;
    float low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < r.nx * r.ny; k++) {
        holes += isnan(r.z[k]) ? 1 : 0;
        low = fminf(low, r.z[k]);
        high = fmaxf(high, r.z[k]);
    }
    check(holes == 3942 && low == 141 && high == 547, "%zu holes, %g to %g", holes, (double)low, (double)high);
    assert_true(r.map[0][3] > 5.7 && r.map[0][3] < 5.8 && r.map[1][3] > 50.1 && r.map[1][3] < 50.2);
    io_raster_free(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(without_the_module, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(samples_stand_at_pixel_centres, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(values_become_heights, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(ascii_grids, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bands_are_chosen, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(units_are_known, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(large_files_come_in_pieces, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_smells_is_said, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_are_whole, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_are_cogs, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(large_files_are_bigtiff, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_are_pictures, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pictures_have_a_place, scratch_enter, scratch_leave),
        cmocka_unit_test(a_real_terrain),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
