/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures survive the way to a file and back as far as the format promises, and damaged files are refused. */

#include "check.h"
#include "half.h"
#include "image.h"
#include "scratch.h"
#include "workload/random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 37, HEIGHT = 29 };
static float pixels[WIDTH * HEIGHT * 3];
static const io_image picture = {.width = WIDTH, .height = HEIGHT, .rgb = pixels};

static io_image read_picture(const char *path) {
    io_image image;
    io_error error;
    check(io_image_read(path, &image, &error), "%s", error.text);
    assert_non_null(image.rgb = malloc(image.width * image.height * 3 * sizeof *image.rgb));
    for (size_t k = 0; k < image.width * image.height * 3; k++) {
        const size_t x = k / 3 % image.width, y = k / 3 / image.width;
        image.rgb[k] = half_number(image.halves[((image.width + 2) * y + x + 1) * 4 + k % 3]);
    }
    return image;
}

static int set_up(void **state) {
    random_state r = {7};
    /* All sizes that a half can and cannot hold, both signs. */
    for (size_t k = 0; k < WIDTH * HEIGHT * 3; k++)
        pixels[k] = (float)(random_between(&r, -1, 1) * exp2(random_between(&r, -30, 15)));
    pixels[0] = 65504;
    pixels[1] = 65519;
    pixels[2] = 0x1p-24f;
    pixels[3] = 0x1.8p-24f;
    pixels[4] = 1.00048828125f; /* halfway between 1 and the next half: to even */
    pixels[5] = 1.00146484375f; /* halfway again, the even one is above */
    pixels[6] = 0;
    return scratch_enter(state);
}

/* Writes a text file and returns its name. */
static const char *written(const char *name, const char *text) {
    scratch_write(name, text, strlen(text));
    return name;
}

static io_image write_and_read(const char *name) {
    io_error error;
    check(io_image_write(name, &picture, &error), "%s", error.text);
    const io_image back = read_picture(name);
    check(back.width == WIDTH && back.height == HEIGHT, "%s: %zu x %zu", name, back.width, back.height);
    return back;
}

/* The nearest half, found in another way: multiples of the spacing at that size, ties to even as rint does it. */
static float nearest_half(float x) {
    int exponent;
    frexpf(x, &exponent);
    const float spacing = ldexpf(1, (exponent < -13 ? -13 : exponent) - 11);
    const float half = rintf(x / spacing) * spacing;
    return fabsf(half) > 65504 ? copysignf(INFINITY, x) : half;
}

static void exr_rounds_to_the_nearest_half(void **state) {
    (void)state;
    io_image back = write_and_read("a.exr");
    for (size_t k = 0; k < WIDTH * HEIGHT * 3; k++)
        check(back.rgb[k] == nearest_half(pixels[k]), "%a came back as %a, not %a", (double)pixels[k],
              (double)back.rgb[k], (double)nearest_half(pixels[k]));
    io_image_free(&back);
}

/* Halves are those that were written. */
static void halves_are_read_as_they_are(void **state) {
    (void)state;
    io_image back = write_and_read("a.exr");
    for (size_t k = 0; k < WIDTH * HEIGHT; k++)
        for (size_t c = 0; c < 3; c++)
            check(back.halves[4 * (k / WIDTH * (WIDTH + 2) + k % WIDTH + 1) + c] == half_from_float(pixels[3 * k + c]),
                  "half %zu differs", 4 * k + c);
    io_image_free(&back);
}

/* PNG cannot be read back: its header at least, and that the whole file is there. */
static void png_is_whole(void **state) {
    (void)state;
    io_error error;
    if (!io_image_can_write("a.png", &error)) skip();
    check(io_image_write("a.png", &picture, &error), "%s", error.text);
    unsigned char bytes[1 << 14];
    FILE *file = fopen("a.png", "rb");
    assert_non_null(file);
    const size_t n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    check(n > 45 && memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0, "no PNG header");
    check(bytes[19] == WIDTH && bytes[23] == HEIGHT && bytes[24] == 8 && bytes[25] == 2, "not 8-bit RGB of that size");
    check(memcmp(bytes + n - 8, "IEND", 4) == 0, "the end is missing");
}

static void refuse(const char *path, const char *reason) {
    io_image image;
    io_error error;
    check(!io_image_read(path, &image, &error), "%s was read", path);
    check(image.halves == NULL, "pixels are left");
    check(strncmp(error.text, path, strlen(path)) == 0 && strstr(error.text, reason) != NULL, "message: %s",
          error.text);
}

static void damaged_files_are_refused(void **state) {
    (void)state;
    refuse("missing.exr", "No such file");
    refuse(written("a.gif", "GIF"), "unknown kind of picture");
    io_error error;
    refuse(written("word.exr", "hello"), "not a readable OpenEXR picture");
    check(io_image_write("whole.exr", &picture, &error), "%s", error.text);
    /* Cut at every 97th byte. */
    for (long size = 0;; size += 97) {
        FILE *file = fopen("whole.exr", "rb");
        char bytes[1 << 15];
        const long whole = (long)fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        if (size >= whole) break;
        file = fopen("cut.exr", "wb");
        fwrite(bytes, 1, (size_t)size, file);
        fclose(file);
        refuse("cut.exr", "");
    }
}

static void a_full_disk_is_reported_and_nothing_left(void **state) {
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    static const char *const names[] = {"full.png", "full.exr"};
    for (int k = 0; k < 2; k++) {
        io_error error;
        if (!io_image_can_write(names[k], &error)) continue;
        check(symlink("/dev/full", names[k]) == 0, "cannot link");
        const int before = (int)scratch_entries();
        check(!io_image_write(names[k], &picture, &error), "%s was written", names[k]);
        check(strstr(error.text, "No space left") != NULL, "message: %s", error.text);
        check((int)scratch_entries() == before, "files are left");
    }
}

static void unknown_endings_are_refused(void **state) {
    (void)state;
    io_error error;
    const int before = (int)scratch_entries();
    check(!io_image_write("a.jpg", &picture, &error), "a.jpg was written");
    check(strstr(error.text, ".exr") != NULL, "the message does not say what can be written: %s", error.text);
    check(!io_image_write("none/a.exr", &picture, &error), "written into a missing folder");
    check((int)scratch_entries() == before, "files are left");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exr_rounds_to_the_nearest_half),
        cmocka_unit_test(halves_are_read_as_they_are),
        cmocka_unit_test(png_is_whole),
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(a_full_disk_is_reported_and_nothing_left),
        cmocka_unit_test(unknown_endings_are_refused),
    };
    return cmocka_run_group_tests(tests, set_up, scratch_leave);
}
