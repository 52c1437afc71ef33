/* SPDX-License-Identifier: Apache-2.0 */
#include "wave.h"

#include <stdlib.h>

static bool allocate(wave *w, const plan *p) {
    for (int k = 0; k < 2; k++) {
        w->rays[k].segments = calloc(p->shape_count + 1, sizeof *w->rays[k].segments);
        w->rays[k].spread = p->spreads ? calloc(1, sizeof *w->rays[k].spread) : NULL;
        if (w->rays[k].segments == NULL || (p->spreads && w->rays[k].spread == NULL)) return false;
    }
    w->shadows = calloc(p->light_count + 1, sizeof *w->shadows);
    for (size_t l = 0; w->shadows != NULL && l < p->light_count; l++) {
        w->shadows[l].segments = calloc(p->shape_count + 1, sizeof *w->shadows[l].segments);
        if (w->shadows[l].segments == NULL) return false;
    }
    w->answers = calloc(p->field_count + 1, sizeof *w->answers);
    return w->shadows != NULL && w->answers != NULL;
}

wave *wave_create(const plan *p, const scene_tracer *tracer) {
    wave *w = calloc(1, sizeof *w);
    if (w == NULL) return NULL;
    w->plan = p;
    w->tracer = tracer;
    if (allocate(w, p)) return w;
    wave_free(w);
    return NULL;
}

void wave_free(wave *w) {
    if (w == NULL) return;
    for (int k = 0; k < 2; k++) {
        free(w->rays[k].segments);
        free(w->rays[k].spread);
    }
    for (size_t l = 0; w->shadows != NULL && l < w->plan->light_count; l++) free(w->shadows[l].segments);
    free(w->shadows);
    free(w->answers);
    free(w);
}
