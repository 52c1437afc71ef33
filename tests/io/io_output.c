/* SPDX-License-Identifier: Apache-2.0 */
/* Output files appear whole or not at all. */

#include "check.h"
#include "inputs.h"
#include "output.h"
#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* The order of what is done to an output at its end; fsync fails on request. */
static bool synced, named_too_early, sync_fails;

int fsync(int fd) {
    synced = true;
    if (sync_fails) errno = EIO;
    return sync_fails ? -1 : fdatasync(fd);
}

int rename(const char *from, const char *to) {
    named_too_early = named_too_early || !synced;
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}

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
    check(scratch_entries() == 1, "another file than the temporary");
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

/* A link that leads to no file yet is written through, also over another link and from another folder. */
static void dangling_links_are_followed(void **state) {
    (void)state;
    assert_int_equal(mkdir("folder", 0777), 0);
    assert_int_equal(symlink("../file", "folder/second"), 0);
    assert_int_equal(symlink("folder/second", "first"), 0);
    io_output out;
    open_and_write(&out, "first", "new");
    assert_true(io_output_commit(&out, NULL));
    check_content("file", "new");
    struct stat about;
    assert_int_equal(lstat("first", &about), 0);
    assert_true(S_ISLNK(about.st_mode));
}

/* A shell has opened the file, to append to it: it is written to as it is, by whatever name. */
static void names_of_descriptors_are_no_files(void **state) {
    (void)state;
    scratch_write("log", "old ", 4);
    assert_int_equal(symlink("/dev/stdout", "link"), 0);
    const int file = open("log", O_WRONLY | O_APPEND | O_CLOEXEC), saved = dup(STDOUT_FILENO);
    char by_number[32];
    snprintf(by_number, sizeof by_number, "/dev/fd/%d", file);
    fflush(stdout);
    assert_true(file >= 0 && saved >= 0 && dup2(file, STDOUT_FILENO) >= 0);
    const char *const names[] = {"/dev/stdout", "link", "-", by_number, "/proc/self/fd/1"};
    bool good = true;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        io_output out;
        good = good && io_output_open(&out, names[k], NULL) && io_output_write(&out, "new ", 4, NULL) &&
               io_output_commit(&out, NULL);
    }
    dup2(saved, STDOUT_FILENO);
    close(saved);
    close(file);
    assert_true(good);
    check_content("log", "old new new new new new ");
}

static void discard_all_removes_open_ones(void **state) {
    (void)state;
    io_output a, b, c;
    open_and_write(&a, "a", "1");
    open_and_write(&b, "b", "2");
    open_and_write(&c, "c", "3");
    check(scratch_entries() == 3, "not a file for each output");
    assert_true(io_output_commit(&a, NULL));
    io_output_discard_all();
    assert_int_equal(scratch_entries(), 1);
    /* As where a second signal comes before the first one's handler has removed the file. */
    scratch_write(io_output_temporary(&b), "2", 1);
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

/* A file that another program writes meanwhile under a new output's name is replaced, as an old one is. */
static void names_taken_meanwhile_are_replaced(void **state) {
    (void)state;
    io_output out;
    io_error error = {""};
    open_and_write(&out, "a", "mine");
    scratch_write("a", "theirs", 6);
    check(io_output_commit(&out, &error), "%s", error.text);
    check_content("a", "mine");
    assert_int_equal(scratch_entries(), 1);

    /* Two writers of one name: each file is whole, and the last one stays. */
    io_output first, second;
    open_and_write(&first, "a", "first");
    open_and_write(&second, "a", "second");
    assert_true(io_output_commit(&second, NULL));
    assert_true(io_output_commit(&first, NULL));
    check_content("a", "first");
    assert_int_equal(scratch_entries(), 1);
}

/* So that a machine that stops has the old file or the new one, and not an empty one. */
static void bytes_are_on_the_disk_before_the_name(void **state) {
    (void)state;
    for (int old = 0; old < 2; old++) { /* the target is new, or replaces a file */
        io_output out;
        open_and_write(&out, "a", "text");
        synced = named_too_early = false;
        assert_true(io_output_commit(&out, NULL));
        assert_true(synced && !named_too_early);
    }
    io_output out;
    io_error error = {""};
    open_and_write(&out, "a", "other");
    sync_fails = true;
    const bool committed = io_output_commit(&out, &error);
    sync_fails = false;
    assert_false(committed);
    assert_string_equal(error.text, "a: cannot write: Input/output error");
    check_content("a", "text");
    assert_int_equal(scratch_entries(), 1);
}

static void deleted_folders_are_an_error(void **state) {
    (void)state;
    assert_int_equal(mkdir("folder", 0777), 0);
    io_output out;
    io_error error = {""};
    open_and_write(&out, "folder/a", "text");
    assert_int_equal(system("rm -r folder"), 0);
    assert_false(io_output_commit(&out, &error));
    check(strstr(error.text, "folder/a: cannot write: No such file") != NULL, "%s", error.text);
    assert_int_equal(scratch_entries(), 0);
}

/* By whatever name: spelt otherwise, linked softly or hard. Only once a program has asked for it. */
static void inputs_are_not_replaced(void **state) {
    (void)state;
    scratch_write("in", "input", 5);
    scratch_write("later", "input", 5);
    assert_int_equal(symlink("in", "soft"), 0);
    assert_int_equal(link("in", "hard"), 0);
    io_output out;
    io_error error = {""};
    size_t size;
    free(io_file_read("in", &size, NULL));
    open_and_write(&out, "in", "new"); /* not protected yet */
    io_output_discard(&out);
    io_inputs_protect();
    char *text = io_file_read("in", &size, NULL);
    free(text);
    static const char *const names[] = {"in", "./in", "soft", "hard"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        check(!io_output_open(&out, names[k], &error), "%s was opened", names[k]);
        check(strstr(error.text, "is also an input") != NULL && strstr(error.text, names[k]), "%s", error.text);
    }
    /* Standard output leads there. */
    const int file = open("in", O_WRONLY | O_APPEND | O_CLOEXEC), saved = dup(STDOUT_FILENO);
    fflush(stdout);
    assert_true(file >= 0 && saved >= 0 && dup2(file, STDOUT_FILENO) >= 0);
    const bool opened = io_output_open(&out, "-", &error);
    dup2(saved, STDOUT_FILENO);
    close(saved);
    close(file);
    assert_false(opened);
    check(strstr(error.text, "standard output: is also an input") != NULL, "%s", error.text);
    /* Read only after the output was opened. */
    open_and_write(&out, "later", "new");
    free(io_file_read("later", &size, NULL));
    assert_false(io_output_commit(&out, &error));
    check(strstr(error.text, "later: is also an input") != NULL, "%s", error.text);
    check_content("in", "input");
    check_content("later", "input");
    assert_int_equal(scratch_entries(), 4);
}

static void dash_is_standard_output(void **state) {
    (void)state;
    FILE *file = tmpfile();
    const int old = dup(STDOUT_FILENO);
    fflush(stdout);
    assert_true(file && old >= 0 && dup2(fileno(file), STDOUT_FILENO) >= 0);
    io_output out;
    io_error error = {""};
    const bool opened = io_output_open(&out, "-", &error);
    const bool written = opened && io_output_write(&out, "text", 4, &error) && io_output_commit(&out, &error);
    dup2(old, STDOUT_FILENO);
    close(old);
    check(written, "%s", error.text);
    char text[8] = "";
    rewind(file);
    assert_int_equal(fread(text, 1, 7, file), 4);
    assert_string_equal(text, "text");
    fclose(file);
    assert_int_equal(scratch_entries(), 0);
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

/* Of two files that belong together, neither gets its name if the disk has no room for the other. */
static void files_are_settled_together(void **state) {
    (void)state;
    static const char block[1024];
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    scratch_write("a", "old", 3);
    for (int full = 0; full < 2; full++) {
        io_output out, beside;
        io_error error = {""};
        open_and_write(&out, "a", "new");
        open_and_write(&beside, "b", "text");
        check(io_output_write(&beside, block, sizeof block, &error), "%s", error.text); /* into the stream's buffer */
        signal(SIGXFSZ, SIG_IGN);
        const struct rlimit little = {full ? 512 : before.rlim_cur, before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
        const bool good = io_output_settle(&beside, &error) && io_output_commit(&out, &error);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        if (full) {
            assert_false(good);
            assert_string_equal(error.text, "b: cannot write: File too large");
        } else {
            check(good && io_output_commit(&beside, &error), "%s", error.text);
        }
        io_output_discard(&out);
        io_output_discard(&beside);
        check_content("a", "new");
        assert_int_equal(scratch_entries(), 2);
        if (!full) scratch_write("b", "old", 3);
    }
    check_content("b", "old");
}

/* A child that was forked and ends has no say in its parent's files; a process that ends leaves none of its own. */
static void each_process_removes_its_own(void **state) {
    (void)state;
    io_output out;
    open_and_write(&out, "a", "");
    for (int k = 0; k < 3; k++) {
        fflush(out.file);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            io_output own;
            if (k == 0) io_output_discard(&out);
            if (k == 1) io_output_discard_all();
            if (k == 2) open_and_write(&own, "b", "text");
            fclose(stdout);
            exit(EXIT_SUCCESS); /* NOLINT: what is done at exit is what is looked at */
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_int_equal(status, 0);
    }
    check(scratch_entries() == 1, "%zu files", scratch_entries());
    io_error error = {""};
    check(io_output_write(&out, "text", 4, &error) && io_output_commit(&out, &error), "%s", error.text);
    check_content("a", "text");
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

/* Bytes of a name that are no text, or command a terminal. */
static void messages_are_text(void **state) {
    (void)state;
    static const struct {
        const char *given, *shown;
    } names[] = {
        {"caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8f\x94", "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8f\x94"},
        {"a\x1b[2Jb\x7f\n", "a?[2Jb??"},
        {"a\xc2\x9b"
         "b",
         "a??b"},
        {"a\x9b"
         "31m",
         "a?31m"},                                             /* alone */
        {"exe\xe2\x80\xaetxt.npy", "exe???txt.npy"},           /* U+202E */
        {"\xe2\x81\xa6x\xe2\x80\x8f", "???x???"},              /* U+2066, U+200F */
        {"\xe2\x80", "??"},                                    /* cut off */
        {"\xc0\x9b\xe0\x82\x9b\xf0\x80\x82\x9b", "?????????"}, /* C1 spelt too long */
        {"\xed\xa0\x80\xf4\x90\x80\x80\xff", "????????"},
    };
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        io_error error;
        io_fail(&error, "%s", names[k].given);
        assert_string_equal(error.text, names[k].shown);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(commit_gives_the_name, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(old_file_stays_until_commit, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(links_are_followed, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(dangling_links_are_followed, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(names_of_descriptors_are_no_files, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(discard_all_removes_open_ones, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(names_taken_meanwhile_are_replaced, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bytes_are_on_the_disk_before_the_name, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(deleted_folders_are_an_error, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(bad_targets_are_refused, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(failures_leave_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(files_are_settled_together, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(each_process_removes_its_own, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(devices_are_written_to, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(dash_is_standard_output, scratch_enter, scratch_leave),
        cmocka_unit_test(full_disk_is_an_error),
        cmocka_unit_test(messages_are_text),
        /* Last: what it asks for stays. */
        cmocka_unit_test_setup_teardown(inputs_are_not_replaced, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
