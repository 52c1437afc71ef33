/* SPDX-License-Identifier: Apache-2.0 */
/* What the program says to bad input, and that it leaves nothing behind. */

#include "program.h"
#include "tool_files.h"

#include <signal.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

enum { RAYS = 1000, NX = 5, NY = 4 };

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static const float z[NX * NY];
    static cw_ray rays[RAYS];
    for (size_t k = 0; k < RAYS; k++)
        rays[k] = (cw_ray){.org = {2.25f, 1.5f, (float)k + 1}, .dir = {0, 0, -1}, .tmax = 1e9f};
    field_file("field.npy", z, NX, NY);
    rays_file("rays.npy", rays, RAYS);
    return 0;
}

static void check_failure(const program_result *r, int status, const char *part) {
    check(r->status == status, "exit status %d instead of %d: %s", r->status, status, r->err);
    check(strstr(r->err, part) != NULL, "'%s' is not in '%s'", part, r->err);
    check(strncmp(r->err, "cellwalk", 8) == 0, "'%s' does not say who speaks", r->err);
    check(r->out[0] == '\0', "standard output: %s", r->out);
}

/* The program is told to write hits.npy, and must not. */
static void check_refused(const program_setting *setting, const char *field, const char *rays, const char *part) {
    const size_t entries = scratch_entries();
    check_failure(program_run(setting, (const char *const[]){"trace", field, rays, "-o", "hits.npy", NULL}), 1, part);
    assert_int_equal(scratch_entries(), entries);
}

static void bad_command_lines(void **state) {
    (void)state;
    static const struct {
        const char *arguments[8], *part;
    } cases[] = {
        {{NULL}, ""},
        {{"tarce"}, "did you mean trace?"},
        {{"--verbose"}, "unknown option '--verbose'"},
        {{"trace"}, "FIELD is missing"},
        {{"trace", "field.npy"}, "RAYS.npy is missing"},
        {{"trace", "field.npy", "rays.npy"}, "nothing to do"},
        {{"trace", "field.npy", "rays.npy", "hits.npy"}, "'hits.npy' is one argument too many"},
        {{"trace", "field.npy", "rays.npy", "-o"}, "--output needs a value"},
        {{"trace", "field.npy", "rays.npy", "-o", ""}, "--output needs a value"},
        {{"trace", "field.npy", "rays.npy", "-x"}, "unknown option -x"},
        {{"trace", "field.npy", "rays.npy", "--kernal=cell"}, "--kernal; did you mean --kernel?"},
        {{"trace", "field.npy", "rays.npy", "--json=yes"}, "--json takes no value"},
        {{"trace", "field.npy", "rays.npy", "--json", "--kernel", "celt"}, "'celt' is unknown; did you mean cell?"},
        {{"trace", "field.npy", "rays.npy", "--json", "--leaf", "woop"},
         "there are default, moller-trumbore, watertight"},
        {{"trace", "field.npy", "rays.npy", "--json", "--isa", "avx"}, "scalar, sse4.2, avx2, avx512"},
        {{"trace", "field.npy", "rays.npy", "--json", "--repeat", "0"}, "from 1 to 1000000, not '0'"},
        {{"trace", "field.npy", "rays.npy", "--json", "--threads", "-1"}, "not '-1'"},
        {{"trace", "field.npy", "rays.npy", "--json", "--threads", "two"}, "not 'two'"},
        {{"trace", "field.npy", "rays.npy", "--json", "--threads", "4x"}, "not '4x'"},
        {{"trace", "field.npy", "rays.npy", "--json", "--threads=99999999999999999999"}, "not '99999999999999999999'"},
        {{"trace", "field.npy", "rays.npy", "-o", "-", "--json"}, "standard output cannot take both"},
        {{"info", "a", "b"}, "'b' is one argument too many"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const program_result *r = program_run(NULL, cases[k].arguments);
        check(r->status == 2 && strstr(r->err, cases[k].part), "case %zu: exit status %d: %s", k, r->status, r->err);
        check(r->out[0] == '\0', "standard output: %s", r->out);
    }
    assert_int_equal(scratch_entries(), 2);
}

static void kernels_out_of_reach(void **state) {
    (void)state;
    const program_setting scalar = {.isa = "scalar"}, wrong = {.isa = "sse"}, empty = {.isa = ""};
    const char *const trace[] = {"trace", "field.npy", "rays.npy", "-o", "hits.npy", NULL};
    check_failure(program_run(&wrong, trace), 2, "CELLWALK_ISA 'sse' is unknown; there are scalar,");
    check_failure(program_run(&empty, trace), 2, "CELLWALK_ISA '' is unknown; there are scalar,");
    check_failure(program_run(NULL, (const char *const[]){"trace", "field.npy", "rays.npy", "--json", "--kernel",
                                                          "brute", "--leaf", "watertight", NULL}),
                  2, "brute does not have the leaf test watertight");
    assert_int_equal(program_run(&scalar, trace)->status, 0);
    if (!cw_kernel_exists(cw_kernel_find("packet4"))) return; /* a build without them */
    check_failure(program_run(&scalar, (const char *const[]){"trace", "field.npy", "rays.npy", "--json", "--kernel",
                                                             "packet4", NULL}),
                  2,
                  "--kernel packet4 needs sse4.2; this machine, or the limit set by --isa or CELLWALK_ISA, has scalar");
    check_failure(program_run(NULL, (const char *const[]){"trace", "field.npy", "rays.npy", "--json", "--kernel",
                                                          "packet4", "--isa", "scalar", NULL}),
                  2, "--kernel packet4 needs sse4.2");
    /* The variable is an upper bound: no option lifts it. */
    check_failure(program_run(&scalar, (const char *const[]){"trace", "field.npy", "rays.npy", "--json", "--isa",
                                                             "sse4.2", NULL}),
                  2, "--isa sse4.2: this machine, or CELLWALK_ISA, allows no more than scalar");
}

static void bad_rays(void **state) {
    (void)state;
    static const float values[64];
    npy_file("f8.npy", "<f8", "(2, 8)", values, 128);
    npy_file("big.npy", ">f4", "(2, 8)", values, 64);
    npy_file("seven.npy", "<f4", "(2, 7)", values, 56);
    npy_file("flat.npy", "<f4", "(16,)", values, 64);
    npy_file("huge.npy", "<f4", "(1000000000, 8)", values, 64);
    npy_file("longer.npy", "<f4", "(2, 8)", values, 65);
    check_refused(NULL, "field.npy", "f8.npy", "f8.npy: holds elements of type '<f8', not '<f4'");
    check_refused(NULL, "field.npy", "big.npy", "big.npy: holds elements of type '>f4'");
    check_refused(NULL, "field.npy", "seven.npy", "seven.npy: shape (2, 7), but rays are (N, 8)");
    check_refused(NULL, "field.npy", "flat.npy", "flat.npy: shape (16,), but rays are (N, 8)");
    check_refused(NULL, "field.npy", "huge.npy", "huge.npy: truncated: shape (1000000000, 8)");
    check_refused(NULL, "field.npy", "longer.npy", "longer.npy: too long");
    check_refused(NULL, "field.npy", "absent.npy", "absent.npy: cannot read: No such file");
    check_refused(NULL, "field.npy", ".", ".: cannot read: Is a directory");
    check_refused(NULL, "field.npy", "/dev/null", "/dev/null: cannot read: not a regular file");
    size_t size;
    char *bytes = scratch_read("rays.npy", &size);
    for (size_t cut = 0; cut < 128; cut += 9) { /* each byte of the header is the library's test's */
        scratch_write("cut.npy", bytes, cut);
        check_refused(NULL, "field.npy", "cut.npy", "cut.npy: ");
    }
    scratch_write("cut.npy", bytes, size - 1);
    check_refused(NULL, "field.npy", "cut.npy", "cut.npy: truncated");
    free(bytes);
}

static void bad_fields(void **state) {
    (void)state;
    static const float values[16];
    npy_file("row.npy", "<f4", "(1, 16)", values, 64);
    npy_file("none.npy", "<f4", "(0, 16)", values, 0);
    npy_file("cube.npy", "<f4", "(2, 2, 4)", values, 64);
    npy_file("bytes.npy", "|u1", "(8, 8)", values, 64);
    npy_file("cut.npy", "<f4", "(4, 4)", values, 63);
    scratch_write("word.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 four\n", 39);
    static const char sea[] = "Shape \"heightfield\" \"integer nu\" [2] \"integer nv\" [2] \"float Pz\" [0 1 2 3]\n";
    char twice[2 * sizeof sea];
    snprintf(twice, sizeof twice, "%s%s", sea, sea);
    scratch_write("two.pbrt", twice, strlen(twice));
    scratch_write("none.pbrt", "\n", 1);
    check_refused(NULL, "two.pbrt", "rays.npy", "two.pbrt: holds 2 height fields, not one");
    check_refused(NULL, "none.pbrt", "rays.npy", "none.pbrt: holds 0 height fields, not one");
    check_refused(NULL, "row.npy", "rays.npy", "row.npy: 16 x 1 samples: ");
    check_refused(NULL, "none.npy", "rays.npy", "none.npy: shape (0, 16) holds no samples");
    check_refused(NULL, "cube.npy", "rays.npy", "cube.npy: shape (2, 2, 4), but a raster is (rows, columns)");
    check_refused(NULL, "bytes.npy", "rays.npy", "bytes.npy: holds elements of type '|u1'");
    check_refused(NULL, "cut.npy", "rays.npy", "cut.npy: truncated");
    check_refused(NULL, "word.asc", "rays.npy", "word.asc:5: 'four' stands where a number should");
    check_refused(NULL, "absent.npy", "rays.npy", "absent.npy: cannot read: No such file");
    check_refused(NULL, "field", "rays.npy", "cellwalk trace: field: ");
}

/* Nothing in a file's name or text commands the terminal that shows the message. */
static void messages_hold_no_commands(void **state) {
    (void)state;
    static const char red[] = "\33[31mred\7\r\302\233m\177.asc";
    scratch_write("word.asc", "ncols 2\nnrows 2\ncellsize 1\n1 2\n3 \33]0;title\7\n", 44);
    scratch_write("a.pbrt", "Shape \"\33[2J\302\233\"\n", 15);
    static const char *const cases[][5] = {
        {"info", red}, {"info", "word.asc"}, {"info", "a.pbrt"}, {"info", "--kernel", red}, {"info", "field.npy", red},
        {red}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const program_result *r = program_run(NULL, cases[k]);
        check(r->status != 0 && r->err[0] != '\0', "case %zu: %s", k, r->err);
        for (const char *c = r->err; *c; c++)
            check((*c == '\n' || (unsigned char)*c >= 0x20) && *c != 0x7f &&
                      !((unsigned char)c[0] == 0xc2 && (unsigned char)c[1] < 0xa0),
                  "case %zu: byte %#x", k, (unsigned)(unsigned char)*c);
    }
}

static void check_no_output(const char *output, const program_setting *setting, const char *part) {
    const size_t entries = scratch_entries();
    const program_result *r =
        program_run(setting, (const char *const[]){"trace", "field.npy", "rays.npy", "-o", output, NULL});
    check_failure(r, 1, part);
    assert_int_equal(scratch_entries(), entries);
}

static void bad_outputs(void **state) {
    (void)state;
    check_no_output("/dev/full", NULL, "/dev/full: cannot write: No space left on device");
    check_no_output("absent/hits.npy", NULL, "absent/hits.npy: cannot write: No such file");
    check_no_output(".", NULL, ".: cannot write: Is a directory");
    /* A disk quota shows in the same way as this limit; the file that was there stays. */
    scratch_write("hits.npy", "old", 3);
    const program_setting little = {.file_size_limit = 8192};
    check_no_output("hits.npy", &little, "hits.npy: cannot write: File too large");
    size_t size;
    char *bytes = scratch_read("hits.npy", &size);
    assert_string_equal(bytes, "old");
    free(bytes);
    const program_result *r =
        program_run(NULL, (const char *const[]){"trace", "field.npy", "rays.npy", "-o", "/dev/full", "--json", NULL});
    check_failure(r, 1, "No space left"); /* and no time is told of a run that failed */
}

static void directories_without_permission(void **state) {
    (void)state;
    assert_int_equal(mkdir("closed", 0555), 0);
    const program_setting powerless = {.powerless = true};
    const char *const arguments[] = {"trace", "field.npy", "rays.npy", "-o", "closed/hits.npy", NULL};
    const program_result *r = program_run(&powerless, arguments);
    if (r->status == 255) skip(); /* root that may not give up its rights */
    check_failure(r, 1, "closed/hits.npy: cannot write: Permission denied");
    /* A file can be replaced wherever its directory may be written to; but its owner wants it to stay. */
    scratch_write("hits.npy", "old", 3);
    assert_int_equal(chmod("hits.npy", 0444), 0);
    check_no_output("hits.npy", &powerless, "hits.npy: cannot write: Permission denied");
}

/* What is read is never replaced by what is written, by whatever name. */
static void inputs_as_outputs(void **state) {
    (void)state;
    size_t size, size_now;
    char *field = scratch_read("field.npy", &size);
    assert_int_equal(link("field.npy", "again.npy"), 0);
    assert_int_equal(symlink("rays.npy", "same.npy"), 0);
    check_no_output("field.npy", NULL, "field.npy: is also an input");
    check_no_output("rays.npy", NULL, "rays.npy: is also an input");
    check_no_output("./field.npy", NULL, "./field.npy: is also an input");
    check_no_output("again.npy", NULL, "again.npy: is also an input");
    check_no_output("same.npy", NULL, "same.npy: is also an input");
    static const char scene[] = "Camera \"perspective\"\nWorldBegin\n"
                                "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"image.exr\"\n"
                                "Material \"matte\" \"texture Kd\" \"t\"\n"
                                "Include \"shape.exr\"\nWorldEnd\n";
    static const char shape[] = "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 1 2 3]\n";
    scratch_write("scene.pbrt", scene, sizeof scene - 1);
    scratch_write("shape.exr", shape, sizeof shape - 1);
    static const char image[] = "Camera \"perspective\"\nWorldBegin\nWorldEnd\n";
    scratch_write("image.pbrt", image, sizeof image - 1);
    const program_result *r = program_run(NULL, (const char *const[]){"render", "image.pbrt", "-o", "image.exr", NULL});
    for (int k = 0; r->status == 0 && k < 2; k++) { /* with OpenEXR */
        const char *output = k == 0 ? "shape.exr" : "image.exr";
        check_failure(program_run(NULL, (const char *const[]){"render", "scene.pbrt", "-o", output, NULL}), 1,
                      "is also an input");
    }
    char *now = scratch_read("field.npy", &size_now);
    assert_int_equal(size, size_now);
    assert_memory_equal(field, now, size);
    free(field);
    free(now);
}

static void output_to_standard_output(void **state) {
    (void)state;
    char command[4200];
    snprintf(command, sizeof command,
             "'%s' trace field.npy rays.npy -o - > piped.npy && '%s' trace field.npy rays.npy -o hits.npy",
             CELLWALK_PROGRAM, CELLWALK_PROGRAM);
    assert_int_equal(system(command), 0);
    size_t size, other;
    char *piped = scratch_read("piped.npy", &size), *hits = scratch_read("hits.npy", &other);
    assert_int_equal(size, other);
    assert_memory_equal(piped, hits, size);
    free(piped);
    free(hits);
}

/* A warning that cannot be shown lands in no file either. */
static void closed_streams_are_no_files(void **state) {
    (void)state;
    float z[NX * NY] = {-9999};
    field_file("warns.npy", z, NX, NY);
    char command[4200];
    snprintf(command, sizeof command, "'%s' trace warns.npy rays.npy -o hits.npy 2> warnings", CELLWALK_PROGRAM);
    assert_int_equal(system(command), 0);
    size_t size, other;
    char *warnings = scratch_read("warnings", &size);
    check(strstr(warnings, "-9999") != NULL, "no warning: %s", warnings);
    free(warnings);
    char *hits = scratch_read("hits.npy", &size);
    static const char *const closed[] = {"<&- 2>&-", ">&- 2>&-", "<&- >&- 2>&-", "2>&-"};
    for (size_t k = 0; k < sizeof closed / sizeof closed[0]; k++) {
        snprintf(command, sizeof command, "'%s' trace warns.npy rays.npy -o again.npy %s", CELLWALK_PROGRAM, closed[k]);
        assert_int_equal(system(command), 0);
        char *again = scratch_read("again.npy", &other);
        check(size == other && memcmp(hits, again, size) == 0, "%s: another file", closed[k]);
        free(again);
    }
    free(hits);
}

static void killed_programs_leave_nothing(void **state) {
    (void)state;
    const size_t entries = scratch_entries();
    const pid_t process = program_start(
        NULL, (const char *const[]){"trace", "field.npy", "rays.npy", "-o", "hits.npy", "--repeat", "1000000", NULL});
    program_wait_for_output(process);
    const bool unnamed = scratch_entries() == entries;
    kill(process, SIGKILL);
    assert_int_equal(program_wait(process)->status, 128 + SIGKILL);
    if (!unnamed) skip(); /* this file system knows no files without names */
    assert_int_equal(scratch_entries(), entries);
}

static void check_signal(int number) {
    const size_t entries = scratch_entries();
    const char *const arguments[] = {"trace",    "field.npy", "rays.npy",  "-o", "hits.npy",
                                     "--repeat", "1000000",   "--threads", "2",  NULL};
    const pid_t process = program_start(NULL, arguments);
    program_wait_for_output(process);
    kill(process, number);
    const program_result *r = program_wait(process);
    check(r->status == 128 + number, "exit status %d: %s", r->status, r->err);
    check(strstr(r->err, "interrupted") != NULL, "%s", r->err);
    assert_int_equal(scratch_entries(), entries);
}

static void interruptions_leave_nothing(void **state) {
    (void)state;
    check_signal(SIGINT);
    check_signal(SIGTERM);
    check_signal(SIGHUP);
}

/* A field and rays for which a query by brute force takes minutes. */
static void large_work(void) {
    enum { SIDE = 1000, MANY = 100000 };
    float *z = calloc(SIDE * SIDE, sizeof *z);
    cw_ray *rays = calloc(MANY, sizeof *rays);
    assert_true(z && rays);
    for (size_t k = 0; k < MANY; k++) rays[k] = (cw_ray){.org = {5.5f, 5, 1}, .dir = {0, 0, -1}, .tmax = 1e9f};
    field_file("large.npy", z, SIDE, SIDE);
    rays_file("many.npy", rays, MANY);
    free(rays);
    free(z);
}

static const char *const minutes[] = {"trace", "large.npy", "many.npy", "-o", "hits.npy", "--kernel", "brute", NULL};

/* The program is in the middle of a query that does not look whether it is told to stop. */
static void interruptions_do_not_wait(void **state) {
    (void)state;
    large_work();
    const size_t entries = scratch_entries();
    const pid_t process = program_start(NULL, minutes);
    program_wait_for_output(process);
    program_wait_until_read(process, "many.npy"); /* rays are read for the query that traces them */
    kill(process, SIGINT);
    const program_result *r = program_wait(process);
    check(r->status == 128 + SIGINT, "exit status %d: %s", r->status, r->err);
    check(strstr(r->err, "interrupted") != NULL, "%s", r->err);
    assert_int_equal(scratch_entries(), entries);
}

/* Nor does it look while it reads, here nine million numbers of many digits. */
static void interruptions_while_reading(void **state) {
    (void)state;
    enum { SIDE = 3000 };
    FILE *file = fopen("text.asc", "w");
    assert_non_null(file);
    fprintf(file, "ncols %d\nnrows %d\ncellsize 1\n", SIDE, SIDE);
    for (int k = 0; k < SIDE * SIDE; k++) fputs("1.2345678901234567890123456789 ", file);
    fclose(file);
    const pid_t process = program_start(NULL, (const char *const[]){"info", "text.asc", NULL});
    program_wait_for_input(process, "text.asc");
    kill(process, SIGTERM);
    const program_result *r = program_wait(process);
    check(r->status == 128 + SIGTERM, "exit status %d: %s", r->status, r->err);
}

static void second_interruption_is_the_end(void **state) {
    (void)state;
    large_work();
    const size_t entries = scratch_entries();
    const pid_t process = program_start(NULL, minutes);
    program_wait_for_output(process);
    kill(process, SIGINT);
    assert_int_equal(kill(process, SIGTERM), 0);
    const program_result *r = program_wait(process);
    check(r->status == 128 + SIGINT || r->status == 128 + SIGTERM, "exit status %d: %s", r->status, r->err);
    assert_int_equal(scratch_entries(), entries);
}

static void results_that_cannot_be_printed(void **state) {
    (void)state;
    /* The shell redirects, so that the program's own standard output is the full device. */
    char command[4200];
    snprintf(command, sizeof command, "'%s' info > /dev/full 2> message", CELLWALK_PROGRAM);
    assert_int_not_equal(system(command), 0);
    size_t size;
    char *bytes = scratch_read("message", &size);
    assert_string_equal(bytes, "cellwalk: cannot write to standard output: No space left on device\n");
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(bad_command_lines, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(kernels_out_of_reach, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_rays, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_fields, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_outputs, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(directories_without_permission, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(messages_hold_no_commands, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(inputs_as_outputs, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(output_to_standard_output, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(closed_streams_are_no_files, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(killed_programs_leave_nothing, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(interruptions_leave_nothing, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(interruptions_do_not_wait, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(interruptions_while_reading, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(second_interruption_is_the_end, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_that_cannot_be_printed, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
