/* SPDX-License-Identifier: Apache-2.0 */
/* .npy files: what is written is read back, and only a whole, plain array is read. */

#include "check.h"
#include "npy.h"
#include "scratch.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ROWS = 1000, COLUMNS = 3, NPY_MAX = 1 << 16 };

/* A file with this header text and that many bytes of data, which count up. Returns its size. */
static size_t make(const char *name, unsigned version, const char *text, size_t data) {
    static unsigned char bytes[NPY_MAX];
    const size_t length = strlen(text), start = version == 1 ? 10 : 12;
    assert_true(start + length + data <= sizeof bytes);
    memset(bytes, 0, start);
    memcpy(bytes, "\x93NUMPY", 6);
    bytes[6] = (unsigned char)version;
    bytes[8] = (unsigned char)(length & 0xff);
    bytes[9] = (unsigned char)(length >> 8);
    memcpy(bytes + start, text, length);
    for (size_t k = 0; k < data; k++) bytes[start + length + k] = (unsigned char)k;
    scratch_write(name, bytes, start + length + data);
    return start + length + data;
}

static void check_refused(const char *name, const char *part) {
    io_npy npy;
    io_error error = {""};
    check(!io_npy_open(&npy, name, &error), "%s was read as an array", name);
    check(strncmp(error.text, name, strlen(name)) == 0, "%s is not named in '%s'", name, error.text);
    check(strstr(error.text, part) != NULL, "'%s' is not in '%s'", part, error.text);
}

static void written_is_read(void **state) {
    (void)state;
    float values[ROWS];
    for (size_t k = 0; k < ROWS; k++) values[k] = (float)k * 0.25f;
    io_output out;
    io_error error = {""};
    check(io_npy_create(&out, "a.npy", "'<f4'", 4, ROWS, &error), "%s", error.text);
    for (size_t done = 0, n = 1; done < ROWS; done += n, n = n * 2 + 1) {
        if (n > ROWS - done) n = ROWS - done;
        check(io_output_write(&out, values + done, n * sizeof *values, &error), "%s", error.text);
    }
    check(io_output_commit(&out, &error), "%s", error.text);
    assert_int_equal(scratch_entries(), 1);

    io_npy npy;
    check(io_npy_open(&npy, "a.npy", &error), "%s", error.text);
    assert_string_equal(npy.header.type, "<f4");
    assert_int_equal(npy.header.rank, 1);
    assert_int_equal(npy.header.shape[0], ROWS);
    assert_int_equal(npy.offset % 64, 0);
    assert_memory_equal(io_npy_rows(&npy, 0, ROWS, &error), values, sizeof values);
    io_npy_close(&npy);
}

static void too_long_is_not_created(void **state) {
    (void)state;
    io_output out;
    io_error error = {""};
    assert_false(io_npy_create(&out, "a.npy", "'<f4'", 4, UINT64_MAX / 2, &error));
    assert_int_equal(scratch_entries(), 0);
}

/* Every window, at aligned and at odd places of the file. */
static void windows_show_their_rows(void **state) {
    (void)state;
    static const char *const texts[] = {
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1000, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1000, 3), } ",
        "{\"shape\":(1000L,3,),\"fortran_order\":False,\"descr\":\"<f4\"}\n",
    };
    static const struct {
        size_t first, count;
    } windows[] = {{0, ROWS}, {0, 1}, {1, 1}, {ROWS - 1, 1}, {ROWS, 0}, {341, 400}, {342, 399}, {342, 399}, {0, 0}};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        for (unsigned version = 1; version <= 3; version++) {
            const size_t size = make("a.npy", version, texts[k], ROWS * COLUMNS * 4),
                         offset = size - ROWS * COLUMNS * 4;
            io_npy npy;
            io_error error = {""};
            check(io_npy_open(&npy, "a.npy", &error), "%s", error.text);
            assert_int_equal(npy.offset, offset);
            assert_int_equal(npy.row_bytes, COLUMNS * 4);
            for (size_t w = 0; w < sizeof windows / sizeof windows[0]; w++) {
                const unsigned char *rows = io_npy_rows(&npy, windows[w].first, windows[w].count, &error);
                check(rows != NULL, "%s", error.text);
                assert_int_equal((uintptr_t)rows % 4, 0);
                for (size_t b = 0; b < windows[w].count * COLUMNS * 4; b++)
                    assert_int_equal(rows[b], (windows[w].first * COLUMNS * 4 + b) & 0xff);
            }
            io_npy_close(&npy);
        }
    }
}

/* What another program adds meanwhile, or puts in the file's place, is not read. */
static void growth_and_replacement_change_nothing(void **state) {
    (void)state;
    make("a.npy", 1, "{'descr': '|u1', 'fortran_order': False, 'shape': (200,), }", 200);
    io_npy npy;
    io_error error = {""};
    check(io_npy_open(&npy, "a.npy", &error), "%s", error.text);
    FILE *file = fopen("a.npy", "ab");
    assert_non_null(file);
    for (int k = 0; k < 10000; k++) fputc(0xff, file);
    fclose(file);
    for (int replaced = 0; replaced < 2; replaced++) {
        for (unsigned row = 0; row < 200; row += 50) {
            const unsigned char *rows = io_npy_rows(&npy, row, 50, &error);
            check(rows != NULL, "%s", error.text);
            for (unsigned k = 0; k < 50; k++) check(rows[k] == row + k, "row %u is %u", row + k, rows[k]);
        }
        scratch_write("other", "x", 1);
        assert_int_equal(rename("other", "a.npy"), 0);
    }
    io_npy_close(&npy);
    check_refused("a.npy", "not a .npy file");
}

/* Another program cuts the file while it is open. */
static void shrinking_is_an_error(void **state) {
    (void)state;
    make("a.npy", 1, "{'descr': '|u1', 'fortran_order': False, 'shape': (200,), }", 200);
    io_npy npy;
    io_error error = {""};
    check(io_npy_open(&npy, "a.npy", &error), "%s", error.text);
    assert_non_null(io_npy_rows(&npy, 0, 100, &error));
    assert_int_equal(truncate("a.npy", (off_t)npy.offset + 150), 0);
    for (int k = 0; k < 2; k++) {
        assert_null(io_npy_rows(&npy, 100, 100, &error));
        check(strstr(error.text, "a.npy: the file ends at byte") != NULL, "%s", error.text);
    }
    io_npy_close(&npy);
}

static void every_truncation_is_seen(void **state) {
    (void)state;
    for (unsigned version = 1; version <= 3; version++) {
        const size_t size =
            make("whole.npy", version, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }   \n", 24);
        char *bytes = scratch_read("whole.npy", &(size_t){0});
        for (size_t cut = 0; cut < size; cut++) {
            scratch_write("cut.npy", bytes, cut);
            check_refused("cut.npy", cut < 1 ? "not a .npy file" : "truncated");
        }
        scratch_write("long.npy", bytes, size + 1); /* with the NUL byte */
        check_refused("long.npy", "too long");
        free(bytes);
    }
}

static void headers_are_read_strictly(void **state) {
    (void)state;
#define NPY_HEADER(descr, order, shape) "{'descr': " descr ", 'fortran_order': " order ", 'shape': " shape ", }"
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"", "start with {"},
        {"{}", "missing"},
        {"{'descr': '<f4', 'fortran_order': False}", "missing"},
        {"{'descr': '<f4', 'descr': '<f4', 'fortran_order': False, 'shape': (2, 3)}", "second time"},
        {"{'descr': '<f4', 'colour': False, 'shape': (2, 3)}", "key is unknown"},
        {"{'descr': '<f4' 'fortran_order': False, 'shape': (2, 3)}", "comma or }"},
        {"{'descr' '<f4', 'fortran_order': False, 'shape': (2, 3)}", "colon"},
        {"{'descr': '<f4, \"fortran_order\": False, \"shape\": (2, 3)}", "not closed"},
        {"{descr: '<f4', 'fortran_order': False, 'shape': (2, 3)}", "quoted word"},
        {NPY_HEADER("'<f4'", "False", "(2, 3)") "x", "only blanks"},
        {NPY_HEADER("'<f4'", "True", "(2, 3)"), "Fortran order"},
        {NPY_HEADER("'<f4'", "0", "(2, 3)"), "True or False"},
        {NPY_HEADER("'<f4'", "False", "[2, 3]"), "start with ("},
        {NPY_HEADER("'<f4'", "False", "(6)"), "has a comma"},
        {NPY_HEADER("'<f4'", "False", "(2 3)"), "comma or )"},
        {NPY_HEADER("'<f4'", "False", "(-2, -3)"), "size should stand"},
        {NPY_HEADER("'<f4'", "False", "(2.0, 3)"), "comma or )"},
        {NPY_HEADER("'<f4'", "False", "(18446744073709551616,)"), "too large"},
        {NPY_HEADER("'<f4'", "False", "(4294967296, 4294967296)"), "too large"},
        {NPY_HEADER("'<f4'", "False", "(1000000000, 1000000000)"), "truncated"},
        {NPY_HEADER("'<f4'", "False", "(1000000000, 8)"), "truncated"},
        {NPY_HEADER("'<f4'", "False", "(1, 1, 1, 1, 1, 1, 1, 2, 3)"), "many dimensions"},
        {NPY_HEADER("'<f4'", "False", "(2, 2)"), "too long"},
        {NPY_HEADER("'<f4'", "False", "(0, 3)"), "too long"},
        {NPY_HEADER("'|O'", "False", "(2, 3)"), "type '|O'"},
        {NPY_HEADER("'<U4'", "False", "(2, 3)"), "type '<U4'"},
        {NPY_HEADER("'<f3'", "False", "(2, 3)"), "type '<f3'"},
        {NPY_HEADER("''", "False", "(2, 3)"), "type ''"},
        {NPY_HEADER("[('x', '<f4')]", "False", "(2, 3)"), "records"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        make("bad.npy", 1, cases[k].text, 24);
        check_refused("bad.npy", cases[k].part);
    }
    make("version.npy", 4, NPY_HEADER("'<f4'", "False", "(2, 3)"), 24);
    check_refused("version.npy", "version 4.0");
    /* A version 2 header that says it is 10^9 bytes long, in a file of 64. */
    scratch_write("long.npy", "\x93NUMPY\x02\x00\x00\xca\x9a\x3b{                                                   ",
                  64);
    check_refused("long.npy", "1000000000 bytes");
}

/* The same header in a file that really is as long (and takes no room on the disk). */
static void long_headers_are_not_loaded(void **state) {
    (void)state;
    scratch_write("long.npy", "\x93NUMPY\x02\x00\x00\xca\x9a\x3b{", 13);
    FILE *file = fopen("long.npy", "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, 1000000100, SEEK_SET), 0);
    fputc(0, file);
    assert_int_equal(fclose(file), 0);
    check_refused("long.npy", "1000000000 bytes long; no array");
}

static void types_are_told_apart(void **state) {
    (void)state;
    make("big.npy", 1, NPY_HEADER("'>f4'", "False", "(2, 3)"), 24);
    io_npy npy;
    io_error error = {""};
    check(io_npy_open(&npy, "big.npy", &error), "%s", error.text);
    assert_false(io_npy_expect_type(&npy, (const char *const[]){"<f4", "<f8"}, 2, &error));
    assert_string_equal(error.text,
                        "big.npy: holds elements of type '>f4', not '<f4', '<f8'; in NumPy, a.astype('<f4') converts");
    assert_true(io_npy_expect_type(&npy, (const char *const[]){"<f4", ">f4"}, 2, &error));
    io_npy_close(&npy);
}

static void only_files_are_read(void **state) {
    (void)state;
    check_refused("absent.npy", "No such file");
    check_refused(".", "Is a directory");
    check_refused("/dev/null", "not a regular file");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(written_is_read, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(too_long_is_not_created, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(windows_show_their_rows, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(growth_and_replacement_change_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(shrinking_is_an_error, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(every_truncation_is_seen, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(headers_are_read_strictly, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(long_headers_are_not_loaded, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(types_are_told_apart, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(only_files_are_read, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
