/* SPDX-License-Identifier: Apache-2.0 */
/* GDAL where threads or memory are short, for each subcommand and for GeoTIFF read and written: the program ends, with the same
 * result as ever or without one. GDAL would wait for ever for a thread that the system refuses. */

#include "program.h"
#include "tool_files.h"

#include <signal.h>
#include <unistd.h>

enum { SIDE = 1025, SECONDS = 60 }; /* a run takes one; only one that hangs is ended by the alarm */

/* dem.tif is compressed, and results of four bands are large enough for threads that compress. */
#define FROM "500,500,50"
static const char *const commands[][12] = {
    {"info", "dem.tif"},
    {"trace", "dem.tif", "rays.npy", "-o", "out.npy"},
    {"shadow", "dem.tif", "--sun", "90,10", "-o", "out.tif"},
    {"sun", "dem.tif", "--lon-lat", "9,47", "--date", "2024-06-21", "--step", "6h", "-o", "out.tif"},
    {"horizon", "dem.tif", "--directions", "4", "--max-distance", "20", "-o", "out.tif"},
    {"horizon", "dem.tif", "--directions", "4", "--max-distance", "20", "--threads", "1", "-o", "out.tif"},
    {"horizon", "dem.tif", "--directions", "4", "--max-distance", "20", "--cog", "-o", "out.tif"},
    {"horizon", "dem.tif", "--directions", "1", "--max-distance", "20", "--co=NUM_THREADS=7", "-o", "out.tif"},
    {"viewshed", "dem.tif", "--from", FROM, "-o", "out.tif"},
    {"visibility", "dem.tif", "--directions", "2", "--every", "64", "--max-distance", "20", "-o", "out.tif"},
    {"los", "dem.tif", FROM, "600,600,50"},
    {"render", "dem.tif", "--size", "8x8", "-o", "out.png"},
};
enum { COMMANDS = sizeof commands / sizeof commands[0] };

static char *expected[COMMANDS];
static size_t expected_size[COMMANDS];

static const char *result_of(size_t c) {
    const char *last = NULL;
    for (size_t k = 0; commands[c][k] != NULL; k++) last = commands[c][k];
    return strncmp(last, "out.", 4) == 0 ? last : NULL;
}

static const program_result *run(size_t c, const program_setting *setting) { return program_run(setting, commands[c]); }

static char *take_result(size_t c, size_t *size) {
    const char *name = result_of(c);
    *size = 0;
    if (name == NULL || access(name, F_OK) != 0) return NULL;
    char *bytes = scratch_read(name, size);
    assert_int_equal(unlink(name), 0);
    unlink("out.pgw");
    return bytes;
}

static int enter(void **state) {
    static const char *const land[] = {"horizon", "rough.npy", "--cellsize", "1", "--directions",
                                       "1",       "-o",        "dem.tif",    NULL};
    if (scratch_enter(state) != 0) return -1;
    float *z = malloc(sizeof *z * SIDE * SIDE);
    assert_non_null(z);
    for (size_t k = 0; k < (size_t)SIDE * SIDE; k++) z[k] = (float)((k * 2654435761u >> 7) % 1000) / 100;
    field_file("rough.npy", z, SIDE, SIDE);
    free(z);
    const cw_ray ray = {.org = {3.3f, 1.5f, 1e4f}, .dir = {0, 0, -1}, .tmax = 1e9f};
    rays_file("rays.npy", &ray, 1);
    const program_result *r = program_run(NULL, land);
    check(r->status == 0, "%s", r->err);
    for (size_t c = 0; c < COMMANDS; c++) {
        r = run(c, NULL);
        if (r->status != 0 && strstr(r->err, "no library")) continue; /* for .png */
        check(r->status == 0, "%s: %s", commands[c][0], r->err);
        expected[c] = take_result(c, &expected_size[c]);
    }
    return 0;
}

static int leave(void **state) {
    for (size_t c = 0; c < COMMANDS; c++) free(expected[c]);
    return scratch_leave(state);
}

/* True if all went well. */
static bool check_end(size_t c, const program_result *r, const char *what, unsigned long limit) {
    size_t size;
    char *bytes = take_result(c, &size);
    const bool same = size == expected_size[c] && (size == 0 || memcmp(bytes, expected[c], size) == 0);
    check(r->status != 128 + SIGALRM, "%s, %s %lu: hangs: %s", commands[c][0], what, limit, r->err);
    /* GDAL and libraries behind it end a process that has no memory by a signal, also while they are loaded. */
    check(r->status <= 1 || r->status == 128 + SIGABRT || r->status == 128 + SIGSEGV, "%s, %s %lu: status %d: %s",
          commands[c][0], what, limit, r->status, r->err);
    check(r->status == 0 ? same : bytes == NULL, "%s, %s %lu: status %d and %zu bytes instead of %zu", commands[c][0],
          what, limit, r->status, size, expected_size[c]);
    free(bytes);
    return r->status == 0;
}

static void few_threads(void **state) {
    (void)state;
    for (size_t c = 0; c < COMMANDS; c++)
        for (unsigned long limit = 0; limit < 8; limit += strcmp(commands[c][0], "horizon") == 0 ? 1 : 7) {
            char text[16];
            snprintf(text, sizeof text, "%lu", limit);
            const program_setting setting = {.preload = PRELOAD, .threads = text, .seconds_limit = SECONDS};
            const bool good = check_end(c, run(c, &setting), "threads", limit);
            const bool one = limit == 0 && strcmp(commands[c][5] ? commands[c][5] : "", "--threads") != 0;
            check(good || one || limit < 7, "%s: %lu threads are not enough", commands[c][0], limit);
        }
}

static void little_memory(void **state) {
    (void)state;
    enum { FIRST = 120, STEP = 12, STEPS = 24 };
    unsigned ended[2] = {0, 0};
    for (size_t c = 0; c < COMMANDS; c++)
        for (unsigned long k = 0; k < STEPS; k++) {
            if ((k + c) % 8 != 0) continue;
            const unsigned long limit = FIRST + STEP * k;
            const program_setting setting = {.address_space_limit = limit << 20, .seconds_limit = SECONDS};
            ended[check_end(c, run(c, &setting), "MB", limit)]++;
        }
    print_message("%u runs ended without a result, %u with it\n", ended[0], ended[1]);
    assert_true(ended[0] > 0);
}

/* A new subcommand has to have its line above. */
static void all_commands_are_tried(void **state) {
    (void)state;
    const program_result *r = program_run(NULL, (const char *const[]){"--help", NULL});
    const char *line = strstr(r->out, "Commands:\n");
    assert_non_null(line);
    for (line = strchr(line, '\n') + 1; *line == ' '; line = strchr(line, '\n') + 1) {
        const size_t length = strcspn(line + 2, " ");
        bool tried = false;
        for (size_t c = 0; c < COMMANDS; c++)
            tried = tried || (strlen(commands[c][0]) == length && strncmp(commands[c][0], line + 2, length) == 0);
        check(tried, "%.*s is not tried", (int)length, line + 2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_commands_are_tried),
        cmocka_unit_test(few_threads),
        cmocka_unit_test(little_memory),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
