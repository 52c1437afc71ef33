/* SPDX-License-Identifier: Apache-2.0 */
#include "calls.h"

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <string.h>

enum { RAYS = 6000, LINES = 300, SAMPLES = 256 * 256 };

static cw_field_desc desc;
static cw_field *field;
static cw_terrain *terrain;
static cw_area part;
static cw_ray rays[RAYS], moved[RAYS];
static cw_user_ray user_rays[RAYS];
static struct answers {
    cw_hit hits[RAYS];
    uint8_t bytes[SAMPLES];
    uint16_t seen[SAMPLES];
    float numbers[SAMPLES], others[SAMPLES], more[SAMPLES];
    double points[RAYS][3], sums[SAMPLES];
} to;
static cw_hit found[RAYS];

cw_field *calls_begin(const test_field *f, const cw_allocator *allocator) {
    random_state r = {3};
    desc = (cw_field_desc){.samples = f->z, .nx = f->nx, .ny = f->ny, .allocator = allocator};
    part = (cw_area){.at = {f->nx / 3, f->ny / 3, f->nx / 3, f->ny / 4}};
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_terrain_create(&(cw_terrain_desc){.field = field}, NULL, &terrain), CW_OK);
    for (size_t k = 0; k < RAYS; k++) {
        rays[k] = ray_make((ray_class)(k % RAY_CLASSES), f, &r);
        user_rays[k] = ray_for_user(&rays[k]);
    }
    check_status(cw_closest(field, NULL, rays, RAYS, found), CW_OK);
    return field;
}

void calls_end(void) {
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
}

uint64_t calls_sum(void) { /* FNV-1a by words */
    uint64_t sum = 0xcbf29ce484222325, word;
    const char *at = (const char *)&to;
    for (size_t k = 0; k < sizeof to / sizeof word; k++) {
        memcpy(&word, at + k * sizeof word, sizeof word);
        sum = (sum ^ word) * 0x100000001b3;
    }
    memset(&to, 0xa5, sizeof to);
    return sum;
}

static cw_status closest(const cw_run *run) {
    cw_status s;
    (void)((s = cw_closest(field, run, rays, RAYS, to.hits)) ||
           (s = cw_closest_user(field, run, user_rays, RAYS, to.hits)));
    return s;
}
static cw_status occluded(const cw_run *run) {
    cw_status s;
    (void)((s = cw_occluded(field, run, rays, RAYS, to.bytes)) ||
           (s = cw_occluded_user(field, run, user_rays, RAYS, to.bytes)));
    return s;
}
static cw_status make_field(const cw_run *run) {
    cw_status s = CW_OK;
    for (int storage = CW_COPY; storage <= CW_BORROW && s == CW_OK; storage++) {
        cw_field_desc d = desc;
        cw_field *other;
        d.storage = (cw_storage)storage;
        s = cw_field_create(&d, run, &other);
        check((other != NULL) == (s == CW_OK), "a field with status %d", (int)s);
        cw_field_destroy(other);
    }
    return s;
}
static cw_status update_by(const cw_run *run, cw_rectangle at, uint32_t wait) {
    const cw_update change = {
        .at = at, .samples = desc.samples + at.j * desc.nx + at.i, .stride = desc.nx, .wait = wait};
    return cw_field_update(field, run, &change);
}
static cw_status update(const cw_run *run) { return update_by(run, (cw_rectangle){3, 5, desc.nx / 2, desc.ny / 2}, 0); }
static cw_status update_waiting(const cw_run *run) { return update_by(run, (cw_rectangle){3, 5, 2, 1}, 1); }
static cw_status move_field(const cw_run *run) {
    return cw_field_move(field, (const double[3][4]){{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, 1);
}
static cw_status be_refused(const cw_run *run) {
    const cw_status wrong[] = {
        cw_closest(NULL, run, rays, 1, to.hits),
        cw_field_update(field, run, &(cw_update){.at = {0, 0, desc.nx + 1, 1}, .samples = desc.samples})};
    return wrong[0] == CW_ERROR_ARGUMENT && wrong[1] == wrong[0] && cw_last_error()[0] ? CW_OK : CW_ERROR_ARGUMENT;
}
static cw_status places_of(const cw_run *run, size_t n) {
    cw_status s;
    (void)((s = cw_surface_at_user(field, run, to.points[0], n, to.hits)) ||
           (s = cw_surface_at(field, run, to.points[0], n, to.hits)) ||
           (s = cw_hit_points(field, run, found, n, to.points[0])) ||
           (s = cw_hit_normals(field, run, found, n, to.points[0])) ||
           (s = cw_hit_phong_normals(field, run, found, n, to.points[0])));
    return s;
}
static cw_status places(const cw_run *run) { return places_of(run, RAYS); }
static cw_status one_place(const cw_run *run) { return places_of(run, 1); }
static cw_status move_rays(const cw_run *run) { return cw_rays_to_field(field, run, user_rays, RAYS, moved); }
static cw_status heading(const cw_run *run) {
    cw_heading *h;
    cw_status status = cw_heading_create(field, &(cw_heading_desc){.dir = {0.3, 1}}, &h);
    const cw_rectangle at = {0, 7, desc.nx, desc.ny - 7};
    if (status == CW_OK) status = cw_heading_steepest(h, run, -INFINITY, INFINITY, at, to.numbers);
    if (status == CW_OK) status = cw_heading_occluded(h, run, 0.1f, at, to.bytes);
    cw_heading_destroy(h);
    return status;
}
static cw_status coarser(const cw_run *run) {
    cw_status status = CW_OK;
    for (int32_t filter = CW_FILTER_MEAN; filter <= CW_FILTER_LOWEST && status == CW_OK; filter++) {
        cw_field *other;
        cw_difference difference;
        status = cw_field_coarser(field, run, 3, filter, &other, &difference, sizeof difference);
        check((other != NULL) == (status == CW_OK), "a coarser field with status %d", (int)status);
        cw_field_destroy(other);
    }
    return status;
}
static cw_status make_terrain(const cw_run *run) {
    static double scale[CW_SCALE_ROWS * CW_SCALE_COLUMNS][2];
    for (size_t k = 0; k < CW_SCALE_ROWS * CW_SCALE_COLUMNS; k++) scale[k][0] = scale[k][1] = 1;
    cw_terrain *other;
    const cw_status status = cw_terrain_create(&(cw_terrain_desc){.field = field, .scale = scale[0]}, run, &other);
    cw_terrain_destroy(other);
    return status;
}
static cw_status shadow(const cw_run *run) {
    return cw_shadow(terrain, run, &(cw_light){.azimuth = 200, .altitude = 15}, part, to.bytes);
}
static cw_status sunlight(const cw_run *run) {
    const cw_light sun = {.azimuth = 200, .altitude = 15, .radius = 1, .hillshade = 1};
    return cw_sunlight(terrain, run, &sun, part, to.numbers);
}
static cw_status horizons(const cw_run *run) {
    static double azimuths[3600];
    const cw_horizon all = {.curvature = 1, .count = 3600}, some = {.count = 12, .flags = CW_HORIZON_TILTED},
                     below = {.count = 12, .flags = CW_HORIZON_BELOW};
    cw_status s;
    (void)((s = cw_horizon_azimuths(terrain, &all, azimuths)) ||
           (s = cw_horizon_angles(terrain, run, &all, 5, part, to.numbers, to.others)) ||
           (s = cw_sky_view(terrain, run, &some, part, to.numbers)) ||
           (s = cw_sky_view(terrain, run, &(cw_horizon){.count = 3}, part, to.numbers)) ||
           (s = cw_openness(terrain, run, &below, part, to.numbers)));
    return s;
}
static cw_status viewshed(const cw_run *run) {
    const cw_observer from = {.x = 0.4 * (double)desc.nx,
                              .y = 0.5 * (double)desc.ny,
                              .height = 3,
                              .target = 1,
                              .curvature = 1,
                              .limits = CW_OBSERVER_AZIMUTHS,
                              .azimuths = {10, 300}};
    cw_status s;
    (void)((s = cw_viewshed(terrain, run, &from, (cw_area){0},
                            &(cw_view){.seen = to.seen, .sum = to.sums, .needed = to.others})) ||
           (s = cw_viewshed(terrain, run, &from, (cw_area){0}, &(cw_view){.angle = to.numbers})) ||
           (s = cw_viewshed(terrain, run, &(cw_observer){.x = 5, .y = 5, .height = 1}, (cw_area){0},
                            &(cw_view){.seen = to.seen})));
    return s;
}
static cw_status lines(const cw_run *run) {
    static cw_sight all[LINES];
    static cw_sight_answer answers[LINES];
    const double last = (double)(desc.nx - 1);
    for (size_t k = 0; k < LINES; k++)
        all[k] = (cw_sight){.from = {1, (double)(k % desc.ny), 2}, .to = {last, (double)(k * 7 % desc.ny), 2}};
    cw_status s;
    (void)((s = cw_lines_of_sight(terrain, run, 1, all, LINES, answers)) ||
           (s = cw_lines_of_sight(terrain, run, 0, all, LINES, answers)));
    return s;
}
static cw_status visibility(const cw_run *run) {
    static float azimuth[SAMPLES];
    const cw_visibility_answers all = {.area = to.numbers, .share = to.others, .farthest = to.more, .azimuth = azimuth};
    cw_status s;
    (void)((s = cw_visibility(terrain, run, &(cw_visibility_desc){.directions = 9, .height = 2, .every = 3}, part,
                              &all)) ||
           (s = cw_visibility(terrain, run, &(cw_visibility_desc){.directions = 3}, (cw_area){0},
                              &(cw_visibility_answers){.share = to.numbers, .farthest = to.others})));
    return s;
}

const every_call every_calls[] = {
    {"closest hits", STACK_FOR_ALL, closest, false, false},
    {"any hits", STACK_FOR_ALL, occluded, false, false},
    {"cw_field_create", STACK_FOR_ALL, make_field, false, true},
    {"cw_field_update", STACK_FOR_ALL, update, true, false},
    {"cw_field_update waiting", STACK_FOR_ALL, update_waiting, true, false},
    {"cw_field_move", STACK_FOR_ALL, move_field, true, false},
    {"errors", STACK_FOR_FEW, be_refused, true, false},
    {"places, points and normals", STACK_FOR_ALL, places, false, false},
    {"one place, point and normal", STACK_FOR_FEW, one_place, true, false},
    {"cw_rays_to_field", STACK_FOR_ALL, move_rays, false, false},
    {"a heading", STACK_FOR_ALL, heading, false, true},
    {"cw_field_coarser", STACK_FOR_TERRAIN, coarser, false, true},
    {"cw_terrain_create", STACK_FOR_TERRAIN, make_terrain, true, true},
    {"cw_shadow", STACK_FOR_TERRAIN, shadow, true, true},
    {"cw_sunlight", STACK_FOR_TERRAIN, sunlight, true, true},
    {"horizons", STACK_FOR_TERRAIN, horizons, true, true},
    {"cw_viewshed", STACK_FOR_TERRAIN, viewshed, true, true},
    {"cw_lines_of_sight", STACK_FOR_TERRAIN, lines, true, true},
    {"cw_visibility", STACK_FOR_TERRAIN, visibility, true, true},
};
const size_t every_calls_count = sizeof every_calls / sizeof *every_calls;
