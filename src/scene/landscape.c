/* SPDX-License-Identifier: Apache-2.0 */
#include "landscape.h"

#include "model.h"

#include <stdlib.h>
#include <string.h>

/* Lights are points; from so many times the field's size away their rays are parallel to 6·10^-5 degrees. */
static const double far_away = 1e6;

static const double pi = 3.141592653589793;

/* A light in that direction from the middle of the field, whose light on a white surface across its rays comes out as
 * strength. */
static point_light distant_light(const transform *object, const double direction[3], double strength) {
    const double middle[3] = {0.5, 0.5, 0};
    double size = 0, distance;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 2; c++) size += object->m[r][c] * object->m[r][c];
    distance = far_away * sqrt(size);
    point_light light;
    transform_point(object, middle, light.position);
    for (int c = 0; c < 3; c++) {
        light.position[c] += distance * direction[c];
        light.intensity[c] = (float)(pi * strength * distance * distance);
    }
    return light;
}

/* The camera looks along +z, +y is up, +x to the right. */
static transform camera_at(const double eye[3], const double target[3]) {
    double forward[3], right[3], up[3];
    for (int c = 0; c < 3; c++) forward[c] = target[c] - eye[c];
    normalise(forward);
    const bool steep = hypot(forward[0], forward[1]) < 1e-9; /* straight down: north is up */
    cross(forward, steep ? (const double[3]){0, 1, 0} : (const double[3]){0, 0, 1}, right);
    normalise(right);
    cross(right, forward, up);
    transform t;
    for (int r = 0; r < 3; r++) {
        t.m[r][0] = right[r];
        t.m[r][1] = up[r];
        t.m[r][2] = forward[r];
        t.m[r][3] = eye[r];
    }
    return t;
}

static bool allocate(scene *s) {
    s->heightfields = calloc(1, sizeof *s->heightfields);
    s->lights = calloc(2, sizeof *s->lights);
    s->textures = calloc(1, sizeof(texture *));
    s->sky = calloc(1, sizeof *s->sky);
    return s->heightfields && s->lights && s->textures && s->sky;
}

/* Lights of strength 0 are left out: their shadow rays would change nothing. */
static void add_lights(scene *s, const landscape_desc *d) {
    const transform *object = &s->heightfields[0].to_world;
    if (d->sun_light > 0) s->lights[s->light_count++] = distant_light(object, d->sun, d->sun_light);
    if (d->sky_light > 0) s->lights[s->light_count++] = distant_light(object, (const double[3]){0, 0, 1}, d->sky_light);
}

/* The share 2^-(haze d) of light is left on a way of d: 2 % where d is the visibility (Koschmieder). */
static double haze_of(double visibility) { return log2(50) / visibility; }

/* Without haze the plain vanishes in the distance all the same, or the world would end at an edge: as in clear air,
 * which is so many of the field's sizes deep. */
static const double clear_air = 12;

static void add_sky(scene *s, const landscape_desc *d) {
    sky *to = s->sky;
    const cw_field_info info = cw_field_describe(d->field);
    double size = 0;
    for (int c = 0; c < 3; c++) {
        to->up[c] = (float)s->camera_to_world.m[2][c];
        to->horizon[c] = d->horizon[c];
        to->above[c] = d->above[c];
        to->plain[c] = d->plain[c];
        for (int r = 0; r < 3 && d->sun_light > 0; r++) to->sun[c] += (float)(s->camera_to_world.m[r][c] * d->sun[r]);
    }
    for (int r = 0; r < 2; r++)
        size += fabs(d->to_world[r][0]) * (double)(d->nx - 1) + fabs(d->to_world[r][1]) * (double)(d->ny - 1);
    if (d->visibility > 0) s->haze = (float)haze_of(d->visibility);
    to->vault = d->vault;
    if (!d->vault) return;
    const double plain = d->to_world[2][2] * (double)info.low + d->to_world[2][3], above = d->eye[2] - plain;
    to->eye_height = (float)fmax(above, 1e-6 * size);
    to->plain_haze = d->visibility > 0 ? s->haze : (float)haze_of(clear_air * size);
}

static bool add_water(scene *s, const landscape_desc *d) {
    /* Light from below the surface, which of all that comes in is little and blue-green. */
    static const double depth[3] = {0.02, 0.08, 0.11};
    const double light = d->sun_light * fmax(d->sun[2], 0) + d->sky_light;
    if (d->water_level == NULL) return true;
    if ((s->water = calloc(1, sizeof *s->water)) == NULL) return false;
    s->water->level = (float)*d->water_level;
    for (int c = 0; c < 3; c++) s->water->colour[c] = (float)(depth[c] * light);
    return true;
}

static void add_field(scene *s, const landscape_desc *d) {
    heightfield *h = &s->heightfields[s->heightfield_count++];
    *h = (heightfield){.field = d->field, .samples = d->samples, .nx = d->nx, .ny = d->ny, .borrowed = true};
    h->surface = (material){.kind = MATTE, .colour = {1, 1, 1}, .image = s->textures[0]};
    transform cells = transform_identity();
    cells.m[0][0] = (double)(d->nx - 1);
    cells.m[1][1] = (double)(d->ny - 1);
    transform world;
    memcpy(world.m, d->to_world, sizeof world.m);
    h->to_world = transform_multiply(&world, &cells);
}

/* Lights of land that is too large are infinite. */
static bool can_be_drawn(const scene *s, const landscape_desc *d) {
    transform world;
    memcpy(world.m, d->to_world, sizeof world.m);
    return transform_is_measurable(&world) && isfinite(s->lights[0].intensity[0] + s->lights[1].intensity[0]);
}

static scene *refuse(scene *s, const char *why, io_error *error) {
    scene_free(s);
    io_fail(error, "%s", why);
    return NULL;
}

scene *landscape_create(const landscape_desc *d, io_error *error) {
    scene *s = calloc(1, sizeof *s);
    bool good = s != NULL && allocate(s) && (s->textures[0] = calloc(1, sizeof(texture))) != NULL;
    if (good) s->texture_count = 1;
    if (!good || !add_water(s, d)) return refuse(s, "out of memory", error);
    add_field(s, d);
    add_lights(s, d);
    if (!can_be_drawn(s, d)) return refuse(s, "the land is too small or too large to be drawn", error);
    if (!texture_fill(s->textures[0], d->colours)) return refuse(s, "out of memory", error);
    s->textures[0]->clamps = true; /* one side of the land has nothing of the other's colour */
    s->width = d->width;
    s->height = d->height;
    s->samples = d->samples_a_pixel;
    s->field_of_view = d->field_of_view;
    s->camera_to_world = camera_at(d->eye, d->target);
    add_sky(s, d);
    return s;
}
