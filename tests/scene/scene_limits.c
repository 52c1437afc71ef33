/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes that ask for more than any honest one: each ends soon, with a message that names the limit. */

#include "check.h"
#include "image.h"
#include "model.h"
#include "scene.h"
#include "scratch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEAD  "LookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\"\nWorldBegin\n"
#define PLAIN "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0]\n"

/* What hangs is ended by a signal. */
static int enter(void **state) {
    alarm(60);
    return scratch_enter(state);
}

static void write_text(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static void check_refused(const char *path, const char *part) {
    io_error error = {""};
    scene *s = scene_load(path, NULL, NULL, &error);
    check(s == NULL, "%s was read, which should fail with '%s'", path, part);
    check(strstr(error.text, part) != NULL, "'%s' instead of '%s'", error.text, part);
}

static void included_files_are_counted(void **state) {
    (void)state;
    enum { LEVELS = 12, TIMES = 10 };
    write_text("bomb.pbrt", HEAD "Include \"0\"\nWorldEnd\n");
    for (int level = 0; level < LEVELS; level++) {
        char name[16], text[32 * TIMES] = "";
        snprintf(name, sizeof name, "%d", level);
        for (int k = 0; level + 1 < LEVELS && k < TIMES; k++) {
            char line[32];
            snprintf(line, sizeof line, "Include \"%d\"\n", level + 1);
            strcat(text, line);
        }
        write_text(name, text);
    }
    check_refused("bomb.pbrt", "more than 4096 files are included");
}

static void only_files_are_read(void **state) {
    (void)state;
    assert_int_equal(mkfifo("pipe", 0666), 0);
    assert_int_equal(mkfifo("pipe.exr", 0666), 0);
    assert_int_equal(symlink("/dev/zero", "zero.exr"), 0);
    static const char *const included[] = {"pipe", "/dev/zero"};
    for (size_t k = 0; k < 2; k++) {
        char text[200];
        snprintf(text, sizeof text, HEAD "Include \"%s\"\nWorldEnd\n", included[k]);
        write_text("a.pbrt", text);
        check_refused("a.pbrt", "not a regular file");
    }
    static const char *const images[] = {"pipe.exr", "zero.exr"};
    for (size_t k = 0; k < 2; k++) {
        char text[600];
        snprintf(text, sizeof text,
                 HEAD "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"%s\"\n"
                      "Material \"matte\" \"texture Kd\" \"t\"\n" PLAIN "WorldEnd\n",
                 images[k]);
        write_text("a.pbrt", text);
        check_refused("a.pbrt", "not a regular file");
    }
}

static void films_are_bounded(void **state) {
    (void)state;
    write_text("a.pbrt",
               "Film \"image\" \"integer xresolution\" 65536 \"integer yresolution\" 65536\n" HEAD "WorldEnd\n");
    check_refused("a.pbrt", "a.pbrt:1: Film: 65536 x 65536 pixels are more than 268435456");
    write_text("a.pbrt",
               "Film \"image\" \"integer xresolution\" 16384 \"integer yresolution\" 16384\n" HEAD "WorldEnd\n");
    io_error error = {""};
    scene *s = scene_load("a.pbrt", NULL, NULL, &error);
    check(s != NULL, "%s", error.text);
    scene_free(s);
}

/* A picture's size, in a header that is whole otherwise. */
static void claim(char *bytes, size_t size, const char *attribute, int32_t side) {
    const size_t length = strlen(attribute) + 1 + sizeof "box2i" + 4; /* name, type, size */
    for (size_t k = 0; k + length + 16 <= size; k++)
        if (memcmp(bytes + k, attribute, strlen(attribute) + 1) == 0) {
            memcpy(bytes + k + length + 8, &side, 4);
            memcpy(bytes + k + length + 12, &side, 4);
            return;
        }
    check(false, "the header has no %s", attribute);
}

static void small_files_hold_no_large_pictures(void **state) {
    (void)state;
    static float rgb[12];
    io_error error = {""};
    io_image image;
    check(io_image_write("a.exr", &(io_image){.width = 2, .height = 2, .rgb = rgb}, &error), "%s", error.text);
    size_t size;
    char *bytes = scratch_read("a.exr", &size);
    static const int32_t sides[] = {16383, 1600000};
    for (size_t k = 0; k < 2; k++) {
        claim(bytes, size, "dataWindow", sides[k]);
        claim(bytes, size, "displayWindow", sides[k]);
        scratch_write("a.exr", bytes, size);
        check(!io_image_read("a.exr", &image, &error), "a picture of %d a side in %zu bytes", sides[k], size);
        check(strstr(error.text, "pixels are more than") != NULL, "%s", error.text);
    }
    free(bytes);
}

typedef struct warnings {
    unsigned count;
    char last[512];
} warnings;

static void note(void *context, const char *message) {
    warnings *w = context;
    w->count++;
    check(w->count > 100 || strstr(message, "Accelerator: skipped") != NULL, "%s", message);
    char line[32];
    snprintf(line, sizeof line, "a.pbrt:%u: ", w->count);
    check(w->count > 100 || strncmp(message, line, strlen(line)) == 0, "'%s' is not line %u", message, w->count);
    snprintf(w->last, sizeof w->last, "%s", message);
}

static void warnings_end(void **state) {
    (void)state;
    FILE *file = fopen("a.pbrt", "w");
    assert_non_null(file);
    for (int k = 0; k < 40000; k++) fputs("Accelerator \"bvh\"\n", file);
    fputs(HEAD "Material \"matte\" \"float first\" 1\n\"float second\" 2\n", file);
    fclose(file);
    warnings w = {0};
    io_error error = {""};
    assert_null(scene_load("a.pbrt", note, &w, &error));
    assert_int_equal(w.count, 101);
    check(strstr(w.last, "further warnings") != NULL, "%s", w.last);
    check(strstr(error.text, "a.pbrt:40004: Material: ") != NULL, "%s", error.text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(included_files_are_counted, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(only_files_are_read, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(films_are_bounded, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(small_files_hold_no_large_pictures, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(warnings_end, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
