/* SPDX-License-Identifier: Apache-2.0 */
/* All products: parts of a field, with a stride, on threads, by every instruction set, and of a field that borrows rows with gaps, have
 * the bits of the whole; a watch ends each product; wrong calls name argument, value and limit. */
#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "check.h"
#include "insolation.h"
#include "workload/random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NX = 61, NY = 47, STRIDE = NX + 5, SAMPLES = NX * NY, GAP = 77 };
static const double degree = 3.141592653589793 / 180;

static cw_field *field;
static cw_terrain *land;
static float samples[NY * GAP];

static void make(bool degrees) {
    random_state r = {31};
    for (size_t k = 0; k < NY * GAP; k++)
        samples[k] = (float)(40 * sin((double)(k % GAP) / 7) * cos((double)(k / GAP) / 5) + random_between(&r, 0, 8));
    samples[20 * GAP + 30] = NAN;
    const double side = degrees ? 0.0001 : 10;
    const cw_field_desc desc = {.samples = samples,
                                .nx = NX,
                                .ny = NY,
                                .stride = GAP,
                                .storage = CW_BORROW,
                                .map = {{side, 0, 0, 7}, {0, -side, 0, 47}, {0, 0, 1, 0}}};
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    const cw_terrain_desc t = {.field = field, .geographic = degrees, .unit = degrees ? degree : 0};
    check_status(cw_terrain_create(&t, NULL, &land), CW_OK);
}

static void destroy(void) {
    cw_terrain_destroy(land);
    cw_field_destroy(field);
}

/* ---- products ---------------------------------------------------------------------------------------------------------- */

static const double hill[2] = {30, 20}; /* where an observer stands, in samples */

static cw_observer observer(void) {
    const cw_field_info info = cw_field_describe(field);
    return (cw_observer){.x = info.map[0][0] * hill[0] + info.map[0][3],
                         .y = info.map[1][1] * (hill[1] + 1) + info.map[1][3],
                         .height = 3,
                         .target = 1};
}

typedef cw_status product(const cw_run *run, cw_area area, void *to);

static cw_status shadow(const cw_run *run, cw_area area, void *to) {
    return cw_shadow(land, run, &(cw_light){.azimuth = 200, .altitude = 15}, area, to);
}
static cw_status light(const cw_run *run, cw_area area, void *to) {
    const cw_light sun = {.azimuth = 200, .altitude = 15, .radius = 1, .hillshade = 1};
    return cw_sunlight(land, run, &sun, area, to);
}
static cw_status angles(const cw_run *run, cw_area area, void *to) {
    return cw_horizon_angles(land, run, &(cw_horizon){.start = 13, .curvature = 1}, 5, area, to, NULL);
}
static cw_status metres(const cw_run *run, cw_area area, void *to) {
    return cw_horizon_angles(land, run, &(cw_horizon){.count = 7}, 2, area, NULL, to);
}
static cw_status sky(const cw_run *run, cw_area area, void *to) {
    return cw_sky_view(land, run, &(cw_horizon){.count = 11, .max_distance = 150}, area, to);
}
static cw_status tilted(const cw_run *run, cw_area area, void *to) {
    return cw_sky_view(land, run, &(cw_horizon){.flags = CW_HORIZON_TILTED}, area, to);
}
static cw_status open_below(const cw_run *run, cw_area area, void *to) {
    return cw_openness(land, run, &(cw_horizon){.count = 8, .flags = CW_HORIZON_BELOW}, area, to);
}
static cw_status needed(const cw_run *run, cw_area area, void *to) {
    const cw_observer from = observer();
    return cw_viewshed(land, run, &from, area, &(cw_view){.needed = to});
}
static cw_status view_angle(const cw_run *run, cw_area area, void *to) {
    const cw_observer from = observer();
    return cw_viewshed(land, run, &from, area, &(cw_view){.angle = to});
}
static cw_status in_sight(const cw_run *run, cw_area area, void *to) {
    return cw_visibility(land, run, &(cw_visibility_desc){.directions = 9, .height = 2}, area,
                         &(cw_visibility_answers){.area = to});
}
static cw_status share(const cw_run *run, cw_area area, void *to) {
    return cw_visibility(land, run, &(cw_visibility_desc){.directions = 9, .height = 2}, area,
                         &(cw_visibility_answers){.share = to});
}
static cw_status seen(const cw_run *run, cw_area area, void *to) { /* by none or one */
    const cw_observer from = observer();
    return cw_viewshed(land, run, &from, area, &(cw_view){.seen = to});
}
static cw_status sun(const cw_run *run, cw_area area, void *to, bool direct) {
    static sun_position suns[48];
    for (size_t k = 0; k < 48; k++) suns[k] = cw_sun_at(1.7e9 + 1800 * (double)k, 11, 46);
    insolation *sum = NULL;
    const insolation_desc desc = {
        .suns = suns, .count = 48, .hours = 0.5, .linke = 3, .curvature = 1, .directions = direct ? 0 : 100};
    cw_status status = cw_insolation_create(land, &desc, &sum);
    if (status == CW_OK) status = (direct ? cw_insolation_direct : cw_insolation_hours)(sum, run, area, to);
    cw_insolation_destroy(sum);
    return status;
}
static cw_status hours(const cw_run *run, cw_area area, void *to) { return sun(run, area, to, false); }
static cw_status energy(const cw_run *run, cw_area area, void *to) { return sun(run, area, to, true); }

static const struct {
    const char *name;
    product *make;
    size_t bytes;
    bool adds; /* to what is there */
} products[] = {
    {"shadow", shadow, 1, false},       {"sunlight", light, 4, false},       {"angles", angles, 4, false},
    {"distances", metres, 4, false},    {"sky view", sky, 4, false},         {"tilted sky view", tilted, 4, false},
    {"openness", open_below, 4, false}, {"needed", needed, 4, false},        {"view's angle", view_angle, 4, false},
    {"in sight", in_sight, 4, false},   {"share in sight", share, 4, false}, {"seen", seen, 2, true},
    {"hours of sun", hours, 4, false},  {"energy", energy, 4, false},
};
enum { PRODUCTS = sizeof products / sizeof *products };

/* ---- tests --------------------------------------------------------------------------------------------------------------- */

/* One part, into rows with room behind them. */
static void check_part(size_t p, const cw_run *run, cw_rectangle at, const uint8_t *whole, const char *who) {
    static uint8_t part[NY * STRIDE * 4], before[NY * STRIDE * 4];
    const size_t bytes = products[p].bytes;
    memset(before, products[p].adds ? 0 : 0xa5, sizeof before);
    memcpy(part, before, sizeof part);
    check_status(products[p].make(run, (cw_area){at, STRIDE}, part), CW_OK);
    for (size_t y = 0; y < at.ny; y++) {
        const size_t end = (y * STRIDE + at.nx) * bytes;
        check(memcmp(part + y * STRIDE * bytes, whole + ((at.j + y) * NX + at.i) * bytes, at.nx * bytes) == 0,
              "%s by %s: row %zu of %zu x %zu", products[p].name, who, y, at.nx, at.ny);
        check(memcmp(part + end, before + end, (STRIDE - at.nx) * bytes) == 0, "%s by %s: written behind row %zu",
              products[p].name, who, y);
    }
}

static void parts_have_the_bits_of_the_whole(void **state) {
    (void)state;
    static uint8_t whole[SAMPLES * 4];
    static const cw_rectangle parts[] = {{0, 0, NX, NY}, {0, 5, 20, 30}, {NX - 9, NY - 3, 9, 3}, {31, 0, 1, NY}};
    static const char *const kernels[] = {"pyramid1", "pyramid4", "pyramid8", "pyramid16"};
    cw_pool *pool = NULL;
    check_status(cw_pool_create(3, &pool), CW_OK);
    for (int degrees = 0; degrees < 2; degrees++) {
        make(degrees != 0);
        for (size_t p = 0; p < PRODUCTS; p++) {
            memset(whole, 0, sizeof whole);
            check_status(products[p].make(NULL, (cw_area){0}, whole), CW_OK);
            for (size_t k = 0; k < 4; k++) {
                cw_run run = {.pool = k % 2 ? pool : NULL};
                check_part(p, &run, parts[k], whole, "the default kernel");
                run.expert.kernel = cw_kernel_find(kernels[k]);
                check(cw_kernel_exists(run.expert.kernel) || k > 0, "there is no kernel %s", kernels[k]);
                for (size_t n = 0; n < 4 && cw_kernel_describe(run.expert.kernel).available; n++)
                    if (test_takes(n + k + p, 4)) check_part(p, &run, parts[n], whole, kernels[k]);
            }
        }
        destroy();
    }
    cw_pool_destroy(pool);
}

typedef struct watching {
    double last, stop;
} watching;

static bool watch(void *context, double done) {
    watching *w = context;
    check(done >= w->last && done <= 1, "%g after %g", done, w->last);
    w->last = done;
    return done < w->stop;
}

static void watches_see_shares_and_end_products(void **state) {
    (void)state;
    static uint8_t to[SAMPLES * 4];
    make(false);
    for (size_t p = 0; p < PRODUCTS; p++) {
        watching w = {0, 2};
        check_status(products[p].make(&(cw_run){.watch = watch, .watch_context = &w}, (cw_area){0}, to), CW_OK);
        check(w.last > 0.9, "%s: done at %g", products[p].name, w.last);
        w = (watching){0, 0};
        check(products[p].make(&(cw_run){.watch = watch, .watch_context = &w}, (cw_area){0}, to) == CW_ERROR_CANCELLED,
              "%s goes on", products[p].name);
    }
    destroy();
}

/* Of several observers: each adds. One call for several outputs is several calls. */
static void outputs_go_together(void **state) {
    (void)state;
    static uint16_t one[SAMPLES], both[SAMPLES];
    static double sum[SAMPLES];
    static float angle[SAMPLES], need[SAMPLES], alone[SAMPLES];
    make(false);
    const cw_observer from = observer();
    check_status(cw_viewshed(land, NULL, &from, (cw_area){0}, &(cw_view){.seen = one}), CW_OK);
    const cw_view all = {.seen = both, .sum = sum, .weight = 2.5, .angle = angle, .needed = need};
    for (int k = 0; k < 2; k++) check_status(cw_viewshed(land, NULL, &from, (cw_area){0}, &all), CW_OK);
    check_status(needed(NULL, (cw_area){0}, alone), CW_OK);
    assert_memory_equal(need, alone, sizeof need);
    size_t seen = 0;
    for (size_t k = 0; k < SAMPLES; k++) {
        check(both[k] == 2 * one[k] && sum[k] == 5.0 * one[k] && isnan(angle[k]) == !one[k], "sample %zu", k);
        seen += one[k];
    }
    check(seen > 100 && seen < SAMPLES - 100, "%zu are seen", seen);
    /* Lines say the same. */
    const cw_field_info info = cw_field_describe(field);
    for (size_t k = 0; k < SAMPLES; k += 7) {
        const double x = info.map[0][0] * (double)(k % NX) + info.map[0][3],
                     y = info.map[1][1] * (double)(k / NX) + info.map[1][3];
        const cw_sight line = {{from.x, from.y, from.height}, {x, y, from.target}, 0, 0};
        cw_sight_answer a;
        check_status(cw_lines_of_sight(land, NULL, 0, &line, 1, &a), CW_OK);
        if (k == 20 * NX + 30)
            check(a.state == CW_SIGHT_NO_GROUND && a.end == 1, "the hole: %u", a.state);
        else
            check((a.state == CW_SIGHT_SEEN) == one[k], "sample %zu: %u", k, a.state);
    }
    destroy();
}

#define WRONG(CALL, ...)                                                                                               \
    do {                                                                                                               \
        const char *const words[] = {__VA_ARGS__};                                                                     \
        check_status(CALL, CW_ERROR_ARGUMENT);                                                                         \
        for (size_t w_ = 0; w_ < sizeof words / sizeof *words; w_++)                                                   \
            check(strstr(cw_last_error(), words[w_]) != NULL, "\"%s\" lacks \"%s\"", cw_last_error(), words[w_]);      \
    } while (0)

static void wrong_calls_are_told(void **state) {
    (void)state;
    static float to[SAMPLES];
    static uint8_t lit[SAMPLES];
    const cw_area all = {0};
    make(false);
    cw_terrain *t = NULL;
    cw_field *coarser = NULL;
    const cw_observer from = observer();
    cw_observer o = from;
    WRONG(cw_terrain_create(NULL, NULL, &t), "desc", "NULL");
    WRONG(cw_terrain_create(&(cw_terrain_desc){0}, NULL, &t), "field", "NULL");
    WRONG(cw_terrain_create(&(cw_terrain_desc){.field = field}, NULL, NULL), "terrain", "NULL");
    WRONG(cw_terrain_create(&(cw_terrain_desc){.field = field, .geographic = 2}, NULL, &t), "geographic", "2", "1");
    WRONG(cw_terrain_create(&(cw_terrain_desc){.field = field, .unit = -1}, NULL, &t), "unit", "-1");
    WRONG(cw_terrain_create(&(cw_terrain_desc){.field = field, .zero = 1}, NULL, &t), "cw_terrain_desc", "reserved");
    WRONG(cw_terrain_create(&(cw_terrain_desc){.field = field, .reserved = {[7] = 1}}, NULL, &t), "reserved");
    assert_null(t);
    WRONG(cw_shadow(NULL, NULL, &(cw_light){0}, all, lit), "terrain", "NULL");
    WRONG(cw_shadow(land, NULL, NULL, all, lit), "light", "NULL");
    WRONG(cw_shadow(land, NULL, &(cw_light){0}, all, NULL), "lit", "NULL");
    WRONG(cw_shadow(land, NULL, &(cw_light){.altitude = 91}, all, lit), "altitude", "91", "90");
    WRONG(cw_shadow(land, NULL, &(cw_light){.azimuth = NAN}, all, lit), "azimuth", "nan");
    WRONG(cw_sunlight(land, NULL, &(cw_light){.radius = 11}, all, to), "radius", "11", "10");
    WRONG(cw_sunlight(land, NULL, &(cw_light){.strips = 65}, all, to), "strips", "65", "64");
    WRONG(cw_sunlight(land, NULL, &(cw_light){.curvature = -1}, all, to), "curvature", "-1");
    WRONG(cw_sunlight(land, NULL, &(cw_light){0}, (cw_area){{1, 0, NX, 1}, 0}, to), "area", "61 x 1");
    WRONG(cw_sunlight(land, NULL, &(cw_light){0}, (cw_area){{0, 0, NX, 1}, 60}, to), "stride", "60", "61");
    WRONG(cw_horizon_angles(land, NULL, &(cw_horizon){0}, 32, all, to, NULL), "number", "32", "31");
    WRONG(cw_horizon_angles(land, NULL, &(cw_horizon){0}, 0, all, NULL, NULL), "degrees", "NULL");
    WRONG(cw_sky_view(land, NULL, &(cw_horizon){.count = 3601}, all, to), "count", "3601", "3600");
    WRONG(cw_sky_view(land, NULL, &(cw_horizon){.flags = 4}, all, to), "flags", "4", "3");
    WRONG(cw_horizon_azimuths(land, &(cw_horizon){0}, NULL), "azimuths", "NULL");
    WRONG(cw_viewshed(land, NULL, &from, all, NULL), "view", "NULL");
    o.limits = 4;
    WRONG(cw_viewshed(land, NULL, &o, all, &(cw_view){.angle = to}), "limits", "4", "3");
    o = from, o.height = -1;
    WRONG(cw_viewshed(land, NULL, &o, all, &(cw_view){.angle = to}), "height", "under the ground");
    o = from, o.x = 1e4;
    WRONG(cw_viewshed(land, NULL, &o, all, &(cw_view){.angle = to}), "x, y", "no ground");
    o = from, o.x = 1e12;
    WRONG(cw_viewshed(land, NULL, &o, all, &(cw_view){.angle = to}), "x, y", "too far");
    const struct {
        uint32_t limits;
        double nearest, farthest, azimuth, verticals[2];
    } wrong[] = {{.nearest = -1},
                 {.farthest = NAN},
                 {CW_OBSERVER_AZIMUTHS, .azimuth = INFINITY},
                 {CW_OBSERVER_VERTICALS, .verticals = {1, 0}},
                 {CW_OBSERVER_VERTICALS, .verticals = {-91, 0}}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        o = from, o.limits = wrong[k].limits, o.nearest = wrong[k].nearest, o.farthest = wrong[k].farthest;
        o.azimuths[1] = wrong[k].azimuth, o.verticals[0] = wrong[k].verticals[0],
        o.verticals[1] = wrong[k].verticals[1];
        WRONG(cw_viewshed(land, NULL, &o, all, &(cw_view){.angle = to}), "nearest", "verticals", "out of range");
    }
    WRONG(cw_viewshed(land, NULL, &from, all, &(cw_view){.angle = to, .weight = NAN}), "weight", "nan");
    WRONG(cw_lines_of_sight(land, NULL, -1, NULL, 0, NULL), "curvature", "-1", "1e+09");
    WRONG(cw_lines_of_sight(land, NULL, 0, NULL, 1, NULL), "lines", "NULL");
    WRONG(cw_lines_of_sight(land, NULL, 0, &(cw_sight){.absolute = 4}, 1, &(cw_sight_answer){0}), "absolute", "4");
    WRONG(cw_visibility(land, NULL, &(cw_visibility_desc){.directions = 3601}, all, &(cw_visibility_answers){0}),
          "directions", "3601", "3600");
    WRONG(cw_visibility(land, NULL, &(cw_visibility_desc){.height = -1}, all, &(cw_visibility_answers){0}), "height");
    WRONG(cw_visibility(land, NULL, &(cw_visibility_desc){0}, all, NULL), "answers", "NULL");
    WRONG(cw_field_coarser(field, NULL, 1, 0, &coarser, NULL, 0), "factor", "1", "2");
    WRONG(cw_field_coarser(field, NULL, 2, 3, &coarser, NULL, 0), "filter", "3", "2");
    WRONG(cw_field_coarser(field, NULL, (size_t)CW_SIDE_MAX + 1, 0, &coarser, NULL, 0), "factor", "8388609");
    WRONG(cw_field_coarser(field, &(cw_run){.reserved = {1}}, 2, 0, &coarser, NULL, 0), "cw_run");
    assert_null(coarser);
    /* Nothing to do is no error. */
    check_status(cw_lines_of_sight(land, NULL, 0, NULL, 0, NULL), CW_OK);
    check_status(cw_shadow(land, NULL, &(cw_light){0}, (cw_area){{3, 3, 0, 2}, 0}, NULL), CW_OK);
    cw_terrain_destroy(NULL);
    destroy();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_have_the_bits_of_the_whole),
        cmocka_unit_test(watches_see_shares_and_end_products),
        cmocka_unit_test(outputs_go_together),
        cmocka_unit_test(wrong_calls_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
