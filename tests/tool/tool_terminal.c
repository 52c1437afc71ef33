/* SPDX-License-Identifier: Apache-2.0 */
/* Every subcommand on a terminal, with names, options and files that hold commands to it: nothing but text arrives there. */

#include "printable.h"
#include "tool_files.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ESC with a title, C1 in UTF-8 (CSI, NEL), a bare C1 byte, text turned round, DEL, CR, a line's end. */
#define HOSTILE "\33]0;t\7\33[31m\302\233m\302\205\233\342\200\256\342\201\246\177\r\n"

/* ---- the terminal ------------------------------------------------------------------------------------------------ */

static char shown[1 << 20];
static size_t shown_bytes;
static unsigned masked; /* runs in which hostile text arrived without its commands */

static void run_in_child(int side, const char *const *arguments) {
    char *argv[16] = {(char *)"cellwalk"};
    for (size_t k = 0; arguments[k] != NULL; k++) argv[k + 1] = (char *)(uintptr_t)arguments[k];
    for (int k = 0; k < 3; k++)
        if (dup2(side, k) < 0) _exit(255);
    alarm(60);
    execv(CELLWALK_PROGRAM, argv);
    _exit(255);
}

/* Returns the exit status. Reading fails with EIO when the program has ended, which alone has the other side. */
static int run(const char *const *arguments) {
    char name[64];
    const int terminal = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (terminal < 0) skip();
    assert_true(grantpt(terminal) == 0 && unlockpt(terminal) == 0 && ptsname_r(terminal, name, sizeof name) == 0);
    const int side = open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
    assert_true(side >= 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) run_in_child(side, arguments);
    close(side);
    shown_bytes = 0;
    for (ssize_t got;
         (got = read(terminal, shown + shown_bytes, sizeof shown - 1 - shown_bytes)) > 0 || errno == EINTR;)
        shown_bytes += got > 0 ? (size_t)got : 0;
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    close(terminal);
    shown[shown_bytes] = '\0';
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/* After a failure all lines are the program's, and none is a library's. */
static void check_lines(void) {
    for (const char *line = shown; *line; line += strcspn(line, "\n") + 1) {
        const bool own =
            strncmp(line, "cellwalk", 8) == 0 || strncmp(line, "Try '", 5) == 0 || strncmp(line, "sun at", 6) == 0;
        check(own, "a line of another: %s", line);
        if (line[strcspn(line, "\n")] == '\0') return;
    }
}

/* Takes out the line of progress, which comes by the clock: "\r", text, and "\33[K", which clears the rest. */
static void remove_progress(void) {
    size_t to = 0;
    for (size_t k = 0; k < shown_bytes;) {
        size_t end = k + 1;
        while (shown[end] != '\0' && printable_length((const unsigned char *)shown + end) > 0) end++;
        const bool progress = shown[k] == '\r' && strncmp(shown + end, "\33[K", 3) == 0;
        if (!progress) shown[to++] = shown[k];
        k = progress ? end + 3 : k + 1;
    }
    shown[shown_bytes = to] = '\0';
}

/* The terminal makes "\r\n" of a line's end. */
static void check_text(const char *const *arguments) {
    const int status = run(arguments);
    remove_progress();
    check(status <= 2 && (status == 0 || shown_bytes > 0), "%s: status %d, %zu bytes", arguments[0], status,
          shown_bytes);
    if (status != 0) check_lines();
    masked += strstr(shown, "0;t?") != NULL;
    for (size_t k = 0; k < shown_bytes;) {
        const size_t length = printable_length((const unsigned char *)shown + k);
        const char *at = shown + k;
        const bool line = *at == '\n' || (*at == '\r' && at[1] == '\n');
        check(length > 0 || line, "%s %s %s: byte %02x at %zu: %.200s", arguments[0], arguments[1],
              arguments[2] ? arguments[2] : "", (unsigned)*(const unsigned char *)at, k, shown);
        k += length > 0 ? length : 1;
    }
}

/* ---- what is hostile --------------------------------------------------------------------------------------------- */

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

#define VRT(crs, source)                                                                                               \
    "<VRTDataset rasterXSize=\"3\" rasterYSize=\"3\"><SRS>" crs "</SRS><GeoTransform>0,1,0,3,0,-1</GeoTransform>"      \
    "<VRTRasterBand dataType=\"Float32\" band=\"1\"><UnitType>" HOSTILE "</UnitType><SimpleSource>"                    \
    "<SourceFilename>" source                                                                                          \
    "</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"
#define LOCAL "LOCAL_CS[\"" HOSTILE "\",UNIT[\"metre\",1]]"

static const char *const fields[] = {HOSTILE ".npy", "no" HOSTILE ".npy", HOSTILE ".asc", HOSTILE ".pbrt",
                                     "word.asc",     "crs.vrt",           "source.vrt",   HOSTILE ".h5",
                                     HOSTILE ".nc",  "no" HOSTILE ".tif", "word.npy",     "url.vrt"};
enum { FIELDS = sizeof fields / sizeof fields[0] };

static int enter(void **state) {
    static const float z[9] = {0, 1, 2, 3, 9, 3, 2, 1, 0};
    static const char hdf[] = "\211HDF\r\n\32\n\2\10\10\0" HOSTILE HOSTILE HOSTILE,
                      cdf[] = "CDF\1\0\0\0\0" HOSTILE HOSTILE;
    if (scratch_enter(state) != 0) return -1;
    field_file(HOSTILE ".npy", z, 3, 3);
    field_file("z.npy", z, 3, 3);
    text_file(HOSTILE ".asc", "ncols 3\nnrows 3\ncellsize 1\n0 1 2\n3 9 3\n2 1 0\n");
    text_file("word.asc", "ncols 3\nnrows 3\ncellsize 1\n0 1 2\n3 " HOSTILE "x\n");
    text_file("word.npy", "\x93NUMPY\1\0\x40\0{'descr': '" HOSTILE "', 'fortran_order': False, 'shape': (3, 3), }\n");
    text_file(HOSTILE ".pbrt", "Shape \"" HOSTILE "\" \"float " HOSTILE "\" [0]\n" HOSTILE "\n");
    text_file("crs.vrt", VRT(LOCAL, HOSTILE ".asc"));
    text_file("source.vrt", VRT(LOCAL, "no" HOSTILE ".tif"));
    text_file("url.vrt", VRT("", "NETCDF:&quot;http://nowhere.invalid/" HOSTILE "&quot;:" HOSTILE));
    scratch_write(HOSTILE ".h5", hdf, sizeof hdf);
    scratch_write(HOSTILE ".nc", cdf, sizeof cdf);
    text_file("o.csv", "x,y," HOSTILE "\n1," HOSTILE ",2\n");
    text_file(HOSTILE ".csv", "x,y,height,name\n1,1,2," HOSTILE "\n99,99,2,b\n");
    text_file(HOSTILE ".geojson",
              "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"geometry\":null," HOSTILE);
    const cw_ray ray = {.org = {1.3f, 1.5f, 1e4f}, .dir = {0, 0, -1}, .tmax = 1e9f};
    rays_file("rays.npy", &ray, 1);
    return 0;
}

/* FIELD stands for each of the fields. */
#define FIELD "@"
enum { WORDS = 12 }; /* of a command, and NULL */
static const char *const commands[][WORDS] = {
    {"info", FIELD},
    {"info", FIELD, "--coarser", "2"},
    {"info", FIELD, "--json"},
    {"trace", FIELD, "rays.npy", "--user", "-o", "out.npy"},
    {"trace", "z.npy", FIELD, "-o", "out.npy"},
    {"shadow", FIELD, "--sun", "90,10", "-o", "out.npy"},
    {"shadow", FIELD, "--time", "2024-06-21T12:00Z", "--lon-lat", "9,47", "-o", "out.npy"},
    {"sun", FIELD, "--date", "2024-06-21", "--lon-lat", "9,47", "--step", "6h", "-o", "out.npy"},
    {"horizon", FIELD, "--directions", "4", "-o", "out.npy"},
    {"viewshed", FIELD, "--from", "1,1,2", "-o", "out.npy"},
    {"viewshed", "z.npy", "--observers", FIELD, "-o", "out.npy"},
    {"visibility", FIELD, "--directions", "4", "-o", "out.npy"},
    {"los", FIELD, "1,1,2", "2,2,2"},
    {"los", "z.npy", "--pairs", FIELD, "-o", "out.csv"},
    {"render", FIELD, "--size", "8x8", "-o", "out.png"},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static void fields_of_every_kind(void **state) {
    (void)state;
    for (size_t c = 0; c < COMMANDS; c++)
        for (size_t f = 0; f < FIELDS; f++) {
            if (c > 2 && !test_takes(c * FIELDS + f, 2)) continue;
            const char *arguments[WORDS] = {NULL};
            for (size_t k = 0; commands[c][k] != NULL; k++)
                arguments[k] = strcmp(commands[c][k], FIELD) == 0 ? fields[f] : commands[c][k];
            check_text(arguments);
        }
    print_message("%u runs printed hostile text\n", masked);
    assert_true(masked > COMMANDS * FIELDS / 4);
}

static void options_and_outputs(void **state) {
    (void)state;
    check_text((const char *const[]){HOSTILE, "x", NULL});
    check_text((const char *const[]){"--" HOSTILE, "x", NULL});
    static const char *const tables[] = {"o.csv", HOSTILE ".csv", HOSTILE ".geojson"};
    for (size_t t = 0; t < 3; t++) {
        check_text((const char *const[]){"viewshed", "z.npy", "--observers", tables[t], "-o", "out.npy", NULL});
        check_text((const char *const[]){"los", "z.npy", "--pairs", tables[t], "-o", "out.csv", NULL});
    }
    for (size_t c = 0; c < COMMANDS; c++) {
        const char *name = commands[c][0];
        check_text((const char *const[]){name, "z.npy", "--" HOSTILE, NULL});
        check_text((const char *const[]){name, "z.npy", "--threads", HOSTILE, NULL});
        check_text(
            (const char *const[]){name, "z.npy", "--sun", HOSTILE, "--from", HOSTILE, "-o", HOSTILE ".xyz", NULL});
        check_text((const char *const[]){name, "z.npy", "--nodata", HOSTILE, "-o", "none" HOSTILE "/out.npy", NULL});
    }
    setenv("CELLWALK_ISA", HOSTILE, 1);
    check_text((const char *const[]){"info", "--json", NULL});
    check_text((const char *const[]){"info", "z.npy", NULL});
    unsetenv("CELLWALK_ISA");
}

/* A new subcommand has to have its line above. */
static void all_commands_are_tried(void **state) {
    (void)state;
    assert_int_equal(run((const char *const[]){"--help", NULL}), 0);
    const char *line = strstr(shown, "Commands:");
    assert_non_null(line);
    for (line = strchr(line, '\n') + 1; *line == ' '; line = strchr(line, '\n') + 1) {
        const size_t length = strcspn(line + 2, " ");
        bool tried = false;
        for (size_t c = 0; c < COMMANDS; c++)
            tried = tried || (strlen(commands[c][0]) == length && strncmp(commands[c][0], line + 2, length) == 0);
        check(tried, "%.*s is not tried", (int)length, line + 2);
    }
}

/* Messages go through one function. These files write to standard error: that function, usage and progress. */
static void one_place_writes_messages(void **state) {
    (void)state;
    static const char wanted[] = "options/command.c\noptions/options.c\nprogress.c\n";
    char found[1024];
    FILE *list =
        popen("cd '" SOURCE "' && grep -rlE '[(,] *stderr *[,)]|perror *\\(' --include='*.c' tool io scene terrain base"
              " | sed 's,^tool/,,' | LC_ALL=C sort",
              "r");
    assert_non_null(list);
    found[fread(found, 1, sizeof found - 1, list)] = '\0';
    assert_int_equal(pclose(list), 0);
    assert_string_equal(found, wanted);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(fields_of_every_kind, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(options_and_outputs, enter, scratch_leave),
        cmocka_unit_test(all_commands_are_tried),
        cmocka_unit_test(one_place_writes_messages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
