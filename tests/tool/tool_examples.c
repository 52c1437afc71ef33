/* SPDX-License-Identifier: Apache-2.0 */
/* The examples of --help run as they stand, on files made here: exit status 0 and nothing on standard error. Examples of
 * cellwalk-bench would take minutes, so only their command lines are checked, by --help behind all other arguments. */

#include "tool_files.h"

#include <math.h>
#include <unistd.h>

static const char programs[] = OPTIONS_PROGRAMS; /* paths of cellwalk and cellwalk-bench */

enum { NX = 100, NY = 100, TEXT_MAX = 4096 };

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

/* Land around the places of the examples: 5 km, below 1250 m. The GeoTIFF is a VRT by content, so no library is needed to
 * write it. */
static void make_land(void) {
    static float z[NX * NY];
    static char text[NX * NY * 10];
    size_t used = (size_t)snprintf(text, sizeof text,
                                   "ncols 100\nnrows 100\nxllcorner 599000\nyllcorner 5199000\n"
                                   "cellsize 50\nNODATA_value -9999\n");
    for (size_t k = 0; k < NX * NY; k++) {
        z[k] = (float)(1000 + 150 * sin((double)(k % NX) / 9) * cos((double)(k / NX) / 7));
        used +=
            (size_t)snprintf(text + used, sizeof text - used, "%.2f%s", (double)z[k], k % NX == NX - 1 ? "\n" : " ");
    }
    field_file("terrain.npy", z, NX, NY);
    text_file("dem.asc", text);
    static const char vrt[] = "<VRTDataset rasterXSize=\"100\" rasterYSize=\"100\"><SRS>EPSG:32632</SRS>"
                              "<GeoTransform>599000, 50, 0, 5204000, 0, -50</GeoTransform>"
                              "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                              "<SourceFilename relativeToVRT=\"1\">dem.asc</SourceFilename><SourceBand>1</SourceBand>"
                              "</SimpleSource></VRTRasterBand></VRTDataset>\n";
    text_file("dem.tif", vrt);
}

/* The road is GeoJSON by content, for the same reason. */
static void make_places(void) {
    text_file("towers.csv", "x,y,height,weight\n600250,5199800,30,1\n602000,5201000,20,2\n");
    text_file("links.csv", "x1,y1,height1,x2,y2,height2\n600250,5199800,2,601500,5200100,30\n");
    text_file("road.gpkg",
              "{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":"
              "{\"name\":\"urn:ogc:def:crs:EPSG::32632\"}},\"features\":[{\"type\":\"Feature\",\"properties\":{},"
              "\"geometry\":{\"type\":\"LineString\",\"coordinates\":[[600250,5199800],[600400,5199900]]}}]}\n");
}

static void make_rays(void) {
    enum { N = 100 };
    static cw_ray rays[N], sun[N];
    static double user[N][8];
    for (size_t k = 0; k < N; k++) {
        const float at = (float)k * 0.9f;
        rays[k] = (cw_ray){.org = {at, at, 2000}, .dir = {0, 0, -1}, .tmax = INFINITY};
        sun[k] = (cw_ray){.org = {599100 + 40 * at, 5199100 + 40 * at, 1300}, .dir = {1, 1, 1}, .tmax = INFINITY};
        const double one[8] = {599100 + 40 * (double)at, 5199100 + 40 * (double)at, 2000, 0, 0, 0, -1, INFINITY};
        memcpy(user[k], one, sizeof one);
    }
    rays_file("rays.npy", rays, N);
    sun[0] = rays[0]; /* one hit: a run in which no ray meets the field's bounds prints a warning */
    rays_file("sun.npy", sun, N);
    npy_file("lidar.npy", "<f8", "(100, 8)", user, sizeof user);
}

static void make_scenes(void) {
    static const char scene[] = "Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 30\n"
                                "LookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\"\nWorldBegin\n"
                                "LightSource \"point\" \"color I\" [9 9 9]\nTranslate -1 -1 2\nScale 2 2 1\n"
                                "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 .3 0]\n"
                                "WorldEnd\n";
    text_file("landsea-0.pbrt", scene);
    text_file("texture.pbrt", scene);
}

/* The programs by their names, in ./bin. */
static void make_path(void) {
    char list[sizeof programs], link[TEXT_MAX], path[2 * TEXT_MAX];
    assert_int_equal(system("mkdir bin"), 0);
    memcpy(list, programs, sizeof list);
    for (char *rest = NULL, *of = strtok_r(list, ":", &rest); of; of = strtok_r(NULL, ":", &rest)) {
        snprintf(link, sizeof link, "bin/%s", strrchr(of, '/') + 1);
        assert_int_equal(symlink(of, link), 0);
    }
    assert_non_null(getcwd(link, sizeof link));
    snprintf(path, sizeof path, "%s/bin:%s", link, getenv("PATH"));
    assert_int_equal(setenv("PATH", path, 1), 0);
}

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    make_land();
    make_places();
    make_rays();
    make_scenes();
    make_path();
    return setenv("ASAN_OPTIONS", "symbolize=0", 0); /* see program.c */
}

/* The output of a command; the caller frees it. */
static char *output_of(const char *line) {
    char words[TEXT_MAX + 64];
    size_t size;
    snprintf(words, sizeof words, "%s >printed", line);
    check(system(words) == 0, "%s fails", line);
    return scratch_read("printed", &size);
}

/* Whether the line writes or reads a format that this build lacks. */
static bool lacks(const char *line) {
    static const char *const needs[][2] = {
        {".tif", "GDAL     yes"}, {".gpkg", "GDAL     yes"}, {".exr", "OpenEXR  yes"}, {".png", "libpng   yes"}};
    static char version[TEXT_MAX];
    bool lacking = false;
    if (version[0] == '\0') { /* takes a tenth of a second: GDAL is loaded */
        char *printed = output_of("cellwalk --version");
        snprintf(version, sizeof version, "%s", printed);
        free(printed);
    }
    for (size_t k = 0; k < sizeof needs / sizeof *needs; k++)
        lacking |= strstr(line, needs[k][0]) && !strstr(version, needs[k][1]);
    return lacking;
}

/* Pictures get one sample a pixel, and few pixels unless the line crops them: later options win. An instruction set may be
 * missing on this machine. */
static const char *reduced(const char *line) {
    if (strncmp(line, "cellwalk ", 9) != 0 || strstr(line, " --isa ")) return " --help";
    if (strncmp(line, "cellwalk render ", 16) != 0) return "";
    return strstr(line, " --crop ") ? " --samples 1" : " --samples 1 --size 60x40";
}

static void run_example(const char *line) {
    char words[2 * TEXT_MAX], command[TEXT_MAX];
    size_t size;
    if (lacks(line)) {
        print_message("skipped: %s\n", line);
        return;
    }
    /* A comment ends the command. */
    snprintf(command, sizeof command, "%.*s", (int)strcspn(line, "#"), line);
    char *redirection = strstr(command, " > ");
    if (redirection) *redirection = '\0';
    snprintf(words, sizeof words, "%s%s >output 2>err", command, reduced(command));
    const int status = system(words);
    char *err = scratch_read("err", &size);
    const bool quiet = size == 0 || (strchr(err, '\n') == err + size - 1 && strstr(err, " samples") != NULL);
    check(status == 0 && quiet, "%s: status %d: %s", words, status, err);
    free(err);
    char *written = strstr(command, " -o ");
    if (written == NULL || strstr(words, " --help ")) return;
    written += 4;
    written[strcspn(written, " ")] = '\0';
    check(unlink(written) == 0, "%s writes no %s", line, written);
}

/* Runs each line that begins with the program's name, or has it behind a gap; lines that end in a backslash go on. */
static size_t run_examples(char *text, const char *program) {
    char start[64], line[TEXT_MAX];
    size_t count = 0;
    snprintf(start, sizeof start, "  %s ", program);
    for (char *at = text; (at = strstr(at, start)) != NULL;) {
        size_t used = 0;
        at += 2;
        for (bool more = true; more; at += *at == '\n') {
            const size_t length = strcspn(at, "\n");
            more = length > 0 && at[length - 1] == '\\';
            used += (size_t)snprintf(line + used, sizeof line - used, "%.*s", (int)(length - more), at);
            at += length;
        }
        run_example(line);
        count++;
    }
    return count;
}

/* X,Y in the program's own help stands for a place. */
static void fill_in_places(const char *text, char *to, size_t size) {
    for (size_t used = 0; *text && used + 32 < size; to[used] = '\0') {
        const bool place = strncmp(text, "X,Y", 3) == 0;
        used += (size_t)snprintf(to + used, size - used, place ? "600250,5199800" : "%.1s", text);
        text += place ? 3 : 1;
    }
}

static void examples_run(const char *program) {
    char words[TEXT_MAX], filled[2 * TEXT_MAX];
    snprintf(words, sizeof words, "%s --help", program);
    char *help = output_of(words);
    fill_in_places(help, filled, sizeof filled);
    check(run_examples(filled, program) > 0, "%s --help has no examples", program);
    for (char *line = strstr(help, "Commands:\n");
         line && (line = strchr(line, '\n')) && strncmp(line, "\n  ", 3) == 0;) {
        line += 3;
        snprintf(words, sizeof words, "%s %.*s --help", program, (int)strcspn(line, " "), line);
        char *text = output_of(words);
        char *examples = strstr(text, "\nExamples:\n");
        check(examples && run_examples(examples, program) > 0, "%s has no examples", words);
        free(text);
    }
    free(help);
}

static void examples_of_cellwalk(void **state) {
    (void)state;
    examples_run("cellwalk");
}

static void examples_of_the_benchmark(void **state) {
    (void)state;
    examples_run("cellwalk-bench");
}

/* Without arguments: all that the program can do, with a task for each command, on a screen of 24 lines. */
static void map_fits_a_screen(void **state) {
    (void)state;
    size_t size, lines = 0;
    check(system("cellwalk 2>err") != 0, "no command is a success");
    char *text = scratch_read("err", &size);
    for (const char *c = text; *c; c++) lines += *c == '\n';
    const char *tasks = strstr(text, "By task"), *name = strstr(text, "Commands:\n");
    check(tasks && name && lines <= 24, "%zu lines: %s", lines, text);
    size_t commands = 0;
    for (name = strchr(name, '\n') + 1; name[0] == ' '; name = strchr(name, '\n') + 1, commands++) {
        char task[40];
        const int length = (int)strcspn(name + 2, " ");
        snprintf(task, sizeof task, " cellwalk %.*s dem.tif", length < 20 ? length : 20, name + 2);
        check(strstr(tasks, task) != NULL, "no task says%s", task);
    }
    assert_true(commands > 5);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(examples_of_cellwalk, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(examples_of_the_benchmark, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(map_fits_a_screen, enter, scratch_leave),
    };
    return cmocka_run_group_tests_name("tool_examples", tests, NULL, NULL);
}
