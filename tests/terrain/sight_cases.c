/* SPDX-License-Identifier: Apache-2.0 */
#include "sight_cases.h"

/* ---- terrains -------------------------------------------------------------------------------------------------------- */

static const double ground_map[3][4] = {{GROUND_CELL, 0, 0, 0}, {0, -GROUND_CELL, 0, 0}, {0, 0, 1, 0}};

/* As usual; neither square nor in metres; turned; mirrored. */
enum { GROUND_MAPS = 4 };
static const double ground_maps[GROUND_MAPS][3][4] = {
    {{10, 0, 0, 500}, {0, -10, 0, 900}, {0, 0, 1, 0}},
    {{10, 0, 0, 0}, {0, -25, 0, 0}, {0, 0, 0.3048, 0}},
    {{8, 6, 0, 100}, {6, -8, 0, 100}, {0, 0, 1, 0}},
    {{-5, 0, 0, 0}, {1, 5, 0, 0}, {0, 0, 1, 0}},
};

static void ground_take(ground *g, size_t nx, size_t ny, float *z, const double map[3][4]) {
    const cw_field_desc desc = {.samples = z, .nx = nx, .ny = ny};
    g->z = z;
    check_status(cw_field_create(&desc, NULL, &g->field), CW_OK);
    assert_true(
        cw_terrain_init(&g->terrain, &(terrain_desc){.field = g->field, .nx = nx, .ny = ny, .z = z, .map = map}));
    check_status(cw_sight_bounds_create(&g->terrain, &g->bounds), CW_OK);
}

static float *heights_for(size_t nx, size_t ny) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    return z;
}

void ground_make(ground *g, size_t nx, size_t ny, ground_height *height, const double *shape) {
    float *z = heights_for(nx, ny);
    for (size_t k = 0; k < nx * ny; k++)
        z[k] = (float)height(shape, GROUND_CELL * (double)(k % nx), -GROUND_CELL * (double)(k / nx));
    ground_take(g, nx, ny, z, ground_map);
}

void ground_free(ground *g) {
    cw_sight_bounds_destroy(g->bounds);
    cw_field_destroy(g->field);
    free(g->z);
}

/* WRONG: no-data values that are read as heights, such as -32768. */
typedef enum roughness { SMOOTH, ROUGH, HOLES, SPIKES, WHOLE, WRONG, ROUGHNESSES } roughness;

static void ground_rough(ground *g, size_t nx, size_t ny, roughness rough, random_state *r, const double map[3][4]) {
    float *z = heights_for(nx, ny);
    const double a = random_between(r, 3, 9), b = random_between(r, 3, 9);
    for (size_t k = 0; k < nx * ny; k++) {
        const double x = (double)(k % nx), y = (double)(k / nx), wave = 20 * sin(x / a) * cos(y / b);
        z[k] = (float)(rough == SPIKES ? (random_below(r, 40) == 0 ? random_between(r, 0, 90) : 0)
                                       : wave + random_between(r, 0, rough == SMOOTH ? 1 : 15));
        if (rough == HOLES && random_below(r, 12) == 0) z[k] = NAN;
        if (rough == WHOLE) z[k] = rintf(0.2F * z[k]);
        if (rough == WRONG && random_below(r, 50) == 0) z[k] = random_below(r, 2) ? -32768 : -9999;
    }
    ground_take(g, nx, ny, z, map);
}

/* ---- land and observers ---------------------------------------------------------------------------------------------- */

static void place_anywhere(viewshed_desc *d, random_state *r, double x0, double x1, double y0, double y1, bool whole) {
    d->place[0] = random_between(r, x0, x1);
    d->place[1] = random_between(r, y0, y1);
    for (int c = 0; c < 2 && whole; c++) d->place[c] = floor(d->place[c]);
}

/* On a sample, on a border, anywhere, outside; with curvature 3000, that it be seen on a few hundred metres. */
static void small_land(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    static const size_t sizes[][2] = {{2, 2}, {3, 17}, {23, 9}, {41, 38}};
    const size_t place = n % 6, size = n / 6, nx = sizes[size % 4][0], ny = sizes[size % 4][1];
    ground_rough(g, nx, ny, (roughness)(size / 4 % ROUGHNESSES), r, ground_maps[(size + size / 4) % GROUND_MAPS]);
    *d = (viewshed_desc){.height = random_between(r, 0.5, 30),
                         .target_height = place % 2 ? random_between(r, 0, 10) : 0,
                         .limits.farthest = place == 4 ? random_between(r, 20, 200) : 0,
                         .curvature = place == 5   ? 3000
                                      : place == 3 ? 6.0 / 7
                                                   : 0};
    place_anywhere(d, r, 0, (double)(nx - 1), 0, (double)(ny - 1), place == 0 || place == 5);
    if (place == 1) d->place[0] = floor(d->place[0]);
    if (place == 3) place_anywhere(d, r, -30, 60, -30, 60, false);
    d->absolute = place == 3 || isnan(cw_terrain_height(&g->terrain, d->place[0], d->place[1]));
    if (d->absolute) d->height += 20;
}

/* With everything that bounds pass over. */
static void large_land(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    ground_rough(g, 200, 197, SMOOTH, r, ground_map);
    *d = (viewshed_desc){.height = random_between(r, 1, 40), .curvature = (double)n};
    place_anywhere(d, r, 0, 199, 0, 196, false);
}

/* shape: sample (i, j) stands out by 1000 m. */
static double spike(const double *shape, double x, double y) {
    return x == 10 * shape[0] && y == -10 * shape[1] ? 1000 : 0;
}

/* A spike next to the eye hides what its edges cross, though they end at the eye's own row or column, a hair beside it, or behind it. */
static void spike_beside_eye(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    static const double eyes[][2] = {
        {20.2, 20},          {20, 20.2},         {19.8, 20},         {20, 19.8},
        {20.3, 20.6},        {20 + 1e-10, 20.3}, {20.3, 20 - 1e-10}, {20 + 1e-12, 20 + 1e-12},
        {20.3, 20.3 + 1e-13}};
    const double shape[2] = {19 + (double)(n % 3), 19 + (double)(n / 3 % 3)};
    (void)r;
    ground_make(g, 41, 41, spike, shape);
    *d = (viewshed_desc){.place = {eyes[n / 9][0], eyes[n / 9][1]}, .height = 5, .absolute = true};
}

/* A bowl around the eye at shape, ever steeper outward, and a spike of 100 m close by, at (21, 20). */
static double spike_in_bowl(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, ring = fmax(fabs(i - shape[0]), fabs(j - shape[1]));
    if (ring < 2.5) return i == 21 && j == 20 ? 100 : -1000;
    return ring * (100 / 0.7 - 0.1 + 0.001 * ring);
}

/* The tip of the spike alone hides what is behind it: its flanks, a hair to the side, do not. */
static void behind_a_tip(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    static const double eye[2] = {20.3, 20.2};
    (void)n, (void)r;
    ground_make(g, 41, 41, spike_in_bowl, eye);
    *d = (viewshed_desc){.place = {eye[0], eye[1]}, .absolute = true};
}

/* shape: 1 if the spike at (12, 10) stands among holes. */
static double lone_spike(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, away = fmax(fabs(i - 12), fabs(j - 10));
    return away == 0 ? 100 : away == 1 && shape[0] == 1 ? (double)NAN : 0;
}

/* A sample without edges hides what is exactly behind it. */
static void behind_a_lone_sample(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    static const double eyes[][2] = {{4, 10}, {8, 8}, {12, 2}, {9, 7}, {16, 12}, {15, 13}}, shape[1] = {1};
    (void)r;
    ground_make(g, 41, 31, lone_spike, shape);
    *d = (viewshed_desc){.place = {eyes[n][0], eyes[n][1]}, .height = 5, .absolute = true};
}

enum { SIDE = 24 };

void slope_of_whole_numbers(ground *g, size_t nx, size_t ny, random_state *r, double to[3]) {
    float *z = heights_for(nx, ny);
    to[2] = (double)random_below(r, 5);
    for (int c = 0; c < 2; c++) to[c] = (double)random_below(r, 5) - 2;
    for (size_t k = 0; k < nx * ny; k++) {
        const double high = to[2] + to[0] * (double)(k % nx) + to[1] * (double)(k / nx);
        const uint64_t kind = random_below(r, 100);
        z[k] = (float)(kind == 0 ? (double)NAN : kind < 4 ? high + 1 : kind < 40 ? high : high - 50);
    }
    ground_take(g, nx, ny, z, ground_map);
}

static void in_a_plane(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    double slope[3];
    slope_of_whole_numbers(g, SIDE, SIDE - n % 5, r, slope);
    *d = (viewshed_desc){.absolute = true, .target_height = n % 3 == 2 ? 0.5 : 0};
    for (int c = 0; c < 2; c++) d->place[c] = 0.5 * (double)random_below(r, 2 * (SIDE - 5));
    d->height = slope[2] + slope[0] * d->place[0] + slope[1] * d->place[1];
}

/* shape: slopes of a plane, and which ridges come up to it: all, columns, rows, oblique ones. */
static double ridges(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, z = shape[0] * i + shape[1] * j;
    const bool ridge = fmod(shape[2] == 1 ? i : shape[2] == 2 ? j : i + 2 * j, 4) == 0;
    return shape[2] == 0 || ridge ? z : z - 10;
}

/* With the eye in that plane: but for the rounding of the eye's height and the samples', all are ties, and the last digits decide. */
static void last_digits(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    double shape[3] = {0.5, 0.25, 3};
    for (int c = 0; c < 2 && n % 2; c++) shape[c] = random_between(r, -1, 1);
    ground_make(g, SIDE, SIDE, ridges, shape);
    *d = (viewshed_desc){.absolute = true, .curvature = n % 5 == 4 ? 1 : 0};
    place_anywhere(d, r, -3, SIDE + 3, -3, SIDE + 3, false);
    if (n % 3 == 0) d->place[1] = floor(d->place[1]);
    /* Within rounding of a row: what is between eye and row counts. */
    if (n % 6 == 3) d->place[0] = floor(d->place[0]) + 1e-12;
    d->height = shape[0] * d->place[0] + shape[1] * d->place[1];
}

static void large_ties(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    const double shape[3] = {0.5, 0.25, (double)(n % 4)};
    ground_make(g, 150, 90, ridges, shape);
    *d = (viewshed_desc){.absolute = true};
    place_anywhere(d, r, 40, 80, 30, 60, false);
    d->height = 0.5 * d->place[0] + 0.25 * d->place[1];
}

/* Land on one side of a line of samples along x, along y or a diagonal, with holes on its other side or where the raster ends; and an
 * eye that is next to the line, on either side or on it. */
static void shore(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    enum { LONG = 90, THIN = 3 };
    static const size_t sizes[3][2] = {{LONG, THIN}, {THIN, LONG}, {SIDE, SIDE}};
    const size_t kind = random_below(r, 3), nx = sizes[kind][0], ny = sizes[kind][1];
    const bool after = random_below(r, 2) == 0, on_holes = random_below(r, 3) > 0;
    const double last = THIN - 1, line = kind == 2 ? (double)random_below(r, 5) - 2 : on_holes ? 1 : after ? 0 : last;
    float *z = heights_for(nx, ny);
    for (size_t k = 0; k < nx * ny; k++) {
        const double i = (double)(k % nx), j = (double)(k / nx);
        const double side = (kind == 0 ? j : kind == 1 ? i : j - i) - line, height = random_between(r, 0, 10);
        z[k] = (after ? side : -side) < 0 ? NAN : (float)height;
    }
    ground_take(g, nx, ny, z, ground_map);
    const double off = ldexp(random_below(r, 2) ? 1 : -1, -(int)(18 + random_below(r, 43)));
    *d = (viewshed_desc){.absolute = true, .height = 10 * random_between(r, -0.2, 1.5), .curvature = n % 7 == 6};
    place_anywhere(d, r, -2, (double)nx + 1, -2, (double)ny + 1, false);
    if (kind == 2)
        d->place[1] = d->place[0] + line + off;
    else
        d->place[kind == 0] = line + (n % 8 == 7 ? 0 : off);
}

enum { NX = 330, NY = 250 };

/* Also from under the ground, and with targets in it. */
static void wide_land(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    static const double eyes[5] = {50, 60, 70, 80, -3}, targets[5] = {0, 0, 3, -1, 0};
    ground_rough(g, NX, NY, (roughness)(n / 5), r, ground_map);
    *d = (viewshed_desc){
        .height = eyes[n % 5], .absolute = true, .target_height = targets[n % 5], .curvature = n % 5 == 2 ? 100 : 0};
    place_anywhere(d, r, 0, NX - 1, 0, 12, n % 2 == 1);
}

/* Steps and lakes: many edges on one line, whose pieces of the skyline become one. */
static void steps(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    float *z = heights_for(NX, NY);
    double waves[12][3];
    for (int k = 0; k < 12; k++) {
        const double size = random_between(r, 0.02, k < 4 ? 0.06 : 0.4), angle = random_between(r, 0, 6.3);
        waves[k][0] = size * cos(angle);
        waves[k][1] = size * sin(angle);
        waves[k][2] = random_between(r, 0, 6.3);
    }
    for (size_t k = 0; k < (size_t)NX * NY; k++) {
        double height = 0;
        for (int w = 0; w < 12; w++)
            height += sin(waves[w][0] * (double)(k % NX) + waves[w][1] * (double)(k / NX) + waves[w][2]) /
                      (1 + 20 * hypot(waves[w][0], waves[w][1]));
        z[k] = (float)((n % 3 == 0 ? 2000 : 100) * fmax(height, -0.4));
    }
    ground_take(g, NX, NY, z, ground_map);
    *d = (viewshed_desc){.height = n % 2 == 0 ? 2 : 0.5};
    place_anywhere(d, r, 0, NX - 1, 0, NY - 1, n % 4 != 0);
}

/* For an eye at (9.75, 0) and height 0: from shape on, a dam at that height in row 16, then a cliff, and a shore at that height again
 * in the last two rows, whose end is a tower before the cliff. */
static double dam_and_shore(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10;
    if (j == 16 && i >= shape[0]) return i < 12 ? 0 : 500;
    return j < 257 ? -100 : i < 15 ? 0 : i < 38 ? -100 : 3000;
}

/* An edge of the shore joins an edge of the dam, as both are on one line as seen from the eye, and the dam's piece of the skyline is gone.
 * Bins of directions farther right must not look for the cliff from that piece. There are enough bins from row 257 on. */
static void behind_a_joined_piece(size_t n, ground *g, viewshed_desc *d, random_state *r) {
    const double shape[1] = {10};
    (void)n, (void)r;
    ground_make(g, 43, 259, dam_and_shore, shape);
    *d = (viewshed_desc){.place = {9.75, 0}, .absolute = true};
}

const row sight_rows[ROWS] = {
    {"small land", small_land, 576, 12, true, 80, {3000, 0, 3000, 0}},
    {"large land", large_land, 4, 2, true, 1000, {100, 0, 500, 0}},
    {"a spike beside the eye", spike_beside_eye, 81, 7, true, 280, {5000, 0, 500, 0}},
    {"behind a tip", behind_a_tip, 1, 1, true, 0, {100, 0, 1, 0}},
    {"behind a lone sample", behind_a_lone_sample, 6, 3, true, 0, {2000, 0, 6, 0}},
    {"in a plane", in_a_plane, 60, 8, true, SIDE *SIDE - 1, {2000, 2000, 2000, 0}},
    {"last digits", last_digits, 30, 4, true, SIDE *SIDE - 1, {1000, 0, 1000, 0}},
    {"beside lines, holes and borders", shore, 80, 8, true, 0, {1600, 0, 400, 0}},
    {"wide land", wide_land, 30, 3, false, 3000, {4000, 0, 4000, 0}},
    {"large ties", large_ties, 16, 8, false, 1500, {0, 0, 1000, 0}},
    {"steps and lakes", steps, 25, 24, false, 5000, {1000, 0, 1000, 1000}},
    {"behind a joined piece", behind_a_joined_piece, 1, 1, false, 0, {100, 0, 100, 0}},
};
