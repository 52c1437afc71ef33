/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds on floods in SECURITY.md: each number is that of the code, and each measured one is kept, but not by far. */

#include "check.h"
#include "image.h"
#include "pbrt_state.h"
#include "scene.h"
#include "scratch.h"
#include "table.h"

#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define HEAD                                                                                                           \
    "LookAt 0 0 -5 0 0 0 0 1 0\nCamera \"perspective\"\nFilm \"image\" \"integer xresolution\" 16 \"integer "          \
    "yresolution\" 16\n"                                                                                               \
    "WorldBegin\n"
#define LIGHT "LightSource \"point\" \"color I\" [8 8 8]\n"

static void repeat(FILE *file, size_t times, const char *text) {
    for (size_t k = 0; k < times; k++) fputs(text, file);
}

static void make_fields(FILE *file) {
    repeat(file, 1, LIGHT);
    repeat(file, 10000, "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0]\n");
}

static void make_lights(FILE *file) {
    repeat(file, 1000, LIGHT);
    repeat(file, 1000, "Shape \"cylinder\"\n");
}

static const struct bound {
    const char *name;
    uint64_t value;            /* in the code */
    void (*make)(FILE *scene); /* or a scene to render */
} bounds[] = {
    {"PBRT_FILES_MAX", PBRT_FILES_MAX, NULL},
    {"PBRT_INCLUDE_MAX", PBRT_INCLUDE_MAX, NULL},
    {"pbrt_bytes_max", pbrt_bytes_max, NULL},
    {"PBRT_WARNINGS_MAX", PBRT_WARNINGS_MAX, NULL},
    {"IO_IMAGE_PIXELS_MAX", IO_IMAGE_PIXELS_MAX, NULL},
    {"IO_EXR_PIXELS_PER_BYTE_MAX", IO_EXR_PIXELS_PER_BYTE_MAX, NULL},
    {"IO_TABLE_COLUMNS_MAX", IO_TABLE_COLUMNS_MAX, NULL},
    {"render_fields", 0, make_fields},
    {"render_lights", 0, make_lights},
};
enum { BOUNDS_COUNT = sizeof bounds / sizeof bounds[0] };

static int render(void) {
    io_error error = {""};
    io_image image;
    scene *s = scene_load("flood.pbrt", NULL, NULL, &error);
    if (s == NULL || !scene_render(s, &(scene_render_options){.threads = 1}, &image, NULL, &error)) return 1;
    scene_free(s);
    return 0;
}

/* MB that a process takes at most which renders it. */
static uint64_t measure(const struct bound *b) {
    FILE *file = fopen("flood.pbrt", "w");
    assert_non_null(file);
    fputs(HEAD, file);
    b->make(file);
    fputs("WorldEnd\n", file);
    fclose(file);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) _exit(render());
    int status;
    struct rusage usage;
    assert_int_equal(wait4(child, &status, 0, &usage), child);
    check(WIFEXITED(status) && WEXITSTATUS(status) == 0, "%s ended with %#x", b->name, (unsigned)status);
    return (uint64_t)usage.ru_maxrss / 1000;
}

static void the_table_is_true(void **state) {
    (void)state;
    char line[400];
    bool found[BOUNDS_COUNT] = {false}, inside = false;
    FILE *file = fopen(BOUNDS, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        if (line[0] == '#') inside = strcmp(line, "## Floods\n") == 0;
        unsigned long long value;
        char name[64];
        if (!inside || sscanf(line, "|%*[^|]| %llu | `%63[^`]` |", &value, name) != 2) continue;
        size_t k = 0;
        while (k < BOUNDS_COUNT && strcmp(bounds[k].name, name) != 0) k++;
        check(k < BOUNDS_COUNT, "%s stands in the table and is none", name);
        found[k] = true;
        if (bounds[k].make) {
            const uint64_t taken = measure(&bounds[k]);
#ifdef TEST_IN_EMULATOR
            continue; /* it counts the emulator's too */
#endif
            check(taken <= value && taken > value / 4, "%s takes %llu MB, and %llu are said", name,
                  (unsigned long long)taken, value);
        } else {
            check(bounds[k].value == value, "%s is %llu, not %llu", name, (unsigned long long)bounds[k].value, value);
        }
    }
    fclose(file);
    for (size_t k = 0; k < BOUNDS_COUNT; k++) check(found[k], "%s is not in the table", bounds[k].name);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_table_is_true, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
