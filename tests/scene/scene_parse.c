/* SPDX-License-Identifier: Apache-2.0 */
/* The .pbrt reader: numbers to the last bit, and every mistake named with file, line and directive. */

#include "check.h"
#include "image.h"
#include "pbrt_lex.h"
#include "plain.h"
#include "scene.h"
#include "scratch.h"
#include "workload/random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define HEAD "LookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\"\nWorldBegin\n"

/* Writes a text file and returns its name. */
static const char *written(const char *name, const char *text) {
    scratch_write(name, text, strlen(text));
    return name;
}

static void number_equals_plain(const char *text) {
    double number = 0;
    const char *end = pbrt_number(text, &number);
    check(end != NULL && *end == '\0', "\"%s\" is not read to its end", text);
    check(number == plain_double(text), "\"%s\" is %a, not %a", text, number, plain_double(text));
}

static void numbers_are_rounded_correctly(void **state) {
    (void)state;
    static const char *const texts[] = {"0",
                                        "-0",
                                        ".5",
                                        "5.",
                                        "+1e+3",
                                        "1E-3",
                                        "9007199254740993",
                                        "0.1",
                                        "123456789012345678901234567890",
                                        "0.000000000000000000000000000000000001234567890123456789",
                                        "2.2250738585072011e-308",
                                        "1e23",
                                        "8.5e22",
                                        "1e400",
                                        "1e-400",
                                        "1e99999999999"};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) number_equals_plain(texts[k]);
    random_state r = {3};
    for (int k = 0; k < 100000; k++) {
        char text[64];
        const double size = ldexp(random_unit(&r), (int)random_below(&r, 200) - 100);
        plain_print(text, sizeof text, "%.*g", 1 + (int)random_below(&r, 20), k % 2 ? size : -size);
        number_equals_plain(text);
    }
    double number;
    static const char *const wrong[] = {"", "-", ".", "e5", "nan", "inf", "+-1", "1e", "1e+"};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++)
        check(pbrt_number(wrong[k], &number) == NULL, "\"%s\" counts as a number", wrong[k]);
}

/* Texts beside the points halfway between two floats, by less than a double can tell; and plain ones. */
static void halfway_texts(char texts[][48], int count) {
    random_state r = {5};
    for (int k = 0; k < count; k++) {
        const float below = (float)ldexp(random_unit(&r), (int)random_below(&r, 8) - 4);
        const double middle = ((double)below + (double)nextafterf(below, INFINITY)) / 2;
        if (k % 4 == 3)
            plain_print(texts[k], sizeof texts[k], "%.6f", middle);
        else
            plain_print(texts[k], sizeof texts[k], k % 4 == 0 ? "-%.40f" : "%.40f", middle);
        /* All 40 digits are exact, and the last one is a zero. */
        if (k % 4 == 1) texts[k][strlen(texts[k]) - 1] = '1';
    }
}

/* Samples are what strtof says, not a double rounded a second time. */
static void samples_are_rounded_once(void **state) {
    (void)state;
    enum { SIDE = 40, RANDOM = SIDE * SIDE - 8 };
    static char texts[SIDE * SIDE][48] = {"1.000000059604644775390625000000001",
                                          "1.000000059604644775390625",
                                          "1.000000178813934326171875",
                                          "-7.006492321624086e-46",
                                          "1267650600228229401496703205376",
                                          "1e-46",
                                          "-0.0",
                                          "16777217"};
    halfway_texts(texts + 8, RANDOM);
    static char file[SIDE * SIDE * 50 + 200];
    size_t used = (size_t)snprintf(
        file, sizeof file, HEAD "Shape \"heightfield\" \"integer nu\" %d \"integer nv\" %d \"float Pz\" [", SIDE, SIDE);
    for (int k = 0; k < SIDE * SIDE; k++)
        used += (size_t)snprintf(file + used, sizeof file - used, "%s%s", texts[k],
                                 k + 1 == SIDE * SIDE ? "]\nWorldEnd\n"
                                 : k % 7 == 3         ? "\t# word\n"
                                                      : " ");
    io_error error = {""};
    scene *s = scene_load(written("halfway.pbrt", file), NULL, NULL, &error);
    check(s != NULL, "%s", error.text);
    const cw_field *field = scene_field(s, 0);
    int doubled = 0;
    for (size_t k = 0; k < SIDE * SIDE; k++) {
        const float sample = cw_field_row(field, k / SIDE)[k % SIDE], wanted = plain_float(texts[k]);
        check(memcmp(&sample, &wanted, sizeof sample) == 0, "%s is %a, not %a", texts[k], (double)sample,
              (double)wanted);
        doubled += (float)plain_double(texts[k]) != wanted;
    }
    check(doubled > SIDE, "only %d texts tell one rounding from two", doubled);
    scene_free(s);
}

#define PLAIN "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0]\n"

/* Each text is a whole file, message what follows its name. */
static const struct {
    const char *text, *message;
} mistakes[] = {
    {"", ": the file ends without WorldEnd"},
    {HEAD, ": the file ends without WorldEnd"},
    {"Camra \"perspective\"", ":1: Camra: this directive is not supported"},
    {"# comment\n\n  Film 5", ":3: Film: a string is expected"},
    {"Film \"movie\"", ":1: Film: \"movie\" is not supported, only \"image\" is"},
    {"Film \"image\"\n\"integer xresolution\" 0", ":2: Film: \"integer xresolution\" must be a whole number"},
    {"Film \"image\"\n\"integer xresolution\" 1.5", ":2: Film: \"integer xresolution\" must be a whole number"},
    {"Film \"image\"\n\n\"float cropwindow\" [0 1 0 1]", ":3: Film: parameter \"float cropwindow\" is not supported"},
    {"Film \"image\" \"xresolution\" 5", ":1: Film: \"xresolution\" is no parameter"},
    {"Film \"image\" \"integer xresolution\" 5 \"integer xresolution\" 6", ":1: Film: \"xresolution\" is given twice"},
    {"Film \"image\" \"string filename\" [\"a\"", ":1: Film: \"filename\": the file ends within its values"},
    {"Film \"image\n", ":1: Film: unterminated string"},
    {"Film \"image", ":1: Film: unterminated string"},
    {"\"", ":1: unterminated string"},
    {"\"\"", ":1: a directive is expected"},
    {"Camera \"perspective\" \"float fov\" 180", ":1: Camera: \"float fov\" must lie between 0 and 180 degrees"},
    {"Camera \"perspective\" \"float fov\" \"a\"", ":1: Camera: \"float fov\" must be one number"},
    {"LookAt 0 0 0 0 0 0 0 1 0", ":1: LookAt: eye and target coincide"},
    {"LookAt 0 0 0 0 0 1", ":1: LookAt: the file ends: number 7 of 9 is expected"},
    {"Translate 1 2 nan", ":1: Translate: not a number: number 3 of 3 is expected"},
    {"Translate 1 2\n3x", ":2: Translate: malformed number: number 3 of 3 is expected"},
    {"Translate 1 2 1e999", ":1: Translate: a number is too large"},
    {"Rotate 10 0 0 0", ":1: Rotate: the axis has no length"},
    {"WorldBegin", ":1: WorldBegin: no Camera has been set"},
    {"CoordSysTransform \"camera\"", ":1: CoordSysTransform: no Camera has been set"},
    {HEAD "CoordSysTransform \"world\"", ":4: CoordSysTransform: only \"camera\" is supported"},
    {HEAD "Camera \"perspective\"", ":4: Camera: it must stand before WorldBegin"},
    {PLAIN, ":1: Shape: it must stand after WorldBegin"},
    {HEAD "WorldEnd\nWorldEnd", ":5: WorldEnd: nothing may follow WorldEnd"},
    {HEAD "AttributeEnd", ":4: AttributeEnd: there is no AttributeBegin for it"},
    {HEAD "AttributeBegin\nWorldEnd", ":5: WorldEnd: an AttributeBegin has no AttributeEnd"},
    {HEAD "Shape \"sphere\"", ":4: Shape: \"sphere\" is not supported, only \"heightfield\" and \"cylinder\" are"},
    {HEAD "Shape \"cylinder\" \"float radius\" 2",
     ":4: Shape \"cylinder\": parameter \"float radius\" is not supported"},
    {HEAD "Scale 1 0 1\nShape \"cylinder\"", ":5: Shape \"cylinder\": the current transform cannot be inverted"},
    {HEAD "Scale 1 0 1\n" PLAIN, ":5: Shape \"heightfield\": map: not finite, or it cannot be inverted"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"float Pz\" [0]",
     ":4: Shape \"heightfield\": \"integer nv\" is missing"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2",
     ":4: Shape \"heightfield\": \"float Pz\" with numbers is missing"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 1 \"integer nv\" 2 \"float Pz\" [0 0]",
     ":4: Shape \"heightfield\": \"integer nu\" must be a whole number from 2 to 8388608"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 1000000000000 \"integer nv\" 2 \"float Pz\" [0 0]",
     ":4: Shape \"heightfield\": \"integer nu\" must be a whole number from 2 to 8388608"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 8000000 \"integer nv\" 8000000\n\"float Pz\" [0 0]",
     ":5: Shape \"heightfield\": \"float Pz\" has 2 values; nu 8000000 times nv 8000000 are 64000000000000"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2\n\"float Pz\" [0 0 0\n0 0]",
     ":5: Shape \"heightfield\": \"float Pz\" has 5 values; nu 2 times nv 2 are 4"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2\n\"float Pz\" [0 0\nnan 0]",
     ":6: Shape \"heightfield\": \"Pz\": value 3 is not a number but nan"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0\n1e39 0]",
     ":5: Shape \"heightfield\": \"Pz\": 1e39 is too large for a float"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0\n1.2.3 0]",
     ":5: Shape \"heightfield\": \"Pz\": malformed number"},
    {HEAD "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0",
     ":4: Shape \"heightfield\": \"Pz\": the file ends within its values"},
    {HEAD "Material \"glass\"", ":4: Material: \"glass\" is not supported, only \"matte\" and \"mirror\" are"},
    {HEAD "Material \"matte\" \"color Kd\" [1 2]", ":4: Material: \"color Kd\" must be three numbers"},
    {HEAD "Material \"matte\" \"float sigma\" 20", ":4: Material: \"sigma\" must be 0"},
    {HEAD "Material \"matte\" \"texture Kd\" \"none\"", ":4: Material: texture \"none\" is not defined"},
    {HEAD "AttributeBegin\nTexture \"t\" \"color\" \"imagemap\" \"string filename\" \"a.exr\"\nAttributeEnd\n"
          "Material \"matte\" \"texture Kd\" \"t\"",
     ":7: Material: texture \"t\" is not defined"},
    {HEAD "Texture \"t\" \"color\" \"checkerboard\"", ":4: Texture: \"color\" \"checkerboard\" is not supported"},
    {HEAD "Texture \"t\" \"color\" \"imagemap\"", ":4: Texture: \"string filename\" is missing"},
    {HEAD "LightSource \"distant\"", ":4: LightSource: \"distant\" is not supported, only \"point\" is"},
    {HEAD "LightSource \"point\" \"point from\" [0 0 0]", ":4: LightSource: parameter \"point from\" is not supported"},
    {HEAD "\n]", ":5: ]: a directive is expected"},
    {HEAD "Include", ":4: Include: a string is expected"},
};

static void load_fails(const char *path, const char *message) {
    io_error error = {""};
    scene *s = scene_load(path, NULL, NULL, &error);
    check(s == NULL, "%s was read; it should fail with %s", path, message);
    check(strncmp(error.text, path, strlen(path)) == 0 &&
              strncmp(error.text + strlen(path), message, strlen(message)) == 0,
          "message: %s\ninstead of …%s", error.text, message);
}

static void mistakes_are_named(void **state) {
    (void)state;
    static float rgb[12];
    assert_true(io_image_write("a.exr", &(io_image){.width = 2, .height = 2, .rgb = rgb}, NULL));
    for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++)
        load_fails(written("mistake.pbrt", mistakes[k].text), mistakes[k].message);
    load_fails("missing.pbrt", ": cannot read: No such file");
    load_fails(".", ": cannot read: ");
}

/* Every beginning of a scene is read without harm, and only the whole is a scene. */
static void cut_files_are_refused(void **state) {
    (void)state;
    static const char text[] =
        HEAD "AttributeBegin # c\nScale 1 1 2\nMaterial \"matte\" \"color Kd\" [1 .5 2]\n" PLAIN
             "Shape \"cylinder\"\nAttributeEnd\nLightSource \"point\" \"color I\" [1 1 1]\nWorldEnd";
    char part[sizeof text];
    for (size_t n = 0; n < sizeof text; n++) {
        memcpy(part, text, n);
        part[n] = '\0';
        io_error error = {""};
        scene *s = scene_load(written("cut.pbrt", part), NULL, NULL, &error);
        check((s != NULL) == (n == sizeof text - 1), "%zu characters: %s", n, s ? "read" : error.text);
        scene_free(s);
    }
}

static void includes_are_followed_and_not_in_circles(void **state) {
    (void)state;
    char message[256];
    written("plain.pbrt", PLAIN);
    const char *good = written("good.pbrt", HEAD "Include \"plain.pbrt\"\nInclude \"plain.pbrt\"\nWorldEnd\n");
    io_error error = {""};
    scene *s = scene_load(good, NULL, NULL, &error);
    check(s != NULL && scene_field_count(s) == 2, "%s", error.text);
    scene_free(s);

    const char *none = written("none.pbrt", HEAD "\nInclude \"nowhere.pbrt\"\n");
    snprintf(message, sizeof message, ":5: Include: %s: cannot read: No such file or directory", "nowhere.pbrt");
    load_fails(none, message);

    const char *self = written("self.pbrt", HEAD "Include \"self.pbrt\"\n");
    snprintf(message, sizeof message, ":4: Include: %s includes itself", self);
    load_fails(self, message);

    /* In a circle of two the mistake is found in the second. */
    const char *first = written("first.pbrt", HEAD "Include \"second.pbrt\"\n");
    const char *second = written("second.pbrt", "\nInclude \"./first.pbrt\"\n");
    s = scene_load(first, NULL, NULL, &error);
    snprintf(message, sizeof message, "%s:2: Include: ", second);
    check(s == NULL && strncmp(error.text, message, strlen(message)) == 0, "message: %s", error.text);

    /* Names are relative to the folder of the first file. */
    check(mkdir("folder", 0777) == 0, "cannot make a folder");
    written("folder/part.pbrt", PLAIN);
    s = scene_load(written("folder/whole.pbrt", HEAD "Include \"part.pbrt\"\nWorldEnd"), NULL, NULL, &error);
    check(s != NULL && scene_field_count(s) == 1, "%s", error.text);
    scene_free(s);

    /* Longer and longer chains, until there are too many levels. */
    char name[32], text[64];
    for (int k = 0; k < 40; k++) {
        snprintf(name, sizeof name, "chain%d.pbrt", k);
        snprintf(text, sizeof text, "Include \"chain%d.pbrt\"\n", k + 1);
        written(name, text);
    }
    s = scene_load("chain0.pbrt", NULL, NULL, &error);
    check(s == NULL && strstr(error.text, ":1: Include: too many levels") != NULL, "message: %s", error.text);

    /* A mistake in an included file is named with that file. */
    const char *wrong = written("wrong.pbrt", "Translate 1\n2\nz");
    s = scene_load(written("includer.pbrt", HEAD "Include \"wrong.pbrt\"\nWorldEnd"), NULL, NULL, &error);
    snprintf(message, sizeof message, "%s:3: Translate: ", wrong);
    check(s == NULL && strncmp(error.text, message, strlen(message)) == 0, "message: %s", error.text);
}

static void unreadable_images_are_named(void **state) {
    (void)state;
    static const char text[] = HEAD "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"%s\"\n"
                                    "Material \"matte\" \"texture Kd\" \"t\"\n%sWorldEnd\n";
    char file[512], message[256];
    written("broken.exr", "v/1");
    snprintf(file, sizeof file, text, "broken.exr", PLAIN);
    snprintf(message, sizeof message, ":4: Texture: %s: not a readable OpenEXR picture", "broken.exr");
    load_fails(written("broken.pbrt", file), message);
    snprintf(file, sizeof file, text, "gone.exr", PLAIN);
    load_fails(written("gone.pbrt", file), ":4: Texture: ");
}

/* What stands first in the file is told. */
static void the_first_error_is_told(void **state) {
    (void)state;
    static const char text[] = HEAD "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"%s\"\n"
                                    "Material \"matte\" \"texture Kd\" \"t\"\n" PLAIN
                                    "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"%s\"\nMaterial "
                                    "\"matte\" \"texture Kd\" \"t\"\n%s" PLAIN "WorldEnd\n";
    static const struct {
        const char *first, *second, *line, *message;
    } cases[] = {{"good.exr", "good.exr", "", NULL},
                 {"good.exr", "good.exr", "Wrong\n", "Wrong: "},
                 {"broken.exr", "good.exr", "Wrong\n", ": Texture: broken.exr: "},
                 {"good.exr", "broken.exr", "Wrong\n", ": Texture: broken.exr: "},
                 {"good.exr", "broken.exr", "", ": Texture: broken.exr: "},
                 {"broken.exr", "gone.exr", "", ": Texture: broken.exr: "},
                 {"gone.exr", "broken.exr", "", ": Texture: gone.exr: "}};
    static float rgb[12];
    io_error error = {""};
    check(io_image_write("good.exr", &(io_image){.width = 2, .height = 2, .rgb = rgb}, &error), "%s", error.text);
    written("broken.exr", "v/1");
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char file[1024];
        snprintf(file, sizeof file, text, cases[k].first, cases[k].second, cases[k].line);
        scene *s = scene_load(written("first.pbrt", file), NULL, NULL, &error);
        check((s != NULL) == (cases[k].message == NULL), "case %zu: %s", k, s ? "read" : error.text);
        check(s != NULL || strstr(error.text, cases[k].message), "case %zu: %s", k, error.text);
        scene_free(s);
    }
}

static void count_warning(void *context, const char *message) {
    check(strstr(message, ":1: Accelerator: ") || strstr(message, ":2: Film: ") || strstr(message, ":3: Sampler: "),
          "message: %s", message);
    ++*(int *)context;
}

static void what_changes_nothing_is_a_warning(void **state) {
    (void)state;
    const char *path =
        written("warn.pbrt", "Accelerator \"grid\" \"bool refine\" \"false\"\n"
                             "Film \"image\" \"bool display\" [\"true\"] \"integer xresolution\" 12\n"
                             "Sampler \"lowdiscrepancy\" \"integer pixelsamples\" [3]\n" HEAD "WorldEnd\n");
    int warnings = 0;
    io_error error = {""};
    scene *s = scene_load(path, count_warning, &warnings, &error);
    check(s != NULL, "%s", error.text);
    check(warnings == 3, "%d warnings", warnings);
    check(scene_width(s) == 12 && scene_height(s) == 480, "%zu x %zu", scene_width(s), scene_height(s));
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_rounded_correctly),
        cmocka_unit_test(samples_are_rounded_once),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(cut_files_are_refused),
        cmocka_unit_test(includes_are_followed_and_not_in_circles),
        cmocka_unit_test(unreadable_images_are_named),
        cmocka_unit_test(the_first_error_is_told),
        cmocka_unit_test(what_changes_nothing_is_a_warning),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
