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

/* Without a light that is 0, which would be asked for in vain. */
static void add_lights(scene *s, const landscape_desc *d) {
    const transform *object = &s->heightfields[0].to_world;
    if (d->sun_light > 0) s->lights[s->light_count++] = distant_light(object, d->sun, d->sun_light);
    if (d->sky_light > 0) s->lights[s->light_count++] = distant_light(object, (const double[3]){0, 0, 1}, d->sky_light);
}

scene *landscape_create(const landscape_desc *d, io_error *error) {
    scene *s = calloc(1, sizeof *s);
    bool good = s != NULL && allocate(s) && (s->textures[0] = texture_new()) != NULL;
    if (good) s->texture_count = 1;
    if (!good || !texture_fill(s->textures[0], d->colours)) {
        scene_free(s);
        io_fail(error, "out of memory");
        return NULL;
    }
    s->width = d->width;
    s->height = d->height;
    s->samples = d->samples_a_pixel;
    s->field_of_view = d->field_of_view;
    s->camera_to_world = camera_at(d->eye, d->target);
    heightfield *h = &s->heightfields[0];
    *h = (heightfield){.field = d->field, .samples = d->samples, .nx = d->nx, .ny = d->ny, .borrowed = true};
    h->surface = (material){.kind = MATTE, .colour = {1, 1, 1}, .image = s->textures[0]};
    s->heightfield_count = 1;
    transform cells = transform_identity();
    cells.m[0][0] = (double)(d->nx - 1);
    cells.m[1][1] = (double)(d->ny - 1);
    transform world;
    memcpy(world.m, d->to_world, sizeof world.m);
    h->to_world = transform_multiply(&world, &cells);
    add_lights(s, d);
    for (int c = 0; c < 3; c++) {
        s->sky->up[c] = (float)s->camera_to_world.m[2][c];
        s->sky->horizon[c] = d->horizon[c];
        s->sky->above[c] = d->above[c];
    }
    return s;
}
