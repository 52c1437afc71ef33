/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes from their reading to their end. */

#include "model.h"

#include <stdlib.h>

void scene_free(scene *s) {
    if (s == NULL) return;
    for (size_t k = 0; k < s->heightfield_count; k++) {
        if (s->heightfields[k].borrowed) continue;
        cw_field_destroy(s->heightfields[k].field);
        free((void *)(uintptr_t)s->heightfields[k].samples); /* which the scene alone could write to */
    }
    for (size_t k = 0; k < s->texture_count; k++) texture_free(s->textures[k]);
    free(s->heightfields);
    free(s->cylinders);
    free(s->lights);
    free(s->textures);
    free(s->sky);
    free(s->water);
    free(s);
}

scene *scene_load(const char *path, scene_warn_fn *warn, void *warn_context, io_error *error) {
    scene *s = calloc(1, sizeof *s);
    if (s == NULL) {
        io_fail(error, "%s: out of memory", path);
        return NULL;
    }
    if (pbrt_parse(path, s, warn, warn_context, error)) return s;
    scene_free(s);
    return NULL;
}

size_t scene_field_count(const scene *s) { return s->heightfield_count; }

cw_field *scene_field(scene *s, size_t number) { return s->heightfields[number].field; }

size_t scene_width(const scene *s) { return s->width; }

size_t scene_height(const scene *s) { return s->height; }
