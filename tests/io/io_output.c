/* SPDX-License-Identifier: Apache-2.0 */
/* Output files appear whole or not at all. */

#include "check.h"
#include "output.h"
#include "scratch.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

static void open_and_write(io_output *out, const char *name, const char *text) {
    io_error error = {""};
    check(io_output_open(out, name, &error), "%s", error.text);
    check(io_output_write(out, text, strlen(text), &error), "%s", error.text);
}

static void check_content(const char *name, const char *text) {
    size_t size;
    char *have = scratch_read(name, &size);
    assert_string_equal(have, text);
    free(have);
}

static void commit_gives_the_name(void **state) {
    (void)state;
    io_output out;
    open_and_write(&out, "a", "new");
    assert_int_equal(access("a", F_OK), -1);
    assert_int_equal(scratch_entries(), 1);
    assert_true(io_output_commit(&out, NULL));
    check_content("a", "new");
    assert_int_equal(scratch_entries(), 1);
    io_output_discard(&out); /* does nothing now */
    check_content("a", "new");
}

static void old_file_stays_until_commit(void **state) {
    (void)state;
    scratch_write("a", "old", 3);
    chmod("a", 0640);
    io_output out;
    open_and_write(&out, "a", "new");
    check_content("a", "old");
    io_output_discard(&out);
    check_content("a", "old");
    assert_int_equal(scratch_entries(), 1);
    open_and_write(&out, "a", "new");
    assert_true(io_output_commit(&out, NULL));
    check_content("a", "new");
    struct stat about;
    assert_int_equal(stat("a", &about), 0);
    assert_int_equal(about.st_mode & 0777, 0640);
}

static void links_are_followed(void **state) {
    (void)state;
    scratch_write("a", "old", 3);
    assert_int_equal(symlink("a", "link"), 0);
    io_output out;
    open_and_write(&out, "link", "new");
    assert_true(io_output_commit(&out, NULL));
    check_content("a", "new");
    struct stat about;
    assert_int_equal(lstat("link", &about), 0);
    assert_true(S_ISLNK(about.st_mode));
}

static void discard_all_removes_open_ones(void **state) {
    (void)state;
    io_output a, b, c;
    open_and_write(&a, "a", "1");
    open_and_write(&b, "b", "2");
    open_and_write(&c, "c", "3");
    assert_int_equal(scratch_entries(), 3);
    assert_true(io_output_commit(&a, NULL));
    io_output_discard_all();
    assert_int_equal(scratch_entries(), 1);
    io_error error = {""};
    assert_false(io_output_commit(&b, &error));
    check(strstr(error.text, "b: cannot write") != NULL, "%s", error.text);
    io_output_discard(&c);
    assert_int_equal(scratch_entries(), 1);
    check_content("a", "1");
    /* Their places are free again. */
    io_output more[IO_OUTPUT_MAX];
    for (int k = 0; k < IO_OUTPUT_MAX; k++) open_and_write(&more[k], "d", "4");
    assert_false(io_output_open(&a, "e", &error));
    for (int k = 0; k < IO_OUTPUT_MAX; k++) io_output_discard(&more[k]);
    assert_int_equal(scratch_entries(), 1);
}

static void bad_targets_are_refused(void **state) {
    (void)state;
    assert_int_equal(mkdir("directory", 0777), 0);
    assert_int_equal(symlink("loop", "loop"), 0);
    static const char *const targets[] = {"", "directory", "directory/", "absent/a", "directory/../absent/a", "loop"};
    for (size_t k = 0; k < sizeof targets / sizeof targets[0]; k++) {
        io_output out;
        io_error error = {""};
        check(!io_output_open(&out, targets[k], &error), "'%s' was opened", targets[k]);
        check(strstr(error.text, targets[k]) != NULL && error.text[0] != '\0', "'%s': %s", targets[k], error.text);
        io_output_discard(&out);
    }
    assert_int_equal(scratch_entries(), 2);
}

static void failures_leave_nothing(void **state) {
    (void)state;
    /* A name that another program takes meanwhile, in a way that renaming cannot undo. */
    io_output out;
    io_error error = {""};
    open_and_write(&out, "a", "text");
    assert_int_equal(mkdir("a", 0777), 0);
    assert_false(io_output_commit(&out, &error));
    check(strstr(error.text, "a: cannot write: Is a directory") != NULL, "%s", error.text);
    assert_int_equal(scratch_entries(), 1);

    /* No room: found out when writing, or as late as when the stream is flushed. */
    static const char block[8192];
    struct rlimit old;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    const struct rlimit little = {1024, old.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
    open_and_write(&out, "b", "text");
    const bool written = io_output_write(&out, block, sizeof block, NULL);
    io_output_discard(&out);
    open_and_write(&out, "c", "text");
    const bool buffered = io_output_write(&out, block, 1024, NULL), committed = io_output_commit(&out, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_true(!written && buffered && !committed);
    assert_string_equal(error.text, "c: cannot write: File too large");
    assert_int_equal(scratch_entries(), 1);
}

static void devices_are_written_to(void **state) {
    (void)state;
    io_output out;
    open_and_write(&out, "/dev/null", "text");
    assert_true(io_output_commit(&out, NULL));
    struct stat about;
    assert_int_equal(stat("/dev/null", &about), 0);
    assert_true(S_ISCHR(about.st_mode));
}

static void full_disk_is_an_error(void **state) {
    (void)state;
    io_output out;
    io_error error = {""};
    open_and_write(&out, "/dev/full", "text"); /* fits into the stream's buffer */
    assert_false(io_output_commit(&out, &error));
    assert_string_equal(error.text, "/dev/full: cannot write: No space left on device");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(commit_gives_the_name, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(old_file_stays_until_commit, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(links_are_followed, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(discard_all_removes_open_ones, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_targets_are_refused, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(failures_leave_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(devices_are_written_to, scratch_enter, scratch_leave),
        cmocka_unit_test(full_disk_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
