/* SPDX-License-Identifier: Apache-2.0 */
/* Threads take tiles of the picture in turn. A tile is rendered in the same way by any thread. */

#include "wave.h"

#include "cpus.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS_MAX = 1024 };

typedef struct render {
    plan plan;
    const scene_render_options *options;
    io_image *image;
    scene_crop region;
    wave_tile_fn *tile;
    size_t first_x, first_y, tiles_x, tiles; /* tiles are counted from (first_x, first_y), the first one's corner */
    atomic_size_t next;
    pthread_mutex_t lock; /* of done and progress */
    size_t done;
} render;

typedef struct worker {
    render *job;
    wave *wave;
    pthread_t thread;
} worker;

/* ---- the default tracer ------------------------------------------------------------------------------------------ */

typedef struct library {
    const scene *scene;
    cw_run query;
    atomic_int status; /* of a query that failed, though prepare had found nothing wrong with it */
} library;

static void library_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    library *l = context;
    const cw_status status = cw_closest(l->scene->heightfields[field].field, &l->query, rays, n, hits);
    if (status == CW_OK) return;
    atomic_store(&l->status, (int)status);
    for (size_t k = 0; k < n; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
}

static void library_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    library *l = context;
    const cw_status status = cw_occluded(l->scene->heightfields[field].field, &l->query, rays, n, occluded);
    if (status == CW_OK) return;
    atomic_store(&l->status, (int)status);
    memset(occluded, 0, n);
}

/* Builds the structures of the query's kernel and runs it on no rays, so that errors appear here. */
static bool prepare(const library *l, io_error *error) {
    for (size_t k = 0; k < l->scene->heightfield_count; k++) {
        cw_field *field = l->scene->heightfields[k].field;
        const cw_kernel *kernel = cw_run_kernel(field, &l->query);
        cw_status status = cw_field_build(field, &(cw_run){.expert.kernel = kernel});
        if (status == CW_OK) status = cw_closest(field, &l->query, NULL, 0, NULL);
        if (status == CW_OK) status = cw_occluded(field, &l->query, NULL, 0, NULL);
        if (status != CW_OK) return io_fail(error, "kernel %s: %s", cw_kernel_describe(kernel).name, cw_last_error());
    }
    return true;
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

static void report(render *r) {
    pthread_mutex_lock(&r->lock);
    r->done++;
    if (r->options->progress) r->options->progress(r->options->progress_context, (double)r->done / (double)r->tiles);
    pthread_mutex_unlock(&r->lock);
}

static void *work(void *context) {
    worker *me = context;
    render *r = me->job;
    for (;;) {
        const size_t tile = atomic_fetch_add(&r->next, 1);
        if (tile >= r->tiles) return NULL;
        const size_t x = r->first_x + tile % r->tiles_x * WAVE_TILE, y = r->first_y + tile / r->tiles_x * WAVE_TILE;
        r->tile(me->wave, x, y, &r->region, r->image);
        report(r);
    }
}

/* The calling thread is the first worker; where the system gives fewer threads than asked for, fewer do the work. */
static void run(worker *workers, unsigned count) {
    unsigned started = 1;
    while (started < count && pthread_create(&workers[started].thread, NULL, work, &workers[started]) == 0) started++;
    work(&workers[0]);
    for (unsigned k = 1; k < started; k++) pthread_join(workers[k].thread, NULL);
}

static void add_stats(scene_render_stats *sum, const wave *part) {
    sum->camera_rays += part->stats.camera_rays;
    sum->shadow_rays += part->stats.shadow_rays;
    sum->mirror_rays += part->stats.mirror_rays;
    sum->field_queries += part->stats.field_queries;
}

static bool render_with(render *r, const scene_tracer *tracer, unsigned threads, scene_render_stats *stats,
                        io_error *error) {
    worker *workers = calloc(threads, sizeof *workers);
    bool good = workers != NULL;
    for (unsigned k = 0; good && k < threads; k++) {
        workers[k].job = r;
        workers[k].wave = wave_create(&r->plan, tracer);
        good = workers[k].wave != NULL;
    }
    if (good) run(workers, threads);
    for (unsigned k = 0; workers != NULL && k < threads; k++) {
        if (good) add_stats(stats, workers[k].wave);
        wave_free(workers[k].wave);
    }
    free(workers);
    return good || io_fail(error, "out of memory");
}

/* The code for the widest instruction set that there is. The last tile is scalar. */
#define TILE(set, name) extern wave_tile_fn wave_tile_##name;
CELLWALK_TILES
#undef TILE
static wave_tile_fn *tile_function(void) {
    const cw_isa isa = cw_isa_best();
#define TILE(set, name)                                                                                                \
    if (cw_isa_includes(isa, CW_ISA_##set)) return wave_tile_##name;
    CELLWALK_TILES
#undef TILE
    return NULL;
}

/* Finds the region and the tiles that it touches, and allocates its picture. */
static bool lay_out(render *r, const scene_crop *crop, io_error *error) {
    const size_t width = r->plan.width, height = r->plan.height;
    r->region = crop->x1 > 0 ? *crop : (scene_crop){0, 0, width, height};
    const scene_crop *g = &r->region;
    if (g->x0 >= g->x1 || g->y0 >= g->y1 || g->x1 > width || g->y1 > height)
        return io_fail(error, "the crop from (%zu, %zu) to (%zu, %zu) is no part of %zu x %zu pixels", g->x0, g->y0,
                       g->x1, g->y1, width, height);
    r->first_x = g->x0 / WAVE_TILE * WAVE_TILE;
    r->first_y = g->y0 / WAVE_TILE * WAVE_TILE;
    r->tiles_x = (g->x1 - r->first_x + WAVE_TILE - 1) / WAVE_TILE;
    r->tiles = r->tiles_x * ((g->y1 - r->first_y + WAVE_TILE - 1) / WAVE_TILE);
    *r->image = (io_image){.width = g->x1 - g->x0, .height = g->y1 - g->y0};
    const size_t pixel = 3 * sizeof *r->image->rgb;
    if (r->image->width <= SIZE_MAX / pixel / r->image->height)
        r->image->rgb = malloc(r->image->width * r->image->height * pixel);
    return r->image->rgb != NULL || io_fail(error, "no memory for %zu x %zu pixels", r->image->width, r->image->height);
}

static bool render_planned(render *r, const scene_tracer *tracer, scene_render_stats *stats, io_error *error) {
    if (!lay_out(r, &r->options->crop, error)) return false;
    unsigned threads = r->options->threads ? r->options->threads : cpus_usable();
    if (threads > r->tiles) threads = (unsigned)r->tiles;
    if (threads > THREADS_MAX) threads = THREADS_MAX;
    if (pthread_mutex_init(&r->lock, NULL) != 0) return io_fail(error, "out of memory");
    const bool good = render_with(r, tracer, threads, stats, error);
    pthread_mutex_destroy(&r->lock);
    return good;
}

bool scene_render(const scene *s, const scene_render_options *options, io_image *image, scene_render_stats *stats,
                  io_error *error) {
    scene_render_stats unused;
    stats = stats ? stats : &unused;
    *stats = (scene_render_stats){0};
    *image = (io_image){0};

    library own = {.scene = s, .query = options->query};
    own.query.pool = NULL;
    const scene_tracer standard = {&own, library_closest, library_any};
    if (options->tracer == NULL && !prepare(&own, error)) return false;

    render r = {.options = options, .image = image, .tile = tile_function()};
    if (!plan_make(&r.plan, s, options)) return io_fail(error, "out of memory");
    bool good = render_planned(&r, options->tracer ? options->tracer : &standard, stats, error);
    plan_free(&r.plan);
    const cw_status status = (cw_status)atomic_load(&own.status);
    if (good && status != CW_OK) good = io_fail(error, "%s", cw_last_error());
    if (!good) io_image_free(image);
    return good;
}
