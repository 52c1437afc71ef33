/* SPDX-License-Identifier: Apache-2.0 */
/* Observers of a viewshed from tables, files of features and along lines, and what is written of them. */

#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NX = 60, NY = 50, ARGUMENTS = 24 };

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

/* Hills with a hole; on a map in metres of UTM, and on one in degrees. */
static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    static char text[NX * NY * 16];
    size_t used = 0;
    for (size_t k = 0; k < NX * NY; k++) {
        const double x = (double)(k % NX), y = (double)(k / NX);
        z[k] = k == 7 * NX + 9 ? NAN : (float)rint(8 * (30 + 20 * sin(x / 6) * cos(y / 5) + 3 * sin(x + 2 * y))) / 8;
        used += (size_t)snprintf(text + used, sizeof text - used, "%.9g%c", isnan(z[k]) ? -9999 : (double)z[k],
                                 k % NX == NX - 1 ? '\n' : ' ');
    }
    field_file("land.npy", z, NX, NY);
    static char asc[sizeof text + 200];
    snprintf(asc, sizeof asc,
             "ncols %d\nnrows %d\nxllcorner 500000\nyllcorner 5200000\ncellsize 10\nnodata_value -9999\n%s", NX, NY,
             text);
    text_file("land.asc", asc);
    static const char vrt[] =
        "<VRTDataset rasterXSize=\"60\" rasterYSize=\"50\"><SRS>EPSG:%d</SRS><GeoTransform>%s</GeoTransform>"
        "<VRTRasterBand dataType=\"Float32\" band=\"1\"><NoDataValue>-9999</NoDataValue><SimpleSource>"
        "<SourceFilename relativeToVRT=\"1\">land.asc</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>";
    char made[1000];
    snprintf(made, sizeof made, vrt, 32632, "500000,10,0,5200500,0,-10");
    text_file("utm.vrt", made);
    snprintf(made, sizeof made, vrt, 4326, "9,0.00013,0,46.95,0,-0.00009");
    text_file("degrees.vrt", made);
    return 0;
}

static bool have_gdal(void) { return program_run(NULL, (const char *const[]){"info", "utm.vrt", NULL})->status == 0; }

/* The cells of an array that `viewshed DEM …` writes; the caller frees *file. Messages must be those words, or none. */
static const void *view(const char *dem, const char *const *more, size_t bytes, char **file, const char *words) {
    const char *arguments[ARGUMENTS] = {"viewshed", dem, "-o", "v.npy"};
    size_t n = 4, size;
    for (; *more; more++) arguments[n++] = *more;
    if (strstr(dem, ".npy")) arguments[n++] = "--cellsize", arguments[n++] = "10";
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    check(words ? strstr(r->err, words) != NULL : r->err[0] == '\0', "standard error: %s", r->err);
    *file = scratch_read("v.npy", &size);
    check(size > bytes, "%zu bytes", size);
    return *file + (size - bytes);
}

#define OPTIONS(...) ((const char *const[]){__VA_ARGS__, NULL})

static void check_same(const char *dem, const char *const *one, const char *const *other, size_t bytes,
                       const char *words) {
    char *file[2];
    const void *a = view(dem, one, bytes, &file[0], NULL), *b = view(dem, other, bytes, &file[1], words);
    check(memcmp(a, b, bytes) == 0, "another raster by %s", other[1]);
    free(file[0]);
    free(file[1]);
}

/* The same places, whatever the table looks like. */
static void tables(void **state) {
    (void)state;
    static const char *const from[] = {"--from", "100,100,3", "--from", "250.5,321.25", "--from", "400,20,=90", NULL};
    static const struct {
        const char *text, *words;
    } cases[] = {
        {"x,y,height\n100,100,3\n250.5,321.25,2\n400,20,=90\n", NULL},
        {"x,y,height\n100,100,3\n250.5,321.25,\n400,20,=90", NULL},
        {"\xef\xbb\xbfX,Y,Height\r\n100,100,3\r\n250.5,321.25,2\r\n400,20,=90\r\n", NULL},
        {"\n\"height\" , \"y\",\tx\n3,100,100\n\n 2.0 , 3.2125e2 ,\"250.5\"\n\"=90\",20,400\n  \n", NULL},
        {"label,x,y,height\n\"a, \"\"b\"\"\nc\",100,100,3\nd,250.5,321.25,2\n,400,20,=90\n",
         "t.csv: passed over: 'label'; columns with a meaning are x, y, height, weight and name"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        text_file("t.csv", cases[k].text);
        check_same("land.npy", from, OPTIONS("--observers", "t.csv"), NX * NY, cases[k].words);
    }
    /* A table of a single place answers as it does. */
    text_file("t.csv", "x,y\n250.5,321.25\n");
    check_same("land.npy", OPTIONS("--from", "250.5,321.25", "--angle"),
               OPTIONS("--observers", "t.csv", "--angle", "--threads", "3"), 4 * NX * NY, NULL);
}

/* A line for each observer, by the samples of its own view; the raster is the same as without a table. Row 0 of an array lies in the
 * north, so sample (i, j) is at (10 i, 490 - 10 j). */
static void a_table_of_views(void **state) {
    (void)state;
    static const char *const places[] = {"100,100,3", "250.5,321.25,2", "400,20,=90"};
    text_file("t.csv", "x,y,height\n100,100,3\n250.5,321.25,2\n400,20,=90\n");
    check_same("land.npy", OPTIONS("--observers", "t.csv"), OPTIONS("--observers", "t.csv", "--table", "seen.csv"),
               NX * NY, NULL);
    size_t size;
    char *table = scratch_read("seen.csv", &size), *file;
    const char *line = strchr(table, '\n') + 1;
    check(strncmp(table, "observer,x,y,samples,km2,farthest,farthest_x,farthest_y\n", (size_t)(line - table)) == 0,
          "%s", table);
    for (size_t k = 0; k < 3; k++, line = strchr(line, '\n') + 1) {
        const uint8_t *seen = view("land.npy", OPTIONS("--from", places[k]), NX * NY, &file, NULL);
        double x, y, of[8], far = 0;
        size_t count = 0;
        sscanf(places[k], "%lf,%lf", &x, &y);
        for (size_t n = 0; n < NX * NY; n++) {
            const double away = hypot(10.0 * (double)(n % NX) - x, 490 - 10.0 * (double)(n / NX) - y);
            count += seen[n] == 1;
            if (seen[n] == 1) far = fmax(far, away);
        }
        check(sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &of[0], &of[1], &of[2], &of[3], &of[4], &of[5], &of[6],
                     &of[7]) == 8,
              "%s", line);
        check(of[0] == (double)(k + 1) && of[1] == x && of[2] == y && of[3] == (double)count &&
                  fabs(of[4] - 1e-4 * (double)count) < 1e-9 && fabs(of[5] - far) < 1e-3 &&
                  fabs(hypot(of[6] - x, of[7] - y) - far) < 1e-3,
              "%zu samples, %g m: %s", count, far, line);
        free(file);
    }
    free(table);
    check_refused((const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv", "--table",
                                        "no.csv", "--bands", "-o", "o.npy", NULL},
                  2, "--table is about what is seen");
}

static void weights_and_bands(void **state) {
    (void)state;
    static const char *const places[] = {"100,100,3", "250.5,321.25,2", "400,20,=90"};
    static const double weights[] = {0.5, -3, 1e6};
    text_file("t.csv", "x,y,height,weight\n100,100,3,0.5\n250.5,321.25,2,-3\n400,20,=90,1e6\n");
    static float sums[NX * NY];
    static double wanted[NX * NY];
    char *file, *bands[3];
    const float *sum = view("land.npy", OPTIONS("--observers", "t.csv", "--weights"), sizeof sums, &file, NULL);
    memcpy(sums, sum, sizeof sums);
    free(file);
    static const struct {
        const char *option;
        size_t bytes;
    } kinds[] = {{"--threads=2", 1}, {"--angle", 4}, {"--needed", 4}, {"--needed-absolute", 4}};
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
        const size_t bytes = kinds[kind].bytes * NX * NY;
        const char *all = view("land.npy", OPTIONS("--observers", "t.csv", "--bands", kinds[kind].option), 3 * bytes,
                               &bands[0], NULL);
        for (size_t k = 0; k < 3; k++) {
            const uint8_t *one = view("land.npy", OPTIONS("--from", places[k], kinds[kind].option), bytes, &file, NULL);
            check(memcmp(one, all + k * bytes, bytes) == 0, "%s: band %zu", kinds[kind].option, k + 1);
            for (size_t n = 0; kind == 0 && n < NX * NY; n++) wanted[n] += one[n] == 1 ? weights[k] : 0;
            free(file);
        }
        free(bands[0]);
    }
    for (size_t n = 0; n < NX * NY; n++)
        check(n == 7 * NX + 9 ? isnan(sums[n]) : sums[n] == (float)wanted[n], "sample %zu: %g, not %g", n,
              (double)sums[n], wanted[n]);
    /* Sums of 8 bytes a sample count against the memory: with 4 bytes of samples, 36 kB of 150, of which a quarter may be used. */
    check_refused((const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv", "--weights",
                                        "--memory", "100K", "-o", "o.npy", NULL},
                  1, "60 x 50 samples matter at once, which need --memory 1M");
    check_same("land.npy", OPTIONS("--observers", "t.csv", "--weights"),
               OPTIONS("--observers", "t.csv", "--weights", "--memory", "150K"), 4 * NX * NY, NULL);
    check_same("land.npy", OPTIONS("--observers", "t.csv"), OPTIONS("--observers", "t.csv", "--memory", "100K"),
               NX * NY, NULL);
    /* A GeoTIFF says whose band is whose. */
    const program_result *r =
        program_run(NULL, (const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv",
                                                "--bands", "--azimuth", "10,200", "-o", "o.tif", NULL});
    if (strstr(r->err, "GeoTIFF needs GDAL")) return;
    check(r->status == 0, "%s", r->err);
    size_t size;
    char *tif = scratch_read("o.tif", &size);
    static const char *const says[] = {"observer 2 at 250.5,321.25", ">10,200<", ">t.csv<", "OBSERVER_3", "AZIMUTH"};
    for (size_t k = 0; k < sizeof says / sizeof *says; k++)
        check(memmem(tif, size, says[k], strlen(says[k])) != NULL, "'%s' is not said", says[k]);
    free(tif);
}

/* 500 m in two legs: an observer each 50 m, with heights and weights between those of corners. */
static void along_a_line(void **state) {
    (void)state;
    text_file("line.csv", "x,y,height,weight\n100,100,2,1\n400,100,8,4\n400,300,4,0\n");
    char text[600] = "x,y,height,weight\n";
    for (int k = 0; k <= 10; k++) {
        const double s = 50 * k, x = fmin(100 + s, 400), y = k > 6 ? s - 200 : 100;
        const double h = k <= 6 ? 2 + k : 8 - (k - 6), w = k <= 6 ? 1 + 0.5 * k : 4 - (k - 6);
        snprintf(text + strlen(text), 60, "%g,%g,%g,%g\n", x, y, h, w);
    }
    text_file("places.csv", text);
    check_same("land.npy", OPTIONS("--observers", "places.csv"), OPTIONS("--observers", "line.csv", "--every", "50"),
               NX * NY, NULL);
    check_same("land.npy", OPTIONS("--observers", "places.csv", "--weights"),
               OPTIONS("--observers", "line.csv", "--every", "50", "--weights"), 4 * NX * NY, NULL);
    check_same("land.npy", OPTIONS("--observers", "places.csv"),
               OPTIONS("--from", "100,100", "--from", "400,100,8", "--from", "400,300,4", "--every", "50"), NX * NY,
               NULL);
    /* The last 20 m are less than a step, and a step longer than the line leaves its beginning. */
    check_same("land.npy", OPTIONS("--from", "100,100", "--from", "160,100", "--from", "220,100", "--from", "280,100"),
               OPTIONS("--from", "100,100", "--from", "300,100", "--every", "60"), NX * NY, NULL);
    check_same("land.npy", OPTIONS("--from", "100,100"),
               OPTIONS("--from", "100,100", "--from", "300,100", "--every", "1000"), NX * NY, NULL);
}

/* All see all of level ground: counts are of two bytes, and from 65 535 observers on floats. */
static void any_number(void **state) {
    (void)state;
    enum { SIDE = 12 };
    static float z[SIDE * SIDE];
    static char text[70000 * 8];
    field_file("level.npy", z, SIDE, SIDE);
    for (int round = 0; round < 2; round++) {
        if (!test_takes((size_t)round, 2)) continue;
        const size_t observers = round ? 65535 : 10000;
        size_t used = (size_t)snprintf(text, sizeof text, "x,y\n");
        for (size_t k = 0; k < observers; k++)
            used += (size_t)snprintf(text + used, sizeof text - used, "%zu,%zu\n", 10 * (k % 7), 10 * (k / 7 % 12));
        scratch_write("many.csv", text, used);
        /* In a sector of no width, so that most parts of a sweep are left out: the column to the north. */
        char *file;
        const size_t bytes = (round ? 4 : 2) * SIDE * SIDE;
        const void *cells =
            view("level.npy", OPTIONS("--observers", "many.csv", "--azimuth", "0,0"), bytes, &file, NULL);
        static size_t wanted[SIDE * SIDE];
        memset(wanted, 0, sizeof wanted);
        for (size_t k = 0; k < observers; k++)
            for (size_t y = k / 7 % 12; y < SIDE; y++) wanted[(SIDE - 1 - y) * SIDE + k % 7]++;
        for (size_t n = 0; n < SIDE * SIDE; n++) {
            const double got = round ? (double)((const float *)cells)[n] : ((const uint16_t *)cells)[n];
            check(got == (double)wanted[n], "sample %zu: %g of %zu", n, got, wanted[n]);
        }
        free(file);
    }
}

/* A part of the raster, limits and a map with a coordinate system: the same bits as from all of it. */
static void windows(void **state) {
    (void)state;
    if (!have_gdal()) skip();
    static const char *const dems[] = {"utm.vrt", "degrees.vrt"};
    static const char *const tables[] = {"x,y,weight\n500100,5200200,2\n500444.4,5200333.3,0.125\n",
                                         "x,y,weight\n9.0013,46.9482,2\n9.0058,46.947,0.125\n"};
    static const char *const window[] = {"500100,5200100,500300,5200250", "9.0013,46.9464,9.0039,46.94775"};
    static const char *const more[][5] = {
        {"--weights"}, {"--angle", "--bands"}, {"--weights", "--azimuth", "300,120"}, {"--vertical", "-5,-1"}};
    for (size_t d = 0; d < 2; d++)
        for (size_t m = 0; m < 4; m++) {
            if (!test_takes(d + m, 2)) continue;
            const size_t cell = m == 3 ? 1 : 4, bands = m == 1 ? 2 : 1;
            text_file("t.csv", tables[d]);
            char *file[2];
            const char *whole =
                view(dems[d],
                     OPTIONS("--observers", "t.csv", "--min-distance", "40", more[m][0],
                             more[m][1] ? more[m][1] : "--threads=1", more[m][2] ? more[m][2] : "--threads=1"),
                     bands * cell * NX * NY, &file[0], NULL);
            const size_t wide = 20, high = 15, left = 10, top = 25;
            const char *part =
                view(dems[d],
                     OPTIONS("--observers", "t.csv", "--min-distance", "40", "--window", window[d], more[m][0],
                             more[m][1] ? more[m][1] : "--threads=2", more[m][2] ? more[m][2] : "--threads=2"),
                     bands * cell * wide * high, &file[1], NULL);
            for (size_t b = 0; b < bands; b++)
                for (size_t y = 0; y < high; y++)
                    check(memcmp(whole + ((b * NY + top + y) * NX + left) * cell, part + (b * high + y) * wide * cell,
                                 wide * cell) == 0,
                          "%s %s: other bits in row %zu", dems[d], more[m][0], y);
            free(file[0]);
            free(file[1]);
        }
}

static const char json[] =
    "{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"%s\"}},\"features\":[%s]}";

static void json_file(const char *name, const char *crs, const char *features) {
    char text[2000];
    snprintf(text, sizeof text, json, crs, features);
    text_file(name, text);
}

#define FEATURE(properties, type, places)                                                                              \
    "{\"type\":\"Feature\",\"properties\":{" properties "},\"geometry\":{\"type\":\"" type                             \
    "\",\"coordinates\":" places "}}"

static void features(void **state) {
    (void)state;
    if (!have_gdal()) skip();
    static const char utm[] = "urn:ogc:def:crs:EPSG::32632", degrees[] = "urn:ogc:def:crs:OGC:1.3:CRS84";
    json_file("p.geojson", utm,
              FEATURE("\"height\":3,\"weight\":2.5", "Point", "[500100,5200100]") "," FEATURE(
                  "\"height\":null,\"weight\":1", "MultiPoint", "[[500250.5,5200321.25],[500400,5200020]]"));
    text_file("p.csv", "x,y,height,weight\n500100,5200100,3,2.5\n500250.5,5200321.25,,1\n500400,5200020,,1\n");
    check_same("utm.vrt", OPTIONS("--observers", "p.csv", "--weights"),
               OPTIONS("--observers", "p.geojson", "--weights"), 4 * NX * NY, NULL);
    json_file("q.geojson", degrees, FEATURE("", "Point", "[9.00400,46.949800]"));
    char *file[2];
    const uint8_t *seen = view("degrees.vrt", OPTIONS("--observers", "q.geojson"), NX * NY, &file[0], NULL);
    const uint8_t *same = view("degrees.vrt", OPTIONS("--from", "9.004,46.9498"), NX * NY, &file[1], NULL);
    assert_memory_equal(seen, same, NX * NY);
    free(file[0]);
    free(file[1]);
    /* The middle of zone 32 is 9 degrees east: 500 000 m, beside the first column of samples. */
    json_file("q.geojson", degrees, FEATURE("", "Point", "[9,46.9535]"));
    check_refused((const char *const[]){"viewshed", "utm.vrt", "--observers", "q.geojson", "-o", "o.npy", NULL}, 1,
                  "q.geojson: feature 0: 500000,");
    json_file("l.geojson", utm,
              FEATURE("\"height\":4", "LineString", "[[500100,5200100],[500400,5200100]]") "," FEATURE(
                  "\"height\":6", "MultiLineString",
                  "[[[500200,5200300],[500200,5200360]],[[500300,5200300],[500300,5200340]]]"));
    /* 95 m of ground are 0.9996 times as much on the map, in the middle of UTM's zone. */
    text_file("l.csv", "x,y,height\n500100,5200100,4\n500194.962,5200100,4\n500289.924,5200100,4\n"
                       "500384.886,5200100,4\n500200,5200300,6\n500300,5200300,6\n");
    check_same("utm.vrt", OPTIONS("--observers", "l.csv"), OPTIONS("--observers", "l.geojson", "--every", "95"),
               NX * NY, NULL);
    /* What is wrong with a file is said. */
    static const struct {
        const char *features, *more, *why;
    } cases[] = {
        {FEATURE("", "LineString", "[[500100,5200100],[500400,5200100]]"), "--threads=1",
         "w.geojson: holds lines, and --every D"},
        {FEATURE("", "Polygon", "[[[500100,5200100],[500400,5200100],[500400,5200400],[500100,5200100]]]"),
         "--threads=1", "w.geojson: feature 0: is a POLYGON, neither points nor a line"},
        {FEATURE("", "Point", "[500100,5200100]") "," FEATURE("", "LineString", "[[500100,5200100],[500400,5200100]]"),
         "--every=9", "w.geojson: has points and lines"},
        {FEATURE("\"height\":\"high\"", "Point", "[500100,5200100]"), "--threads=1",
         "w.geojson: feature 0: 'high' stands where a number should, in height"},
        {FEATURE("", "Point", "[500100,5200900]"), "--threads=1",
         "w.geojson: feature 0: 500100,5200900,2: lies outside"},
        {"", "--threads=1", "w.geojson: holds no places"},
        {FEATURE("", "Point", "[500100,5200100]"), "--layer=other", "w.geojson: has no layer 'other'; there are w"},
        {FEATURE("", "Point", "[500100,5200100]"), "--weights", "w.geojson: has no column 'weight'"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        if (!test_takes(k, 3)) continue;
        json_file("w.geojson", utm, cases[k].features);
        check_refused((const char *const[]){"viewshed", "utm.vrt", "--observers", "w.geojson", cases[k].more, "-o",
                                            "o.npy", NULL},
                      1, cases[k].why);
    }
    /* Doors: no network, no waiting for a pipe, no input overwritten. */
    check_refused((const char *const[]){"viewshed", "utm.vrt", "--observers", "http://127.0.0.1:9/a.geojson", "-o",
                                        "o.npy", NULL},
                  1, "--allow-network");
    check_refused(
        (const char *const[]){"viewshed", "utm.vrt", "--observers", "WFS:http://127.0.0.1:9/a", "-o", "o.npy", NULL}, 1,
        "--allow-network");
    assert_int_equal(mkfifo("pipe.geojson", 0600), 0);
    check_refused((const char *const[]){"viewshed", "utm.vrt", "--observers", "pipe.geojson", "-o", "o.npy", NULL}, 1,
                  "not a regular file");
}

static void what_is_refused(void **state) {
    (void)state;
#define LAND "viewshed", "land.npy", "--cellsize", "10", "-o", "o.npy"
    static const struct {
        const char *text, *why;
    } tables[] = {
        {"", "t.csv: is empty; its first line should name the columns"},
        {"x,y\n", "t.csv: holds no places"},
        {"a,y\n1,2\n", "t.csv: has no column 'x'; its first line names a, y"},
        {"100,200\n1,2\n", "t.csv: has no column 'x'; its first line names 100, 200"},
        {"x,y\n100,100\n100,two\n", "t.csv:3: 'two' stands where a number should, in y"},
        {"x,y\n0x10,100\n", "t.csv:2: '0x10' stands where a number should, in x"},
        {"x,y\nnan,100\n", "t.csv:2: 'nan' stands where a number should, in x"},
        {"x,y\n,100\n", "t.csv:2: x is empty where a number should stand"},
        {"x,y,height\n100,100,=\n", "t.csv:2: '=' stands where a height, as 2 or =1250, should, in height"},
        {"x,y,weight\n100,100,heavy\n", "t.csv:2: 'heavy' stands where a number should, in weight"},
        {"x,y\r\n100,100\r\n\r\n700,100\r\n", "t.csv:4: 700,100,2: lies outside"},
        {"x,y\n100,100\n100\n", "t.csv:3: the line has 1 cell where the first one names 2 columns"},
        {"x,y\n100,100,5\n", "t.csv:2: the line has 3 cells where the first one names 2 columns"},
        {"x;y\n100;100\n", "t.csv:1: cells are separated by semicolons; a comma should stand between them"},
        {"x\ty\n100\t100\n", "t.csv:1: cells are separated by tabs"},
        {"x,y\n100,\"100\n", "t.csv:2: a quotation mark has no end"},
        {"x,y\n100,\"10\"0\n", "t.csv:2: text stands behind a quotation mark"},
        {"x,X,y\n1,1,1\n", "t.csv: two columns have the name 'x'"},
        {"x,y\n1e300,1\n", "t.csv:2: 1e+300,1,2: is too far away"},
        {"x,y,height\n100,100,=-500\n", "t.csv:2: 100,100,=-500: is under the ground"},
        {"\xff\xfex", "t.csv: has no column 'x'"},
    };
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++) {
        text_file("t.csv", tables[k].text);
        check_refused((const char *const[]){LAND, "--observers", "t.csv", NULL}, 1, tables[k].why);
    }
    scratch_write("t.csv", "\xff\xfex\0,\0y\0\n\0", 10);
    check_refused((const char *const[]){LAND, "--observers", "t.csv", NULL}, 1, "t.csv: is no text in UTF-8");
    check_refused((const char *const[]){LAND, "--observers", "none.csv", NULL}, 1,
                  "none.csv: cannot read: No such file");
    text_file("t.csv", "x,y\n100,100\n200,100\n");
    static const struct {
        const char *more[6], *why;
        int status;
    } cases[] = {
        {{"--observers", "t.csv", "--from", "1,2"}, "do not go together", 2},
        {{"--layer", "a", "--from", "1,2"}, "--layer goes with --observers", 2},
        {{"--from", "1,2", "--every", "5"}, "takes two places or more", 2},
        {{"--observers", "t.csv", "--every", "-5"}, "--every takes metres, not -5", 2},
        {{"--observers", "t.csv", "--every", "1e-9"}, "more than 16777216 observers", 1},
        {{"--from", "1,2", "--from", "9,2,=400", "--every", "5"}, "9,2,=400: heights along a line are all above", 1},
        {{"--from", "1,2", "--weights"}, "--weights goes with --observers", 2},
        {{"--observers", "t.csv", "--weights"}, "t.csv: has no column 'weight'", 1},
        {{"--observers", "t.csv", "--weights", "--bands"}, "keeps them apart", 2},
        {{"--observers", "t.csv", "--weights", "--angle"}, "one can be written", 2},
        {{"--observers", "t.csv", "--angle"}, "is that of one observer, not of 2; --bands", 1},
        {{"--from", "1,2", "--from", "9,2", "--needed"}, "is that of one observer, not of 2; --bands", 2},
        {{"--observers", "t.csv", "--layer", "a"}, "a table has no layers", 1},
        {{"--from", "1,2", "--azimuth", "1"}, "--azimuth takes two angles", 2},
        {{"--from", "1,2", "--azimuth", "1,400"}, "--azimuth takes two angles", 2},
        {{"--from", "1,2", "--vertical", "5,-5"}, "the lower one first, not '5,-5'", 2},
        {{"--from", "1,2", "--vertical", "-91,0"}, "--vertical takes two angles", 2},
        {{"--from", "1,2", "--vertical", "-9,0", "--needed"}, "--needed looks for that height", 2},
        {{"--from", "1,2", "--min-distance", "-1"}, "--min-distance takes metres, not -1", 2},
        {{"--from", "1,2", "--min-distance", "9", "--max-distance=5"}, "--min-distance 9 is more than", 2},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *arguments[ARGUMENTS] = {LAND};
        for (size_t n = 0; n < 6 && cases[k].more[n]; n++) arguments[6 + n] = cases[k].more[n];
        check_refused(arguments, cases[k].status, cases[k].why);
    }
    check_refused((const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv", "--bands",
                                        "-o", "o.png", NULL},
                  1, "no room for 2 bands");
#undef LAND
    /* The table is not overwritten. */
    assert_int_equal(link("t.csv", "t.npy"), 0);
    check_refused(
        (const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv", "-o", "t.npy", NULL},
        1, "t.npy: is also an input");
}

static void interrupted(void **state) {
    (void)state;
    text_file("t.csv", "x,y\n100,100\n400,100\n");
    for (int bands = 0; bands < 2; bands++)
        check_interrupted((const char *const[]){"viewshed", "land.npy", "--cellsize", "10", "--observers", "t.csv",
                                                "--every", "0.005", "-o", "o.npy", bands ? "--bands" : NULL, NULL},
                          bands);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(tables, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(a_table_of_views, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(weights_and_bands, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(along_a_line, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(any_number, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(windows, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(features, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(interrupted, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
