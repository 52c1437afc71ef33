/* SPDX-License-Identifier: Apache-2.0 */
/* Threads take tiles of the picture in turn. A tile is always rendered in the same way, by whichever thread. */

#include "wave.h"

#include "clock.h"
#include "cpus.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS_MAX = 1024 };

typedef struct render {
    const scene *scene;
    const scene_render_options *options;
    io_image *image;
    size_t tiles_x, tiles;
    atomic_size_t next;
    atomic_bool stopped;
    pthread_mutex_t lock; /* of done and progress */
    size_t done;
} render;

typedef struct worker {
    render *job;
    wave *wave;
    pthread_t thread;
} worker;

/* ---- the default tracer ------------------------------------------------------------------------------------------- */

typedef struct library {
    const scene *scene;
    cw_query query;
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
    const cw_status status = cw_any(l->scene->heightfields[field].field, &l->query, rays, n, occluded);
    if (status == CW_OK) return;
    atomic_store(&l->status, (int)status);
    memset(occluded, 0, n);
}

/* Builds what the query's kernel needs and asks it about no rays: what it refuses, it refuses here. */
static bool prepare(const library *l, io_error *error) {
    for (size_t k = 0; k < l->scene->heightfield_count; k++) {
        cw_field *field = l->scene->heightfields[k].field;
        const cw_kernel *kernel = cw_query_kernel(field, &l->query);
        cw_status status = cw_field_build(field, kernel);
        if (status == CW_OK) status = cw_closest(field, &l->query, NULL, 0, NULL);
        if (status == CW_OK) status = cw_any(field, &l->query, NULL, 0, NULL);
        if (status != CW_OK)
            return io_fail(error, "kernel %s: %s", cw_kernel_describe(kernel).name, cw_status_message(status));
    }
    return true;
}

/* ---- threads ------------------------------------------------------------------------------------------------------ */

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
        if (tile >= r->tiles || atomic_load(&r->stopped)) return NULL;
        const size_t x = tile % r->tiles_x * WAVE_TILE, y = tile / r->tiles_x * WAVE_TILE;
        if (wave_render_tile(me->wave, x, y, r->image))
            report(r);
        else
            atomic_store(&r->stopped, true);
    }
}

/* The calling thread is the first worker; where the system gives fewer threads than asked for, fewer do the work. */
static void run(worker *workers, unsigned count) {
    unsigned started = 1;
    while (started < count && pthread_create(&workers[started].thread, NULL, work, &workers[started]) == 0) started++;
    work(&workers[0]);
    for (unsigned k = 1; k < started; k++) pthread_join(workers[k].thread, NULL);
}

static void add_stats(scene_render_stats *sum, const scene_render_stats *part) {
    sum->camera_rays += part->camera_rays;
    sum->shadow_rays += part->shadow_rays;
    sum->mirror_rays += part->mirror_rays;
    sum->field_queries += part->field_queries;
    sum->trace_seconds += part->trace_seconds;
}

static bool render_with(render *r, const scene_tracer *tracer, unsigned threads, scene_render_stats *stats,
                        io_error *error) {
    const unsigned samples = r->options->samples ? r->options->samples : r->scene->samples;
    worker *workers = calloc(threads, sizeof *workers);
    bool good = workers != NULL;
    for (unsigned k = 0; good && k < threads; k++) {
        workers[k].job = r;
        workers[k].wave = wave_create(r->scene, tracer, r->options, samples);
        good = workers[k].wave != NULL;
    }
    if (good) run(workers, threads);
    for (unsigned k = 0; workers != NULL && k < threads; k++) {
        if (good) add_stats(stats, &workers[k].wave->stats);
        wave_free(workers[k].wave);
    }
    free(workers);
    if (!good) return io_fail(error, "out of memory");
    return !atomic_load(&r->stopped) || io_fail(error, "cancelled");
}

bool scene_render(const scene *s, const scene_render_options *options, io_image *image, scene_render_stats *stats,
                  io_error *error) {
    scene_render_stats unused;
    stats = stats ? stats : &unused;
    *stats = (scene_render_stats){0};
    *image = (io_image){.width = s->width, .height = s->height};

    double start = clock_seconds();
    library own = {.scene = s, .query = options->query};
    own.query.pool = NULL;
    const scene_tracer standard = {&own, library_closest, library_any};
    if (options->tracer == NULL && !prepare(&own, error)) return false;
    stats->build_seconds = options->tracer == NULL ? clock_seconds() - start : 0;

    start = clock_seconds();
    image->rgb = malloc(s->width * s->height * 3 * sizeof *image->rgb);
    if (image->rgb == NULL) return io_fail(error, "no memory for %zu x %zu pixels", s->width, s->height);
    render r = {.scene = s, .options = options, .image = image};
    r.tiles_x = (s->width + WAVE_TILE - 1) / WAVE_TILE;
    r.tiles = r.tiles_x * ((s->height + WAVE_TILE - 1) / WAVE_TILE);
    unsigned threads = options->threads ? options->threads : cpus_usable();
    if (threads > r.tiles) threads = (unsigned)r.tiles;
    if (threads > THREADS_MAX) threads = THREADS_MAX;

    bool good = pthread_mutex_init(&r.lock, NULL) == 0 || io_fail(error, "out of memory");
    if (good) {
        good = render_with(&r, options->tracer ? options->tracer : &standard, threads, stats, error);
        pthread_mutex_destroy(&r.lock);
    }
    const cw_status status = (cw_status)atomic_load(&own.status);
    if (good && status != CW_OK) good = io_fail(error, "%s", cw_status_message(status));
    stats->seconds = clock_seconds() - start;
    if (!good) io_image_free(image);
    return good;
}
