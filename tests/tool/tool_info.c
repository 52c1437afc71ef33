/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk info` says what the library says. */

#include "program.h"
#include "tool_files.h"

#include <math.h>
#include <stdio.h>

static const program_result *run_well(const program_setting *setting, program_arguments arguments) {
    const program_result *r = program_run(setting, arguments);
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    check(r->err[0] == '\0', "standard error: %s", r->err);
    return r;
}

__attribute__((format(printf, 2, 3))) static void check_has(const program_result *r, const char *format, ...) {
    char part[256];
    va_list list;
    va_start(list, format);
    vsnprintf(part, sizeof part, format, list);
    va_end(list);
    check(strstr(r->out, part) != NULL, "'%s' is not in:\n%s", part, r->out);
}

static void kernels_are_listed(void **state) {
    (void)state;
    const program_result *r = run_well(NULL, (const char *const[]){"info", "--json", NULL});
    const cw_kernel *chosen = cw_run_kernel(NULL, NULL);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        check_has(
            r,
            "{\"name\": \"%s\", \"width\": %u, \"isa\": \"%s\", \"leaf\": \"%s\", \"available\": %s, \"chosen\": %s,",
            info.name, info.width, cw_isa_name(info.isa), cw_leaf_name(info.default_leaf),
            info.available ? "true" : "false", cw_kernel_at(k) == chosen ? "true" : "false");
    }
    check_has(r, "\"isa\": \"%s\"", cw_isa_name(cw_isa_best()));
    check_has(run_well(NULL, (const char *const[]){"info", NULL}), "* %s ", cw_kernel_describe(chosen).name);
}

static void limits_are_kept(void **state) {
    (void)state;
    const program_setting scalar = {.isa = "scalar"};
    check_has(run_well(&scalar, (const char *const[]){"info", "--json", NULL}), "\"isa\": \"scalar\"");
    for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
        if (!cw_isa_includes(cw_isa_best(), (cw_isa)isa)) continue;
        const program_setting bound = {.isa = cw_isa_name((cw_isa)isa)};
        const program_result *r = run_well(&bound, (const char *const[]){"info", NULL});
        check_has(r, "instruction set %s (CELLWALK_ISA=%s)\n", bound.isa, bound.isa);
        cw_isa_limit((cw_isa)isa);
        check_has(r, "* %s ", cw_kernel_describe(cw_run_kernel(NULL, NULL)).name);
        cw_isa_limit(CW_ISA_ANY);
    }
    check_has(run_well(NULL, (const char *const[]){"info", "--isa=scalar", NULL}), "instruction set scalar");
    check_has(run_well(NULL, (const char *const[]){"info", "--kernel", "cell", NULL}), "* cell ");
}

static void fields_are_described(void **state) {
    (void)state;
    static const float z[12] = {3, 1, 2, NAN, -5.5f, 0, 7.25f, 8, 1, 1, INFINITY, 2};
    field_file("quo\"te.npy", z, 4, 3);
    const program_result *r =
        run_well(NULL, (const char *const[]){"info", "quo\"te.npy", "--json", "--kernel", "cell", NULL});
    check_has(r, "\"path\": \"quo\\\"te.npy\", \"nx\": 4, \"ny\": 3, \"low\": -5.5, \"high\": 8, \"holes\": 2, "
                 "\"bytes_samples\": 48, \"mapped\": false, \"bytes_built\": ");
    r = run_well(NULL, (const char *const[]){"info", "quo\"te.npy", NULL});
    check_has(r, "4 x 3 (3 x 2 cells)");
    check_has(r, "-5.5 to 8");

    static const float holes[4] = {NAN, NAN, NAN, NAN};
    field_file("holes.npy", holes, 2, 2);
    r = run_well(NULL, (const char *const[]){"info", "holes.npy", "--json", "--kernel", "grid3d", NULL});
    check_has(r, "\"low\": null, \"high\": null, \"holes\": 4, \"bytes_samples\": 16, \"mapped\": true");

    static const char pbrt[] = "Shape \"heightfield\" \"integer nu\" [2] \"integer nv\" [2] \"float Pz\" [0 1 2 3]\n";
    scratch_write("a.pbrt", pbrt, sizeof pbrt - 1);
    r = run_well(NULL, (const char *const[]){"info", "a.pbrt", "--json", "--kernel", "cell", NULL});
    check_has(r, "\"bytes_samples\": 16, \"mapped\": false, \"bytes_built\": ");

    static const char asc[] = "ncols 2\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\n1 2 3 4\n";
    scratch_write("a.asc", asc, sizeof asc - 1);
    r = run_well(NULL, (const char *const[]){"info", "a.asc", "--json", NULL});
    check_has(r, "\"map\": [[2, 0, 0, 11], [0, -2, 0, 23], [0, 0, 1, 0]]");
    check_has(r, "\"extent\": [11, 21, 13, 23], \"cell_size\": [2, 2], \"degrees\": false, ");
}

/* What people ask of a terrain comes first, and kernels only where no file is asked about. */
static void places_come_first(void **state) {
    (void)state;
    static const char asc[] =
        "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 20\ncellsize 2\nNODATA_value -9\n1 2 3 4 -9 6\n",
                      prj[] = "PROJCS[\"Somewhere\",GEOGCS[\"g\",DATUM[\"d\",SPHEROID[\"s\",6378137,298.257223563]],"
                              "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
                              "PROJECTION[\"Transverse_Mercator\"],UNIT[\"foot\",0.3048]]";
    scratch_write("a.asc", asc, sizeof asc - 1);
    scratch_write("a.prj", prj, sizeof prj - 1);
    const program_result *r = program_run(NULL, (const char *const[]){"info", "a.asc", NULL});
    check(strstr(r->err, "a.asc: heights taken as ft, as x and y; --zscale 3.2808") != NULL, "%s", r->err);
    static const char first[] = "a.asc\n"
                                "  extent        X 101 to 105, Y 21 to 23 (pixels' centres)\n"
                                "  cell size     2 x 2 ft\n"
                                "  coordinates   Somewhere\n"
                                "  heights       1 to 6 ft\n"
                                "  holes         1 (no data: -9)\n"
                                "  samples       3 x 2 (2 x 1 cells)\n";
    check(strncmp(r->out, first, sizeof first - 1) == 0, "%s", r->out);
    check(strstr(r->out, "leaf test") == NULL && strstr(r->out, "instruction set") == NULL, "%s", r->out);
    r = run_well(NULL, (const char *const[]){"info", "a.asc", "--zscale", "2", NULL});
    check_has(r, "  heights       1 to 6 x 0.6096 m\n");
    static const float z[4] = {1, 2, 3, 4};
    field_file("z.npy", z, 2, 2);
    r = run_well(NULL, (const char *const[]){"info", "z.npy", NULL});
    check_has(r, "z.npy\n  extent        no map: ");
    check_has(r, "  heights       1 to 4\n");
}

/* Each optional library is named once, as there or as not there: what is there can be written. */
static void libraries_are_told(void **state) {
    (void)state;
    static const struct {
        const char *name, *output, *missing;
    } libraries[] = {{"GDAL", "o.tif", "GDAL"}, {"libpng", "o.png", "no library"}};
    static const float z[4] = {1, 2, 3, 4};
    field_file("z.npy", z, 2, 2);
    for (size_t k = 0; k < sizeof libraries / sizeof libraries[0]; k++) {
        const program_result *r = program_run(NULL, (const char *const[]){"shadow", "z.npy", "--cellsize", "1", "--sun",
                                                                          "0,9", "-o", libraries[k].output, NULL});
        const bool there = r->status == 0;
        check(there || strstr(r->err, libraries[k].missing) != NULL, "%s", r->err);
        r = run_well(NULL, (const char *const[]){"info", "--json", NULL});
        check_has(r, "\"%s\": %s", libraries[k].name, there ? "true" : "false");
        r = run_well(NULL, (const char *const[]){"info", NULL});
        const char *name = strstr(r->out, libraries[k].name), *missing = strstr(r->out, "not there ");
        check(name && (there ? missing == NULL || name < missing : missing && name > missing), "%s", r->out);
        check_has(run_well(NULL, (const char *const[]){"--version", NULL}), "%-8s %s", libraries[k].name,
                  there ? "yes" : "no");
    }
    /* Without its module GDAL is not there. */
    setenv("CELLWALK_MODULES", "/nowhere", 1);
    check_has(run_well(NULL, (const char *const[]){"info", "--json", NULL}), "\"GDAL\": false");
    check_has(run_well(NULL, (const char *const[]){"--version", NULL}), "GDAL     no: ");
    unsetenv("CELLWALK_MODULES");
}

static void help_is_printed(void **state) {
    (void)state;
    check_has(run_well(NULL, (const char *const[]){"--help", NULL}), "  trace ");
    check_has(run_well(NULL, (const char *const[]){"--version", NULL}), "cellwalk %s\n", CW_VERSION);
    check_has(run_well(NULL, (const char *const[]){"trace", "--help", NULL}), "-o, --output HITS.npy");
    check_has(run_well(NULL, (const char *const[]){"info", "x", "-h", NULL}), "Usage: cellwalk info");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(kernels_are_listed, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(limits_are_kept, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(fields_are_described, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(places_come_first, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(libraries_are_told, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(help_is_printed, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
