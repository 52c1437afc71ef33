/* SPDX-License-Identifier: Apache-2.0 */
/* The program's render command from outside: exit statuses, messages, and what it leaves behind. */

#include "check.h"
#include "program.h"
#include "read_picture.h"
#include "scratch.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const char scene_file[] = "scene.pbrt";

/* Writes a text file and returns its name. */
static const char *written(const char *name, const char *text) {
    scratch_write(name, text, strlen(text));
    return name;
}

static int set_up(void **state) {
    if (scratch_enter(state) != 0) return -1;
    written(scene_file, "Film \"image\" \"integer xresolution\" 40 \"integer yresolution\" 30\n"
                        "LookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\"\nWorldBegin\n"
                        "LightSource \"point\" \"color I\" [9 9 9]\nTranslate -1 -1 2\nScale 2 2 1\n"
                        "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 .3 0]\n"
                        "WorldEnd\n");
    return 0;
}

/* Bytes that the program may write to a file; 0 for any number. */
static unsigned long file_limit;

/* Starts `cellwalk render …` with its output in files of the scratch folder. */
static pid_t start(const char *const *arguments) {
    char *argv[16] = {(char *)CELLWALK_PROGRAM, (char *)"render"};
    int argc = 2;
    while (*arguments != NULL) argv[argc++] = (char *)*arguments++;
    const char *out = "stdout", *err = "stderr";
    const pid_t child = fork();
    if (child != 0) return child;
    signal(SIGINT, SIG_DFL); /* a shell may have started the test with it ignored */
    const struct rlimit limit = {file_limit, file_limit};
    if (file_limit > 0 && setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(99);
    if (freopen(out, "w", stdout) && freopen(err, "w", stderr)) execv(CELLWALK_PROGRAM, argv);
    _exit(99);
}

static int finish(pid_t child) {
    int status = 0;
    check(child > 0 && waitpid(child, &status, 0) == child, "the program did not run");
    return status;
}

static void said(const char *file, const char *words) {
    char text[4096];
    FILE *from = fopen(file, "r");
    assert_non_null(from);
    const size_t n = fread(text, 1, sizeof text - 1, from);
    fclose(from);
    text[n] = '\0';
    check(strstr(text, words) != NULL, "%s lacks \"%s\": %s", file, words, text);
}

/* Runs to the end and compares exit status and words on standard error. */
static void run(const char *const *arguments, int expected, const char *words) {
    const int status = finish(start(arguments));
    check(WIFEXITED(status) && WEXITSTATUS(status) == expected, "exit status %d, not %d", WEXITSTATUS(status),
          expected);
    said("stderr", words);
}

static void pictures_and_counts(void **state) {
    (void)state;
    run((const char *const[]){scene_file, "-o", "a.exr", "--stats", "--json", NULL}, 0, "");
    said("stdout", "camera rays   4800\n");
    said("stdout", "\"width\": 40, \"height\": 30, ");
    static const char *const stages[] = {"parsing", "building", "rays", "tracing", "shading", "film", "writing"};
    for (size_t k = 0; k < sizeof stages / sizeof stages[0]; k++) said("stdout", stages[k]);
    io_image image = read_picture("a.exr");
    check(image.width == 40 && image.height == 30 && image.rgb[(15 * 40 + 20) * 3] > 0.1f, "not the picture");
    io_image_free(&image);
    run((const char *const[]){scene_file, "-o", "b.exr", "--threads", "1", NULL}, 0, "");
    size_t size, other;
    char *one = scratch_read("a.exr", &size), *same = scratch_read("b.exr", &other);
    check(size == other && memcmp(one, same, size) == 0, "one thread draws another picture");
    free(one);
    free(same);
}

static void a_crop_of_a_size_is_a_part_of_it(void **state) {
    (void)state;
    run((const char *const[]){scene_file, "-o", "whole.exr", "--size", "80x60", "--seed", "7", NULL}, 0, "");
    run((const char *const[]){scene_file, "-o", "part.exr", "--size=80x60", "--seed=7", "--crop", "30,20,50,41", NULL},
        0, "");
    run((const char *const[]){scene_file, "-o", "other.exr", "--size=80x60", NULL}, 0, "");
    io_image whole = read_picture("whole.exr"), part = read_picture("part.exr"), other = read_picture("other.exr");
    check(whole.width == 80 && whole.height == 60 && part.width == 20 && part.height == 21, "not the sizes asked for");
    for (size_t y = 0; y < 21; y++)
        check(memcmp(part.rgb + y * 60, whole.rgb + ((20 + y) * 80 + 30) * 3, 60 * sizeof(float)) == 0,
              "row %zu differs", y);
    check(memcmp(whole.rgb, other.rgb, 80 * 60 * 3 * sizeof(float)) != 0, "the seed makes no difference");
    io_image_free(&whole);
    io_image_free(&part);
    io_image_free(&other);
}

static void quiet_means_no_warning(void **state) {
    (void)state;
    written("odd.pbrt", "Film \"image\" \"integer xresolution\" 4 \"integer yresolution\" 4\nAccelerator \"grid\"\n"
                        "Camera \"perspective\"\nWorldBegin\nWorldEnd\n");
    run((const char *const[]){"odd.pbrt", "-o", "odd.exr", NULL}, 0, "warning: ");
    run((const char *const[]){"odd.pbrt", "-o", "odd.exr", "--quiet", NULL}, 0, "");
    struct stat stderr_file;
    check(stat("stderr", &stderr_file) == 0 && stderr_file.st_size == 0, "something was said");
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    written("broken.pbrt", "WorldBegin");
    written("stdout", "");
    written("stderr", "");
    const size_t before = scratch_entries();
    run((const char *const[]){"missing.pbrt", "-o", "b.exr", NULL}, 1, "missing.pbrt: cannot read: No such file");
    run((const char *const[]){"broken.pbrt", "-o", "b.exr", NULL}, 1, "broken.pbrt:1: WorldBegin: no Camera");
    run((const char *const[]){scene_file, NULL}, 2, "-o IMAGE is missing");
    run((const char *const[]){scene_file, "-o", "b.jpeg", NULL}, 2, "unknown kind of picture");
    run((const char *const[]){scene_file, "-o", "none/b.exr", NULL}, 1, "cannot write: No such file");
    run((const char *const[]){scene_file, "-o", "b.exr", "--kernel", "nothing", NULL}, 2, "'nothing' is unknown");
    run((const char *const[]){scene_file, "-o", "b.exr", "--samples", "0", NULL}, 2, "samples");
    const char *const sizes[] = {"80", "80x", "x60", "80x0", "0x60", "80x60x", "-80x60", " 80x60", "80x65537"};
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        run((const char *const[]){scene_file, "-o", "b.exr", "--size", sizes[k], NULL}, 2, "not a width and a height");
    const char *const crops[] = {"1,2,3", "1,2,3,4,", "3,2,3,4", "1,4,3,4", "1 2 3 4", "0,0,99999999999999999999,9"};
    for (size_t k = 0; k < sizeof crops / sizeof crops[0]; k++)
        run((const char *const[]){scene_file, "-o", "b.exr", "--crop", crops[k], NULL}, 2, "not X0,Y0,X1,Y1");
    run((const char *const[]){scene_file, "-o", "b.exr", "--crop", "0,0,41,30", NULL}, 1, "no part of 40 x 30 pixels");
    check(scratch_entries() == before, "files are left");
}

static void a_full_disk_is_a_failure(void **state) {
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    check(symlink("/dev/full", "full.exr") == 0, "cannot link");
    run((const char *const[]){scene_file, "-o", "full.exr", NULL}, 1,
        "full.exr: cannot write: No space left on device");
}

/* The picture does not fit, which shows while it is being put into its file, not only when that is closed. */
static void a_picture_that_does_not_fit_leaves_nothing(void **state) {
    (void)state;
    written("stdout", "");
    written("stderr", "");
    const char *const pictures[] = {"d.png", "d.exr"};
    for (size_t k = 0; k < sizeof pictures / sizeof pictures[0]; k++) {
        io_error error;
        if (!io_image_can_write(pictures[k], &error)) continue;
        const size_t before = scratch_entries();
        file_limit = 64; /* less than any of them takes */
        run((const char *const[]){scene_file, "-o", pictures[k], NULL}, 1, pictures[k]);
        file_limit = 0;
        check(scratch_entries() == before, "%s: files are left", pictures[k]);
    }
}

static void ctrl_c_leaves_nothing(void **state) {
    (void)state;
    written("stdout", "");
    written("stderr", "");
    const size_t before = scratch_entries();
    /* Minutes of work, unless it is stopped as soon as its output is open. */
    const pid_t child = start((const char *const[]){scene_file, "-o", "c.exr", "--samples", "65536", NULL});
    program_wait_for_output(child);
    kill(child, SIGINT);
    const int status = finish(child);
    check((WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) || (WIFEXITED(status) && WEXITSTATUS(status) == 130),
          "status %#x", (unsigned)status);
    check(scratch_entries() == before, "files are left");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_and_counts),      cmocka_unit_test(a_crop_of_a_size_is_a_part_of_it),
        cmocka_unit_test(quiet_means_no_warning),   cmocka_unit_test(mistakes_leave_nothing),
        cmocka_unit_test(a_full_disk_is_a_failure), cmocka_unit_test(a_picture_that_does_not_fit_leaves_nothing),
        cmocka_unit_test(ctrl_c_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, scratch_leave);
}
