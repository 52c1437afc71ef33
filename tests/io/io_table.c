/* SPDX-License-Identifier: Apache-2.0 */
/* Tables in CSV: cells as spreadsheets and programs write them, and the message for each mistake, with its line. */

#include "check.h"
#include "plain.h"
#include "scratch.h"
#include "table.h"

#include <stdlib.h>
#include <string.h>

enum { WIDE = IO_TABLE_COLUMNS_MAX };

static void write_text(const char *text) { scratch_write("t.csv", text, strlen(text)); }

static io_table read_text(const char *text) {
    io_table t;
    io_error error = {""};
    write_text(text);
    check(io_table_read("t.csv", &t, &error), "%s", error.text);
    return t;
}

/* text is a table of columns x and y; the cells of all rows, with their lines, are as in wanted. */
static void check_cells(const char *text, const char *wanted) {
    io_table t = read_text(text);
    char found[200] = "";
    assert_int_equal(t.columns, 2);
    assert_string_equal(t.names[0], "x");
    assert_string_equal(t.names[1], "y");
    for (size_t row = 0, used = 0; row < t.rows; row++)
        used += (size_t)snprintf(found + used, sizeof found - used, "%zu[%s][%s]", t.lines[row], t.cells[2 * row],
                                 t.cells[2 * row + 1]);
    assert_string_equal(found, wanted);
    io_table_free(&t);
}

static void check_refused(const void *text, size_t size, const char *wanted) {
    io_table t;
    io_error error = {""};
    scratch_write("t.csv", text, size);
    check(!io_table_read("t.csv", &t, &error), "a table that should be refused, with: %s", wanted);
    assert_string_equal(error.text, wanted);
}

static void cells_are_read(void **state) {
    (void)state;
    check_cells("x,y\n1,2\n3,4\n", "2[1][2]3[3][4]");
    check_cells("x,y\n1,2", "2[1][2]");
    check_cells("x,y\n1,", "2[1][]");
    check_cells("x,y", "");
    check_cells(" x\t, y \n 1 ,\t2 \n", "2[1][2]");
    check_cells("\xef\xbb\xbfx,y\r\n1,2\r\n", "2[1][2]");
    check_cells("x,y\r1,2\r", "2[1][2]");
    check_cells("\"x\",\"y\"\n\"1,5\",\"a \"\"b\"\"\"\n", "2[1,5][a \"b\"]");
    check_cells("x,y\n \" 1\" ,b\"c\n", "2[ 1][b\"c]");
}

static void lines_without_cells_are_passed_over(void **state) {
    (void)state;
    check_cells("\n  \nx,y\n\n \t\n1,2\n   ", "6[1][2]");
    check_cells("\r\n\r\nx,y\r\n\r\n1,2\r\n\r\n", "5[1][2]");
}

static void lines_are_counted_within_cells(void **state) {
    (void)state;
    check_cells("x,y\n\"a\nb\",1\n2,3\n", "2[a\nb][1]4[2][3]");
    check_cells("x,y\r\n\"a\r\nb\",1\r\n2,3\r\n", "2[a\r\nb][1]4[2][3]");
    check_cells("x,y\r\"a\rb\",1\r2,3\r", "2[a\rb][1]4[2][3]");
}

static void mistakes_are_named(void **state) {
    (void)state;
    static char commas[20000];
    memset(commas, ',', sizeof commas - 1);
    const char *const cases[][2] = {
        {"", "t.csv: is empty; its first line should name the columns"},
        {"\xef\xbb\xbf", "t.csv: is empty; its first line should name the columns"},
        {" \n\n", "t.csv: is empty; its first line should name the columns"},
        {"x;y\n1;2\n", "t.csv:1: cells are separated by semicolons; a comma should stand between them, and a point in "
                       "decimal numbers"},
        {"x\ty\n", "t.csv:1: cells are separated by tabs; a comma should stand between them"},
        {"x,y\n1,2\n1,2,\n", "t.csv:3: the line has 3 cells where the first one names 2 columns"},
        {commas, "t.csv:1: names more than 16384 columns"},
        {"x,y\n1\n", "t.csv:2: the line has 1 cell where the first one names 2 columns"},
        {"x,y\n1,2\n3,\"4\n5,6\n", "t.csv:3: a quotation mark has no end"},
        {"x,y\n\"1\"2,3\n", "t.csv:2: text stands behind a quotation mark that ends a cell"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        check_refused(cases[k][0], strlen(cases[k][0]), cases[k][1]);
    check_refused("x,y\n1,\0002\n", 9, "t.csv: is no text in UTF-8: it has zero bytes, as UTF-16 has");
}

static void numbers_are_decimal(void **state) {
    (void)state;
    static const char *const good[] = {"0", "-1.5", "+2", ".5", "5.", "1e3", "1E-3", "1e-400"};
    static const char *const bad[] = {"nan", "inf", "1e999", "0x10", "1e", "--1", "1.2.3", "1 2", "1_0", "e", "."};
    io_error error;
    double number = 0;
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++) {
        char text[40];
        snprintf(text, sizeof text, "x\n%s\n", good[k]);
        io_table t = read_text(text);
        check(io_table_number(&t, 0, 0, &number, &error), "%s", error.text);
        check(number == plain_double(good[k]), "%s is read as %g", good[k], number);
        io_table_free(&t);
    }
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        char text[40], wanted[80];
        snprintf(text, sizeof text, "x\n%s\n", bad[k]);
        snprintf(wanted, sizeof wanted, "t.csv:2: '%s' stands where a number should, in x", bad[k]);
        io_table t = read_text(text);
        check(!io_table_number(&t, 0, 0, &number, &error), "%s is read as %g", bad[k], number);
        assert_string_equal(error.text, wanted);
        io_table_free(&t);
    }
    io_table t = read_text("x,y\n,1\n");
    check(!io_table_number(&t, 0, 0, &number, &error), "an empty cell is read as %g", number);
    assert_string_equal(error.text, "t.csv:2: x is empty where a number should stand");
    io_table_free(&t);
}

static void keep(void *context, const char *text) { snprintf(context, 200, "%s", text); }

/* A column without a meaning is named, one in capitals has its meaning. */
static void columns_are_found_by_name(void **state) {
    (void)state;
    static const char *const names[] = {"x", "z", "note", "y"};
    io_table t = read_text("X,height,y,Y,note\n1,2,3,4,5\n");
    size_t columns[4];
    char said[200] = "";
    io_error error;
    assert_true(io_table_columns(&t, names, 3, 1, columns, keep, said, &error));
    assert_true(columns[0] == 0 && columns[1] == t.columns && columns[2] == 4);
    assert_string_equal(said, "t.csv: passed over: 'height', 'y', 'Y'; columns with a meaning are x, z and note");
    assert_false(io_table_columns(&t, names, 3, 2, columns, NULL, NULL, &error));
    assert_string_equal(error.text, "t.csv: has no column 'z'; its first line names X, height, y, Y, note");
    assert_false(io_table_columns(&t, names, 4, 1, columns, NULL, NULL, &error));
    assert_string_equal(error.text, "t.csv: two columns have the name 'y'");
    io_table_free(&t);
    t = read_text("X,Z\n1,2\n");
    said[0] = '\0';
    assert_true(io_table_columns(&t, names, 2, 2, columns, keep, said, &error) && said[0] == '\0');
    io_table_free(&t);
}

/* Room is made for the rows that come, not for many: each of them may be as long as the file. */
static void a_wide_row_takes_no_room_for_others(void **state) {
    (void)state;
    char *text = malloc(4 * WIDE + 1);
    assert_non_null(text);
    for (int line = 0, k = 0; line < 2; line++)
        for (int c = 0; c < WIDE; c++, k += 2) memcpy(text + k, c < WIDE - 1 ? "1," : "1\n", 3);
    io_table t = read_text(text);
    assert_int_equal(t.columns, WIDE);
    assert_int_equal(t.rows, 1);
    assert_string_equal(t.cells[WIDE - 1], "1");
    check(t.room <= 2, "there is room for %zu rows of %zu cells", t.room, t.columns);
    io_table_free(&t);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_are_read),
        cmocka_unit_test(lines_without_cells_are_passed_over),
        cmocka_unit_test(lines_are_counted_within_cells),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(numbers_are_decimal),
        cmocka_unit_test(columns_are_found_by_name),
        cmocka_unit_test(a_wide_row_takes_no_room_for_others),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
