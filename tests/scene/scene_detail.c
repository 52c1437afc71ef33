/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail: no ray slips through between two of them, surfaces lie no farther apart than is promised, and pictures without
 * detail keep their bits. */

#include "check.h"
#include "detail.h"
#include "landscape.h"
#include "pictures.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 301, OTHER = 260 }; /* no multiple of a level's step */

/* Steps, walls and pits of up to 64 cells, in whole numbers: all sums of few of them are exact. */
static float cliffs(size_t i, size_t j) {
    const uint32_t block = terrain_hash(1, (uint32_t)(i / 9), (uint32_t)(j / 7));
    const uint32_t wall = terrain_hash(2, (uint32_t)(i / 31), (uint32_t)j / 31);
    return (float)((block & 15) + (i % 31 == wall % 31 ? 64 : 0) + (terrain_hash(3, (uint32_t)i, (uint32_t)j) & 3));
}

static float level_land(size_t i, size_t j) { return 0 * (float)(i + j); }

typedef struct ground {
    float *z;
    cw_field *field;
    detail levels;
} ground;

static ground ground_make(float (*height)(size_t i, size_t j)) {
    ground g = {.z = malloc(sizeof(float) * SIDE * OTHER)};
    assert_non_null(g.z);
    for (size_t j = 0; j < OTHER; j++)
        for (size_t i = 0; i < SIDE; i++) g.z[j * SIDE + i] = height(i, j);
    const cw_field_desc desc = {.samples = g.z, .nx = SIDE, .ny = OTHER, .storage = CW_BORROW};
    io_error error;
    assert_int_equal(cw_field_create(&desc, NULL, &g.field), CW_OK);
    check(detail_make(&g.levels, g.field, NULL, &error), "%s", error.text);
    check(g.levels.count == 5, "%zu levels", g.levels.count); /* 300, 150, 75, 38 and 19 by 17 cells */
    return g;
}

static void ground_free(ground *g) {
    detail_free(&g->levels);
    cw_field_destroy(g->field);
    free(g->z);
}

/* ---- rays --------------------------------------------------------------------------------------------------------- */

static void closest(void *context, size_t level, const cw_ray *rays, size_t n, cw_hit *hits) {
    assert_int_equal(cw_closest(((const ground *)context)->levels.level[level].field, NULL, rays, n, hits), CW_OK);
}

static double unit(uint32_t stream, size_t k) { return (double)terrain_hash(stream, (uint32_t)k, 9) * 0x1p-32; }

/* From over every sample to a place under every sample, within the field all the way. */
static cw_ray downward(const float eye[3], size_t k) {
    cw_ray ray = {.org = {eye[0], eye[1], eye[2]}, .tmax = INFINITY};
    const double to[3] = {1 + unit(4, k) * (SIDE - 3), 1 + unit(5, k) * (OTHER - 3), -1 - 9 * unit(6, k)};
    const double way =
        sqrt((to[0] - (double)eye[0]) * (to[0] - (double)eye[0]) + (to[1] - (double)eye[1]) * (to[1] - (double)eye[1]) +
             (to[2] - (double)eye[2]) * (to[2] - (double)eye[2]));
    for (int c = 0; c < 3; c++) ray.dir[c] = (float)((to[c] - (double)eye[c]) / way);
    return ray;
}

/* The same rays turned round meet the surface from below. */
static cw_ray upward(const cw_ray *down) {
    cw_ray ray = *down;
    const float far = -(ray.org[2] + 2) / ray.dir[2];
    for (int c = 0; c < 3; c++) {
        ray.org[c] += far * ray.dir[c];
        ray.dir[c] = -ray.dir[c];
    }
    return ray;
}

typedef struct outcome {
    size_t leaks, caught, levels[DETAIL_LEVELS_MAX];
} outcome;

static void trace(ground *g, const detail_view *view, const cw_ray *rays, outcome *o) {
    static detail_room room;
    static cw_hit hits[SCENE_BATCH];
    static uint8_t levels[SCENE_BATCH];
    static float reach[SCENE_BATCH];
    const scene_tracer tracer = {.context = g, .closest = closest};
    for (size_t k = 0; k < SCENE_BATCH; k++) reach[k] = 1 + (float)(k % 8) / 8;
    detail_closest(&g->levels, view, &tracer, rays, reach, SCENE_BATCH, hits, levels, &room);
    for (size_t k = 0; k < SCENE_BATCH; k++) {
        o->leaks += hits[k].i < 0;
        if (hits[k].i < 0) continue;
        const float begin = (float)(view->begin[levels[k]] * (double)reach[k]);
        check(hits[k].t >= begin, "ray %zu hits at %g, before its level begins, %g", k, (double)hits[k].t,
              (double)begin);
        o->levels[levels[k]]++;
        o->caught += levels[k] > 0 && hits[k].t == begin;
    }
}

/* Whatever the borders are: they cut hills and walls at all distances. */
static void no_ray_slips_through(void **state) {
    (void)state;
    ground g = ground_make(cliffs);
    static cw_ray rays[SCENE_BATCH], back[SCENE_BATCH];
    outcome o = {0};
    const size_t views = test_share(24, 6);
    for (size_t v = 0; v < views; v++) {
        const float eye[3] = {(float)(2 + unit(7, v) * (SIDE - 5)), (float)(2 + unit(8, v) * (OTHER - 5)),
                              85 + 60 * (float)unit(9, v)};
        detail_view view = {{0}};
        for (size_t k = 1; k < g.levels.count; k++) view.begin[k] = view.begin[k - 1] + 60 * unit(10, v * 32 + k);
        for (size_t k = 0; k < SCENE_BATCH; k++) {
            rays[k] = downward(eye, v * SCENE_BATCH + k);
            back[k] = upward(&rays[k]);
        }
        trace(&g, &view, rays, &o);
        trace(&g, &view, back, &o);
    }
    check(o.leaks == 0, "%zu of %zu rays slip through", o.leaks, 2 * views * SCENE_BATCH);
    check(o.caught > views * SCENE_BATCH / 100, "only %zu rays are caught at borders", o.caught);
    for (size_t k = 0; k < g.levels.count; k++) check(o.levels[k] > 100, "%zu hits on level %zu", o.levels[k], k);
    ground_free(&g);
}

/* With borders by pixels, strict and detail hit alike as far as rays go down; where no level but the first serves, hits are the
 * same to the bit. */
static void far_borders_change_nothing(void **state) {
    (void)state;
    ground g = ground_make(cliffs);
    static cw_ray rays[SCENE_BATCH];
    static cw_hit hits[SCENE_BATCH], strict[SCENE_BATCH];
    static uint8_t levels[SCENE_BATCH];
    static float reach[SCENE_BATCH];
    static detail_room room;
    const scene_tracer tracer = {.context = &g, .closest = closest};
    const detail_view view = detail_view_of(&g.levels, 1, 1, 1e-6);
    for (size_t k = 0; k < SCENE_BATCH; k++) {
        rays[k] = downward((const float[3]){150, -40, 100}, k);
        reach[k] = 1;
    }
    detail_closest(&g.levels, &view, &tracer, rays, reach, SCENE_BATCH, hits, levels, &room);
    assert_int_equal(cw_closest(g.field, NULL, rays, SCENE_BATCH, strict), CW_OK);
    check(memcmp(hits, strict, sizeof hits) == 0, "hits differ");
    ground_free(&g);
}

/* ---- promises ----------------------------------------------------------------------------------------------------- */

/* Heights of level k are whole numbers over 16^k, which doubles hold, as they do all of the interpolation but for the division by
 * the step, which is a power of 2. So the comparison is exact. */
static double height_on(const detail_level *l, size_t step, size_t i, size_t j) {
    const size_t a = i / step < l->nx - 1 ? i / step : l->nx - 2, b = j / step < l->ny - 1 ? j / step : l->ny - 2;
    const double u = (double)(i - a * step) / (double)step, v = (double)(j - b * step) / (double)step;
    const float *z = l->z + b * l->nx + a, *north = z + l->nx;
    return u >= v ? (double)z[0] + u * ((double)z[1] - (double)z[0]) + v * ((double)north[1] - (double)z[1])
                  : (double)z[0] + v * ((double)north[0] - (double)z[0]) + u * ((double)north[1] - (double)north[0]);
}

static void promises_hold(void **state) {
    (void)state;
    ground g = ground_make(cliffs);
    const double seen = 1.0 / 128, height = 2, cell = 3;
    const detail_view view = detail_view_of(&g.levels, cell, height, seen);
    for (size_t k = 1; k < g.levels.count; k++) {
        const detail_level *l = &g.levels.level[k];
        const size_t step = (size_t)1 << k;
        double above = 0, below = 0, near_above = 0, near_below = 0;
        for (size_t j = 0; j < OTHER; j++)
            for (size_t i = 0; i < SIDE; i++) {
                const double here = height_on(l, step, i, j), near = height_on(l - 1, step / 2, i, j);
                above = fmax(above, here - (double)g.z[j * SIDE + i]);
                below = fmax(below, (double)g.z[j * SIDE + i] - here);
                near_above = fmax(near_above, here - near);
                near_below = fmax(near_below, near - here);
            }
        check(above > 1 && above <= l->above && below > 1 && below <= l->below,
              "level %zu lies %.17g above and %.17g below, not %.17g and %.17g", k, above, below, l->above, l->below);
        check(near_above <= l->near_above && near_below <= l->near_below, "level %zu and the one before", k);
        /* seen is a power of 2: nothing is rounded. */
        check(fmax(above, below) * height <= seen * view.begin[k] && cell * (double)step <= seen * view.begin[k],
              "level %zu begins at %g, where its errors are seen", k, view.begin[k]);
        check(view.begin[k] >= view.begin[k - 1], "level %zu begins before the last one", k);
    }
    ground_free(&g);
}

/* ---- pictures ----------------------------------------------------------------------------------------------------- */

static scene *landscape(const ground *g, const detail *levels, const double *water) {
    landscape_desc d = {.field = g->field,
                        .samples = g->z,
                        .nx = SIDE,
                        .ny = OTHER,
                        .levels = levels,
                        .to_world = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0.25, 0}},
                        .eye = {150, 3, 30},
                        .target = {140, 120, 0},
                        .field_of_view = 50,
                        .sun = {0.6, 0, 0.8},
                        .sun_light = 0.85,
                        .sky_light = 0.3,
                        .horizon = {0.7f, 0.8f, 0.9f},
                        .above = {0.2f, 0.3f, 0.7f},
                        .vault = true,
                        .water_level = water,
                        .width = 70,
                        .height = 50,
                        .samples_a_pixel = 2};
    io_image colours;
    io_error error;
    check(io_image_allocate(&colours, 2, 2, false, "", &error), "%s", error.text);
    for (size_t k = 0; k < 12; k++) colours.rgb[k] = 0.1f * (float)k;
    d.colours = &colours;
    scene *s = landscape_create(&d, &error);
    check(s != NULL, "%s", error.text);
    return s;
}

static io_image draw(const scene *s, double pixels, bool general, scene_render_stats *stats) {
    return pictures_render(
        s, &(scene_render_options){.threads = 1, .phong = true, .detail = pixels, .general = general}, stats);
}

static void check_same(io_image a, io_image b, bool same, const char *what) {
    check(pictures_same(&a, &b) == same, "%s", what);
    io_image_free(&a);
    io_image_free(&b);
}

static void pictures_without_detail_keep_their_bits(void **state) {
    (void)state;
    ground g = ground_make(cliffs);
    const double water = 9;
    for (int wet = 0; wet < 2; wet++) {
        scene *bare = landscape(&g, NULL, wet ? &water : NULL), *s = landscape(&g, &g.levels, wet ? &water : NULL);
        scene_render_stats none, some;
        check_same(draw(bare, 0, false, NULL), draw(s, 0, false, NULL), true, "levels alone change the picture");
        check_same(draw(bare, 4, false, NULL), draw(s, 0, false, NULL), true, "without levels, detail changes it");
        check_same(draw(s, 1e-9, false, NULL), draw(s, 0, false, NULL), true, "detail that nobody sees changes it");
        check_same(draw(s, 4, false, &some), draw(s, 0, false, &none), false, "detail changes nothing");
        check(some.camera_rays == none.camera_rays && (some.mirror_rays > 0) == (wet == 1), "%llu mirror rays",
              (unsigned long long)some.mirror_rays);
        check_same(draw(s, 4, true, NULL), draw(s, 4, false, NULL), true, "the plan changes a picture with detail");
        io_image first = {0};
        for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
            cw_isa_limit((cw_isa)isa);
            if (cw_isa_best() != (cw_isa)isa) continue;
            io_image image = draw(s, 4, false, NULL);
            if (isa == CW_ISA_SCALAR) {
                first = image;
                continue;
            }
            check(pictures_same(&first, &image), "%s: pixels differ", cw_isa_name((cw_isa)isa));
            io_image_free(&image);
        }
        cw_isa_limit(CW_ISA_ANY);
        io_image_free(&first);
        scene_free(bare);
        scene_free(s);
    }
    ground_free(&g);
}

/* Rays that a level mirrors into the sky have the full field's directions but for powers of 2. */
static void water_mirrors_the_same_sky_on_all_levels(void **state) {
    (void)state;
    ground g = ground_make(level_land);
    const double water = 1;
    scene *s = landscape(&g, &g.levels, &water);
    scene_render_stats stats;
    check_same(draw(s, 64, false, &stats), draw(s, 0, false, NULL), true, "the water looks otherwise");
    check(stats.mirror_rays > stats.camera_rays / 4, "%llu mirror rays", (unsigned long long)stats.mirror_rays);
    scene_free(s);
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_ray_slips_through),
        cmocka_unit_test(far_borders_change_nothing),
        cmocka_unit_test(promises_hold),
        cmocka_unit_test(pictures_without_detail_keep_their_bits),
        cmocka_unit_test(water_mirrors_the_same_sky_on_all_levels),
    };
    return cmocka_run_group_tests_name("scene_detail", tests, NULL, NULL);
}
