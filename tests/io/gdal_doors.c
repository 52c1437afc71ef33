/* SPDX-License-Identifier: Apache-2.0 */
/* What files may make GDAL do, as users run the program: wait for nobody, read no memory, and leave nothing of a GeoTIFF that
 * was not finished. gdal_network.c has the network. */

#include "program.h"
#include "tool_files.h"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static void vrt_file(const char *name, const char *source) {
    char text[2048];
    snprintf(text, sizeof text,
             "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><GeoTransform>0,1,0,4,0,-1</GeoTransform>"
             "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename>%s</SourceFilename>"
             "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>",
             source);
    text_file(name, text);
}

/* Refused, and soon, with the words in the message. */
static void check_refused(const char *file, const char *words) {
    const program_setting setting = {.seconds_limit = 20};
    const program_result *r = program_run(&setting, (const char *const[]){"info", file, NULL});
    check(r->status == EXIT_FAILURE, "%s: exit status %d: %s", file, r->status, r->err);
    check(strstr(r->err, words) != NULL, "%s: '%s' is not in '%s'", file, words, r->err);
}

static void pipes_are_refused(void **state) {
    (void)state;
    assert_int_equal(mkfifo("pipe", 0600), 0);
    assert_int_equal(symlink("pipe", "link.tif"), 0);
    check_refused("link.tif", "not a regular file");
    vrt_file("source.vrt", "pipe");
    check_refused("source.vrt", "pipe is not a regular file");
    vrt_file("inner.vrt", "source.vrt");
    check_refused("inner.vrt", "pipe is not a regular file");
    assert_int_equal(symlink("/dev/zero", "zero.tif"), 0);
    check_refused("zero.tif", "not a regular file");
    check_refused("/vsistdin/", "cannot read");
    /* One that GDAL looks into by itself. */
    vrt_file("good.vrt", "grid.asc");
    text_file("grid.asc",
              "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4\n1 2 3 4\n1 2 3 4\n1 2 3 4\n");
    const program_setting setting = {.seconds_limit = 20};
    assert_int_equal(mkfifo("grid.prj", 0600), 0);
    const program_result *r = program_run(&setting, (const char *const[]){"info", "good.vrt", NULL});
    check(r->status == EXIT_SUCCESS, "beside a pipe: exit status %d: %s", r->status, r->err);
}

/* A name may hold an address in memory, or text in which one stands. */
static void names_are_files(void **state) {
    (void)state;
#define ADDRESS "DATAPOINTER=1,PIXELS=4,LINES=4,DATATYPE=Float32"
    static const char *const hostile[] = {"MEM:::" ADDRESS,
                                          "mem:::" ADDRESS,
                                          "Mem:::" ADDRESS,
                                          "DERIVED_SUBDATASET:AMPLITUDE:MEM:::" ADDRESS,
                                          "derived_subdataset:AMPLITUDE:DERIVED_SUBDATASET:AMPLITUDE:MEM:::" ADDRESS,
                                          "vrt://MEM:::" ADDRESS,
                                          "vrt://MEM:::" ADDRESS "?bands=1"};
    const program_setting setting = {.seconds_limit = 20};
    char text[2048];
    size_t size;
    static const float z[4] = {1, 2, 3, 4};
    field_file("field.npy", z, 2, 2);
    for (size_t k = 0; k < sizeof hostile / sizeof hostile[0]; k++) {
        check_refused(hostile[k], "cannot read");
        vrt_file("hidden.vrt", hostile[k]);
        check_refused("hidden.vrt", "cannot read");
        char *xml = scratch_read("hidden.vrt", &size);
        check_refused(xml, "cannot read");
        snprintf(text, sizeof text, " %s", xml);
        check_refused(text, "cannot read");
        free(xml);
        if (k % 3 != 0) continue;
        const program_result *r = program_run(
            &setting, (const char *const[]){"viewshed", "field.npy", "--observers", hostile[k], "-o", "out.npy", NULL});
        check(r->status == EXIT_FAILURE && strstr(r->err, "cannot read") != NULL, "observers %s: status %d: %s",
              hostile[k], r->status, r->err);
    }
    /* Entities hide the name in the text of a VRT. */
    vrt_file("hidden.vrt", "&#77;EM:::" ADDRESS);
    check_refused("hidden.vrt", "cannot read");
}

static void rough_field(size_t side) {
    float *z = malloc(sizeof *z * side * side);
    assert_non_null(z);
    for (size_t k = 0; k < side * side; k++) z[k] = (float)((k * 2654435761u >> 7) % 1000);
    field_file("rough.npy", z, side, side);
    free(z);
}

static void killed_geotiffs_leave_nothing(void **state) {
    (void)state;
    rough_field(1000);
    const size_t entries = scratch_entries();
    static const char *const options[] = {"--directions=3600", "--cog"};
    for (size_t k = 0; k < 2; k++) {
        const pid_t process = program_start(NULL, (const char *const[]){"horizon", "rough.npy", "--directions", "3600",
                                                                        options[k], "-o", "sky.tif", NULL});
        program_wait_for_output(process);
        const bool unnamed = scratch_entries() == entries;
        program_wait_until_read(process, "rough.npy");
        kill(process, SIGKILL);
        assert_int_equal(program_wait(process)->status, 128 + SIGKILL);
        if (!unnamed) skip(); /* this file system knows no files without names */
        assert_int_equal(scratch_entries(), entries);
    }
}

/* A limit on the size of files stands for a disk that is full. */
static void a_full_disk_is_named(void **state) {
    (void)state;
    rough_field(300);
    const size_t entries = scratch_entries();
    static const char *const options[] = {"--compress=none", "--compress=deflate", "--cog", "--cog"};
    /* The last one fails in the COG, which with its smaller copies is larger than the GeoTIFF that it is copied from. */
    size_t size;
    program_run(NULL, (const char *const[]){"horizon", "rough.npy", "--directions", "8", "-o", "sky.tif", NULL});
    free(scratch_read("sky.tif", &size));
    assert_int_equal(unlink("sky.tif"), 0);
    for (size_t k = 0; k < 4; k++) {
        const program_setting little = {.file_size_limit = k == 3 ? size + size / 10 : 100000};
        const program_result *r =
            program_run(&little, (const char *const[]){"horizon", "rough.npy", "--directions", "8", "-o", "sky.tif",
                                                       options[k], k >= 2 ? "--co=BLOCKSIZE=128" : NULL, NULL});
        check(r->status == EXIT_FAILURE, "exit status %d: %s", r->status, r->err);
        check(strstr(r->err, "sky.tif: cannot write: File too large") != NULL, "%s", r->err);
        assert_int_equal(scratch_entries(), entries);
    }
}

static int enter(void **state) {
    signal(SIGXFSZ, SIG_IGN);
    return scratch_enter(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pipes_are_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(names_are_files, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(killed_geotiffs_leave_nothing, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(a_full_disk_is_named, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
