/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain as a program for the tests in Python (words.h). Land is made of the files z and map; products go to files. The file desc has a struct
 * of cellwalk_terrain.h or rows of numbers, as bytes. */

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "compass.h"
#include "insolation.h"
#include "profile.h"
#include "skyline.h"
#include "viewshed.h"
#include "visible.h"
#include "words.h"

#include <math.h>

static float *z;
static cw_field *field;
static cw_terrain *land;
static cw_visible *eyes; /* of the field, that stay for the next direction */
static cw_pool *pool;
static skyline line;
static size_t samples;
static const cw_area all;

static int is_well(cw_status status, io_error *e) {
    return status == CW_OK ? DONE : io_fail(e, "%s: %s", cw_status_message(status), cw_last_error());
}

static void forget(void) {
    cw_visible_destroy(eyes);
    eyes = NULL;
    cw_terrain_destroy(land);
    cw_field_destroy(field);
    free(z);
    land = NULL, field = NULL, z = NULL;
}

/* map: 12 numbers, then the unit. With a stride the field borrows its rows. Only a field is made of a map that no terrain can have. */
static int makes_land(const char *c, const char *words, io_error *e) {
    size_t size;
    forget();
    double *map = load("map", &size);
    z = load("z", &size);
    cw_field_desc desc = {.samples = z,
                          .nx = option(words, "nx="),
                          .ny = option(words, "ny="),
                          .stride = option(words, "stride="),
                          .storage = option(words, "stride=") ? CW_BORROW : CW_COPY};
    samples = desc.nx * desc.ny;
    stop_unless(size == (desc.stride ? desc.stride : desc.nx) * desc.ny * sizeof *z, "z");
    memcpy(desc.map, map, sizeof desc.map);
    const size_t null = option(words, "null=");
    cw_terrain_desc t = {.unit = map[12],
                         .geographic = (uint32_t)option(words, "geographic="),
                         .zero = (uint32_t)option(words, "zero="),
                         .reserved = {[7] = option(words, "reserved=")}};
    free(map);
    const int made = is_well(cw_field_create(&desc, NULL, &field), e);
    t.field = null == 1 ? NULL : field;
    if (made != DONE || strcmp(c, "land") != 0) return made;
    return is_well(cw_terrain_create(null == 2 ? NULL : &t, NULL, null == 3 ? NULL : &land), e);
}

/* ---- products ---------------------------------------------------------------------------------------------------------- */

static double share_done;
static bool watch(void *stop, double done) {
    stop_unless(done >= share_done && done <= 1, "a share that shrinks, or is more than all");
    share_done = done;
    return stop == NULL;
}

/* kernel: its width. watch: 1 sees the whole product, 2 ends it. */
static bool reads_run(const char *words, cw_run *run, io_error *e) {
    char name[30];
    const size_t kernel = option(words, "kernel="), watched = option(words, "watch=");
    *run = (cw_run){.pool = option(words, "pool=") ? pool : NULL,
                    .watch = watched ? watch : NULL,
                    .watch_context = watched == 2 ? run : NULL,
                    .reserved = {option(words, "reserved=")}};
    share_done = 0;
    if (kernel == 0) return true;
    snprintf(name, sizeof name, "pyramid%zu", kernel);
    run->expert.kernel = cw_kernel_find(name);
    return cw_kernel_describe(run->expert.kernel).available || io_fail(e, "not on this machine");
}

/* Suns are in the file suns. d: hours that one stands for, linke, curvature, directions. */
static cw_status adds_light(const char *c, const cw_run *run, const double *d, cw_area at, void *to) {
    size_t size;
    sun_position *suns = load("suns", &size);
    insolation *sum = NULL;
    const insolation_desc desc = {.suns = suns,
                                  .count = size / sizeof *suns,
                                  .hours = d[0],
                                  .linke = d[1],
                                  .curvature = d[2],
                                  .directions = (size_t)d[3]};
    cw_status status = cw_insolation_create(land, &desc, &sum);
    if (status == CW_OK && strcmp(c, "sun hours") == 0) status = cw_insolation_hours(sum, run, at, to);
    if (status == CW_OK && strcmp(c, "sun direct") == 0) status = cw_insolation_direct(sum, run, at, to);
    if (status == CW_OK && strcmp(c, "sun diffuse") == 0) *(double *)to = cw_insolation_diffuse(sum);
    cw_insolation_destroy(sum);
    free(suns);
    return status;
}

/* One output, or of "view all" each, one after the other. A number other than 0 is no weight. */
static cw_status views(const char *c, const cw_terrain *t, const cw_run *run, const cw_observer *from, cw_area at,
                       uint32_t number, char *to) {
    const bool together = strcmp(c, "view all") == 0;
    cw_view view = {.weight = number ? (double)NAN : 2.5};
    if (together || strcmp(c, "view sum") == 0) view.sum = (double *)(void *)to;
    if (together || strcmp(c, "view angle") == 0) view.angle = (float *)(void *)(together ? to + 8 * samples : to);
    if (together || strcmp(c, "view needed") == 0) view.needed = (float *)(void *)(together ? to + 12 * samples : to);
    if (together || strcmp(c, "view seen") == 0) view.seen = (uint16_t *)(void *)(together ? to + 16 * samples : to);
    if (together && from->limits & CW_OBSERVER_VERTICALS) view.needed = NULL;
    return cw_viewshed(t, run, from, at, to ? &view : NULL);
}

static cw_status make(const char *c, const cw_terrain *t, const cw_run *run, const void *desc, cw_area at,
                      uint32_t number, void *to) {
    const cw_visibility_answers area = {.area = to}, share = {.share = to};
    if (strcmp(c, "shadow") == 0) return cw_shadow(t, run, desc, at, to);
    if (strcmp(c, "sunlight") == 0) return cw_sunlight(t, run, desc, at, to);
    if (strcmp(c, "angles") == 0) return cw_horizon_angles(t, run, desc, number, at, to, NULL);
    if (strcmp(c, "metres") == 0) return cw_horizon_angles(t, run, desc, number, at, NULL, to);
    if (strcmp(c, "azimuths") == 0) return cw_horizon_azimuths(t, desc, to);
    if (strcmp(c, "sky") == 0) return cw_sky_view(t, run, desc, at, to);
    if (strcmp(c, "openness") == 0) return cw_openness(t, run, desc, at, to);
    if (strcmp(c, "area") == 0) return cw_visibility(t, run, desc, at, to ? &area : NULL);
    if (strcmp(c, "share") == 0) return cw_visibility(t, run, desc, at, &share);
    if (strncmp(c, "sun ", 4) == 0) return adds_light(c, run, desc, at, to);
    return views(c, t, run, desc, at, number, to);
}

/* Into the bytes of the file to, which then go to the file out. null: 1 no terrain, 2 no description, 3 no output. */
static int makes(const char *c, const char *words, const void *desc, io_error *e) {
    const cw_area at = {{option(words, "left="), option(words, "top="), option(words, "wide="), option(words, "high=")},
                        option(words, "stride=")};
    const size_t null = option(words, "null=");
    cw_run run;
    size_t size;
    if (!reads_run(words, &run, e)) return FAILED;
    void *to = load("to", &size);
    const cw_status status = make(c, null == 1 ? NULL : land, &run, null == 2 ? NULL : desc, at,
                                  (uint32_t)option(words, "number="), null == 3 ? NULL : to);
    save("out", to, size);
    free(to);
    fprintf(answer, "%g", share_done);
    return is_well(status, e);
}

/* ---- sight ------------------------------------------------------------------------------------------------------------- */

/* The curvature, and then lines. */
static int draws_lines(const char *words, double *d, size_t size, io_error *e) {
    const size_t n = (size - sizeof *d) / sizeof(cw_sight);
    cw_sight_answer *answers = calloc(n + 1, sizeof *answers);
    cw_sight *const lines = (cw_sight *)(void *)(d + 1);
    const cw_status status = cw_lines_of_sight(land, NULL, *d, option(words, "null=") ? NULL : lines, n, answers);
    save("out", answers, n * sizeof *answers);
    free(answers);
    return is_well(status, e);
}

/* From a place in field coordinates, its height, whether that is absolute, the target's height, the curvature, the greatest distance: what is
 * seen and the needed heights, and then the eye as it is and how the earth falls. */
static int looks_round(const double *d, io_error *e) {
    const viewshed_desc desc = {.place = {d[0], d[1]},
                                .height = d[2],
                                .absolute = d[3] != 0,
                                .target_height = d[4],
                                .curvature = d[5],
                                .limits.farthest = d[6]};
    const sight_bounds *bounds;
    viewshed *v;
    uint16_t *seen = calloc(samples, sizeof *seen);
    float *needed = calloc(samples, sizeof *needed);
    cw_status status = cw_terrain_bounds(land, &bounds);
    stop_unless(seen && needed && status == CW_OK, "samples");
    status = cw_viewshed_create(land, bounds, &desc, &v);
    if (status == CW_OK) status = cw_viewshed_see(v, NULL, all, &(cw_view){.seen = seen, .needed = needed});
    if (status == CW_OK) {
        save("eye", cw_viewshed_sight(v)->eye, 3 * sizeof(double));
        save("fall", cw_viewshed_sight(v)->fall, 3 * sizeof(double));
    }
    cw_viewshed_destroy(v);
    cw_terrain_bounds_release(land, bounds);
    save("seen", seen, samples * sizeof *seen);
    save("needed", needed, samples * sizeof *needed);
    free(seen);
    free(needed);
    return is_well(status, e);
}

/* Of the line between two places of the field, with the earth's curvature: share, ground, line and seen of each point. */
static int follows(const double *d, io_error *e) {
    profile p = {0};
    sight s;
    cw_sight_init(&s, land, NULL, d, d[6]);
    const cw_status status = cw_profile_make(&p, &s, d[3], d[4], d[5]);
    double *out = malloc(p.count * 4 * sizeof *out);
    for (size_t k = 0; k < p.count; k++) {
        const profile_point *at = &p.points[k];
        memcpy(out + 4 * k, (double[4]){at->share, at->ground, at->line, at->seen}, 4 * sizeof *out);
    }
    save("out", out, p.count * 4 * sizeof *out);
    free(out);
    cw_profile_free(&p);
    return is_well(status, e);
}

/* The coarser field, and how far it is; then a sample of it is changed. */
static int coarsens(const char *words, io_error *e) {
    cw_field *coarser = NULL;
    cw_difference d;
    cw_run run;
    if (!reads_run(words, &run, e)) return FAILED;
    const cw_status status = cw_field_coarser(field, &run, option(words, "factor="), (int32_t)option(words, "filter="),
                                              &coarser, &d, sizeof d);
    if (status != CW_OK) return is_well(status, e);
    const cw_field_info info = cw_field_describe(coarser);
    FILE *file = fopen("out", "wb");
    stop_unless(file != NULL, "out");
    for (size_t j = 0; j < info.ny; j++) fwrite(cw_field_row(coarser, j), sizeof(float), info.nx, file);
    stop_unless(fclose(file) == 0, "out");
    save("difference", &d, sizeof d);
    double point[3];
    cw_hit_points(coarser, NULL, &(cw_hit){.i = 0, .j = 0, .u = 1}, 1, point);
    save("point", point, sizeof point);
    cw_field_update(coarser, NULL, &(cw_update){.at = {1, 0, 1, 1}, .samples = (const float[]){9}});
    stop_unless(cw_field_row(coarser, 0)[1] == 9, "a coarser field does not own its samples");
    fprintf(answer, "nx=%zu\nny=%zu\n", info.nx, info.ny);
    cw_field_destroy(coarser);
    return DONE;
}

/* The ground in sight from eyes of a rectangle of the field; desc: direction, reach, drop, eye, target, slack. keep: the eyes stay for the next
 * direction. Area, distance and direction of each eye go to files. */
static int sees(const char *words, const double *d, io_error *e) {
    const cw_rectangle at = {option(words, "left="), option(words, "top="), option(words, "wide="),
                             option(words, "high=")};
    const size_t every = option(words, "every="), row = option(words, "row="), rows = option(words, "count="),
                 n = every ? rows * ((at.nx + every - 1) / every) : 0, isa = option(words, "isa=");
    const cw_visible_desc desc = {.dir = {d[0], d[1]},
                                  .reach = d[2],
                                  .drop = d[3],
                                  .eye = (float)d[4],
                                  .target = (float)d[5],
                                  .slack = d[6],
                                  .weight = 1,
                                  .length = 1,
                                  .label = 7};
    double *area = calloc(n + 1, sizeof *area);
    float *far = calloc(n + 1, sizeof *far), *direction = malloc((n + 1) * sizeof *direction);
    stop_unless(area && far && direction, "eyes");
    for (size_t k = 0; k < n; k++) direction[k] = NAN;
    cw_isa_limit((cw_isa)isa);
    const bool there = isa == 0 || cw_isa_best() == (cw_isa)isa;
    cw_status status = eyes ? CW_OK : cw_visible_create(field, at, every, &eyes);
    if (status == CW_OK && there)
        status = cw_visible_add(eyes, &(cw_run){.pool = isa % 2 ? pool : NULL}, &desc, row, rows,
                                (cw_visible_sums){area, far, direction});
    cw_isa_limit(CW_ISA_ANY);
    if (option(words, "keep=") == 0) cw_visible_destroy(eyes), eyes = NULL;
    save("area", area, n * sizeof *area);
    save("far", far, n * sizeof *far);
    save("direction", direction, n * sizeof *direction);
    free(area);
    free(far);
    free(direction);
    return there ? is_well(status, e) : io_fail(e, "not on this machine");
}

/* ---- rows of numbers ------------------------------------------------------------------------------------------------------ */

/* Column, row, azimuth: metres in one of x and y there, a step in that direction and its length, sine, cosine, height. */
static void look_at_place(const double *d, double *to) {
    cw_terrain_metres(land, d[0], d[1], to);
    to[4] = cw_terrain_direction(land, d[0], d[1], d[2], to + 2);
    cw_terrain_sine_cosine(d[2], to + 5, to + 6);
    to[7] = cw_terrain_height(land, d[0], d[1]);
}
static void look_at_sun(const double *d, double *to) { /* seconds, longitude, latitude */
    const sun_position p = cw_sun_at(d[0], d[1], d[2]);
    memcpy(to, &p, sizeof p);
}
static void look_at_sky(const double *d, double *to) { /* linke, distance, altitude, height */
    to[0] = cw_clear_sky_air_mass(d[2], d[3]);
    to[1] = cw_clear_sky_direct(d[0], d[1], d[2], d[3]);
    to[2] = cw_clear_sky_diffuse(d[0], d[1], d[2]);
}
static void look_up(const double *d, double *to) { *to = (double)cw_horizon_degrees((float)*d); }
/* Eye, curvature, place of the target, its height, more over that: the first block, whether it is seen, what is needed, the steepest rise. */
static void look_along(const double *d, double *to) {
    const sight_bounds *bounds;
    sight s;
    stop_unless(cw_terrain_bounds(land, &bounds) == CW_OK, "bounds");
    cw_sight_init(&s, land, bounds, d, d[3]);
    to[0] = cw_sight_first_block(&s, d[4], d[5], d[6]);
    to[1] = cw_sight_sees(&s, d[4], d[5], d[6], d[7], (sight_parts){INFINITY, true});
    to[2] = cw_sight_need(&s, d[4], d[5], d[6], -INFINITY);
    to[3] = cw_sight_steepest(&s, d[4], d[5], -INFINITY).steepest;
    cw_terrain_bounds_release(land, bounds);
}
/* 0: a new skyline. 1: an edge from (u, w) to (u, w) is added, from the last piece on that begins before a place, sought from the last such piece
 * on or anew; says whether who has found a piece behind the edge finds on from it. 2: looks in a direction, from the last look on or anew. 3: the
 * least between two directions. */
static void look_at_skyline(const double *d, double *to) {
    static uint32_t at, before;
    if (d[0] == 0) {
        cw_skyline_free(&line);
        stop_unless(cw_skyline_init(&line, -1, 1), "skyline");
    } else if (d[0] == 1) {
        const double far = fmax(d[1], d[3]) + 0.05;
        before = skyline_find(&line, d[5] != 0 ? before : SKYLINE_FIRST, d[6]);
        const uint32_t behind = skyline_find(&line, before, far);
        cw_skyline_add(&line, before, d + 1, d + 3);
        stop_unless(!line.failed, "skyline");
        to[0] = line.pieces[behind].from > far ||
                skyline_find(&line, behind, far) == skyline_find(&line, SKYLINE_FIRST, far);
    } else if (d[0] == 2) {
        at = d[2] != 0 ? at : SKYLINE_FIRST;
        skyline_at(&line, &at, d[1], to, to + 1);
    } else {
        to[0] = cw_skyline_least(&line, SKYLINE_FIRST, d[1], d[2]);
    }
}

static const struct {
    const char *name;
    void (*look)(const double *row, double *to);
    size_t in, out;
} tables[] = {{"places", look_at_place, 3, 8}, {"suns", look_at_sun, 3, 5},  {"skies", look_at_sky, 4, 3},
              {"degrees", look_up, 1, 1},      {"sights", look_along, 8, 4}, {"skyline", look_at_skyline, 7, 2}};

static int fills_table(size_t k, const double *rows, size_t size) {
    const size_t n = size / sizeof *rows / tables[k].in;
    double *out = calloc(n * tables[k].out, sizeof *out);
    stop_unless(out != NULL, "rows");
    for (size_t r = 0; r < n; r++) tables[k].look(rows + r * tables[k].in, out + r * tables[k].out);
    save("out", out, n * tables[k].out * sizeof *out);
    free(out);
    return DONE;
}

/* Rays of field space: whether they hit something. */
static int traces(const cw_ray *rays, size_t size, io_error *e) {
    const size_t n = size / sizeof *rays;
    uint8_t *hits = malloc(n);
    const cw_status status = cw_occluded(field, NULL, rays, n, hits);
    save("out", hits, n);
    free(hits);
    return is_well(status, e);
}

static int obey(char **w, io_error *e) {
    const char *c = w[0];
    double seconds;
    if (strcmp(c, "land") == 0 || strcmp(c, "field") == 0) return makes_land(c, w[1], e);
    if (strcmp(c, "coarser") == 0) return coarsens(w[1], e);
    if (strcmp(c, "time") == 0) {
        if (!cw_sun_parse_time(w[1], &seconds)) return FAILED;
        fprintf(answer, "%.0f", seconds);
        return DONE;
    }
    size_t size;
    void *desc = load("desc", &size);
    int done = OTHER;
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++)
        if (strcmp(c, tables[k].name) == 0) done = fills_table(k, desc, size);
    if (strcmp(c, "rays") == 0) done = traces(desc, size, e);
    if (strcmp(c, "lines") == 0) done = draws_lines(w[1], desc, size, e);
    if (strcmp(c, "round") == 0) done = looks_round(desc, e);
    if (strcmp(c, "profile") == 0) done = follows(desc, e);
    if (strcmp(c, "visible") == 0) done = sees(w[1], desc, e);
    if (done == OTHER) done = makes(c, w[1], desc, e);
    free(desc);
    return done;
}

int main(int argc, char **argv) {
    stop_unless(cw_pool_create(4, &pool) == CW_OK, "threads");
    const int status = words_run(argc, argv, obey);
    forget();
    cw_pool_destroy(pool);
    cw_skyline_free(&line);
    return status;
}
