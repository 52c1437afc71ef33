/* SPDX-License-Identifier: Apache-2.0 */
/* shadow, horizon, viewshed and los as users run them: files in, files out, on made-up land and on a real one; and what they
 * refuse. */

#include "brute_sight.h"
#include "ground.h"
#include "program.h"
#include "raster.h"
#include "refused.h"
#include "tool_files.h"

#include <unistd.h>

/* Luxembourg in degrees, from SRTM: Debian's r-cran-terra. */
static const char real[] = "/usr/lib/R/site-library/terra/ex/elev.tif";

static bool have_real(void) {
    io_raster raster;
    io_error error;
    if (io_raster_read(real, NULL, &raster, &error)) {
        io_raster_free(&raster);
        return true;
    }
    print_message("skipped: %s (Debian: r-cran-terra)\n", error.text);
    return false;
}

static const program_result *run_well(program_arguments arguments) {
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    check(r->err[0] == '\0', "standard error: %s", r->err);
    return r;
}

/* The elements of an array of n elements; the caller frees *file. */
static const void *elements(const char *name, size_t bytes, char **file) {
    size_t size;
    *file = scratch_read(name, &size);
    check(size > bytes, "%s has %zu bytes, less than %zu", name, size, bytes);
    return *file + (size - bytes);
}

enum { NX = 60, NY = 50 };

/* A wall of 40 m along row 20, on level ground. */
static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) z[k] = k / NX == 20 ? 40 : 0;
    field_file("wall.npy", z, NX, NY);
    return 0;
}

static void shadow_of_a_wall(void **state) {
    (void)state;
    /* The sun in the north, 45 degrees high: 40 m of shadow to the south, over four rows. The ray from the fourth touches
     * the wall's top, to rounding; so the sun is a little higher. */
    run_well((const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--sun", "0,45.1", "-o", "s.npy", NULL});
    char *file;
    const uint8_t *lit = elements("s.npy", NX * NY, &file);
    for (size_t j = 0; j < NY; j++)
        for (size_t i = 0; i < NX; i++) assert_int_equal(lit[j * NX + i], !(j > 20 && j < 24));
    free(file);
    /* Twice as high, twice as long; the same file in single bytes as a picture. */
    run_well((const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--zscale", "2", "--sun", "0,45.1", "-o",
                                   "s.npy", NULL});
    lit = elements("s.npy", NX * NY, &file);
    for (size_t j = 0; j < NY; j++) assert_int_equal(lit[j * NX], !(j > 20 && j < 28));
    free(file);
    run_well((const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--nodata", "40", "--sun", "0,45.1",
                                   "--hillshade", "-o", "s.npy", NULL});
    const float *light = elements("s.npy", 4 * NX * NY, &file);
    for (size_t j = 0; j < NY; j++)
        check(j == 20 ? isnan(light[j * NX]) : fabs((double)light[j * NX] - sin(45.1 * 0.017453292519943295)) < 1e-6,
              "row %zu: %g", j, (double)light[j * NX]);
    free(file);
}

/* Every second row: the wall is as high two rows on, and three coarser rows thick. Each output has as many samples as the
 * coarser terrain, and standard error says how far that lies from the full one. */
static void coarser_wall(void **state) {
    (void)state;
    enum { COARSE_NX = 31, COARSE_NY = 26 };
    const program_result *r = program_run(NULL, (const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--sun",
                                                                      "0,45.1", "--coarser", "2", "--filter", "highest",
                                                                      "--zscale", "0.5", "-o", "s.npy", NULL});
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    check(strstr(r->err, "31 x 26 samples for 60 x 50") && strstr(r->err, "up to 20 above and 0 below"), "%s", r->err);
    char *file;
    const uint8_t *lit = elements("s.npy", COARSE_NX * COARSE_NY, &file);
    for (size_t k = 0; k < COARSE_NX * COARSE_NY; k++) assert_int_equal(lit[k], 1);
    free(file);
    r = program_run(NULL, (const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--sun", "0,45.1",
                                                "--coarser=2", "--filter=highest", "-o", "s.npy", NULL});
    lit = elements("s.npy", COARSE_NX * COARSE_NY, &file);
    for (size_t k = 0; k < COARSE_NX * COARSE_NY; k++) assert_int_equal(lit[k], k / COARSE_NX != 12);
    free(file);
    /* What needs no field otherwise, and a place on the same map. */
    r = program_run(NULL, (const char *const[]){"los", "wall.npy", "50,490,+1", "50,0,+1", "--cellsize", "10",
                                                "--coarser", "2", "--filter", "lowest", NULL});
    check(r->status == 0 && strstr(r->out, "visible") && strstr(r->err, "up to 0 above and 40 below"), "%s%s", r->out,
          r->err);
}

static void horizon_at_a_wall(void **state) {
    (void)state;
    run_well(
        (const char *const[]){"horizon", "wall.npy", "--cellsize", "10", "--directions", "4", "-o", "h.npy", NULL});
    char *file;
    const float *angle = elements("h.npy", 4ul * 4 * NX * NY, &file);
    const size_t at = 30 * NX + 30; /* x = 300, y = 190 */
    const double up = atan(40 / 100.0) * 180 / 3.141592653589793;
    assert_true(fabs((double)angle[at] - up) < 1e-3);
    for (size_t d = 1; d < 4; d++) assert_true(angle[d * NX * NY + at] == 0);
    free(file);
    const program_result *r = run_well(
        (const char *const[]){"horizon", "wall.npy", "--cellsize", "10", "--directions", "4", "--at", "300,190", NULL});
    check(strcmp(r->out, "place,azimuth,true_azimuth,angle,distance,x,y\n1,0,,21.801409,100.000,300,290\n"
                         "1,90,,0.000000,10.000,310,190\n1,180,,0.000000,10.000,300,180\n"
                         "1,270,,0.000000,10.000,290,190\n") == 0,
          "%s", r->out);
    /* Of several places the nearest. */
    run_well((const char *const[]){"horizon", "wall.npy", "--cellsize", "10", "--directions", "4", "--distance", "-o",
                                   "h.npy", NULL});
    const float *metres = elements("h.npy", 4ul * 4 * NX * NY, &file);
    for (size_t d = 0; d < 4; d++) assert_true(metres[d * NX * NY + at] == (d == 0 ? 100 : 10));
    for (size_t i = 0; i < NX; i++) assert_true(isnan(metres[i]));
    free(file);
    run_well((const char *const[]){"horizon", "wall.npy", "--cellsize", "10", "--directions", "4", "--svf", "-o",
                                   "h.npy", NULL});
    const float *sky = elements("h.npy", 4ul * NX * NY, &file);
    const double wanted = (3 + pow(cos(up * 3.141592653589793 / 180), 2)) / 4;
    check(fabs((double)sky[at] - wanted) < 1e-6, "%g, not %g", (double)sky[at], wanted);
    free(file);
}

/* The cells of a band of a raster, read again. */
static io_raster read_band(const char *name, unsigned band) {
    io_raster raster;
    io_error error = {""};
    check(io_raster_read(name, &(io_raster_options){.band = band}, &raster, &error), "%s", error.text);
    return raster;
}

/* Int16 with a scale: no value is off by more than half a step, in a COG neither, and no data stay no data. */
static void scaled_integers(void **state) {
    (void)state;
    if (!have_real()) skip();
    static const struct {
        const char *product;
        double step;
        unsigned bands;
    } cases[] = {{"--curvature=0", 0x1p-8, 3}, {"--svf", 0x1p-14, 1}};
    for (size_t k = 0; k < 2; k++) {
        run_well(
            (const char *const[]){"horizon", real, cases[k].product, "--directions", "3", "-o", "float.tif", NULL});
        run_well((const char *const[]){"horizon", real, cases[k].product, "--directions", "3", "--type", "int16",
                                       "--cog", "-o", "int.tif", NULL});
        for (unsigned b = 1; b <= cases[k].bands; b++) {
            io_raster wanted = read_band("float.tif", b), got = read_band("int.tif", b);
            size_t holes = 0, between = 0;
            for (size_t n = 0; n < got.nx * got.ny; n++) {
                const double off = fabs((double)got.z[n] - (double)wanted.z[n]);
                assert_true(isnan(got.z[n]) == isnan(wanted.z[n]));
                holes += isnan(got.z[n]) ? 1 : 0;
                between += off > 0;
                check(isnan(got.z[n]) || off <= cases[k].step / 2, "%g is %g", (double)wanted.z[n], (double)got.z[n]);
            }
            check(holes > 3000 && between > 1000, "%zu holes, %zu rounded", holes, between);
            assert_true(got.georef.scale == cases[k].step && got.georef.offset == 0 && wanted.georef.scale == 0);
            io_raster_free(&wanted);
            io_raster_free(&got);
        }
    }
    const program_result *r = program_run(NULL, (const char *const[]){"info", "int.tif", NULL});
    check(strstr(r->out, "stored        heights are 0 + 6.10351562e-05 x the file's numbers") != NULL, "%s", r->out);
    r = program_run(NULL, (const char *const[]){"info", "int.tif", "--json", NULL});
    check(strstr(r->out, "\"scale\": 6.103515625e-05, \"offset\": 0") != NULL, "%s", r->out);
}

static void files_for_gdal(void **state) {
    (void)state;
    if (!have_real()) skip();
    static const char *const formats[] = {"--co=BIGTIFF=YES", "--co=BIGTIFF=NO"};
    for (size_t k = 0; k < 2; k++) {
        size_t size;
        run_well((const char *const[]){"shadow", real, "--sun", "0,30", formats[k], "--co", "compress=LZW", "-o",
                                       "s.tif", NULL});
        char *file = scratch_read("s.tif", &size);
        assert_int_equal(file[2], k == 0 ? 43 : 42);
        free(file);
    }
    check_refused((const char *const[]){"shadow", real, "--sun", "0,30", "--co", "FOO=1", "-o", "no.tif", NULL}, 1,
                  "creation option FOO");
    check_refused((const char *const[]){"shadow", real, "--sun", "0,30", "--co", "BIGTIFF", "-o", "no.tif", NULL}, 1,
                  "--co takes NAME=VALUE, not 'BIGTIFF'");
    check_refused(
        (const char *const[]){"shadow", real, "--sun", "0,30", "--cog", "--co", "TILED=NO", "-o", "no.tif", NULL}, 1,
        "creation option TILED");
}

static void view_of_a_wall(void **state) {
    (void)state;
    static uint8_t sum[NX * NY];
    char *file;
    /* From the south all up to the wall; from the north the rest; both together are counted. */
    static const char *const places[] = {"300,100,1.7", "250,400,1.7"};
    for (int k = 0; k < 2; k++) {
        run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "10", "--from", places[k], "--curvature",
                                       "0", "-o", "v.npy", NULL});
        const uint8_t *seen = elements("v.npy", NX * NY, &file);
        for (size_t n = 0; n < NX * NY; n++) {
            const size_t j = n / NX;
            check(seen[n] == (k ? j <= 20 : j >= 20), "(%zu, %zu) from %s: %d", n % NX, j, places[k], seen[n]);
            sum[n] = (uint8_t)(sum[n] + seen[n]);
        }
        free(file);
    }
    run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "10", "--from", places[0], "--from", places[1],
                                   "--curvature", "0", "-o", "v.npy", NULL});
    assert_memory_equal(elements("v.npy", NX * NY, &file), sum, NX * NY);
    free(file);
    /* What stands 10 rows behind the wall, 20 from the eye, must be 80 m high less what the eye is. */
    run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "10", "--from", "300,190,0", "--curvature",
                                   "0", "--needed", "-o", "v.npy", NULL});
    const float *needed = elements("v.npy", 4ul * NX * NY, &file);
    check(fabs((double)needed[10 * NX + 30] - 80) < 1e-4, "%g m are needed", (double)needed[10 * NX + 30]);
    free(file);
}

/* At the pole the sun turns about at one height, 20 degrees in late May: all sides of the wall have shadow for a while; level
 * ground far from it has the whole day. With --irradiance the bands are direct and diffuse light. */
static void sun_at_a_wall(void **state) {
    (void)state;
    run_well((const char *const[]){"sun", "wall.npy", "--cellsize", "10", "--lon-lat", "0,90", "--date", "2024-05-21",
                                   "--step", "1h", "-o", "s.npy", NULL});
    char *file;
    const float *hours = elements("s.npy", 4ul * NX * NY, &file);
    for (size_t j = 0; j < NY; j++) {
        /* 40 m at 20.2 degrees are 109 m of shadow, 10.9 rows; the wall as seen 8 rows off fills nearly half of the round. */
        const float h = hours[j * NX + NX / 2];
        const size_t off = j > 20 ? j - 20 : 20 - j;
        check(off == 0 || off > 10 ? h == 24 : off < 9 ? h >= 12 && h < 20 : h < 24, "row %zu: %g h", j, (double)h);
    }
    free(file);
    run_well((const char *const[]){"sun", "wall.npy", "--cellsize", "10", "--lon-lat", "0,90", "--date", "2024-05-21",
                                   "--to", "2024-05-22", "--irradiance", "--linke", "2", "-o", "s.npy", NULL});
    const float *energy = elements("s.npy", 2ul * 4 * NX * NY, &file);
    const size_t far = 45 * NX + 30, near = 22 * NX + 30, all = NX * NY;
    /* By the formulas at the almanac's mean declination, 20 degrees 20.7', with 1.0122 astronomical units and 0.045 degrees of
     * refraction. From that the declination strays by 12' on either side, and light with it by 1.4 % at most. */
    check(fabs((double)energy[far] / (48 * 294.1) - 1) < 0.02, "%g Wh", (double)energy[far]);
    check(fabs((double)energy[all + far] / (48 * 44.7) - 1) < 0.02, "%g Wh", (double)energy[all + far]);
    check(energy[near] < 0.8f * energy[far] && energy[all + near] < 0.8f * energy[all + far], "%g and %g Wh near",
          (double)energy[near], (double)energy[all + near]);
    free(file);
    static const char *const base[] = {"sun", "wall.npy", "--cellsize", "10", "-o", "s.npy"};
    static const struct {
        const char *more[7], *why;
        int status;
    } cases[] = {
        {{NULL}, "--date is missing", 2},
        {{"--date", "yesterday"}, "not 'yesterday'", 2},
        {{"--date", "2024-02-30"}, "not '2024-02-30'", 2},
        {{"--date", "2024-06-21"}, "names no coordinate system", 1},
        {{"--date", "2024-06-21", "--to", "2024-06-20"}, "is before", 2},
        {{"--date", "2024-06-21", "--step", "7min"}, "divides a day", 2},
        {{"--date", "2024-06-21", "--step", "15"}, "not '15'", 2},
        {{"--date", "2024-06-21", "--linke", "3"}, "go with --irradiance", 2},
        {{"--date", "2024-06-21", "--irradiance", "--linke", "0"}, "from 1 to 10, not 0", 2},
        {{"--date", "2024-06-21", "--lon-lat", "7"}, "not '7'", 2},
        {{"--date", "2000-06-21", "--to", "2024-06-20", "--step", "30s"}, "longer --step", 2},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *arguments[16] = {NULL};
        memcpy(arguments, base, sizeof base);
        for (size_t n = 0; n < 7 && cases[k].more[n]; n++) arguments[6 + n] = cases[k].more[n];
        check_refused(arguments, cases[k].status, cases[k].why);
    }
}

/* Larger than what is written at once, with the wall in the last block. */
static void large_view(void **state) {
    (void)state;
    enum { WIDE = 2000, LONG = 600, WALL = 590 };
    static float z[WIDE * LONG];
    for (size_t k = 0; k < WIDE * LONG; k++) z[k] = k / WIDE == WALL ? 40 : 0;
    field_file("large.npy", z, WIDE, LONG);
    run_well((const char *const[]){"viewshed", "large.npy", "--cellsize", "10", "--from", "9000,5990", "--curvature",
                                   "0", "-o", "v.npy", NULL});
    char *file;
    const uint8_t *seen = elements("v.npy", WIDE * LONG, &file);
    for (size_t k = 0; k < WIDE * LONG; k++)
        check(seen[k] == (k / WIDE <= WALL), "(%zu, %zu): %d", k % WIDE, k / WIDE, seen[k]);
    free(file);
}

static void lines_at_a_wall(void **state) {
    (void)state;
    const program_result *r = run_well((const char *const[]){"los", "wall.npy", "300,190,2", "300,390,=30",
                                                             "--cellsize", "10", "--curvature", "0", NULL});
    /* The line rises 28 m in 200; the wall's flank 40 m in the last 10 of 100: they meet at 94.3 m. */
    const double met = (90 * 4 + 2) / (4 - 0.14);
    double x, y, z, from, of;
    static const char says[] = "blocked: %lf m from the first place, of %lf m, at a height of %lf m\nat %lf,%lf\n";
    check(sscanf(r->out, says, &from, &of, &z, &x, &y) == 5, "%s", r->out);
    check(x == 300 && fabs(z - 2 - 0.14 * met) < 1e-3 && fabs(from - met) < 1e-3 && fabs(y - 190 - met) < 1e-3 &&
              of == 200,
          "%s, not %g", r->out, met);
    r = run_well((const char *const[]){"los", "wall.npy", "300,190,+2", "300,390,=85", "--cellsize", "10",
                                       "--curvature", "0", "--json", NULL});
    check(strcmp(r->out, "{\"visible\": true, \"distance\": 200}\n") == 0, "%s", r->out);
}

static void what_is_refused(void **state) {
    (void)state;
    check_refused((const char *const[]){"horizon", "wall.npy", "--type", "int16", "-o", "no.npy", NULL}, 2,
                  "--type int16 goes with -o FILE.tif");
    check_refused((const char *const[]){"horizon", "wall.npy", "--type", "int16", "--distance", "-o", "no.tif", NULL},
                  2, "--type int16 has no room for --distance");
    check_refused((const char *const[]){"horizon", "wall.npy", "--distance", "--grid", "-o", "no.npy", NULL}, 2,
                  "give --distance without --grid");
    check_refused((const char *const[]){"horizon", "wall.npy", "--distance", "--svf", "-o", "no.npy", NULL}, 2,
                  "--distance goes with none of");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,9", "--cog", "-o", "no.npy", NULL}, 2,
                  "--cog goes with -o FILE.tif");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,9", "--co", "A=B", "-o", "no.npy", NULL}, 2,
                  "--co goes with -o FILE.tif");
    check_refused((const char *const[]){"shadow", "wall.npy", "--time", "2024-06-21T12:00:00Z", "-o", "no.npy", NULL},
                  1, "the sun's place at a time is not known; give --sun");
    check_refused((const char *const[]){"shadow", "wall.npy", "-o", "s.npy", NULL}, 2, "either --sun or --time");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,91", "-o", "s.npy", NULL}, 2,
                  "--sun 0,91: the second number is the altitude");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,30", NULL}, 2, "give -o FILE");
    check_refused((const char *const[]){"shadow", "wall.npy", "--time", "noon", "-o", "s.npy", NULL}, 2, "not 'noon'");
    check_refused((const char *const[]){"shadow", "wall.npy", "--time", "2024-06-21T12:00:00Z", "-o", "s.npy", NULL}, 1,
                  "names no coordinate system");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,30", "-o", "s.xyz", NULL}, 1,
                  "the name's ending tells no format");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,30", "-o", "./wall.npy", NULL}, 1,
                  "is the terrain itself");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,30", "--cellsize", "0", "-o", "s.npy", NULL},
                  2, "--cellsize takes a number above 0");
    check_refused((const char *const[]){"shadow", "wall.npy", "--sun", "0,30", "--band", "2", "-o", "s.npy", NULL}, 1,
                  "has one band, not 2");
    check_refused((const char *const[]){"viewshed", "wall.npy", "-o", "v.npy", NULL}, 2, "--from X,Y is missing");
    check_refused((const char *const[]){"viewshed", "wall.npy", "--from", "3;4", "-o", "v.npy", NULL}, 2, "not '3;4'");
    check_refused((const char *const[]){"horizon", "wall.npy", "-o", "h.png", NULL}, 1, "no room for 32 bands");
    check_refused((const char *const[]){"horizon", "wall.npy", "--compress", "zstd", "-o", "h.npy", NULL}, 2,
                  "--compress goes with -o FILE.tif");
    check_refused((const char *const[]){"horizon", "wall.npy", "--compress", "lzw", "-o", "h.tif", NULL}, 2,
                  "there are deflate, zstd, none");
    check_refused((const char *const[]){"los", "wall.npy", "5", "10,10,+2", NULL}, 2, "not '5'");
    /* Farther away than lines of sight are computed, where numbers no longer fit. */
    check_refused((const char *const[]){"los", "wall.npy", "1e308,1e308,=9", "10,10,2", NULL}, 1, "is too far away");
    check_refused((const char *const[]){"los", "wall.npy", "10,10,2", "1e8,3,=9", NULL}, 1, "is too far away");
    check_refused((const char *const[]){"viewshed", "wall.npy", "--from", "3,1e308,=9", "-o", "v.npy", NULL}, 1,
                  "is too far away");
}

/* One meaning of a place for all: H above ground, =Z absolute, and what is wrong with one is said. */
static void places_that_are_refused(void **state) {
    (void)state;
    /* 60 x 50 samples in cells of 1: column 70 does not exist, nor does row 55 from below; (5, 29) is on the wall. */
    static const struct {
        const char *place, *why;
    } cases[] = {
        {"70,5,2", "70,5,2: lies outside: the samples, which are the pixels' centres, go from X 0 to 59 and Y 0 to 49"},
        {"-300,4", "-300,4: lies outside"},
        {"20,55,+1", "20,55,+1: lies outside, but with X and Y exchanged it would not"},
        {"59.4,5,2", "59.4,5,2: lies in the outer half of a pixel"},
        {"3,4,2", "3,4,2: there is no data at that place"},
        {"5,29,=39", "5,29,=39: is under the ground, which is 40.000 m high there: X,Y,H counts H from the ground"},
        {"5,29,-1", "5,29,-1: is under the ground, which is 40.000 m high there"},
    };
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) z[k] = k / NX == 20 ? 40 : k == 45 * NX + 3 ? NAN : 0;
    field_file("holed.npy", z, NX, NY);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const char *const p = cases[k].place, *const why = cases[k].why;
        check_refused((const char *const[]){"viewshed", "holed.npy", "--from", p, "-o", "v.npy", NULL}, 1, why);
        check_refused((const char *const[]){"horizon", "holed.npy", "--at", p, NULL}, 1, why);
        check_refused((const char *const[]){"los", "holed.npy", "10,10,2", p, NULL}, 1, why);
        check_refused((const char *const[]){"los", "holed.npy", p, "10,10,2", NULL}, 1, why);
        check_refused((const char *const[]){"render", "holed.npy", "--from", p, "-o", "v.exr", NULL}, 1, why);
        check_refused((const char *const[]){"render", "holed.npy", "--to", p, "-o", "v.exr", NULL}, 1, why);
    }
    check_refused((const char *const[]){"los", "wall.npy", "1,2,=", "10,10,2", NULL}, 2, "not '1,2,='");
    check_refused((const char *const[]){"los", "wall.npy", "1,=2", "10,10,2", NULL}, 2, "not '1,=2'");
}

/* A height above ground and the absolute height that it comes to are the same place. */
static void heights_of_places(void **state) {
    (void)state;
    static const char *const same[2][2] = {{"300,290,+3", "300,290,=43"}, {"300,100,3", "300,100,=3"}};
    for (int n = 0; n < 2; n++) {
        char *file[2], *out[2];
        size_t size[2];
        for (int k = 0; k < 2; k++) {
            run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "10", "--from", same[n][k], "-o",
                                           "v.npy", NULL});
            file[k] = scratch_read("v.npy", &size[k]);
            out[k] = strdup(
                run_well((const char *const[]){"los", "wall.npy", "--cellsize", "10", same[n][k], "300,400,60", NULL})
                    ->out);
        }
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(file[0], file[1], size[0]);
        assert_string_equal(out[0], out[1]);
        for (int k = 0; k < 2; k++) {
            free(file[k]);
            free(out[k]);
        }
    }
}

/* Without a map row 0 is in the north and cells are 1 wide, as with --cellsize 1, and that is said. */
static void rows_without_a_map(void **state) {
    (void)state;
    static const char *const runs[][8] = {
        {"shadow", "wall.npy", "--sun", "20,60", "-o", "o.npy", NULL},
        {"horizon", "wall.npy", "--directions", "3", "-o", "o.npy", NULL},
        {"viewshed", "wall.npy", "--from", "7,35,60", "-o", "o.npy", NULL},
        {"render", "wall.npy", "--size", "30x20", "-o", "o.exr", NULL},
        {"los", "wall.npy", "7,3,2", "20,40,60", NULL},
        {"horizon", "wall.npy", "--at", "7,3,2", NULL},
    };
    for (size_t r = 0; r < sizeof runs / sizeof runs[0]; r++) {
        const char *arguments[16] = {NULL};
        size_t n = 0, size[2] = {0};
        char *file[2] = {NULL}, *out[2];
        for (; runs[r][n]; n++) arguments[n] = runs[r][n];
        const bool writes = strcmp(arguments[n - 2], "-o") == 0;
        for (int given = 0; given < 2; given++) {
            if (given) arguments[n] = "--cellsize", arguments[n + 1] = "1";
            if (given && strcmp(runs[r][0], "shadow") != 0 && strcmp(runs[r][0], "horizon") != 0 &&
                strcmp(runs[r][0], "render") != 0)
                arguments[n + 2] = "--curvature", arguments[n + 3] = "0";
            const program_result *p = program_run(NULL, arguments);
            check(p->status == 0, "%s: %s", runs[r][0], p->err);
            const bool said = strstr(p->err, "cells are read as 1 wide, row 0 as the northernmost") != NULL;
            check(said == !given, "%s: %s", runs[r][0], p->err);
            out[given] = strdup(p->out);
            if (writes) file[given] = scratch_read(arguments[n - 1], &size[given]);
        }
        assert_string_equal(out[0], out[1]);
        check(size[0] == size[1] && (!writes || memcmp(file[0], file[1], size[0]) == 0), "%s differs", runs[r][0]);
        for (int k = 0; k < 2; k++) {
            free(out[k]);
            free(file[k]);
        }
    }
    /* The sun in the north: shadow falls on what follows the wall in the file. */
    program_run(NULL, (const char *const[]){"shadow", "wall.npy", "--sun", "0,88", "-o", "o.npy", NULL});
    char *file;
    const uint8_t *lit = elements("o.npy", NX * NY, &file);
    assert_true(lit[19 * NX] == 1 && lit[21 * NX] == 0);
    free(file);
}

/* Each --nodata counts. */
static void several_kinds_of_no_data(void **state) {
    (void)state;
    run_well((const char *const[]){"shadow", "wall.npy", "--cellsize", "10", "--nodata", "40", "--nodata", "0", "--sun",
                                   "0,45", "-o", "s.npy", NULL});
    char *file;
    const uint8_t *lit = elements("s.npy", NX * NY, &file);
    for (size_t k = 0; k < NX * NY; k++) assert_int_equal(lit[k], 255);
    free(file);
    check_refused((const char *const[]){"shadow", "wall.npy", "--nodata", "x", "--sun", "0,45", "-o", "s.npy", NULL}, 2,
                  "--nodata takes a number, not 'x'");
}

/* A border sample has no horizon beyond the border: that is no data, and no angle that statistics would count. */
static void where_the_terrain_ends(void **state) {
    (void)state;
    run_well(
        (const char *const[]){"horizon", "wall.npy", "--cellsize", "10", "--directions", "1", "-o", "h.npy", NULL});
    char *file;
    const float *angle = elements("h.npy", 4ul * NX * NY, &file);
    for (size_t k = 0; k < NX * NY; k++)
        check(k < NX ? isnan(angle[k]) : angle[k] > -89, "(%zu, %zu): %g", k % NX, k / NX, (double)angle[k]);
    free(file);
}

/* A GeoTIFF says how it was made. Metadata are text in the file. */
static void outputs_describe_themselves(void **state) {
    (void)state;
    static const struct {
        const char *arguments[14], *says[6];
    } cases[] = {
        {{"shadow", "wall.npy", "--cellsize", "10", "--sun", "225.5,30", "-o", "o.tif"},
         {">225.5<", "SUN_ALTITUDE", "1 where the sun is seen, 0 in the shadow", "cellwalk " CW_VERSION}},
        {{"shadow", "wall.npy", "--cellsize", "10", "--sun", "225.5,30", "--hillshade", "-o", "o.tif"},
         {"cosine of the angle between sun and normal"}},
        {{"viewshed", "wall.npy", "--cellsize", "10", "--from", "300,100", "--from", "310,100,=7", "-o", "o.tif"},
         {">300,100,2<", ">310,100,=7<", "OBSERVER_2", "number of observers that see the target", "CURVATURE"}},
        {{"viewshed", "wall.npy", "--cellsize", "10", "--from", "300,100", "--needed", "-o", "o.tif"},
         {"height above ground that is needed to be seen", ">m<"}},
        {{"horizon", "wall.npy", "--cellsize", "10", "--directions", "3", "-o", "o.tif"},
         {"azimuth 240", ">degree<", "DIRECTIONS"}},
        {{"horizon", "wall.npy", "--cellsize", "10", "--directions", "3", "--svf", "-o", "o.tif"}, {"sky-view factor"}},
        {{"horizon", "wall.npy", "--cellsize", "10", "--directions", "3", "--svf-tilted", "-o", "o.tif"},
         {"reaches the leaning ground"}},
        {{"sun", "wall.npy", "--cellsize", "10", "--lon-lat", "7,47", "--date", "2024-06-21", "--irradiance", "-o",
          "o.tif"},
         {"Rigollier", ">2024-06-21<", "diffuse light on the ground", "LINKE", ">Wh/m2<"}},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        const program_result *r = program_run(NULL, cases[c].arguments);
        if (c == 0 && strstr(r->err, "GeoTIFF needs GDAL") != NULL) skip();
        check(r->status == 0 && r->err[0] == '\0', "%s", r->err);
        size_t size;
        char *bytes = scratch_read("o.tif", &size);
        for (size_t s = 0; cases[c].says[s]; s++)
            check(memmem(bytes, size, cases[c].says[s], strlen(cases[c].says[s])) != NULL, "%s %s does not say '%s'",
                  cases[c].arguments[0], cases[c].arguments[4], cases[c].says[s]);
        free(bytes);
    }
}

/* A place that is on a row but for a last digit is on it: on the ridge of the wall both sides are seen, not one. */
static void next_to_a_row(void **state) {
    (void)state;
    static const char *const places[] = {"7,29,0", "7,29.000000001,0", "7,28.999999999,0"};
    char *first = NULL;
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
        run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "1", "--curvature", "0", "--from",
                                       places[k], "-o", "v.npy", NULL});
        char *file;
        const uint8_t *seen = elements("v.npy", NX * NY, &file);
        if (k == 0) {
            assert_true(seen[7] == 1 && seen[49 * NX + 7] == 1);
            first = file;
            continue;
        }
        check(memcmp(seen, first + (seen - (const uint8_t *)file), NX * NY) == 0, "another view from %s than from %s",
              places[k], places[0]);
        free(file);
    }
    free(first);
}

/* One over the distance to a row is no number, if that is as small as can be. */
static void as_near_as_can_be(void **state) {
    (void)state;
    static const char *const places[] = {"7,1e-320,=2", "7,-1e-320,=2", "1e-300,7,=2"};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
        run_well((const char *const[]){"viewshed", "wall.npy", "--cellsize", "1", "--from", places[k], "--needed", "-o",
                                       "v.npy", NULL});
        char *file;
        const float *need = elements("v.npy", 4ul * NX * NY, &file);
        for (size_t n = 0; n < NX * NY; n++) assert_true(need[n] >= 0 && need[n] < 1000);
        free(file);
    }
}

/* What a VRT is made of is an input, too, however deep: whatever its name says, GDAL knows an ASCII grid by its content. */
static void sources_are_not_replaced(void **state) {
    (void)state;
    static const char grid[] = "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2 3\n4 5 6\n7 8 9\n";
    static const char vrt[] =
        "<VRTDataset rasterXSize=\"3\" rasterYSize=\"3\"><GeoTransform>0,10,0,30,0,-10</GeoTransform>"
        "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename "
        "relativeToVRT=\"1\">%s</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>\n";
    char outer[1024], inner[1024];
    snprintf(outer, sizeof outer, vrt, "inner.npy");
    snprintf(inner, sizeof inner, vrt, "grid.npy");
    scratch_write("outer.vrt", outer, strlen(outer));
    scratch_write("inner.npy", inner, strlen(inner));
    scratch_write("grid.npy", grid, sizeof grid - 1);
    const cw_ray ray = {.org = {1, 1, 9}, .dir = {0, 0, -1}, .tmax = 9};
    rays_file("rays.npy", &ray, 1);
    if (program_run(NULL, (const char *const[]){"info", "outer.vrt", NULL})->status != 0) skip(); /* no GDAL */
    static const char *const outputs[] = {"inner.npy", "grid.npy", "./grid.npy"};
    for (size_t k = 0; k < 3; k++) {
        const char *const to = outputs[k];
        const char *const runs[][8] = {
            {"shadow", "outer.vrt", "--sun", "0,30", "-o", to, NULL},
            {"horizon", "outer.vrt", "-o", to, NULL},
            {"viewshed", "outer.vrt", "--from", "15,15,2", "-o", to, NULL},
            {"trace", "outer.vrt", "rays.npy", "-o", to, NULL},
        };
        for (size_t r = 0; r < sizeof runs / sizeof runs[0]; r++) check_refused(runs[r], 1, "is also an input");
    }
    size_t size;
    char *now = scratch_read("grid.npy", &size);
    assert_int_equal(size, sizeof grid - 1);
    assert_memory_equal(now, grid, size);
    free(now);
}

/* Ctrl-C in the middle of a long run: no file remains. */
static void interrupted(void **state) {
    (void)state;
    enum { SIDE = 2000 };
    float *z = malloc(sizeof *z * SIDE * SIDE);
    assert_non_null(z);
    for (size_t k = 0; k < SIDE * SIDE; k++) z[k] = (float)((k * 2654435761u >> 7) % 1000);
    field_file("rough.npy", z, SIDE, SIDE);
    free(z);
    static const char *const runs[][10] = {
        {"horizon", "rough.npy", "--directions", "3600", "-o", "o.npy", NULL},
        {"horizon", "rough.npy", "--directions", "3600", "--svf", "-o", "o.npy", NULL},
    };
    /* A viewshed writes nothing before it is done. */
    static const char place[] = "1000,1000,100000";
    static const char *const view[] = {"viewshed", "rough.npy", "--from", place,   "--from",    place, "--from", place,
                                       "--from",   place,       "-o",     "o.npy", "--threads", "1",   NULL};
    check_interrupted(view, false);
    for (size_t k = 0; k < 2; k++) check_interrupted(runs[k], true);
}

static char *whole(const char *name, size_t *size) { return scratch_read(name, size); }

/* Products of a real terrain in degrees, with holes, are the same for each instruction set and number of threads. */
static void real_terrain_same_bits(void **state) {
    (void)state;
    if (!have_real()) return;
    static const char *const products[][10] = {
        {"shadow", real, "--sun", "130,4", "-o", "o.npy"},
        {"shadow", real, "--sun", "130,4", "--hillshade", "--sun-disc", "-o", "o.npy"},
        {"horizon", real, "--directions", "5", "-o", "o.npy"},
        {"horizon", real, "--svf", "-o", "o.npy"},
        {"viewshed", real, "--from", "6.1,49.75,30", "-o", "o.npy"},
        {"viewshed", real, "--from", "6.1,49.75,30", "--needed", "-o", "o.npy"},
    };
    for (size_t p = 0; p < sizeof products / sizeof products[0]; p++) {
        if (!test_takes(p, 3)) continue;
        char *first = NULL;
        size_t size = 0;
        for (cw_isa isa = CW_ISA_SCALAR; isa <= cw_isa_best(); isa++) {
            const char *arguments[16] = {NULL};
            size_t n = 0;
            for (; products[p][n]; n++) arguments[n] = products[p][n];
            arguments[n++] = "--threads";
            arguments[n++] = isa % 2 ? "1" : "3";
            const program_setting setting = {.isa = cw_isa_name(isa)};
            const program_result *r = program_run(&setting, arguments);
            check(r->status == 0, "%s", r->err);
            size_t length;
            char *bytes = whole("o.npy", &length);
            if (first == NULL) {
                first = bytes;
                size = length;
                continue;
            }
            check(length == size && memcmp(bytes, first, size) == 0, "%s differs with %s", products[p][0],
                  cw_isa_name(isa));
            free(bytes);
        }
        free(first);
    }
}

/* What is no GeoTIFF is read by GDAL's other drivers: here a window into the real terrain, made of text. */
static void another_format(void **state) {
    (void)state;
    if (!have_real()) return;
    static const char text[] =
        "<VRTDataset rasterXSize=\"40\" rasterYSize=\"30\"><VRTRasterBand dataType=\"Int16\" band=\"1\">"
        "<SimpleSource><SourceFilename>/usr/lib/R/site-library/terra/ex/elev.tif</SourceFilename><SourceBand>1</"
        "SourceBand>"
        "<SrcRect xOff=\"30\" yOff=\"30\" xSize=\"40\" ySize=\"30\"/><DstRect xOff=\"0\" yOff=\"0\" xSize=\"40\" "
        "ySize=\"30\"/></SimpleSource></VRTRasterBand></VRTDataset>";
    scratch_write("window.vrt", text, sizeof text - 1);
    run_well((const char *const[]){"shadow", "window.vrt", "--nodata", "-32768", "--cellsize", "1000", "--sun", "0,90",
                                   "-o", "s.npy", NULL});
    char *file;
    const uint8_t *lit = elements("s.npy", 40 * 30, &file);
    size_t holes = 0;
    for (size_t k = 0; k < 40 * 30; k++) {
        assert_true(lit[k] == 1 || lit[k] == 255);
        holes += lit[k] == 255;
    }
    assert_int_equal(holes, 98);
    free(file);
}

/* The view of a real terrain, sample by sample, by looking at every edge. */
static void real_view(void **state) {
    (void)state;
    if (!have_real()) return;
    io_raster raster;
    io_error error;
    assert_true(io_raster_read(real, NULL, &raster, &error));
    assert_true(raster.nx == 95 && raster.ny == 90 && raster.georef.geographic);
    const terrain_desc desc = {.nx = raster.nx,
                               .ny = raster.ny,
                               .z = raster.z,
                               .map = (const double(*)[4])raster.map,
                               .geographic = true,
                               .unit = raster.georef.unit,
                               .semi_major = raster.georef.semi_major,
                               .inverse_flattening = raster.georef.inverse_flattening};
    terrain t;
    assert_true(terrain_init(&t, &desc));
    run_well((const char *const[]){"viewshed", real, "--from", "6.1,49.75,30", "-o", "v.npy", NULL});
    char *file;
    const uint8_t *got = elements("v.npy", raster.nx * raster.ny, &file);
    double eye[3];
    terrain_from_map(&t, 6.1, 49.75, eye);
    eye[2] = terrain_height(&t, eye[0], eye[1]) + 30;
    sight s;
    sight_init(&s, &t, NULL, eye, 6.0 / 7);
    size_t seen = 0, holes = 0;
    for (size_t j = 0; j < raster.ny; j++)
        for (size_t i = 0; i < raster.nx; i++) {
            const size_t k = j * raster.nx + i;
            if (isnan(raster.z[k])) {
                assert_int_equal(got[k], 255);
                holes++;
                continue;
            }
            if (!test_takes(k, 4)) continue;
            const double steepest = brute_steepest(&s, (double)i, (double)j), top = sight_sample(&s, i, j);
            check(fabs(steepest - top) < 1e-5 || got[k] == (steepest < top), "(%zu, %zu): %d", i, j, got[k]);
            seen += got[k];
        }
    check(holes == 3942 && seen > 100 / test_step(4), "%zu holes, %zu seen", holes, seen);
    free(file);
    io_raster_free(&raster);
}

/* At noon the sun stands in the south, as high as 90 degrees less the latitude and its declination: 23.436 in summer. */
static void sun_by_time(void **state) {
    (void)state;
    if (!have_real()) return;
    const program_result *r =
        run_well((const char *const[]){"shadow", real, "--time", "2024-06-21T11:37:24Z", "-o", "s.npy", NULL});
    double azimuth = 0, altitude = 0;
    const char *at = strstr(r->out, "azimuth ");
    check(at && sscanf(at, "azimuth %lf (%*f on the map), altitude %lf degrees", &azimuth, &altitude) == 2, "%s",
          r->out);
    check(fabs(azimuth - 180) < 0.05 && fabs(altitude - (90 - 49.8167 + 23.436)) < 0.02, "%s", r->out);
}

/* East of a zone's middle the map's north points to the east of the true one, by the longitude from there times the sine
 * of the latitude, nearly. */
static void sun_on_a_turned_map(void **state) {
    (void)state;
    if (!have_real()) return; /* nor GDAL, perhaps */
    static const char asc[] = "ncols 2 nrows 2 xllcorner 600000 yllcorner 5200000 cellsize 10\n0 1 2 7",
                      prj[] = "PROJCS[\"UTM 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
                              "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
                              "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
                              "PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],"
                              "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
    scratch_write("a.asc", asc, sizeof asc - 1);
    scratch_write("a.prj", prj, sizeof prj - 1);
    const program_result *r =
        run_well((const char *const[]){"shadow", "a.asc", "--time", "2024-12-21T14:00:00+01:00", "-o", "s.npy", NULL});
    double lon = 0, lat = 0, azimuth = 0, map = 0;
    const char *at = strstr(r->out, "over ");
    check(at && sscanf(at, "over %lf, %lf: azimuth %lf (%lf on the map)", &lon, &lat, &azimuth, &map) == 4, "%s",
          r->out);
    const double turned = (lon - 9) * sin(lat * 0.017453292519943295);
    check(fabs(lon - 10.315) < 0.01 && fabs(azimuth - turned - map) < 0.003, "%s, not %g", r->out, azimuth - turned);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(shadow_of_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(coarser_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(horizon_at_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(scaled_integers, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(files_for_gdal, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(view_of_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sun_at_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(large_view, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(lines_at_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(places_that_are_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(heights_of_places, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(rows_without_a_map, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(several_kinds_of_no_data, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(where_the_terrain_ends, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(outputs_describe_themselves, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(next_to_a_row, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(as_near_as_can_be, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sources_are_not_replaced, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(interrupted, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(real_terrain_same_bits, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(another_format, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(real_view, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sun_on_a_turned_map, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sun_by_time, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
