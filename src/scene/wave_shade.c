/* SPDX-License-Identifier: Apache-2.0 */
/* What a path's end sends on: light by way of a shadow ray, or a mirrored path. Only what the material, the options and the
 * scene ask for is computed. */

#include "float3.h"
#include "wave.h"

#include <string.h>

static const float one_by_pi = 0.318309886f;

/* A path's end while it is shaded. */
typedef struct ending {
    const cw_user_ray *ray;
    const wave_path *path;
    const ray_spread *spread; /* of a mirrored path in a scene with textures */
    const heightfield *field; /* one of these two is NULL */
    const cylinder *cylinder;
    const cw_hit *hit; /* on the field */
    float dir[3];
    surface at;
} ending;

/* The changes of the point from one sample to the next. */
static void point_change(const wave *w, const ending *e, ray_spread *spread, float change[2][3]) {
    if (e->spread != NULL)
        *spread = *e->spread;
    else
        camera_spread(&w->camera, e->dir, spread);
    spread_on_plane(spread, e->dir, (float)e->ray->tmax, e->at.normal, change);
}

static void reflectance(const wave *w, const ending *e, const material *m, float colour[3]) {
    if (m->image == NULL) {
        memcpy(colour, m->colour, sizeof m->colour);
        return;
    }
    ray_spread spread;
    float change[2][3], uv[2], uv_change[2][2];
    point_change(w, e, &spread, change);
    if (e->field != NULL) {
        surface_uv_of_field(e->field, e->hit, uv);
        surface_uv_change_on_field(e->field, change, uv_change);
    } else {
        surface_uv_of_cylinder(&e->at, uv);
        surface_uv_change_on_cylinder(e->cylinder, &e->at, change, uv_change);
    }
    texture_lookup(m->image, uv, uv_change[0], uv_change[1], colour);
    for (int c = 0; c < 3; c++) colour[c] = colour[c] > 0 ? colour[c] : 0;
}

/* Queues a shadow ray towards each light whose light would count (Lambert's law, Kd / pi). */
static void shade_matte(wave *w, const ending *e, const material *m) {
    const surface *at = &e->at;
    float kd[3];
    bool kd_known = false;
    const float facing = float3_dot(e->dir, at->normal);
    for (size_t l = 0; l < w->scene->light_count; l++) {
        const point_light *light = &w->scene->lights[l];
        double way[3];
        float to[3];
        for (int c = 0; c < 3; c++) way[c] = light->position[c] - at->point[c];
        float3_from(way, to);
        /* Eye and light must be on the same side of the flat surface. */
        if (!(float3_dot(to, at->normal) * facing < 0)) continue;
        const float near = 1 / sqrtf(float3_dot(to, to));
        const float share = fabsf(float3_dot(to, at->shading)) * near * near * near * one_by_pi;
        if (!(share > 0)) continue;
        if (!kd_known) reflectance(w, e, m, kd);
        kd_known = true;
        float arriving[3];
        for (int c = 0; c < 3; c++) arriving[c] = e->path->throughput[c] * kd[c] * light->intensity[c] * share;
        if (arriving[0] == 0 && arriving[1] == 0 && arriving[2] == 0) continue;

        if (w->shadow_count == SCENE_BATCH) wave_trace_shadows(w);
        w->shadows[w->shadow_count] =
            (wave_shadow){.light = {arriving[0], arriving[1], arriving[2]}, .pixel = e->path->pixel};
        /* t = 1 is the light. */
        w->shadow_rays[w->shadow_count++] = (cw_user_ray){.org = {at->point[0], at->point[1], at->point[2]},
                                                          .tmin = at->offset * (double)near,
                                                          .dir = {way[0], way[1], way[2]},
                                                          .tmax = 1};
    }
}

/* Appends the mirrored path to the next wave. */
static void shade_mirror(wave *w, const ending *e, const material *m, float turn[2][3], int next) {
    const surface *at = &e->at;
    const size_t k = w->count[next];
    wave_path *out = &w->paths[next][k];
    for (int c = 0; c < 3; c++) out->throughput[c] = e->path->throughput[c] * m->colour[c];
    if (out->throughput[0] == 0 && out->throughput[1] == 0 && out->throughput[2] == 0) return;
    out->pixel = e->path->pixel;
    const float along = float3_dot(e->dir, at->shading);
    float dir[3];
    for (int c = 0; c < 3; c++) dir[c] = e->dir[c] - 2 * along * at->shading[c];
    w->rays[next][k] = (cw_user_ray){.org = {at->point[0], at->point[1], at->point[2]},
                                     .tmin = at->offset,
                                     .dir = {(double)dir[0], (double)dir[1], (double)dir[2]},
                                     .tmax = INFINITY};
    if (turn != NULL) {
        ray_spread spread;
        float change[2][3];
        point_change(w, e, &spread, change);
        float uv_change[2][2], normal_change[2][3] = {{0}};
        if (e->field != NULL && w->phong) {
            surface_uv_change_on_field(e->field, change, uv_change);
            for (int i = 0; i < 2; i++)
                for (int c = 0; c < 3; c++)
                    normal_change[i][c] = uv_change[i][0] * turn[0][c] + uv_change[i][1] * turn[1][c];
        }
        spread_reflect(&spread, e->dir, at->shading, change, normal_change, &w->spreads[next][k]);
    }
    w->count[next]++;
    w->stats.mirror_rays++;
}

void wave_shade(wave *w, int current, int bounce, bool last) {
    const scene *s = w->scene;
    const int next = 1 - current;
    w->count[next] = 0;
    for (size_t k = 0; k < w->count[current]; k++) {
        if (w->shape[k] == WAVE_MISS) continue;
        const size_t shape = (size_t)w->shape[k];
        const bool on_field = shape < s->heightfield_count;
        ending e; /* without an initialiser, which would clear the surface for every path */
        e.ray = &w->rays[current][k];
        e.path = &w->paths[current][k];
        e.spread = s->textured && bounce > 0 ? &w->spreads[current][k] : NULL;
        e.field = on_field ? &s->heightfields[shape] : NULL;
        e.cylinder = on_field ? NULL : &s->cylinders[shape - s->heightfield_count];
        e.hit = &w->hits[k];
        const material *m = on_field ? &e.field->surface : &e.cylinder->surface;
        if (m->kind == MIRROR ? last : s->light_count == 0) continue;
        float3_from(e.ray->dir, e.dir);
        float turn[2][3];
        const bool spreads = m->kind == MIRROR && s->textured;
        if (on_field)
            surface_of_field(e.field, e.hit, w->phong, &e.at, spreads ? turn : NULL);
        else
            surface_of_cylinder(e.cylinder, e.ray, e.ray->tmax, &e.at);
        if (m->kind == MIRROR)
            shade_mirror(w, &e, m, spreads ? turn : NULL, next);
        else
            shade_matte(w, &e, m);
    }
}
