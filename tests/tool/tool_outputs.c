/* SPDX-License-Identifier: Apache-2.0 */
/* The files that the program writes, in every format: whose they are, what goes with the file that they replace, and that
 * no two results take one name. */

#include "program.h"
#include "tool_files.h"

#include <errno.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { NX = 20, NY = 16, RAYS = 10, NOBODY = 65534, ARGUMENTS = 10 };

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) z[k] = (float)(k * 7919 % 23);
    cw_ray rays[RAYS];
    for (size_t k = 0; k < RAYS; k++)
        rays[k] = (cw_ray){.org = {2.25f, 1.5f, (float)k + 90}, .dir = {0, 0, -1}, .tmax = 1e9f};
    field_file("field.npy", z, NX, NY);
    rays_file("rays.npy", rays, RAYS);
    text_file("pairs.csv", "x1,y1,x2,y2\n10,10,150,120\n30,20,90,100\n");
    return 0;
}

#define MAP "--cellsize", "10"
static const struct {
    const char *outputs[2]; /* the first is named last */
    const char *arguments[ARGUMENTS];
} formats[] = {
    {{"hits.npy"}, {"trace", "field.npy", "rays.npy", "-o"}},
    {{"light.npy"}, {"shadow", "field.npy", MAP, "--sun", "225,30", "-o"}},
    {{"light.png", "light.pgw"}, {"shadow", "field.npy", MAP, "--sun", "225,30", "-o"}},
    {{"light.tif"}, {"shadow", "field.npy", MAP, "--sun", "225,30", "-o"}},
    {{"light.tiff"}, {"horizon", "field.npy", MAP, "--directions", "4", "--cog", "-o"}},
    {{"answers.csv", "profile.csv"},
     {"los", "field.npy", MAP, "--pairs", "pairs.csv", "--profile", "profile.csv", "-o"}},
    {{"view.png"}, {"render", "field.npy", MAP, "--size", "8x8", "-o"}},
    {{"view.exr"}, {"render", "field.npy", MAP, "--size", "8x8", "-o"}},
};
enum { FORMATS = sizeof formats / sizeof *formats };

static const program_result *run(size_t k, const char *output) {
    const char *arguments[ARGUMENTS + 2] = {NULL};
    size_t count = 0;
    for (; formats[k].arguments[count] != NULL; count++) arguments[count] = formats[k].arguments[count];
    arguments[count] = output;
    return program_run(NULL, arguments);
}

/* Whether this build has the format's library. */
static bool writes(size_t k) {
    const program_result *r = run(k, formats[k].outputs[0]);
    const bool lacks = strstr(r->err, "has no library") != NULL || strstr(r->err, "needs GDAL") != NULL;
    check(r->status == 0 || lacks, "%s: %s", formats[k].outputs[0], r->err);
    if (lacks) print_message("left out: %s", r->err);
    return !lacks;
}

/* Root's result over another's file stays that user's, and never takes a bit that gives rights; with other users, only
 * the mode can be looked at. */
static void rights_stay_and_none_are_added(void **state) {
    (void)state;
    static const mode_t modes[] = {0600, 04777, 06755};
    const uid_t owner = geteuid() == 0 ? NOBODY : geteuid();
    if (geteuid() != 0) print_message("left out: owners, which only root can change\n");
    for (size_t k = 0; k < FORMATS; k++) {
        if (!writes(k)) continue;
        for (size_t m = 0; m < sizeof modes / sizeof *modes; m++) {
            for (size_t n = 0; n < 2 && formats[k].outputs[n] != NULL; n++) {
                text_file(formats[k].outputs[n], "old");
                assert_int_equal(chown(formats[k].outputs[n], owner, getegid()), 0);
                assert_int_equal(chmod(formats[k].outputs[n], modes[m]), 0);
            }
            const program_result *r = run(k, formats[k].outputs[0]);
            check(r->status == 0, "%s", r->err);
            for (size_t n = 0; n < 2 && formats[k].outputs[n] != NULL; n++) {
                struct stat now;
                assert_int_equal(stat(formats[k].outputs[n], &now), 0);
                check(now.st_size > 3, "%s is not written", formats[k].outputs[n]);
                check((now.st_mode & 07777) == (modes[m] & 0777) && now.st_uid == owner, "%s: mode %o of user %u",
                      formats[k].outputs[n], now.st_mode & 07777, now.st_uid);
            }
        }
    }
}

/* Statistics, smaller copies, masks and places of the file before would be read with the new one. */
static const char *const sidecars[][6] = {
    {"light.tif", "light.tif.aux.xml", "light.tif.ovr", "light.tif.msk", "light.tfw", "light.tifw"},
    {"light.png", "light.png.aux.xml", "light.png.ovr", "light.png.msk", "light.pngw", NULL}};

static size_t format_of(const char *output) {
    size_t k = 0;
    while (strcmp(formats[k].outputs[0], output) != 0) k++;
    return k;
}

/* Also if they are links, whose ends stay. */
static void sidecars_go_with_the_old_file(void **state) {
    (void)state;
    for (size_t f = 0; f < sizeof sidecars / sizeof *sidecars; f++) {
        const size_t k = format_of(sidecars[f][0]);
        if (!writes(k)) continue;
        for (int kind = 0; kind < 4; kind++) { /* files, links to a file, to nothing, second names of a file */
            text_file("kept", "old");
            for (size_t n = 1; n < 6 && sidecars[f][n] != NULL; n++) {
                if (kind == 0) text_file(sidecars[f][n], "old");
                if (kind == 1 || kind == 2)
                    assert_int_equal(symlink(kind == 1 ? "kept" : "nothing", sidecars[f][n]), 0);
                if (kind == 3) assert_int_equal(link("kept", sidecars[f][n]), 0);
            }
            const size_t entries = scratch_entries();
            const program_result *r = run(k, sidecars[f][0]);
            check(r->status == 0, "%s", r->err);
            assert_int_equal(scratch_entries(), entries - (f == 0 ? 5 : 4));
            size_t size;
            free(scratch_read("kept", &size));
            assert_int_equal(size, 3);
        }
        if (f == 1) { /* a terrain without a map has no world file; the old one would place the new picture */
            text_file("light.pgw", "old");
            const program_result *r = program_run(
                NULL, (const char *const[]){"shadow", "field.npy", "--sun", "225,30", "-o", sidecars[f][0], NULL});
            check(r->status == 0 && access("light.pgw", F_OK) != 0, "%s", r->err);
        }
        /* Behind a link, they are looked for beside either name. */
        assert_true(mkdir("elsewhere", 0777) == 0 || errno == EEXIST);
        char there[64];
        snprintf(there, sizeof there, "elsewhere/%s", sidecars[f][0]);
        assert_true(rename(sidecars[f][0], there) == 0 && symlink(there, sidecars[f][0]) == 0);
        text_file(sidecars[f][1], "old");
        strcat(there, ".ovr");
        text_file(there, "old");
        const program_result *r = run(k, sidecars[f][0]);
        check(r->status == 0, "%s", r->err);
        check(access(sidecars[f][1], F_OK) != 0 && access(there, F_OK) != 0, "a sidecar beside %s or its end",
              sidecars[f][0]);
    }
}

/* Without an old file, nobody knows whose they are: they are neither removed nor read with the new file. */
static void sidecars_of_no_file_are_refused(void **state) {
    (void)state;
    for (size_t f = 0; f < sizeof sidecars / sizeof *sidecars; f++) {
        const size_t k = format_of(sidecars[f][0]);
        if (!writes(k)) continue;
        assert_int_equal(unlink(sidecars[f][0]), 0);
        for (size_t n = 1; n < 6 && sidecars[f][n] != NULL; n++) {
            text_file(sidecars[f][n], "old");
            const size_t entries = scratch_entries();
            const program_result *r = run(k, sidecars[f][0]);
            check(r->status == EXIT_FAILURE && strstr(r->err, sidecars[f][n]) != NULL &&
                      strstr(r->err, "remove that first") != NULL,
                  "%s: %s", sidecars[f][n], r->err);
            assert_int_equal(scratch_entries(), entries);
            assert_int_equal(unlink(sidecars[f][n]), 0);
        }
    }
    /* One that is the terrain itself. */
    const size_t k = format_of("light.tif");
    if (!writes(k)) return;
    assert_int_equal(rename("light.tif", "sky.tif.ovr"), 0);
    text_file("sky.tif", "old");
    const program_result *r =
        program_run(NULL, (const char *const[]){"shadow", "sky.tif.ovr", "--sun", "225,30", "-o", "sky.tif", NULL});
    check(r->status == EXIT_FAILURE && strstr(r->err, "is also an input") != NULL, "%s", r->err);
    assert_int_equal(access("sky.tif.ovr", F_OK), 0);
}

static void check_los(const char *output, const char *profile, const char *part) {
    const size_t entries = scratch_entries();
    const program_result *r = program_run(NULL, (const char *const[]){"los", "field.npy", MAP, "--pairs", "pairs.csv",
                                                                      "-o", output, "--profile", profile, NULL});
    check(r->status == (part ? EXIT_FAILURE : 0), "%s and %s: exit status %d: %s", output, profile, r->status, r->err);
    check(part == NULL || strstr(r->err, part) != NULL, "%s and %s: %s", output, profile, r->err);
    assert_int_equal(scratch_entries(), entries + (part ? 0 : 2));
}

static void two_results_do_not_take_one_name(void **state) {
    (void)state;
    assert_true(mkdir("folder", 0777) == 0 && symlink("folder", "way") == 0 && symlink("soft.csv", "link.csv") == 0);
    check_los("a.csv", "b.csv", NULL);
    check_los("c.csv", "./c.csv", "is also another output");
    check_los("folder/c.csv", "way/c.csv", "is also another output");
    check_los("link.csv", "soft.csv", "is also another output");
    assert_int_equal(link("a.csv", "hard.csv"), 0);
    check_los("a.csv", "hard.csv", "is also another output");
    /* Standard output. */
    char command[8200];
    snprintf(command, sizeof command,
             "'%s' los field.npy --cellsize 10 --pairs pairs.csv --profile all.csv > all.csv 2> told",
             CELLWALK_PROGRAM);
    assert_int_equal(WEXITSTATUS(system(command)), EXIT_FAILURE);
    size_t size;
    char *told = scratch_read("told", &size);
    check(strstr(told, "all.csv: is also where standard output leads") != NULL, "%s", told);
    free(told);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rights_stay_and_none_are_added, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sidecars_go_with_the_old_file, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sidecars_of_no_file_are_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(two_results_do_not_take_one_name, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
