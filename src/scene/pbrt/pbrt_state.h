/* SPDX-License-Identifier: Apache-2.0 */
/* The state that the directives of a .pbrt file share while it is read. */
#ifndef CELLWALK_SCENE_PBRT_STATE_H
#define CELLWALK_SCENE_PBRT_STATE_H

#include "model.h"
#include "pbrt_params.h"

#include <sys/types.h>

/* A Texture directive. */
typedef struct pbrt_texture {
    char *name;
    texture *image; /* the scene's */
} pbrt_texture;

/* Limits on levels of includes, and on all that a scene reads: a file that includes two others, which include two
 * others… would never end. */
enum { PBRT_DEPTH_MAX = 64, PBRT_INCLUDE_MAX = 16, PBRT_FILES_MAX = 4096, PBRT_WARNINGS_MAX = 100 };
static const uint64_t pbrt_bytes_max = (uint64_t)1 << 34;

/* The state that AttributeBegin saves. */
typedef struct pbrt_attributes {
    transform current;
    material surface;
    int texture_count; /* names that can be seen */
} pbrt_attributes;

typedef struct pbrt_state {
    scene *scene;
    scene_warn_fn *warn;
    void *warn_context;
    unsigned warnings;

    char *directory; /* of the first file, with its last slash: all names are relative to it */
    struct {
        dev_t device;
        ino_t inode;
    } open[PBRT_INCLUDE_MAX];
    int open_count;
    unsigned files; /* read so far, and their size */
    uint64_t bytes;

    pbrt_attributes attributes, saved[PBRT_DEPTH_MAX];
    int depth;
    pbrt_texture *textures;
    int texture_capacity;
    size_t pixels; /* of all images */
    bool camera, world, ended;
} pbrt_state;

typedef bool pbrt_directive_fn(pbrt_state *p, const pbrt_site *site, io_error *error);

/* pbrt_shapes.c: directives that put something into the world. */
pbrt_directive_fn pbrt_shape, pbrt_light, pbrt_material, pbrt_texture_define;

/* name relative to the scene's directory; the caller frees it; NULL when out of memory. */
char *pbrt_resolve(const pbrt_state *p, const char *name);

/* False, with an error, if the renderer cannot measure in the space of that name. */
bool pbrt_measurable(const pbrt_site *site, const transform *to_world, const char *space, io_error *error);

#endif
