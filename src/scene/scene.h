/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes in the subset of the .pbrt language that height-field scenes need, and pictures of them. */
#ifndef CELLWALK_SCENE_SCENE_H
#define CELLWALK_SCENE_SCENE_H

#include "cellwalk_expert.h"
#include "image.h"
#include "io_error.h"

typedef struct scene scene;

/* Reads a scene with all that it includes. NULL on failure, with file, line and directive in error. Directives that
 * were skipped because they change neither geometry nor light are told to warn, which may be NULL. */
typedef void scene_warn_fn(void *context, const char *message);
scene *scene_load(const char *path, scene_warn_fn *warn, void *warn_context, io_error *error);
void scene_free(scene *s);

/* The scene's height fields in the order of the file; owned by the scene. */
size_t scene_field_count(const scene *s);
cw_field *scene_field(scene *s, size_t number);

size_t scene_width(const scene *s);
size_t scene_height(const scene *s);

/* How rays meet height fields. The default is cw_closest and cw_occluded; a measuring program puts its own in. Called
 * from several threads at once, for at most SCENE_BATCH rays. Rays are in the field space of that field. */
enum { SCENE_BATCH = 4096 };
typedef struct scene_tracer {
    void *context;
    void (*closest)(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits);
    void (*any)(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded);
} scene_tracer;

/* Pixels from (x0, y0) to before (x1, y1). */
typedef struct scene_crop {
    size_t x0, y0, x1, y1;
} scene_crop;

typedef struct scene_render_options {
    cw_run query;               /* for the default tracer; its pool is not used, since threads share tiles */
    const scene_tracer *tracer; /* NULL: the default */
    unsigned threads;           /* 0: one per CPU */
    unsigned samples;           /* a pixel; 0: as the scene says */
    uint32_t seed;              /* of the samples' places in their pixels */
    size_t width, height;       /* of the picture; 0: as the scene says */
    scene_crop crop;            /* the part of it that is rendered, each pixel as in the whole; x1 = 0: all */
    /* Phong normals on height fields instead of the triangles' own: of vertices, the sums of the area-weighted normals
     * of their triangles, interpolated barycentrically. */
    bool phong;
    bool general; /* for tests: leave nothing out that the scene does not require */
    /* NULL, or told the share done in [0, 1], from one thread at a time. */
    void (*progress)(void *context, double done);
    void *progress_context;
} scene_render_options;

typedef struct scene_render_stats {
    uint64_t camera_rays, shadow_rays, mirror_rays;
    uint64_t field_queries; /* rays given to a tracer, counted once for each field that they were given to */
} scene_render_stats;

/* Renders into image, which is allocated here. The picture depends neither on the number of threads nor on the kernel
 * or the instruction set. False, with error, when out of memory, on a kernel's refusal, or on a crop that is empty or
 * reaches out of the picture. stats may be NULL. */
bool scene_render(const scene *s, const scene_render_options *options, io_image *image, scene_render_stats *stats,
                  io_error *error);

#endif
