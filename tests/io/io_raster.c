/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters: the same heights from every format, and a clear word about every file that is not whole. */

#include "check.h"
#include "raster.h"
#include "scratch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { NX = 4, NY = 3, N = NX * NY };

static const float heights[N] = {0, 1, 2, 3, 40, 500, 6000, 32767, 8, 9, 10, 11};

static void make_npy(const char *name, const char *type, const void *data, size_t size) {
    char bytes[512] = "\x93NUMPY\x01";
    const int length =
        snprintf(bytes + 10, 200, "{'descr': '%s', 'fortran_order': False, 'shape': (%d, %d), }", type, NY, NX);
    assert_true(length > 0);
    bytes[8] = (char)length;
    memcpy(bytes + 10 + length, data, size);
    scratch_write(name, bytes, 10 + (size_t)length + size);
}

static void check_heights(const char *name, const float *wanted, const double map[3][4]) {
    io_raster r;
    io_error error = {""};
    check(io_raster_read(name, NULL, &r, &error), "%s", error.text);
    assert_int_equal(r.nx, NX);
    assert_int_equal(r.ny, NY);
    for (size_t k = 0; k < N; k++)
        check(r.z[k] == wanted[k] || (isnan(r.z[k]) && isnan(wanted[k])), "%s: sample %zu is %a, not %a", name, k,
              (double)r.z[k], (double)wanted[k]);
    for (int k = 0; k < 12; k++) assert_true(r.map[k / 4][k % 4] == map[k / 4][k % 4]);
    io_raster_free(&r);
    io_raster_free(&r); /* does nothing now */
}

static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

static void arrays_of_every_type(void **state) {
    (void)state;
    double f8[N];
    int16_t i2[N];
    uint16_t u2[N];
    for (size_t k = 0; k < N; k++) {
        f8[k] = (double)heights[k];
        i2[k] = (int16_t)heights[k];
        u2[k] = (uint16_t)heights[k];
    }
    make_npy("f4.npy", "<f4", heights, sizeof heights);
    make_npy("f8.npy", "<f8", f8, sizeof f8);
    make_npy("i2.NPY", "<i2", i2, sizeof i2);
    make_npy("u2.npy", "<u2", u2, sizeof u2);
    check_heights("f4.npy", heights, identity);
    check_heights("f8.npy", heights, identity);
    check_heights("i2.NPY", heights, identity);
    check_heights("u2.npy", heights, identity);

    /* The ends of the ranges. */
    i2[0] = INT16_MIN;
    u2[0] = UINT16_MAX;
    float wanted[N];
    memcpy(wanted, heights, sizeof wanted);
    make_npy("i2.npy", "<i2", i2, sizeof i2);
    make_npy("u2.npy", "<u2", u2, sizeof u2);
    wanted[0] = -32768;
    check_heights("i2.npy", wanted, identity);
    wanted[0] = 65535;
    check_heights("u2.npy", wanted, identity);
    f8[0] = NAN;
    f8[1] = INFINITY;
    f8[2] = 0x1.0000011p0; /* rounded */
    make_npy("f8.npy", "<f8", f8, sizeof f8);
    wanted[0] = NAN;
    wanted[1] = INFINITY;
    wanted[2] = 0x1.000002p0f;
    check_heights("f8.npy", wanted, identity);
}

#define ASC_SAMPLES "0 1 2 3\n40 5e2 +6000. 32767\n8 9.0 1.0E+1\n11"

static void ascii_grids(void **state) {
    (void)state;
    /* Pixels are 10 by 10, the lower left corner at (100, 200): the first sample, of the northern row, is a pixel's
     * centre at (105, 225). */
    static const double map[3][4] = {{10, 0, 0, 105}, {0, -10, 0, 225}, {0, 0, 1, 0}};
    static const double oblong[3][4] = {{10, 0, 0, 100}, {0, -20, 0, 240}, {0, 0, 1, 0}};
    static const char corner[] = "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\n" ASC_SAMPLES;
    static const char centre[] =
        "NROWS 3\r\nNCOLS 4\r\nYLLCENTER 205\r\nXLLCENTER 105\r\nCELLSIZE 10\r\n" ASC_SAMPLES "\r\n";
    static const char sides[] =
        "ncols 4 nrows 3 xllcenter 1e2 yllcenter 200 dx 10 dy 20 nodata_value -9999 " ASC_SAMPLES;
    static const char holes[] =
        "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value 3.0\n" ASC_SAMPLES;
    static const char words[] = "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\nnodata_value nan\nnan 1 "
                                "2 NaN 40 500 6000 32767 8 9 10 11";
    static const char doubles[] =
        "ncols 4\nnrows 3\nxllcorner 100\nyllcorner 200\ncellsize 10\n"
        "nodata_value -1.7976931348623157e308\n0 1 2 -1.7976931348623157e308 40 500 6000 32767 8 9 10 11";
    scratch_write("a.asc", corner, sizeof corner - 1);
    check_heights("a.asc", heights, map);
    scratch_write("b.asc", centre, sizeof centre - 1);
    check_heights("b.asc", heights, map);
    scratch_write("c.asc", sides, sizeof sides - 1);
    check_heights("c.asc", heights, oblong);

    float wanted[N];
    memcpy(wanted, heights, sizeof wanted);
    wanted[3] = NAN;
    scratch_write("d.asc", holes, sizeof holes - 1);
    check_heights("d.asc", wanted, map);
    scratch_write("e.asc", doubles, sizeof doubles - 1);
    check_heights("e.asc", wanted, map);
    wanted[0] = NAN;
    scratch_write("f.asc", words, sizeof words - 1);
    check_heights("f.asc", wanted, map);
}

static void check_refused(const char *name, const char *part) {
    io_raster r;
    io_error error = {""};
    check(!io_raster_read(name, NULL, &r, &error), "%s was read as a raster", name);
    check(strncmp(error.text, name, strlen(name)) == 0, "%s is not named in '%s'", name, error.text);
    check(strstr(error.text, part) != NULL, "'%s' is not in '%s'", part, error.text);
}

#define ASC_HEAD "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n"

static void bad_grids_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"", "truncated"},
        {"ncols 4\n", "nrows"},
        {"nrows 3\n", "ncols"},
        {"ncols 4\nnrows 3\n" ASC_SAMPLES, "cellsize"},
        {"ncols 4\nncols 4\n", "bad.asc:2: 'ncols'"},
        {"ncols 4\nheight 3\n", "bad.asc:2: 'height'"},
        {"ncols four\n", "bad.asc:1: 'four'"},
        {"ncols 4.5\n", "bad.asc:1: '4.5'"},
        {"ncols -4\n", "bad.asc:1: '-4'"},
        {"ncols 99999999999\n", "99999999999"},
        {"ncols 0x4\n", "0x4"},
        {"ncols 2147483648\nnrows 2147483648\ncellsize 1\n0 0", "truncated"},
        {"ncols 1000000000\nnrows 3\ncellsize 1\n0 0", "truncated"},
        {"ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0\n" ASC_SAMPLES, "not positive"},
        {"ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize inf\n" ASC_SAMPLES, "'inf'"},
        {"ncols 4\nnrows 3\nxllcorner 0\nxllcenter 0\ncellsize 1\n" ASC_SAMPLES, "corner and centre"},
        {"ncols 4\nnrows 3\ndx 1\ncellsize 1\n" ASC_SAMPLES, "cellsize and dx"},
        {ASC_HEAD "0 1 2 3\n4 5 6 7\n8 9 10", "bad.asc:8: truncated"},
        {ASC_HEAD "0 1 2 3\n4 5 six 7\n8 9 10 11", "bad.asc:7: 'six'"},
        {ASC_HEAD "0 1 2 3\n4 5 6x 7\n8 9 10 11", "bad.asc:7: '6x'"},
        {ASC_HEAD "0 1 2 3\n4 5 6-7\n8 9 10 11 12", "bad.asc:7: '6-7'"},
        {ASC_HEAD "0 1 2 3\n4 5 inf 7\n8 9 10 11", "bad.asc:7: 'inf'"},
        {ASC_HEAD "0 1 2 3\n4 5 0x6 7\n8 9 10 11", "bad.asc:7: '0x6'"},
        {ASC_HEAD "0 1 2 1e39\n4 5 6 7\n8 9 10 11", "range of float"},
        {ASC_HEAD "0 1 2 3\n4 5 6 7\n8 9 10 11\n12", "bad.asc:9: '12'"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        scratch_write("bad.asc", cases[k].text, strlen(cases[k].text));
        check_refused("bad.asc", cases[k].part);
    }
    static const char nul[] = ASC_HEAD "0 1 2 3\n4 5 6 7\n8 9 10 11\0 ";
    scratch_write("bad.asc", nul, sizeof nul - 1);
    check_refused("bad.asc", "bad.asc:8");
}

static void bad_arrays_are_refused(void **state) {
    (void)state;
    double f8[N] = {0};
    make_npy("bad.npy", "|u1", f8, N);
    check_refused("bad.npy", "'|u1'");
    make_npy("bad.npy", ">f4", f8, N * 4);
    check_refused("bad.npy", "'>f4'");
    f8[7] = -1e39;
    make_npy("bad.npy", "<f8", f8, sizeof f8);
    check_refused("bad.npy", "[1, 3] is -1e+39");
    static const char line[] = "\x93NUMPY\1\0\x3a\0{'descr': '<f4', 'fortran_order': False, 'shape': (2,), } 12345678";
    scratch_write("bad.npy", line, sizeof line - 1);
    check_refused("bad.npy", "shape (2,)");
    check_refused("absent.npy", "No such file");
    check_refused("absent.asc", "No such file");
    check_refused("field.xyz", "known endings are .npy");
    check_refused("npy", "known endings are .npy");
}

/* Sides whose product is 0 agree with a file without data, however long the other one is. */
static void rasters_of_nothing_are_refused(void **state) {
    (void)state;
    static const char *const types[] = {"<f8", "<i2", "<f4"};
    static const char *const shapes[] = {"(9223372036854775807, 0)", "(0, 1000000000)", "(0, 0)"};
    alarm(10); /* a loop over all rows is the end of the test */
    for (size_t k = 0; k < 9; k++) {
        char bytes[256] = "\x93NUMPY\x01";
        const int length = snprintf(bytes + 10, 200, "{'descr': '%s', 'fortran_order': False, 'shape': %s, }",
                                    types[k / 3], shapes[k % 3]);
        bytes[8] = (char)length;
        scratch_write("bad.npy", bytes, 10 + (size_t)length);
        check_refused("bad.npy", "holds no samples");
    }
    alarm(0);
}

static void what_the_caller_knows(void **state) {
    (void)state;
    io_raster r;
    io_error error = {""};
    make_npy("a.npy", "<f4", heights, sizeof heights);
    const io_raster_options options = {
        .nodata = (const double[]){500, 6000}, .nodata_count = 2, .cellsize = 30, .zscale = 0.5};
    check(io_raster_read("a.npy", &options, &r, &error), "%s", error.text);
    for (size_t k = 0; k < N; k++) assert_true(k == 5 || k == 6 ? isnan(r.z[k]) : r.z[k] == heights[k]);
    static const double map[3][4] = {{30, 0, 0, 0}, {0, -30, 0, 60}, {0, 0, 0.5, 0}}; /* the first row in the north */
    for (int k = 0; k < 12; k++) assert_true(r.map[k / 4][k % 4] == map[k / 4][k % 4]);
    assert_true(r.georef.placed && r.georef.has_nodata && r.georef.nodata == 500);
    io_raster_free(&r);
    /* Row 0 in the north, a cell wide 1, and a word on it, where the caller wants it so. */
    const io_raster_options north_up = {.north_up = true};
    check(io_raster_read("a.npy", &north_up, &r, &error), "%s", error.text);
    static const double upright[3][4] = {{1, 0, 0, 0}, {0, -1, 0, 2}, {0, 0, 1, 0}};
    for (int k = 0; k < 12; k++) assert_true(r.map[k / 4][k % 4] == upright[k / 4][k % 4]);
    assert_false(r.georef.placed);
    io_raster_free(&r);
    static const io_raster_options second = {.band = 2};
    assert_false(io_raster_read("a.npy", &second, &r, &error));
    check(strstr(error.text, "has one band") != NULL, "%s", error.text);

    static const char grid[] = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n" ASC_SAMPLES;
    scratch_write("a.asc", grid, sizeof grid - 1);
    assert_false(io_raster_read("a.asc", &options, &r, &error));
    check(strstr(error.text, "the file gives the distance") != NULL, "%s", error.text);
}

/* The coordinate system stands in a file beside the grid. */
static void systems_beside_grids(void **state) {
    (void)state;
    static const char grid[] = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n" ASC_SAMPLES;
    static const struct {
        const char *wkt, *name;
        bool geographic;
        double unit, semi_major;
    } cases[] = {
        {"PROJCS[\"UTM [32]\",GEOGCS[\"WGS\",DATUM[\"D\",SPHEROID[\"WGS_1984\",6378137.0,298.257223563]],"
         "PRIMEM[\"Greenwich\",0],UNIT[\"Degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
         "PARAMETER[\"Scale\",0.9996],UNIT[\"Foot_US\",0.3048006096012192]]",
         "UTM [32]", false, 0.3048006096012192, 6378137},
        {"GEOGCS[\"GCS\", DATUM[\"D\", SPHEROID[\"Sphere\", 6371000, 0]], UNIT[\"Degree\", 0.0174532925199433]]", "GCS",
         true, 0.0174532925199433, 6371000},
        {"COMPD_CS[\"both\",PROJCS[\"a\",UNIT[\"m\",1]],VERT_CS[\"h\",UNIT[\"ft\",0.3048]]]", "both", false, 1, 0},
        {"PROJCS[\"no unit\",GEOGCS[\"b\",UNIT[\"Degree\",0.0174532925199433]]]", "no unit", false, 0, 0},
        {"PROJCRS[\"new\",BASEGEOGCRS[\"b\",DATUM[\"d\",ELLIPSOID[\"e\",6378137,298,LENGTHUNIT[\"metre\",1]]]],"
         "CS[Cartesian,2],AXIS[\"x\",east],LENGTHUNIT[\"metre\",1]]",
         "new", false, 1, 6378137},
        {"no system", "", false, 0, 0},
        {"PROJCS[\"open", "", false, 0, 0},
    };
    scratch_write("a.asc", grid, sizeof grid - 1);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        io_raster r;
        io_error error = {""};
        char name[64];
        scratch_write("a.prj", cases[k].wkt, strlen(cases[k].wkt));
        check(io_raster_read("a.asc", NULL, &r, &error), "%s", error.text);
        io_georef_name(&r.georef, name, sizeof name);
        assert_string_equal(name, cases[k].name);
        check(r.georef.geographic == cases[k].geographic && r.georef.unit == cases[k].unit &&
                  r.georef.semi_major == cases[k].semi_major,
              "case %zu: unit %.17g, semi-major %.17g", k, r.georef.unit, r.georef.semi_major);
        assert_true((r.georef.crs != NULL) == (cases[k].name[0] != '\0'));
        io_raster_free(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(arrays_of_every_type, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(ascii_grids, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_the_caller_knows, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(systems_beside_grids, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_grids_are_refused, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_arrays_are_refused, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(rasters_of_nothing_are_refused, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
