/* SPDX-License-Identifier: Apache-2.0 */
/* Whose the new file is that takes an old one's place, and what outputs do not replace at all. */

#include "check.h"
#include "inputs.h"
#include "linux.h"
#include "output.h"
#include "raster_out.h"
#include "scratch.h"

#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

enum { NOBODY = 65534, OTHER = 12345 };

/* Checks that this user or this file system has no means for. */
static unsigned left_out;

static bool can(bool possible, const char *what) {
    if (!possible) print_message("left out: %s\n", what);
    left_out += !possible;
    return possible;
}

/* In place of libc's: what others could do with a file before it gets its rights. */
static mode_t before_rights;

int fchmod(int fd, mode_t mode) {
    struct stat now;
    if (fstat(fd, &now) == 0) before_rights |= now.st_mode & 077;
    return (int)syscall(SYS_fchmod, fd, mode);
}

static void open_and_write(io_output *out, const char *name, const char *text) {
    io_error error = {""};
    check(io_output_open(out, name, &error), "%s", error.text);
    check(io_output_write(out, text, strlen(text), &error), "%s", error.text);
}

static struct stat about(const char *name) {
    struct stat a;
    check(lstat(name, &a) == 0, "%s: %s", name, strerror(errno));
    return a;
}

static void old_file(const char *name, mode_t mode, uid_t owner, gid_t group) {
    unlink(name);
    scratch_write(name, "old", 3);
    check(chown(name, owner, group) == 0, "chown: %s", strerror(errno));
    check(chmod(name, mode) == 0 && (about(name).st_mode & 07777) == mode, "chmod %o: %s", mode, strerror(errno));
}

/* Writes name anew; at no time may anyone do more with the new file than mode lets him. */
static void replace(const char *name, mode_t mode, uid_t owner, gid_t group) {
    io_output out;
    struct stat early;
    before_rights = 0;
    open_and_write(&out, name, "new");
    check((before_rights & ~mode) == 0, "%s: others may open it before it has its rights", name);
    assert_int_equal(fstat(fileno(out.file), &early), 0);
    check((early.st_mode & 07777 & ~mode) == 0, "%s: mode %o before it is complete", name, early.st_mode & 07777);
    assert_true(io_output_commit(&out, NULL));
    const struct stat now = about(name);
    check((now.st_mode & 07777) == mode, "%s: mode %o, not %o", name, now.st_mode & 07777, mode);
    check(now.st_uid == owner && now.st_gid == group, "%s: of %u:%u, not %u:%u", name, now.st_uid, now.st_gid, owner,
          group);
    assert_int_equal(now.st_size, 3);
}

static void modes_are_kept_without_special_bits(void **state) {
    (void)state;
    static const mode_t modes[] = {0600, 0640, 0644, 0666, 0755, 0777, 0200, 01644, 02755, 04755, 06777, 07777};
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        old_file("a", modes[k], geteuid(), getegid());
        replace("a", modes[k] & 0777, geteuid(), getegid());
    }
}

static void new_files_have_the_rights_of_the_umask(void **state) {
    (void)state;
    static const mode_t masks[] = {0, 022, 027, 077};
    for (size_t k = 0; k < sizeof masks / sizeof *masks; k++) {
        const mode_t before = umask(masks[k]);
        unlink("a");
        replace("a", 0666 & ~masks[k], geteuid(), getegid());
        umask(before);
    }
}

/* Root writes over another user's file: it stays his, and gets none of root's rights. */
static void owner_and_group_are_kept(void **state) {
    (void)state;
    if (can(geteuid() == 0, "owners, which only root can change")) {
        old_file("a", 04777, NOBODY, OTHER);
        replace("a", 0777, NOBODY, OTHER);
        old_file("a", 0640, NOBODY, 0);
        replace("a", 0640, NOBODY, 0);
    }
    gid_t groups[64];
    const int count = getgroups(64, groups);
    gid_t other = getegid();
    for (int k = 0; k < count; k++) other = groups[k] != getegid() ? groups[k] : other;
    if (geteuid() == 0) other = OTHER;
    if (can(other != getegid(), "a second group of this user")) {
        old_file("a", 02664, geteuid(), other);
        replace("a", 0664, geteuid(), other);
    }
}

/* Runs a test's part as a user without rights. */
static void as_nobody(bool (*part)(void)) {
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (setgroups(0, NULL) != 0 || setgid(NOBODY) != 0 || setuid(NOBODY) != 0) _exit(77);
        _exit(part() ? 0 : 1);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    check(status == 0, "the part that ran as nobody failed");
}

static bool write_a(void) {
    io_output out;
    umask(022);
    return io_output_open(&out, "shared/a", NULL) && io_output_write(&out, "new", 3, NULL) &&
           io_output_commit(&out, NULL);
}

static bool link_is_refused(void) {
    io_output out;
    io_error error = {""};
    return !io_output_open(&out, "shared/link", &error) && strstr(error.text, "Permission denied") != NULL;
}

/* Who may not give a file its old owner gets a file of the usual rights: those of the old one were for others. */
static void strangers_files_give_no_rights(void **state) {
    (void)state;
    if (!can(geteuid() == 0, "a second user, which only root can be")) skip();
    static const mode_t modes[] = {0666, 04777, 02777};
    assert_int_equal(chmod(".", 0755), 0);
    assert_true(mkdir("shared", 0777) == 0 && chmod("shared", 0777) == 0);
    for (size_t k = 0; k < sizeof modes / sizeof *modes; k++) {
        old_file("shared/a", modes[k], OTHER, OTHER);
        as_nobody(write_a);
        const struct stat now = about("shared/a");
        check((now.st_mode & 07777) == 0644 && now.st_uid == NOBODY && now.st_gid == NOBODY, "mode %o, of %u:%u",
              now.st_mode & 07777, now.st_uid, now.st_gid);
    }
    /* A group that cannot be kept: its bits are not the new group's. */
    old_file("shared/a", 0664, NOBODY, OTHER);
    as_nobody(write_a);
    assert_int_equal(about("shared/a").st_mode & 07777, 0644);
    old_file("shared/a", 0660, NOBODY, OTHER);
    as_nobody(write_a);
    assert_int_equal(about("shared/a").st_mode & 07777, 0600);
}

/* As Linux itself has it: anybody can put a link into a shared folder. */
static void strangers_links_are_not_followed(void **state) {
    (void)state;
    if (!can(geteuid() == 0, "a second user, which only root can be")) skip();
    assert_int_equal(chmod(".", 0755), 0);
    assert_true(mkdir("shared", 0777) == 0 && chmod("shared", 01777) == 0);
    scratch_write("target", "old", 3);
    assert_true(symlink("../target", "shared/link") == 0 && lchown("shared/link", OTHER, OTHER) == 0);
    check(link_is_refused(), "root follows the link");
    as_nobody(link_is_refused);
    io_output out;
    assert_int_equal(chmod("shared", 0777), 0); /* where links are not protected */
    open_and_write(&out, "shared/link", "new");
    io_output_discard(&out);
    assert_true(chmod("shared", 01777) == 0 &&
                lchown("shared/link", 0, 0) == 0); /* the folder's owner's, and one's own */
    open_and_write(&out, "shared/link", "new");
    io_output_discard(&out);
    assert_int_equal(about("target").st_size, 3);
}

static const float grey[4];
static const double identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

static bool sidecar_is_named(void) {
    const io_georef georef = {0};
    const io_raster_product product = {
        .nx = 2, .ny = 2, .bands = 1, .cell = IO_CELL_FLOAT32, .map = identity, .georef = &georef};
    io_raster_writer w;
    io_error error = {""};
    if (!io_raster_create(&w, "shared/a.png", &product, &error) || !io_raster_write(&w, grey, 2, &error)) return false;
    return !io_raster_commit(&w, &error) &&
           strstr(error.text, "shared/a.png.ovr of the file before it cannot be") != NULL;
}

/* The new picture stays, and the user learns what is wrong beside it. */
static void sidecars_that_stay_are_named(void **state) {
    (void)state;
    if (!can(geteuid() == 0, "a second user, which only root can be")) skip();
    if (!can(io_raster_can_write("a.png", 1, NULL), "pictures, without libpng")) skip();
    assert_int_equal(chmod(".", 0755), 0);
    assert_true(mkdir("shared", 0777) == 0 && chmod("shared", 01777) == 0);
    old_file("shared/a.png", 0644, NOBODY, NOBODY);
    old_file("shared/a.png.ovr", 0644, OTHER, OTHER);
    as_nobody(sidecar_is_named);
    assert_true(about("shared/a.png").st_size > 3 && about("shared/a.png.ovr").st_size == 3);
}

/* user::rw-, user:12345:rw-, group::---, mask::rw-, other::---: the mode's bits for the group are the mask. */
static const unsigned char list[] = {2, 0,    0,    0,   1,   0,   6,  0, 255, 255, 255, 255, 2,   0,  6,
                                     0, 0x39, 0x30, 0,   0,   4,   0,  0, 0,   255, 255, 255, 255, 16, 0,
                                     6, 0,    255,  255, 255, 255, 32, 0, 0,   0,   255, 255, 255, 255};
static const char list_name[] = "system.posix_acl_access", default_name[] = "system.posix_acl_default";

static void lists_are_kept(void **state) {
    (void)state;
    unsigned char now[256];
    old_file("a", 0600, geteuid(), getegid());
    if (!can(CELLWALK_LINUX && setxattr("a", list_name, list, sizeof list, 0) == 0, "access control lists")) skip();
    replace("a", 0660, geteuid(), getegid());
    assert_int_equal(getxattr("a", list_name, now, sizeof now), sizeof list);
    assert_memory_equal(now, list, sizeof list);
    /* One that the folder gives new files, and that the old file has not. */
    assert_true(mkdir("folder", 0777) == 0 && setxattr("folder", default_name, list, sizeof list, 0) == 0);
    old_file("folder/a", 0640, geteuid(), getegid());
    removexattr("folder/a", list_name);
    assert_int_equal(chmod("folder/a", 0640), 0);
    replace("folder/a", 0640, geteuid(), getegid());
    assert_int_equal(getxattr("folder/a", list_name, now, sizeof now), -1);
    /* A new file takes it. */
    unlink("folder/a");
    io_output out;
    open_and_write(&out, "folder/a", "new");
    assert_true(io_output_commit(&out, NULL));
    assert_int_equal(getxattr("folder/a", list_name, now, sizeof now), sizeof list);
}

static void other_names_keep_the_old_file(void **state) {
    (void)state;
    scratch_write("a", "old content", 11);
    assert_int_equal(link("a", "b"), 0);
    replace("a", about("b").st_mode & 0777, geteuid(), getegid());
    assert_int_equal(about("b").st_size, 11);
    assert_true(about("a").st_ino != about("b").st_ino);
}

static void check_content(const char *name, const char *text) {
    size_t size;
    char *have = scratch_read(name, &size);
    assert_string_equal(have, text);
    free(have);
}

/* Where outputs are protected: one file by two names, whether it exists or not. */
static void outputs_differ(void **state) {
    (void)state;
    assert_int_equal(mkdir("folder", 0777), 0);
    assert_int_equal(symlink("folder", "way"), 0);
    assert_int_equal(symlink("new", "soft"), 0);
    scratch_write("old", "old", 3);
    assert_int_equal(link("old", "hard"), 0);
    static const char *const pairs[][2] = {{"new", "./new"},          {"new", "soft"},      {"folder/a", "way/a"},
                                           {"new", "folder/../new"},  {"old", "hard"},      {"old", "./old"},
                                           {"folder/a", "folder//a"}, {"soft", "./soft"},   {"hard", "folder/../old"},
                                           {"/dev/fd/%d", "old"},     {"old", "/dev/fd/%d"}};
    const int old = open("old", O_WRONLY | O_APPEND | O_CLOEXEC);
    char by_number[32];
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++)
        for (int turn = 0; turn < 2; turn++) {
            io_output a, b;
            io_error error = {""};
            const char *names[2];
            for (int n = 0; n < 2; n++) {
                const char *name = pairs[k][n ^ turn];
                snprintf(by_number, sizeof by_number, "/dev/fd/%d", old);
                names[n] = strchr(name, '%') != NULL ? by_number : name;
            }
            open_and_write(&a, names[0], "");
            check(!io_output_open(&b, names[1], &error), "%s is open twice, as %s", names[0], names[1]);
            check(strstr(error.text, "is also another output") != NULL && strstr(error.text, names[1]) == error.text,
                  "%s", error.text);
            io_output_discard(&a);
        }
    close(old);
    io_output a, b;
    open_and_write(&a, "folder/new", "");
    open_and_write(&b, "new", ""); /* the same name elsewhere */
    io_output_discard(&a);
    io_output_discard(&b);
    open_and_write(&a, "/dev/null", "");
    open_and_write(&b, "/dev/null", "");
    io_output_discard(&a);
    io_output_discard(&b);
    check_content("old", "old");
    assert_int_equal(scratch_entries(), 5);
}

/* A file to which standard output is redirected. */
static void streams_are_no_outputs(void **state) {
    (void)state;
    static const int streams[] = {STDOUT_FILENO, STDERR_FILENO};
    scratch_write("log", "old ", 4);
    assert_int_equal(symlink("log", "link"), 0);
    for (int k = 0; k < 2; k++) {
        io_output out = {0}, direct = {0};
        io_error error = {""};
        const int file = open("log", O_WRONLY | O_APPEND | O_CLOEXEC), saved = dup(streams[k]);
        fflush(NULL);
        assert_true(file >= 0 && saved >= 0 && dup2(file, streams[k]) >= 0);
        const bool opened = io_output_open(&out, "link", &error), straight = io_output_open(&direct, "-", NULL);
        io_output_discard(&out);
        io_output_discard(&direct);
        dup2(saved, streams[k]);
        close(saved);
        close(file);
        check(!opened && straight, "link was opened: %d, standard output was not: %d", opened, !straight);
        check(strstr(error.text, k == 0 ? "where standard output leads" : "where standard error leads") != NULL, "%s",
              error.text);
    }
    check_content("log", "old ");
}

int main(void) {
    io_inputs_protect();
    const struct CMUnitTest tests[] = {
#define TEST(test) cmocka_unit_test_setup_teardown(test, scratch_enter, scratch_leave)
        TEST(modes_are_kept_without_special_bits),
        TEST(new_files_have_the_rights_of_the_umask),
        TEST(owner_and_group_are_kept),
        TEST(strangers_files_give_no_rights),
        TEST(strangers_links_are_not_followed),
        TEST(sidecars_that_stay_are_named),
        TEST(lists_are_kept),
        TEST(other_names_keep_the_old_file),
        TEST(outputs_differ),
        TEST(streams_are_no_outputs),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    print_message("%u groups of checks left out\n", left_out);
    return failed;
}
