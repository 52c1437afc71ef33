/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of rasters, and rasters larger than memory: the same bits as from all of it in one piece. */

#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include <math.h>
#include <unistd.h>

enum { NX = 300, NY = 260, ARGUMENTS = 32 };

/* Hills, holes, and a peak in the northwest that throws long shadows. */
static double height(size_t i, size_t j) {
    const double x = (double)i, y = (double)j, peak = 900 - 25 * hypot(x - 20, y - 15);
    if (i > 140 && i < 150 && j > 100 && j < 130) return NAN;
    return 120 + 60 * sin(x / 9) * cos(y / 13) + 25 * sin((x + 2 * y) / 5) + (peak > 0 ? peak : 0);
}

static const char utm[] = "<SRS>EPSG:32632</SRS><GeoTransform>600000,10,0,5200000,0,-10</GeoTransform>",
                  degrees[] = "<SRS>EPSG:4326</SRS><GeoTransform>7,0.0003,0,47,0,-0.0002</GeoTransform>",
                  turned[] = "<SRS>EPSG:32632</SRS><GeoTransform>600000,8,6,5200000,6,-8</GeoTransform>";

/* A raster of side² samples in which land.txt begins at sample (at, at). */
static void vrt_file(const char *name, size_t side_x, size_t side_y, size_t at, const char *place) {
    char text[1024];
    snprintf(text, sizeof text,
             "<VRTDataset rasterXSize=\"%zu\" rasterYSize=\"%zu\">%s<VRTRasterBand dataType=\"Float32\" band=\"1\">"
             "<NoDataValue>-9999</NoDataValue><ComplexSource><SourceFilename relativeToVRT=\"1\">land.txt"
             "</SourceFilename><SrcRect xOff=\"0\" yOff=\"0\" xSize=\"%d\" ySize=\"%d\"/><DstRect xOff=\"%zu\" "
             "yOff=\"%zu\" xSize=\"%d\" ySize=\"%d\"/><NODATA>-9999</NODATA></ComplexSource></VRTRasterBand>"
             "</VRTDataset>",
             side_x, side_y, place, NX, NY, at, at, NX, NY);
    scratch_write(name, text, strlen(text));
}

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    static char text[NX * NY * 16];
    size_t used = (size_t)snprintf(
        text, sizeof text, "ncols %d\nnrows %d\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n", NX, NY);
    for (size_t k = 0; k < NX * NY; k++) {
        z[k] = (float)height(k % NX, k / NX);
        used += (size_t)snprintf(text + used, sizeof text - used, "%.9g%c", isnan(z[k]) ? -9999 : (double)z[k],
                                 k % NX == NX - 1 ? '\n' : ' ');
    }
    scratch_write("land.txt", text, used);
    field_file("land.npy", z, NX, NY);
    vrt_file("utm.vrt", NX, NY, 0, utm);
    vrt_file("degrees.vrt", NX, NY, 0, degrees);
    vrt_file("turned.vrt", NX, NY, 0, turned);
    return 0;
}

static bool have_gdal(void) { return program_run(NULL, (const char *const[]){"info", "utm.vrt", NULL})->status == 0; }

/* An array that the program writes. */
typedef struct array {
    char *file;
    const char *cells;
    size_t bytes, nx, ny, bands; /* bytes: of one cell */
} array;

static array run(const char *file, const char *const *product, const char *const *more) {
    const char *arguments[ARGUMENTS] = {product[0], file, "-o", "out.npy"};
    size_t n = 4, size;
    for (const char *const *p = product + 1; *p; p++) arguments[n++] = *p;
    for (; *more; more++) arguments[n++] = *more;
    if (strstr(file, ".npy")) {
        arguments[n++] = "--cellsize";
        arguments[n++] = "10";
    }
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0, "%s %s: %s", product[0], file, r->err);
    array a = {.file = scratch_read("out.npy", &size), .bands = 1};
    const char *header = a.file + 10, *shape = strstr(header, "'shape': ("), *type = strstr(header, "'descr': '");
    size_t sides[3];
    const int sides_count = sscanf(shape + 10, "%zu, %zu, %zu", &sides[0], &sides[1], &sides[2]);
    assert_true(sides_count >= 2);
    if (sides_count == 3) a.bands = sides[0];
    a.ny = sides[sides_count - 2];
    a.nx = sides[sides_count - 1];
    a.bytes = (size_t)(type[12] - '0');
    a.cells = a.file + (size - a.bands * a.ny * a.nx * a.bytes);
    return a;
}

static void check_part(const array *whole, const array *part, size_t i, size_t j, const char *what) {
    assert_int_equal(whole->bytes, part->bytes);
    assert_int_equal(whole->bands, part->bands);
    for (size_t b = 0; b < part->bands; b++)
        for (size_t y = 0; y < part->ny; y++)
            check(memcmp(whole->cells + ((b * whole->ny + j + y) * whole->nx + i) * whole->bytes,
                         part->cells + (b * part->ny + y) * part->nx * part->bytes, part->nx * part->bytes) == 0,
                  "%s: other bits in row %zu of band %zu", what, y, b);
}

static const char *const none[] = {NULL};

static const char *const products[][9] = {
    {"shadow", "--sun", "315,12", NULL},
    {"shadow", "--sun", "5,30", "--hillshade", NULL},
    {"shadow", "--sun", "200,15", "--sun-disc", NULL},
    {"shadow", "--sun", "90,-3", NULL},
    {"shadow", "--sun", "45,89", "--disc", "4", NULL},
    {"horizon", "--directions", "3", NULL},
    {"horizon", "--directions", "3", "--max-distance", "400", NULL},
    {"horizon", "--directions", "3", "--distance", NULL},
    {"horizon", "--directions", "3", "--distance", "--max-distance", "400", NULL},
    {"shadow", "--sun", "315,12", "--curvature", "200", NULL},
    {"horizon", "--directions", "5", "--svf", NULL},
    {"visibility", "--directions", "7", NULL},
    {"visibility", "--directions", "7", "--share", "--max-distance", "300", NULL},
    {"visibility", "--directions", "7", "--longest", "--target-height", "5", "--max-distance", "500", NULL},
    {"sun", "--date", "2024-12-21", "--step", "4h", "--lon-lat", "7,47", NULL},
};
enum { PRODUCTS = sizeof products / sizeof products[0] };

/* Windows by the edges of pixels. */
static const struct {
    const char *file, *window, *from;
} maps[] = {
    {"land.npy", "995,1295,1994,1744", "1500,1450,10"}, /* columns 100 to 199, rows 85 to 129 */
    {"utm.vrt", "601000,5198700,602000,5199150", "601505,5198995,10"},
    {"degrees.vrt", "7.03,46.974,7.06,46.983", "7.0452,46.9799,10"},
};
enum { MAPS = sizeof maps / sizeof maps[0], I = 100, J = 85, WIDE = 100, LONG = 45 };

static void windows(void **state) {
    (void)state;
    for (size_t m = 0; m < (have_gdal() ? MAPS : 1); m++) {
        const char *const window[] = {"--window", maps[m].window, NULL};
        const char *const views[][6] = {{"viewshed", "--from", maps[m].from, NULL},
                                        {"viewshed", "--from", maps[m].from, "--needed", NULL}};
        for (size_t k = 0; k < PRODUCTS + 2; k++) {
            if (!test_takes(m * (PRODUCTS + 2) + k, 5)) continue;
            const char *const *product = k < PRODUCTS ? products[k] : views[k - PRODUCTS];
            const array whole = run(maps[m].file, product, none), part = run(maps[m].file, product, window);
            assert_true(part.nx == WIDE && part.ny == LONG);
            check_part(&whole, &part, I, J, product[0]);
            free(whole.file);
            free(part.file);
        }
    }
}

/* So little memory that each band has 32 rows, or a few more. */
static void bands(void **state) {
    (void)state;
    static const char *const files[] = {"land.npy", "utm.vrt", "degrees.vrt", "turned.vrt"};
    static const char *const memory[] = {"--memory", "2.4M", NULL};
    static const char *const suns[][6] = {{"shadow", "--sun", "340,35", NULL},
                                          {"shadow", "--sun", "5,30", "--hillshade", NULL},
                                          {"shadow", "--sun", "200,60", "--sun-disc", NULL},
                                          {"shadow", "--sun", "45,89", "--disc", "4", NULL},
                                          {"horizon", "--svf", "--max-distance", "300", NULL},
                                          {"visibility", "--longest", "--max-distance", "100", NULL}};
    for (size_t m = 0; m < (have_gdal() ? 4 : 1); m++)
        for (size_t k = 0; k < sizeof suns / sizeof suns[0]; k++) {
            if (!test_takes(m + k, sizeof suns / sizeof suns[0])) continue;
            const array whole = run(files[m], suns[k], none), part = run(files[m], suns[k], memory);
            assert_true(part.nx == NX && part.ny == NY);
            check_part(&whole, &part, 0, 0, files[m]);
            free(whole.file);
            free(part.file);
        }
}

/* A long strip with ridges, seen over more than two blocks of 256 rows, in which a curvature of 100 and more earths bounds how far there is
 * to see. */
enum { STRIP_NX = 40, STRIP_NY = 3300 };
static void strip_file(void) {
    static float z[STRIP_NX * STRIP_NY];
    for (size_t k = 0; k < (size_t)STRIP_NX * STRIP_NY; k++) {
        const double x = (double)(k % STRIP_NX), y = (double)(k / STRIP_NX);
        const double ridge = 400 - 40 * fabs(fmod(y + 200, 900) - 450); /* row 250, 1150 and so on */
        z[k] = (float)(200 + 8 * sin(y / 9) * cos(x / 5) + fmax(ridge, 0));
    }
    field_file("strip.npy", z, STRIP_NX, STRIP_NY);
}

/* Bands that are proved by the raster's own highest and lowest samples. */
static void far_horizons(void **state) {
    (void)state;
#define DAY "sun", "--date", "2024-06-21", "--step", "6h", "--lon-lat", "7,47"
    static const char *const far[][16] = {
        {"horizon", "--directions", "4", "--curvature", "1000", NULL},
        {"horizon", "--directions", "5", "--svf", "--curvature", "100", NULL},
        {"horizon", "--directions", "4", "--svf-tilted", "--curvature", "100", NULL},
        {DAY, NULL},
        {DAY, "--directions", "8", "--irradiance", "--sky", "4", "--curvature", "100", NULL},
    };
    static const char *const memory[] = {"--memory", "3.9M", NULL};
    strip_file();
    for (size_t k = 0; k < sizeof far / sizeof far[0]; k++) {
        if (!test_takes(k, 3)) continue;
        const char *product[16] = {NULL};
        memcpy(product, far[k], sizeof far[k]);
        const array whole = run("strip.npy", product, none), part = run("strip.npy", product, memory);
        assert_true(part.nx == STRIP_NX && part.ny == STRIP_NY);
        check_part(&whole, &part, 0, 0, far[k][0]);
        free(whole.file);
        free(part.file);
    }
#define STRIP "strip.npy", "--cellsize", "10", "-o", "no.npy", "--memory"
    /* On a flat earth summits see all of it. */
    check_refused((const char *const[]){"horizon", STRIP, "2M", NULL}, 1,
                  "40 x 3300 samples matter at once, which need --memory 5M; there is 2M");
    check_refused((const char *const[]){"horizon", STRIP, "1M", "--curvature", "100", NULL}, 1,
                  "samples matter at once");
    check_refused((const char *const[]){DAY, STRIP, "2M", "--irradiance", NULL}, 1, "40 x 3300 samples matter at once");
#undef STRIP
#undef DAY
}

/* The output is as near as --max-distance, and what the full raster has there; elsewhere there is nothing. */
static void near_views(void **state) {
    (void)state;
    if (!have_gdal()) skip();
    for (size_t m = 1; m < MAPS; m++)
        for (int needed = 0; needed < 2; needed++) {
            if (!test_takes(m + (size_t)needed, 2)) continue;
            const char *const view[] = {"viewshed",
                                        "--from",
                                        maps[m].from,
                                        "--max-distance",
                                        m == 1 ? "600.3" : "600",
                                        needed ? "--needed" : NULL,
                                        NULL};
            const char *const full[] = {"--extent", "full", NULL};
            const array whole = run(maps[m].file, view, full), part = run(maps[m].file, view, none);
            /* Samples 10 m apart on UTM's map, 10.004 on the ground, from (150, 100); or 0.0003 and 0.0002 degrees, 22.8 and 22.2 m. */
            const size_t across = m == 1 ? 60 : 26, down = m == 1 ? 60 : 26;
            check(part.nx == 2 * across + 1 && part.ny == 2 * down + 1, "%zu x %zu", part.nx, part.ny);
            check_part(&whole, &part, 150 - across, 100 - down, maps[m].file);
            for (size_t k = 0; k < NX * NY; k++) {
                const size_t i = k % NX, j = k / NX;
                if (i + across >= 150 && i <= 150 + across && j + down >= 100 && j <= 100 + down) continue;
                const uint8_t seen = (uint8_t)whole.cells[k];
                if (!needed) assert_true(seen == 0 || seen == 255);
            }
            free(whole.file);
            free(part.file);
        }
}

/* Luxembourg, a map in degrees with holes around it. */
static void real_land(void **state) {
    (void)state;
    static const char file[] = "/usr/lib/R/site-library/terra/ex/elev.tif";
    if (!have_gdal() || access(file, R_OK) != 0) skip();
    static const char *const land[][10] = {
        {"sun", "--date", "2024-12-21", "--step", "2h", NULL},
        {"sun", "--date", "2024-03-20", "--step", "4h", "--irradiance", "--sky", "5", NULL},
        {"horizon", "--svf-tilted", "--directions", "5", NULL},
        {"horizon", "--directions", "3", "--curvature", "1", NULL},
    };
    static const char *const window[] = {"--window", "6.0,49.7,6.2,49.9", NULL};
    for (size_t k = 0; k < sizeof land / sizeof land[0]; k++) {
        if (!test_takes(k, 2)) continue;
        const array whole = run(file, land[k], none), part = run(file, land[k], window);
        assert_true(part.nx == 24 && part.ny == 24);
        check_part(&whole, &part, 31, 35, land[k][0]);
        free(whole.file);
        free(part.file);
    }
    /* What is seen needs no height. */
    static const char *const view[] = {"viewshed", "--from", "6.13,49.61,2", NULL}, *const needed[] = {"--needed",
                                                                                                       NULL};
    const array seen = run(file, view, none), need = run(file, view, needed);
    size_t count[2] = {0, 0};
    for (size_t k = 0; k < seen.nx * seen.ny; k++) {
        const uint8_t is_seen = (uint8_t)seen.cells[k];
        float height;
        memcpy(&height, need.cells + k * sizeof height, sizeof height);
        check(is_seen == 255 ? isnan(height) : is_seen == (height == 0), "sample %zu: %d, %g m", k, is_seen,
              (double)height);
        if (is_seen < 2) count[is_seen]++;
    }
    check(count[0] > 100 && count[1] > 10, "%zu hidden, %zu seen", count[0], count[1]);
    free(seen.file);
    free(need.file);
}

/* 4 10^10 samples, of which the land is a small part in the middle, and the rest holes. */
static void huge(void **state) {
    (void)state;
    enum { SIDE = 200000, AT = 100032 };
    if (!have_gdal()) skip();
    vrt_file("huge.vrt", SIDE, SIDE, AT, "<GeoTransform>0,10,0,0,0,-10</GeoTransform>");
    vrt_file("small.vrt", NX, NY, 0, "<GeoTransform>1000320,10,0,-1000320,0,-10</GeoTransform>");
    static const char *const window[] = {"--window", "1001320,-1001620,1002320,-1001170", "--memory", "60M", NULL},
                             *const shadow[] = {"shadow", "--sun", "315,12", NULL},
                             *const view[] = {"viewshed",       "--from", "1001825,-1001325,10",
                                              "--max-distance", "600",    NULL};
    array small = run("small.vrt", shadow, none), part = run("huge.vrt", shadow, window);
    assert_true(part.nx == WIDE && part.ny == LONG);
    check_part(&small, &part, I, J, "shadow");
    free(small.file);
    free(part.file);
    small = run("small.vrt", view, none);
    part = run("huge.vrt", view, window + 2);
    assert_true(part.nx == small.nx && part.ny == small.ny);
    check_part(&small, &part, 0, 0, "viewshed");
    free(small.file);
    free(part.file);
}

static void what_is_refused(void **state) {
    (void)state;
#define LAND "land.npy", "--cellsize", "10", "-o", "no.npy"
    check_refused((const char *const[]){"shadow", LAND, "--sun", "0,30", "--window", "1,2,3", NULL}, 2,
                  "--window takes XMIN,YMIN,XMAX,YMAX");
    check_refused((const char *const[]){"shadow", LAND, "--sun", "0,30", "--window", "5000,0,6000,10", NULL}, 1,
                  "no sample is in it; they go from 0,0 to 2990,2590");
    check_refused((const char *const[]){"shadow", LAND, "--sun", "0,30", "--window", "20,0,10,10", NULL}, 1,
                  "no sample is in it");
    check_refused((const char *const[]){"shadow", LAND, "--sun", "0,30", "--memory", "2X", NULL}, 2,
                  "--memory takes a number of bytes");
    check_refused((const char *const[]){"horizon", LAND, "--memory", "1M", NULL}, 1,
                  "300 x 260 samples matter at once, which need --memory 3M; there is 1M");
    check_refused((const char *const[]){"viewshed", LAND, "--from", "9000,0,=9", "--max-distance", "5", NULL}, 1,
                  "no sample is within 5 m of any observer");
    check_refused((const char *const[]){"horizon", "land.npy", "--at", "10,10", "--window", "0,0,9,9", NULL}, 2,
                  "go with neither --svf nor --window");
#undef LAND
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(windows, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bands, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(far_horizons, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(near_views, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(real_land, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(huge, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
