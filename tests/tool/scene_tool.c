/* SPDX-License-Identifier: Apache-2.0 */
/* The program's render command from outside: exit statuses, messages, and what it leaves behind. */

#include "check.h"
#include "image.h"
#include "program.h"
#include "scratch.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
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

static void pictures_are_the_same_in_all_formats(void **state) {
    (void)state;
    run((const char *const[]){scene_file, "-o", "a.pfm", "--stats", "--json", NULL}, 0, "");
    said("stdout", "camera rays   4800\n");
    said("stdout", "\"width\": 40, \"height\": 30, ");
    io_image image;
    io_error error;
    check(io_image_read("a.pfm", &image, &error), "%s", error.text);
    check(image.width == 40 && image.height == 30 && image.rgb[(15 * 40 + 20) * 3] > 0.1f, "not the picture");
    if (io_image_can_write("a.exr", &error)) {
        run((const char *const[]){scene_file, "-o", "a.exr", "--threads", "1", NULL}, 0, "");
        io_image half;
        check(io_image_read("a.exr", &half, &error), "%s", error.text);
        for (int k = 0; k < 40 * 30 * 3; k++) {
            const float wanted = image.rgb[k], step = wanted > 0.0625f ? 0x1p-11f : 0x1p-15f;
            check(half.rgb[k] >= wanted - step && half.rgb[k] <= wanted + step, "value %d differs", k);
        }
        io_image_free(&half);
    }
    io_image_free(&image);
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    written("broken.pbrt", "WorldBegin");
    written("stdout", "");
    written("stderr", "");
    const size_t before = scratch_entries();
    run((const char *const[]){"missing.pbrt", "-o", "b.pfm", NULL}, 1, "missing.pbrt: cannot read: No such file");
    run((const char *const[]){"broken.pbrt", "-o", "b.pfm", NULL}, 1, "broken.pbrt:1: WorldBegin: no Camera");
    run((const char *const[]){scene_file, NULL}, 2, "-o IMAGE is missing");
    run((const char *const[]){scene_file, "-o", "b.jpeg", NULL}, 2, "unknown kind of picture");
    run((const char *const[]){scene_file, "-o", "none/b.pfm", NULL}, 1, "cannot write: No such file");
    run((const char *const[]){scene_file, "-o", "b.pfm", "--kernel", "nothing", NULL}, 2, "'nothing' is unknown");
    run((const char *const[]){scene_file, "-o", "b.pfm", "--samples", "0", NULL}, 2, "samples");
    check(scratch_entries() == before, "files are left");
}

static void a_full_disk_is_a_failure(void **state) {
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    check(symlink("/dev/full", "full.pfm") == 0, "cannot link");
    run((const char *const[]){scene_file, "-o", "full.pfm", NULL}, 1,
        "full.pfm: cannot write: No space left on device");
}

/* The picture does not fit, which shows while it is being put into its file, not only when that is closed. */
static void a_picture_that_does_not_fit_leaves_nothing(void **state) {
    (void)state;
    written("stdout", "");
    written("stderr", "");
    const char *const pictures[] = {"d.pfm", "d.png", "d.exr"};
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
    const pid_t child = start((const char *const[]){scene_file, "-o", "c.pfm", "--samples", "65536", NULL});
    program_wait_for_output(child);
    kill(child, SIGINT);
    const int status = finish(child);
    check((WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) || (WIFEXITED(status) && WEXITSTATUS(status) == 130),
          "status %#x", (unsigned)status);
    check(scratch_entries() == before, "files are left");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_same_in_all_formats),
        cmocka_unit_test(mistakes_leave_nothing),
        cmocka_unit_test(a_full_disk_is_a_failure),
        cmocka_unit_test(a_picture_that_does_not_fit_leaves_nothing),
        cmocka_unit_test(ctrl_c_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, set_up, scratch_leave);
}
