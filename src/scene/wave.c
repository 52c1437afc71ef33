/* SPDX-License-Identifier: Apache-2.0 */
#include "wave.h"

#include "pattern.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Mirrors behind the first hit that a path may meet. */
enum { BOUNCES = 4 };

/* The way through the picture's upper left corner, and how it changes from pixel to pixel along x and along y. */
static void aim_camera(wave *w) {
    const scene *s = w->scene;
    const double width = (double)s->width, height = (double)s->height;
    const double reach = tan(s->field_of_view * (acos(-1) / 360)) / fmin(width, height);
    const transform *camera = &s->camera_to_world;
    transform_vector(camera, (double[3]){-width * reach, height * reach, 1}, w->corner);
    transform_vector(camera, (double[3]){2 * reach, 0, 0}, w->along[0]);
    transform_vector(camera, (double[3]){0, -2 * reach, 0}, w->along[1]);
}

wave *wave_create(const scene *s, const scene_tracer *tracer, const scene_render_options *options, unsigned samples) {
    wave *w = calloc(1, sizeof *w);
    if (w == NULL) return NULL;
    w->scene = s;
    w->tracer = tracer;
    w->cancel = options->cancel;
    w->phong = options->phong;
    w->samples = samples;
    w->sample_distance = 1 / sqrt((double)samples);
    aim_camera(w);
    for (int k = 0; s->textured && k < 2; k++) {
        w->spreads[k] = malloc(SCENE_BATCH * sizeof *w->spreads[k]);
        if (w->spreads[k] != NULL) continue;
        wave_free(w);
        return NULL;
    }
    return w;
}

void wave_free(wave *w) {
    if (w == NULL) return;
    free(w->spreads[0]);
    free(w->spreads[1]);
    free(w);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- tracing ------------------------------------------------------------------------------------------------------ */

/* Finds where each path of the wave ends. */
static void trace_paths(wave *w, const wave_path *paths, size_t n) {
    const scene *s = w->scene;
    for (size_t k = 0; k < n; k++) {
        cw_user_ray *ray = &w->user[k];
        memcpy(ray->org, paths[k].org, sizeof ray->org);
        memcpy(ray->dir, paths[k].dir, sizeof ray->dir);
        ray->tmin = paths[k].tmin;
        ray->tmax = INFINITY;
        w->ends[k].shape = WAVE_MISS;
    }
    for (size_t f = 0; f < s->heightfield_count; f++) {
        cw_rays_to_field(s->heightfields[f].field, w->user, n, w->rays);
        const double start = now();
        w->tracer->closest(w->tracer->context, f, w->rays, n, w->hits);
        w->stats.trace_seconds += now() - start;
        w->stats.field_queries += n;
        for (size_t k = 0; k < n; k++) {
            if (!((double)w->hits[k].t < w->user[k].tmax)) continue;
            w->user[k].tmax = (double)w->hits[k].t;
            w->ends[k] = (wave_end){.shape = WAVE_FIELD, .number = (uint32_t)f, .hit = w->hits[k]};
        }
    }
    for (size_t c = 0; c < s->cylinder_count; c++)
        for (size_t k = 0; k < n; k++) {
            cw_user_ray *ray = &w->user[k];
            const double t = cylinder_hit(&s->cylinders[c], ray->org, ray->dir, ray->tmin, ray->tmax);
            if (!(t < ray->tmax)) continue;
            ray->tmax = t;
            w->ends[k] = (wave_end){.shape = WAVE_CYLINDER, .number = (uint32_t)c};
        }
}

/* Traces the shadow rays that have come together and adds the light that gets through. */
static void trace_shadows(wave *w) {
    const scene *s = w->scene;
    const size_t n = w->shadow_count;
    if (n == 0) return;
    memset(w->hidden, 0, n);
    for (size_t f = 0; f < s->heightfield_count; f++) {
        cw_rays_to_field(s->heightfields[f].field, w->shadow_rays, n, w->rays);
        const double start = now();
        w->tracer->any(w->tracer->context, f, w->rays, n, w->occluded);
        w->stats.trace_seconds += now() - start;
        w->stats.field_queries += n;
        for (size_t k = 0; k < n; k++) w->hidden[k] |= w->occluded[k];
    }
    for (size_t k = 0; k < n; k++) {
        const cw_user_ray *ray = &w->shadow_rays[k];
        for (size_t c = 0; c < s->cylinder_count && !w->hidden[k]; c++)
            w->hidden[k] = cylinder_hit(&s->cylinders[c], ray->org, ray->dir, ray->tmin, ray->tmax) < INFINITY;
        if (w->hidden[k]) continue;
        double *sum = w->sum[w->shadows[k].pixel];
        for (int c = 0; c < 3; c++) sum[c] += (double)w->shadows[k].light[c];
    }
    w->stats.shadow_rays += n;
    w->shadow_count = 0;
}

/* ---- shading ------------------------------------------------------------------------------------------------------ */

/* A path's hit while it is shaded. */
typedef struct context {
    const wave_path *path;
    const ray_spread *spread; /* NULL in a scene without textures */
    const wave_end *end;
    surface at;
} context;

static void reflectance(const wave *w, const context *h, float colour[3]) {
    const material *m = h->at.material;
    if (m->image == NULL) {
        memcpy(colour, m->colour, sizeof m->colour);
        return;
    }
    double change[2][3], uv[2], uv_change[2][2];
    surface_spread(&h->at, h->path->org, h->path->dir, h->spread, change);
    if (h->end->shape == WAVE_FIELD)
        surface_uv_of_field(&w->scene->heightfields[h->end->number], &h->end->hit, &h->at, change, uv, uv_change);
    else
        surface_uv_of_cylinder(&w->scene->cylinders[h->end->number], &h->at, change, uv, uv_change);
    texture_lookup(m->image, uv, uv_change[0], uv_change[1], colour);
    for (int c = 0; c < 3; c++) colour[c] = colour[c] > 0 ? colour[c] : 0;
}

/* Queues a shadow ray towards each light whose light would count (Lambert's law, Kd / pi). */
static void shade_matte(wave *w, const context *h) {
    const surface *at = &h->at;
    float kd[3];
    bool kd_known = false;
    for (size_t l = 0; l < w->scene->light_count; l++) {
        const point_light *light = &w->scene->lights[l];
        double to[3];
        for (int c = 0; c < 3; c++) to[c] = light->position[c] - at->point[c];
        const double square = dot(to, to), distance = sqrt(square);
        for (int c = 0; c < 3; c++) to[c] /= distance;
        /* Eye and light must be on the same side of the flat surface. */
        if (!(dot(to, at->normal) * dot(h->path->dir, at->normal) < 0)) continue;
        const float share = (float)(fabs(dot(to, at->shading)) / (acos(-1) * square));
        if (!(share > 0)) continue;
        if (!kd_known) reflectance(w, h, kd);
        kd_known = true;
        float arriving[3];
        for (int c = 0; c < 3; c++) arriving[c] = h->path->throughput[c] * kd[c] * light->intensity[c] * share;
        if (arriving[0] == 0 && arriving[1] == 0 && arriving[2] == 0) continue;

        if (w->shadow_count == SCENE_BATCH) trace_shadows(w);
        cw_user_ray *ray = &w->shadow_rays[w->shadow_count];
        wave_shadow *shadow = &w->shadows[w->shadow_count++];
        memcpy(ray->org, at->point, sizeof ray->org);
        memcpy(ray->dir, to, sizeof ray->dir);
        ray->tmin = at->offset;
        ray->tmax = distance;
        memcpy(shadow->light, arriving, sizeof arriving);
        shadow->pixel = h->path->pixel;
    }
}

/* How the reflected rays of neighbouring samples spread: the reflection's derivative. */
static void reflect_spread(const wave *w, const context *h, ray_spread *out) {
    const surface *at = &h->at;
    const double *n = at->shading, *dir = h->path->dir;
    double change[2][3], normal_change[2][3] = {{0}};
    surface_spread(at, h->path->org, dir, h->spread, change);
    if (w->phong && h->end->shape == WAVE_FIELD)
        surface_normal_change(&w->scene->heightfields[h->end->number], &h->end->hit, at, change, normal_change);
    for (int k = 0; k < 2; k++) {
        double turn[3];
        for (int c = 0; c < 3; c++) turn[c] = (double)h->spread->dir[k][c];
        const double along = dot(dir, n), along_change = dot(turn, n) + dot(dir, normal_change[k]);
        for (int c = 0; c < 3; c++) {
            out->org[k][c] = (float)change[k][c];
            out->dir[k][c] = (float)(turn[c] - 2 * (along * normal_change[k][c] + along_change * n[c]));
        }
    }
}

/* Appends the mirrored path to the next wave. */
static void shade_mirror(wave *w, const context *h, int next) {
    const surface *at = &h->at;
    wave_path *out = &w->paths[next][w->count[next]];
    const double along = dot(h->path->dir, at->shading);
    for (int c = 0; c < 3; c++) {
        out->org[c] = at->point[c];
        out->dir[c] = h->path->dir[c] - 2 * along * at->shading[c];
        out->throughput[c] = h->path->throughput[c] * at->material->colour[c];
    }
    normalise(out->dir); /* rounding would add up over bounces, and t counts in lengths of dir */
    if (out->throughput[0] == 0 && out->throughput[1] == 0 && out->throughput[2] == 0) return;
    out->tmin = at->offset;
    out->pixel = h->path->pixel;
    if (h->spread != NULL) reflect_spread(w, h, &w->spreads[next][w->count[next]]);
    w->count[next]++;
    w->stats.mirror_rays++;
}

static void shade_paths(wave *w, int current, bool last) {
    const scene *s = w->scene;
    const int next = 1 - current;
    w->count[next] = 0;
    for (size_t k = 0; k < w->count[current]; k++) {
        context h = {.path = &w->paths[current][k], .end = &w->ends[k]};
        if (w->spreads[current] != NULL) h.spread = &w->spreads[current][k];
        if (h.end->shape == WAVE_MISS) continue;
        const material *m =
            h.end->shape == WAVE_FIELD ? &s->heightfields[h.end->number].surface : &s->cylinders[h.end->number].surface;
        if (m->kind == MIRROR ? last : s->light_count == 0) continue;
        if (h.end->shape == WAVE_FIELD)
            surface_of_field(&s->heightfields[h.end->number], &h.end->hit, w->phong, &h.at);
        else
            surface_of_cylinder(&s->cylinders[h.end->number], h.path->org, h.path->dir, w->user[k].tmax, &h.at);
        if (m->kind == MIRROR)
            shade_mirror(w, &h, next);
        else
            shade_matte(w, &h);
    }
}

/* ---- camera ------------------------------------------------------------------------------------------------------- */

static void camera_path(wave *w, size_t x, size_t y, unsigned sample, uint32_t pixel) {
    wave_path *path = &w->paths[0][w->count[0]];
    double place[2];
    pattern_sample((uint32_t)x, (uint32_t)y, sample, place);
    const double px = (double)x + place[0], py = (double)y + place[1];
    for (int c = 0; c < 3; c++) {
        path->org[c] = w->scene->camera_to_world.m[c][3];
        path->dir[c] = w->corner[c] + px * w->along[0][c] + py * w->along[1][c];
    }
    const double shorten = 1 / sqrt(dot(path->dir, path->dir));
    for (int c = 0; c < 3; c++) path->dir[c] *= shorten;
    path->tmin = 0;
    path->throughput[0] = path->throughput[1] = path->throughput[2] = 1;
    path->pixel = pixel;
    if (w->spreads[0] != NULL) {
        /* The derivative of the unit vector over a pixel, shortened to the mean distance between samples. */
        ray_spread *spread = &w->spreads[0][w->count[0]];
        for (int k = 0; k < 2; k++) {
            const double forward = dot(w->along[k], path->dir);
            for (int c = 0; c < 3; c++) {
                spread->org[k][c] = 0;
                spread->dir[k][c] = (float)((w->along[k][c] - forward * path->dir[c]) * shorten * w->sample_distance);
            }
        }
    }
    w->count[0]++;
}

/* Takes the paths of the first wave through all their bounces. */
static void run_waves(wave *w) {
    w->stats.camera_rays += w->count[0];
    int current = 0;
    for (int bounce = 0; w->count[current] > 0; bounce++) {
        trace_paths(w, w->paths[current], w->count[current]);
        shade_paths(w, current, bounce == BOUNCES);
        trace_shadows(w);
        current = 1 - current;
    }
    w->count[0] = 0;
}

bool wave_render_tile(wave *w, size_t x, size_t y, io_image *image) {
    enum { BLOCK = 4, PER_BLOCK = BLOCK * BLOCK, BLOCKS = WAVE_TILE / BLOCK };
    memset(w->sum, 0, sizeof w->sum);
    w->count[0] = w->count[1] = w->shadow_count = 0;
    /* Block by block, sample by sample, pixel by pixel: sixteen rays in a row look almost the same way. */
    for (uint32_t block = 0; block < BLOCKS * BLOCKS; block++)
        for (unsigned sample = 0; sample < w->samples; sample++)
            for (uint32_t k = 0; k < PER_BLOCK; k++) {
                const uint32_t tx = block % BLOCKS * BLOCK + k % BLOCK, ty = block / BLOCKS * BLOCK + k / BLOCK;
                if (x + tx >= image->width || y + ty >= image->height) continue;
                camera_path(w, x + tx, y + ty, sample, ty * WAVE_TILE + tx);
                if (w->count[0] < SCENE_BATCH) continue;
                if (w->cancel != NULL && atomic_load_explicit(w->cancel, memory_order_relaxed)) return false;
                run_waves(w);
            }
    if (w->cancel != NULL && atomic_load_explicit(w->cancel, memory_order_relaxed)) return false;
    run_waves(w);
    for (size_t ty = 0; ty < WAVE_TILE && y + ty < image->height; ty++)
        for (size_t tx = 0; tx < WAVE_TILE && x + tx < image->width; tx++)
            for (size_t c = 0; c < 3; c++) {
                const double light = w->sum[ty * WAVE_TILE + tx][c] / w->samples;
                image->rgb[((y + ty) * image->width + x + tx) * 3 + c] = light > 0 ? (float)light : 0;
            }
    return true;
}
