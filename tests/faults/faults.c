/* SPDX-License-Identifier: Apache-2.0 */
/* Each call to the system that each subcommand makes fails once: the n-th allocation, write, rename, opening, reading,
 * mapping or thread, for every n. The program then says what went wrong and ends with a status, soon; or, where it can do
 * without, does all that it was asked. Nothing else changes in the folder, and no memory is lost. */

#include "faults.h"

#include "program.h"
#include "tool_files.h"

#include <dirent.h>
#include <unistd.h>

enum { SECONDS = 10, NX = 6, NY = 5, RAYS = 40 };

static const char scene[] = "Film \"image\" \"integer xresolution\" [8] \"integer yresolution\" [8]\n"
                            "Camera \"perspective\" \"float fov\" [60]\n"
                            "WorldBegin\n"
                            "LightSource \"point\" \"color I\" [9 9 9]\n"
                            "Texture \"t\" \"color\" \"imagemap\" \"string filename\" [\"sand.exr\"]\n"
                            "Material \"matte\" \"texture Kd\" [\"t\"]\n"
                            "Translate -2 -2 4\n"
                            "Scale 4 4 1\n"
                            "Include \"sea.pbrt\"\n"
                            "WorldEnd\n";
static const char sea[] = "Shape \"heightfield\" \"integer nu\" [3] \"integer nv\" [2] \"float Pz\" [0 1 2 3 0 1]\n";

/* A picture of 2 x 2 pixels. */
static void texture_file(const char *name) {
    static const char nothing[] = "Camera \"perspective\"\nWorldBegin\nWorldEnd\n";
    scratch_write("nothing.pbrt", nothing, sizeof nothing - 1);
    const char *const render[] = {"render", "nothing.pbrt", "--size", "2x2", "-o", name, NULL};
    assert_int_equal(program_run(NULL, render)->status, 0);
}

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    float z[NX * NY];
    cw_ray rays[RAYS];
    for (size_t k = 0; k < NX * NY; k++) z[k] = (float)(k * 7 % 5);
    for (size_t k = 0; k < RAYS; k++)
        rays[k] = (cw_ray){.org = {0.1f * (float)k, 1.5f, 9}, .dir = {0, 0, -1}, .tmax = 1e9f};
    field_file("field.npy", z, NX, NY);
    double wide[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) wide[k] = (double)z[k];
    npy_file("wide.npy", "<f8", "(5, 6)", wide, sizeof wide);
    rays_file("rays.npy", rays, RAYS);
    scratch_write("grid.asc", "ncols 3\nnrows 2\ncellsize 1\n1 2 3\n4 5 6\n", 39);
    texture_file("sand.exr");
    scratch_write("scene.pbrt", scene, sizeof scene - 1);
    scratch_write("sea.pbrt", sea, sizeof sea - 1);
    scratch_write("counts", "", 0);
    return 0;
}

static fault_counts read_counts(void) {
    fault_counts c;
    size_t size;
    char *text = scratch_read("counts", &size), *at = text;
    for (int k = 0; k < FAULT_KINDS; k++) c.calls[k] = strtoul(at, &at, 10);
    c.blocks = strtol(at, &at, 10);
    assert_true(*at == '\n');
    free(text);
    return c;
}

/* Runs with one fault, and counts. */
static const program_result *run(program_arguments arguments, const char *fault) {
    const program_setting setting = {
        .preload = PRELOAD, .fault = fault, .fault_counts = "counts", .seconds_limit = SECONDS};
    return program_run(&setting, arguments);
}

/* The result, if one was written, is removed. */
static char *take_output(const char *name, size_t *size) {
    if (access(name, F_OK) != 0) return NULL;
    char *bytes = scratch_read(name, size);
    assert_int_equal(unlink(name), 0);
    if (strcmp(name, "out.png") == 0) unlink("out.pgw"); /* that of a product */
    return bytes;
}

static void check_every_fault(program_arguments arguments, const char *output) {
    const size_t entries = scratch_entries();
    const program_result *r = run(arguments, NULL);
    check(r->status == 0, "%s without a fault: %s", arguments[0], r->err);
    const fault_counts good = read_counts();
    size_t good_size = 0;
    char *good_bytes = take_output(output, &good_size);
    unsigned long injections = 0, survived = 0;
    for (int kind = 0; kind < FAULT_KINDS; kind++)
        for (unsigned long n = 1; n <= good.calls[kind]; n++) {
            char fault[64];
            snprintf(fault, sizeof fault, "%s:%lu", fault_names[kind], n);
            r = run(arguments, fault);
            injections++;
            size_t size = 0;
            char *bytes = take_output(output, &size);
            const bool same = (bytes != NULL) == (good_bytes != NULL) && size == good_size &&
                              (bytes == NULL || memcmp(bytes, good_bytes, size) == 0);
            if (r->status == 0) {
                survived++;
                check(same, "%s, %s: success, but another result", arguments[0], fault);
            } else {
                check(r->status == EXIT_FAILURE, "%s, %s: status %d: %s", arguments[0], fault, r->status, r->err);
                check(strncmp(r->err, "cellwalk", 8) == 0 && strlen(r->err) > 20, "%s, %s: '%s'", arguments[0], fault,
                      r->err);
                /* What is printed comes last, when the file is whole, and so does a picture's world file. */
                const bool last = strstr(r->err, "standard output") != NULL || strstr(r->err, ".pgw: ") != NULL;
                check(bytes == NULL || (same && last), "%s, %s: failed, but wrote %s: %s", arguments[0], fault, output,
                      r->err);
            }
            check(scratch_entries() == entries, "%s, %s: %zu files instead of %zu", arguments[0], fault,
                  scratch_entries(), entries);
            check(read_counts().blocks <= good.blocks, "%s, %s: %ld blocks lost, %ld without a fault", arguments[0],
                  fault, read_counts().blocks, good.blocks);
            free(bytes);
        }
    print_message("%s %s: %lu faults, %lu without consequence\n", arguments[0], arguments[1], injections, survived);
    free(good_bytes);
}

static void trace(void **state) {
    (void)state;
    check_every_fault((const char *const[]){"trace", "field.npy", "rays.npy", "-o", "hits.npy", "--threads", "3", NULL},
                      "hits.npy");
    check_every_fault((const char *const[]){"trace", "wide.npy", "rays.npy", "-o", "hits.npy", "--occluded", "--kernel",
                                            "pyramid1", "--json", NULL},
                      "hits.npy");
    check_every_fault((const char *const[]){"trace", "grid.asc", "rays.npy", "-o", "hits.npy", NULL}, "hits.npy");
}

static void info(void **state) {
    (void)state;
    check_every_fault((const char *const[]){"info", NULL}, "none");
    check_every_fault((const char *const[]){"info", "grid.asc", "--kernel", "grid3d", NULL}, "none");
    check_every_fault((const char *const[]){"info", "sea.pbrt", "--json", NULL}, "none");
}

/* A picture and its world file come together, or neither comes. */
static void shadow_png(void **state) {
    (void)state;
    const char *const shadow[] = {"shadow", "grid.asc", "--sun", "90,10", "--threads", "1", "-o", "out.png", NULL};
    if (program_run(NULL, shadow)->status != 0) skip();
    assert_int_equal(unlink("out.png"), 0);
    assert_int_equal(unlink("out.pgw"), 0);
    check_every_fault(shadow, "out.png");
}

static void render_scenery(void **state) {
    (void)state;
    check_every_fault((const char *const[]){"render", "grid.asc", "--size", "8x8", "--sky", "--haze", "9", "--water",
                                            "4", "--threads", "1", "-o", "out.exr", NULL},
                      "out.exr");
}

static void render(void **state) {
    (void)state;
    check_every_fault((const char *const[]){"render", "scene.pbrt", "-o", "out.exr", "--threads", "3", NULL},
                      "out.exr");
}

static void render_one_thread(void **state) {
    (void)state;
    check_every_fault((const char *const[]){"render", "scene.pbrt", "-o", "out.exr", "--threads", "1", NULL},
                      "out.exr");
}

static void render_png(void **state) {
    (void)state;
    if (program_run(NULL, (const char *const[]){"render", "scene.pbrt", "-o", "out.png", NULL})->status != 0) skip();
    assert_int_equal(unlink("out.png"), 0);
    check_every_fault((const char *const[]){"render", "scene.pbrt", "-o", "out.png", NULL}, "out.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(trace, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(info, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(shadow_png, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(render_scenery, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(render, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(render_one_thread, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(render_png, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
