/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk trace` gives what cw_closest and cw_occluded give, bit for bit, in a file that NumPy can read. */

#include "fields.h"
#include "program.h"
#include "rays.h"
#include "tool_files.h"

#include <math.h>

enum { RAYS = 20000, RECORD = 24 };

typedef struct fixture {
    test_field field;
    cw_field *open;
    cw_ray rays[RAYS];
    cw_hit hits[RAYS];
    uint8_t occluded[RAYS];
} fixture;

static fixture *make(void) {
    fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    field_make(&f->field, FIELD_HOLES, 49, 33, 1);
    f->open = field_open(&f->field);
    random_state r = {2};
    for (size_t k = 0; k < RAYS; k++) f->rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &f->field, &r);
    field_file("field.npy", f->field.z, f->field.nx, f->field.ny);
    rays_file("rays.npy", f->rays, RAYS);
    return f;
}

static void destroy(fixture *f) {
    cw_field_destroy(f->open);
    free(f);
}

static void run_well(program_arguments arguments) {
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    check(r->err[0] == '\0', "standard error: %s", r->err);
}

/* The elements, after a look at the header. The caller frees *file. */
static const unsigned char *read_array(const char *name, const char *type, size_t n, size_t item, char **file) {
    size_t size;
    *file = scratch_read(name, &size);
    assert_memory_equal(*file, "\x93NUMPY\x01\x00", 8);
    const unsigned char *bytes = (const unsigned char *)*file;
    const size_t start = 10 + (size_t)bytes[8] + 256 * (size_t)bytes[9];
    assert_int_equal(start % 64, 0);
    assert_int_equal(bytes[start - 1], '\n');
    char header[512];
    const int length =
        snprintf(header, sizeof header, "{'descr': %s, 'fortran_order': False, 'shape': (%zu,), }", type, n);
    assert_memory_equal(*file + 10, header, (size_t)length);
    assert_int_equal(size, start + n * item);
    return bytes + start;
}

static const unsigned char *read_hits(const char *name, size_t n, char **file) {
    return read_array(name,
                      "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4')]", n,
                      RECORD, file);
}

static void check_hits(const char *name, const cw_hit *wanted, size_t n) {
    char *file;
    const unsigned char *record = read_hits(name, n, &file);
    for (size_t k = 0; k < n; k++, record += RECORD) {
        const cw_hit *w = &wanted[k];
        const bool same = memcmp(record, w, RECORD) == 0;
        check(same, "%s: record %zu is not what the library finds", name, k);
    }
    free(file);
}

static void closest_is_the_librarys(void **state) {
    (void)state;
    fixture *f = make();
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        cw_run query = (cw_run){0};
        query.kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(query.kernel);
        if (!info.available) continue;
        check_status(cw_closest(f->open, &query, f->rays, RAYS, f->hits), CW_OK);
        run_well((const char *const[]){"trace", "field.npy", "rays.npy", "-o", "hits.npy", "--kernel", info.name,
                                       "--leaf", cw_leaf_name(info.default_leaf), "--threads", "1", NULL});
        check_hits("hits.npy", f->hits, RAYS);
    }
    /* The default kernel, in threads, by other spellings of the options. */
    check_status(cw_closest(f->open, NULL, f->rays, RAYS, f->hits), CW_OK);
    size_t found = 0;
    for (size_t k = 0; k < RAYS; k++) found += f->hits[k].i >= 0;
    assert_in_range(found, RAYS / 10, RAYS * 9 / 10);
    run_well((const char *const[]){"trace", "--threads=3", "-ohits.npy", "--", "field.npy", "rays.npy", NULL});
    check_hits("hits.npy", f->hits, RAYS);
    assert_int_equal(scratch_entries(), 3);
    destroy(f);
}

static void any_marks_the_occluded(void **state) {
    (void)state;
    fixture *f = make();
    check_status(cw_occluded(f->open, NULL, f->rays, RAYS, f->occluded), CW_OK);
    run_well((const char *const[]){"trace", "--occluded", "field.npy", "rays.npy", "--output=hits.npy", NULL});
    char *file;
    const unsigned char *bytes = read_array("hits.npy", "'|u1'", RAYS, 1, &file);
    assert_memory_equal(bytes, f->occluded, RAYS);
    free(file);
    destroy(f);
}

/* Rays in the coordinates of a map that is far from the origin, against the library's own way there; with places and
 * normals. */
static void rays_of_the_map(void **state) {
    (void)state;
    enum { N = 500, BIG = RECORD + 24 + 12 };
    static const char asc[] = "ncols 3 nrows 3 xllcorner 600000 yllcorner 5200000 cellsize 10\n0 1 2 7 5 3 9 9 1";
    static const float z[9] = {0, 1, 2, 7, 5, 3, 9, 9, 1};
    static const double map[3][4] = {{10, 0, 0, 600005}, {0, -10, 0, 5200025}, {0, 0, 1, 0}};
    static cw_user_ray user[N];
    static cw_ray rays[N];
    static cw_hit hits[N];
    static uint8_t occluded[N];
    random_state r = {4};
    for (size_t k = 0; k < N; k++)
        user[k] = (cw_user_ray){.org = {random_between(&r, 600000, 600030), random_between(&r, 5200000, 5200030), 20},
                                .dir = {random_between(&r, -1, 1), 0.25, -1},
                                .tmax = INFINITY};
    scratch_write("a.asc", asc, sizeof asc - 1);
    npy_file("user.npy", "<f8", "(500, 8)", user, sizeof user);
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = 3;
    memcpy(desc.map, map, sizeof map);
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    cw_rays_to_field(field, user, N, rays);
    check_status(cw_closest(field, NULL, rays, N, hits), CW_OK);
    check_status(cw_occluded(field, NULL, rays, N, occluded), CW_OK);
    run_well((const char *const[]){"trace", "a.asc", "user.npy", "--user", "-o", "hits.npy", NULL});
    check_hits("hits.npy", hits, N);
    run_well((const char *const[]){"trace", "a.asc", "user.npy", "--user", "--points", "--normals", "-o", "hits.npy",
                                   "--stats", NULL});
    char *file;
    const unsigned char *record =
        read_array("hits.npy",
                   "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4'), "
                   "('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('nx', '<f4'), ('ny', '<f4'), ('nz', '<f4')]",
                   N, BIG, &file);
    size_t found = 0;
    for (size_t k = 0; k < N; k++, record += BIG) {
        double point[3] = {NAN, NAN, NAN}, got[3], normal[3] = {NAN, NAN, NAN};
        float got_normal[3];
        if (hits[k].i >= 0)
            cw_hit_points(field, NULL, &hits[k], 1, point), cw_hit_normals(field, NULL, &hits[k], 1, normal), found++;
        memcpy(got, record + RECORD, sizeof got);
        memcpy(got_normal, record + RECORD + sizeof got, sizeof got_normal);
        for (int a = 0; a < 3; a++) {
            check(got[a] == point[a] || (isnan(got[a]) && isnan(point[a])), "ray %zu: %g, not %g", k, got[a], point[a]);
            check(got_normal[a] == (float)normal[a] || (isnan(got_normal[a]) && isnan(normal[a])), "ray %zu", k);
        }
    }
    free(file);
    assert_in_range(found, N / 4, N - 20);
    run_well((const char *const[]){"trace", "a.asc", "user.npy", "--user", "--occluded", "-o", "hits.npy", NULL});
    record = read_array("hits.npy", "'|u1'", N, 1, &file);
    assert_memory_equal(record, occluded, N);
    free(file);
    cw_field_destroy(field);
}

/* Rays that go nowhere near the field are told of, and where it lies; standard output takes hits or words. */
static void what_is_said_of_rays(void **state) {
    (void)state;
    static const char asc[] = "ncols 2 nrows 2 xllcorner 600000 yllcorner 5200000 cellsize 10\n0 1 2 7";
    static const double far[8] = {0, 0, 100, 0, 0, 0, -1, 1e9}, near[8] = {600010, 5200010, 100, 0, 0, 0, -1, 1e9},
                        above[8] = {600010, 5200010, 100, 0, 0, 0, -1, 50};
    static const float lost[8] = {600010, 5200010, 100, 0, 0, 0, -1, 1e9f};
    scratch_write("a.asc", asc, sizeof asc - 1);
    npy_file("far.npy", "<f8", "(1, 8)", far, sizeof far);
    npy_file("near.npy", "<f8", "(1, 8)", near, sizeof near);
    npy_file("above.npy", "<f8", "(1, 8)", above, sizeof above);
    npy_file("lost.npy", "<f4", "(1, 8)", lost, sizeof lost);
    const program_result *r =
        program_run(NULL, (const char *const[]){"trace", "a.asc", "far.npy", "--user", "-o", "hits.npy", NULL});
    check(r->status == 0 && strstr(r->err, "no ray meets the field, which lies at x 600005 to 600015"), "%s", r->err);
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "above.npy", "--user", "-o", "hits.npy", NULL});
    check(r->status == 0 && strstr(r->err, "no ray meets"), "%s", r->err);
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "lost.npy", "-o", "hits.npy", NULL});
    check(r->status == 0 && strstr(r->err, "--user takes them so"), "%s", r->err);
    run_well((const char *const[]){"trace", "a.asc", "near.npy", "--user", "-o", "hits.npy", NULL});
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "near.npy", "-o", "hits.npy", NULL});
    check(r->status == 1 && strstr(r->err, "'<f8', not '<f4'"), "%s", r->err);
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "near.npy", "--user", "--stats", NULL});
    check(r->status == 0 && strstr(r->out, "1 rays, 1 hits"), "%s", r->out);
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "near.npy", "--user", "--occluded", "-o", "-", NULL});
    check(r->status == 0 && memcmp(r->out, "\x93NUMPY", 6) == 0, "%s", r->err);
    r = program_run(NULL, (const char *const[]){"trace", "a.asc", "near.npy", "--user", "-o", "-", "--stats", NULL});
    check(r->status == 2 && strstr(r->err, "cannot take both"), "%s", r->err);
    r = program_run(NULL,
                    (const char *const[]){"trace", "a.asc", "near.npy", "--occluded", "--points", "-o", "h.npy", NULL});
    check(r->status == 2 && strstr(r->err, "--occluded finds no hit"), "%s", r->err);
}

/* More rays than one piece holds, the last piece being short. */
static void pieces_join(void **state) {
    (void)state;
    fixture *f = make();
    enum { COPIES = 27 };
    cw_ray *rays = malloc(COPIES * RAYS * sizeof *rays);
    cw_hit *hits = malloc(COPIES * RAYS * sizeof *hits);
    assert_true(rays && hits);
    for (size_t k = 0; k < COPIES; k++) memcpy(rays + k * RAYS, f->rays, sizeof f->rays);
    check_status(cw_closest(f->open, NULL, rays, COPIES * RAYS, hits), CW_OK);
    rays_file("many.npy", rays, COPIES * RAYS);
    run_well((const char *const[]){"trace", "field.npy", "many.npy", "-o", "hits.npy", NULL});
    check_hits("hits.npy", hits, COPIES * RAYS);
    free(rays);
    free(hits);
    destroy(f);
}

static void no_rays_no_hits(void **state) {
    (void)state;
    fixture *f = make();
    rays_file("none.npy", f->rays, 0);
    run_well((const char *const[]){"trace", "field.npy", "none.npy", "-o", "hits.npy", "--json", NULL});
    check_hits("hits.npy", f->hits, 0);
    destroy(f);
}

/* The same heights in each kind of file. */
static void formats_agree(void **state) {
    (void)state;
    static const float z[6] = {0, 1, 2, 7, 5, 3};
    static const char asc[] = "ncols 3 nrows 2 cellsize 1 0 1 2 7 5 3";
    static const char pbrt[] =
        "Shape \"heightfield\" \"integer nu\" [3] \"integer nv\" [2] \"float Pz\" [0 1 2 7 5 3]\n";
    static const uint16_t u2[6] = {0, 1, 2, 7, 5, 3};
    static cw_ray rays[1000];
    static cw_hit hits[1000];
    random_state r = {3};
    for (size_t k = 0; k < 1000; k++)
        rays[k] = (cw_ray){.org = {(float)random_between(&r, 0, 2), (float)random_between(&r, 0, 1), 9},
                           .dir = {0.1f, 0.05f, -1},
                           .tmax = INFINITY};
    field_file("f4.npy", z, 3, 2);
    npy_file("u2.npy", "<u2", "(2, 3)", u2, sizeof u2);
    scratch_write("a.asc", asc, sizeof asc - 1);
    scratch_write("a.pbrt", pbrt, sizeof pbrt - 1);
    rays_file("rays.npy", rays, 1000);

    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = 3;
    desc.ny = 2;
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_closest(field, NULL, rays, 1000, hits), CW_OK);
    cw_field_destroy(field);
    size_t found = 0;
    for (size_t k = 0; k < 1000; k++) found += hits[k].i >= 0;
    assert_in_range(found, 100, 1000);
    static const char *const names[] = {"f4.npy", "u2.npy", "a.asc", "a.pbrt"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
        run_well((const char *const[]){"trace", names[k], "rays.npy", "-o", "hits.npy", NULL});
        check_hits("hits.npy", hits, 1000);
    }
}

static double number_after(const char *text, const char *key) {
    const char *at = strstr(text, key);
    check(at != NULL, "%s is not in %s", key, text);
    return strtod(at + strlen(key), NULL);
}

static void json_tells_the_time(void **state) {
    (void)state;
    fixture *f = make();
    check_status(cw_closest(f->open, NULL, f->rays, RAYS, f->hits), CW_OK);
    size_t found = 0;
    for (size_t k = 0; k < RAYS; k++) found += f->hits[k].i >= 0;
    const program_result *r =
        program_run(NULL, (const char *const[]){"trace", "field.npy", "rays.npy", "--json", "--repeat", "5", "--kernel",
                                                "cell", "--threads", "2", NULL});
    check(r->status == 0, "%s", r->err);
    check(strncmp(r->out, "{\"kernel\": \"cell\", ", 19) == 0, "%s", r->out);
    check(strchr(r->out, '\n') == r->out + strlen(r->out) - 1, "more than one line: %s", r->out);
    assert_true(number_after(r->out, "\"rays\": ") == RAYS);
    assert_true(number_after(r->out, "\"hits\": ") == (double)found);
    assert_true(number_after(r->out, "\"threads\": ") == 2);
    const double least = number_after(r->out, "\"seconds_min\": ");
    const double median = number_after(r->out, "\"seconds_median\": ");
    const double speed = number_after(r->out, "\"mrays_per_s\": ");
    check(0 < least && least <= median && median < 60, "%s", r->out);
    check(fabs(speed * median * 1e6 - RAYS) < 1e-3 * RAYS, "%s", r->out);
    assert_int_equal(scratch_entries(), 2);
    destroy(f);
}

#if !defined(__SANITIZE_ADDRESS__)
/* 128 MiB of rays through 64 MiB of address space. The rays are a hole in the file: all zero, so they miss. */
static void rays_need_not_fit(void **state) {
    (void)state;
    fixture *f = make();
    const size_t n = 4u << 20;
    rays_file("sparse.npy", NULL, 0);
    char header[128];
    const int length =
        snprintf(header, sizeof header, "{'descr': '<f4', 'fortran_order': False, 'shape': (%zu, 8)}", n);
    memset(header + length, ' ', sizeof header - (size_t)length);
    FILE *file = fopen("sparse.npy", "wb");
    assert_non_null(file);
    fwrite("\x93NUMPY\x01\x00\x76\x00", 1, 10, file);
    fwrite(header, 1, 0x76, file);
    assert_int_equal(fseek(file, (long)(128 + n * sizeof(cw_ray) - 1), SEEK_SET), 0);
    fputc(0, file);
    assert_int_equal(fclose(file), 0);
    const program_setting little = {.address_space_limit = 64u << 20};
    const program_result *r = program_run(
        &little, (const char *const[]){"trace", "field.npy", "sparse.npy", "-o", "hits.npy", "--threads", "1", NULL});
    check(r->status == 0, "exit status %d: %s", r->status, r->err);
    char *bytes;
    const unsigned char *record = read_hits("hits.npy", n, &bytes);
    const unsigned char miss[RECORD] = {0, 0, 0x80, 0x7f, 255, 255, 255, 255, 255, 255, 255, 255};
    for (size_t k = 0; k < n; k += 1001) assert_memory_equal(record + k * RECORD, miss, RECORD);
    free(bytes);
    destroy(f);
}
#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(closest_is_the_librarys, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(any_marks_the_occluded, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(rays_of_the_map, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_said_of_rays, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pieces_join, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(formats_agree, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(no_rays_no_hits, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(json_tells_the_time, scratch_enter, scratch_leave),
#if !defined(__SANITIZE_ADDRESS__)
        cmocka_unit_test_setup_teardown(rays_need_not_fit, scratch_enter, scratch_leave),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
