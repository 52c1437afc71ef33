/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain as a program for the tests in Python (words.h). Land is made of the files z and map; products go to files. The file desc has a struct
 * of cellwalk_terrain.h or rows of numbers, as bytes. */

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "compass.h"
#include "insolation.h"
#include "profile.h"
#include "visible.h"
#include "words.h"

#include <math.h>

static float *z;
static cw_field *field;
static cw_terrain *land;
static cw_visible *eyes; /* of the field, that stay for the next direction */
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

/* map: 12 numbers, then the unit. Only a field is made of one that no terrain can have. */
static int makes_land(const char *c, const char *words, io_error *e) {
    size_t size;
    forget();
    double *map = load("map", &size);
    z = load("z", &size);
    cw_field_desc desc = {.samples = z, .nx = option(words, "nx="), .ny = option(words, "ny=")};
    samples = desc.nx * desc.ny;
    stop_unless(size == samples * sizeof *z, "z");
    memcpy(desc.map, map, sizeof desc.map);
    cw_terrain_desc t = {.unit = map[12], .geographic = (uint32_t)option(words, "geographic=")};
    free(map);
    const int made = is_well(cw_field_create(&desc, NULL, &field), e);
    t.field = field;
    return made == DONE && strcmp(c, "land") == 0 ? is_well(cw_terrain_create(&t, NULL, &land), e) : made;
}

/* ---- products ---------------------------------------------------------------------------------------------------------- */

static int fills(const char *c, char **w, const void *desc, io_error *e) {
    enum { MOST = 1 << 21 };
    static double sums[MOST];
    static uint16_t seen[MOST];
    static float out[MOST], more[MOST];
    cw_status status = CW_OK;
    stop_unless(samples <= MOST, "samples");
    if (strcmp(c, "shadow") == 0) status = cw_shadow(land, NULL, desc, all, (uint8_t *)seen);
    if (strcmp(c, "sunlight") == 0) status = cw_sunlight(land, NULL, desc, all, out);
    if (strcmp(c, "angles") == 0) status = cw_horizon_angles(land, NULL, desc, (uint32_t)whole(w[1]), all, out, more);
    if (strcmp(c, "sky") == 0) status = cw_sky_view(land, NULL, desc, all, out);
    if (strcmp(c, "viewshed") == 0) {
        memset(seen, 0, sizeof seen);
        memset(sums, 0, sizeof sums);
        status = cw_viewshed(land, NULL, desc, all, &(cw_view){.seen = seen, .angle = out});
        for (int k = 1; k <= 3 && status == CW_OK; k++)
            status = cw_viewshed(land, NULL, desc, all, &(cw_view){.sum = sums, .weight = k});
    }
    save("seen", seen, samples * sizeof *seen);
    save("out", out, samples * sizeof *out);
    save("more", more, samples * sizeof *more);
    save("sums", sums, samples * sizeof *sums);
    return is_well(status, e);
}

/* Hours, what a sun stands for, linke, curvature, directions; suns are in the file suns. */
static int adds_light(const double *d, io_error *e) {
    size_t size;
    sun_position *suns = load("suns", &size);
    float *out = malloc(2 * samples * sizeof *out);
    insolation *sum = NULL;
    const insolation_desc desc = {.suns = suns,
                                  .count = size / sizeof *suns,
                                  .hours = d[0],
                                  .linke = d[1],
                                  .curvature = d[2],
                                  .directions = (size_t)d[3]};
    cw_status status = cw_insolation_create(land, &desc, &sum);
    if (status == CW_OK) status = cw_insolation_hours(sum, NULL, all, out);
    if (status == CW_OK) status = cw_insolation_direct(sum, NULL, all, out + samples);
    if (status == CW_OK) fprintf(answer, "%a", cw_insolation_diffuse(sum));
    save("out", out, 2 * samples * sizeof *out);
    cw_insolation_destroy(sum);
    free(out);
    free(suns);
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

/* The coarser field, of the first samples alone that words name, and how far it is; then a sample of it is changed. */
static int coarsens(char **w, io_error *e) {
    cw_field *coarser = NULL;
    cw_pool *pool = NULL;
    cw_difference d;
    if (whole(w[3]) > 1) cw_pool_create(4, &pool);
    const cw_run run = {.pool = pool};
    const cw_status status = cw_field_coarser(field, &run, whole(w[1]), (int32_t)whole(w[2]), &coarser, &d, sizeof d);
    cw_pool_destroy(pool);
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
    cw_pool *pool = NULL;
    stop_unless(area && far && direction && (isa % 2 == 0 || cw_pool_create(3, &pool) == CW_OK), "eyes");
    for (size_t k = 0; k < n; k++) direction[k] = NAN;
    cw_isa_limit((cw_isa)isa);
    const bool there = isa == 0 || cw_isa_best() == (cw_isa)isa;
    cw_status status = eyes ? CW_OK : cw_visible_create(field, at, every, &eyes);
    if (status == CW_OK && there)
        status =
            cw_visible_add(eyes, &(cw_run){.pool = pool}, &desc, row, rows, (cw_visible_sums){area, far, direction});
    cw_isa_limit(CW_ISA_ANY);
    cw_pool_destroy(pool);
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

static const struct {
    const char *name;
    void (*look)(const double *row, double *to);
    size_t in, out;
} tables[] = {{"places", look_at_place, 3, 8},
              {"suns", look_at_sun, 3, 5},
              {"skies", look_at_sky, 4, 3},
              {"degrees", look_up, 1, 1}};

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
    if (strcmp(c, "coarser") == 0) return coarsens(w, e);
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
    if (strcmp(c, "light") == 0) done = adds_light(desc, e);
    if (strcmp(c, "profile") == 0) done = follows(desc, e);
    if (strcmp(c, "visible") == 0) done = sees(w[1], desc, e);
    if (done == OTHER) done = fills(c, w, desc, e);
    free(desc);
    return done;
}

int main(int argc, char **argv) {
    const int status = words_run(argc, argv, obey);
    forget();
    return status;
}
