/* SPDX-License-Identifier: Apache-2.0 */
#include "plan.h"

#include <stdlib.h>

/* Rounding puts a point a little off its surface; a ray to or from it skips this share of the way that it came. A
 * triangle's is larger because a point within half a cell of the horizon may see neighbours at such distances. */
static const float field_offset = 1e-3f, cylinder_offset = 5e-4f;

static plan_space space_of(const transform *to_world) {
    plan_space s = {.to_world = *to_world};
    transform inverse;
    transform_invert(to_world, &inverse); /* the parser refuses singular transforms */
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) s.back[r][c] = inverse.m[r][c];
    return s;
}

static plan_space space_of_field(const heightfield *h) {
    transform cells = transform_identity();
    cells.m[0][0] = 1 / (double)(h->nx - 1);
    cells.m[1][1] = 1 / (double)(h->ny - 1);
    const transform to_world = transform_multiply(&h->to_world, &cells);
    return space_of(&to_world);
}

/* A space's origin, in the world. */
static void origin_of(const plan_space *s, double out[3]) {
    for (int r = 0; r < 3; r++) out[r] = s->to_world.m[r][3];
}

/* A point of the world; the translation goes first, so that points far from the world's origin lose no digits. */
static void into_space(const plan_space *s, const double point[3], double out[3]) {
    double from[3];
    for (int c = 0; c < 3; c++) from[c] = point[c] - s->to_world.m[c][3];
    for (int r = 0; r < 3; r++) out[r] = dot(s->back[r], from);
}

static plan_map map_between(const plan_space *from, const plan_space *to) {
    plan_map map;
    double begin[3], shift[3];
    origin_of(from, begin);
    into_space(to, begin, shift);
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            double sum = 0;
            for (int k = 0; k < 3; k++) sum += to->back[r][k] * from->to_world.m[k][c];
            map.m[r][c] = (float)sum;
        }
        map.m[r][3] = (float)shift[r];
    }
    return map;
}

plan_map plan_map_to(const plan *p, size_t shape, size_t home) {
    if (home == plan_home(shape)) return (plan_map){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return map_between(&p->spaces[home], &p->spaces[plan_home(shape)]);
}

static plan_metric products(double columns[3][3]) {
    static const int pair[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
    plan_metric m;
    for (int k = 0; k < 6; k++) m.g[k] = (float)dot(columns[pair[k][0]], columns[pair[k][1]]);
    return m;
}

static plan_metric metric_of(const plan_space *s) {
    double columns[3][3];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) columns[c][r] = s->to_world.m[r][c];
    return products(columns);
}

/* Whether any light comes from here. */
static bool sends(const material *m, size_t lights) {
    if (m->kind == MATTE) return lights > 0 && (m->image != NULL || m->colour[0] + m->colour[1] + m->colour[2] > 0);
    return m->colour[0] + m->colour[1] + m->colour[2] > 0;
}

static void describe_shape(plan_shape *shape, const plan *p, plan_space *s) {
    shape->metric = metric_of(s);
    shape->inverse = products(s->back);
    shape->sends = sends(shape->surface, p->light_count);
    if (shape->field != NULL) {
        const cw_field_info info = cw_field_describe(shape->field->field);
        const float high[3] = {(float)(info.nx - 1), (float)(info.ny - 1), info.high};
        for (int c = 0; c < 3; c++) {
            shape->low[c] = c < 2 ? 0 : info.low;
            shape->high[c] = high[c];
            if (c < 2) shape->uv_scale[c] = 1 / high[c];
        }
        shape->offset = field_offset;
    } else {
        for (int c = 0; c < 3; c++) {
            shape->low[c] = -1;
            shape->high[c] = 1;
        }
        shape->offset = cylinder_offset;
    }
}

void plan_light(const plan *p, size_t shape, size_t light, float place[3]) {
    double there[3];
    into_space(&p->spaces[plan_home(shape)], p->scene->lights[light].position, there);
    for (int c = 0; c < 3; c++) place[c] = (float)there[c];
}

/* ---- shapes that may hide a light -------------------------------------------------------------------------------- */

/* Margin, as a part of the radius, by which a point must lie within a cylinder to count as inside in spite of
 * rounding; the maps to it are in float. */
static const double inside_margin = 1e-4;

static bool is_inside(const plan_space *round, const double world[3]) {
    double at[3];
    into_space(round, world, at);
    return at[0] * at[0] + at[1] * at[1] < (1 - inside_margin) * (1 - inside_margin);
}

/* Whether a shape lies inside of a cylinder. */
static bool lies_within(const plan_shape *shape, const plan_space *own, const plan_space *round) {
    for (int corner = 0; corner < 8; corner++) {
        double at[3], world[3];
        for (int k = 0; k < 3; k++) at[k] = (double)(corner >> k & 1 ? shape->high[k] : shape->low[k]);
        transform_point(&own->to_world, at, world);
        if (!is_inside(round, world)) return false;
    }
    return true;
}

/* A cylinder's inside is convex: a segment with both ends in it stays there. */
bool plan_blocks(const plan *p, size_t light, size_t home, size_t behind) {
    const plan_space *round = &p->spaces[plan_home(behind)];
    if (!is_inside(round, p->scene->lights[light].position)) return true;
    return home != plan_home(behind) && (p->general || !lies_within(&p->shapes[home - 1], &p->spaces[home], round));
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

/* Mirrors and textures decide which values a path carries. */
static void find_features(plan *p) {
    bool textures = false;
    for (size_t k = 0; k < p->shape_count; k++) {
        const plan_shape *shape = &p->shapes[k];
        if (!shape->sends) continue;
        p->mirrors = p->mirrors || shape->surface->kind == MIRROR;
        textures = textures || shape->surface->image != NULL;
    }
    p->mirrors = p->mirrors || p->scene->water != NULL;
    p->spreads = p->mirrors && (textures || p->general);
}

/* Half of a pixel's side at depth 1. */
static double half_pixel(const plan *p) {
    return tan(p->scene->field_of_view * (acos(-1) / 360)) / fmin((double)p->width, (double)p->height);
}

static void place_camera(plan *p) {
    const double width = (double)p->width, height = (double)p->height, reach = half_pixel(p);
    const float between = (float)(2 * reach / sqrt(p->samples));
    p->camera_metric = metric_of(&p->spaces[PLAN_CAMERA]);
    p->pixel = 2 * reach;
    p->corner[0] = -width * reach;
    p->corner[1] = height * reach;
    for (size_t k = 0; k < p->shape_count; k++) {
        const plan_map map = plan_map_to(p, k, PLAN_CAMERA);
        for (int c = 0; c < 3; c++) {
            p->shapes[k].step[0][c] = map.m[c][0] * between;
            p->shapes[k].step[1][c] = -map.m[c][1] * between;
        }
    }
}

/* Rays that water mirrors begin in the first field's space. */
static void place_sky(plan *p) {
    const sky *s = p->scene->sky;
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            /* The camera's axes are orthogonal and one long. */
            double in_camera = 0;
            for (int k = 0; k < 3; k++)
                in_camera += p->spaces[PLAN_CAMERA].back[r][k] * p->spaces[plan_home(0)].to_world.m[k][c];
            p->up[c] += (float)((double)s->up[r] * in_camera);
            p->sun[c] += (float)((double)s->sun[r] * in_camera);
        }
}

static size_t given(size_t option, size_t otherwise) { return option > 0 ? option : otherwise; }

bool plan_make(plan *p, const scene *s, const scene_render_options *options) {
    *p = (plan){.scene = s,
                .width = given(options->width, s->width),
                .height = given(options->height, s->height),
                .samples = options->samples > 0 ? options->samples : s->samples,
                .seed = options->seed,
                .smooth = options->phong,
                .shape_count = s->heightfield_count + s->cylinder_count,
                .field_count = s->heightfield_count,
                .light_count = s->light_count,
                .general = options->general};
    p->shapes = calloc(p->shape_count + 1, sizeof *p->shapes);
    p->spaces = calloc(p->shape_count + 1, sizeof *p->spaces);
    if (p->shapes == NULL || p->spaces == NULL) {
        plan_free(p);
        return false;
    }
    p->spaces[PLAN_CAMERA] = space_of(&s->camera_to_world);
    for (size_t k = 0; k < p->shape_count; k++) {
        plan_shape *shape = &p->shapes[k];
        plan_space *own = &p->spaces[plan_home(k)];
        if (k < p->field_count) {
            shape->field = &s->heightfields[k];
            shape->surface = &shape->field->surface;
            *own = space_of_field(shape->field);
        } else {
            shape->surface = &s->cylinders[k - p->field_count].surface;
            *own = space_of(&s->cylinders[k - p->field_count].to_world);
        }
        describe_shape(shape, p, own);
    }
    find_features(p);
    place_camera(p);
    if (s->water != NULL) place_sky(p);
    return true;
}

void plan_free(plan *p) {
    free(p->shapes);
    free(p->spaces);
    *p = (plan){0};
}
