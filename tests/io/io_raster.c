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

static void check_refused(const char *name, const char *part) {
    io_raster r;
    io_error error = {""};
    check(!io_raster_read(name, NULL, &r, &error), "%s was read as a raster", name);
    check(strncmp(error.text, name, strlen(name)) == 0, "%s is not named in '%s'", name, error.text);
    check(strstr(error.text, part) != NULL, "'%s' is not in '%s'", part, error.text);
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
    unsetenv("CELLWALK_MODULES"); /* which may name a folder with the module for GDAL */
    check_refused("field.asc", "only .npy is read without GDAL");
    check_refused("npy", "only .npy is read without GDAL");
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
}

/* What the Python module takes of coordinate systems that others give it. */
static void systems_in_text(void **state) {
    (void)state;
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
        {"PROJCRS[\"by axis\",BASEGEOGCRS[\"b\",DATUM[\"d\",ELLIPSOID[\"e\",6378137,298,LENGTHUNIT[\"metre\",1]]]],"
         "CONVERSION[\"c\",PARAMETER[\"p\",1,LENGTHUNIT[\"km\",1000]]],CS[Cartesian,2],"
         "AXIS[\"x\",east,LENGTHUNIT[\"ft\",0.3048]],AXIS[\"y\",north,LENGTHUNIT[\"ft\",0.3048]]]",
         "by axis", false, 0.3048, 6378137},
        {"no system", "", false, 0, 0},
        {"PROJCS[\"open", "", false, 0, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        io_georef g = {0};
        char name[64];
        assert_true(io_georef_from_wkt(&g, cases[k].wkt) == (cases[k].name[0] != '\0'));
        io_georef_name(&g, name, sizeof name);
        assert_string_equal(name, cases[k].name);
        check(g.geographic == cases[k].geographic && g.unit == cases[k].unit && g.semi_major == cases[k].semi_major,
              "case %zu: unit %.17g, semi-major %.17g", k, g.unit, g.semi_major);
        io_georef_free(&g);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(arrays_of_every_type, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_the_caller_knows, scratch_enter, scratch_leave),
        cmocka_unit_test(systems_in_text),
        cmocka_unit_test_setup_teardown(bad_arrays_are_refused, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(rasters_of_nothing_are_refused, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
