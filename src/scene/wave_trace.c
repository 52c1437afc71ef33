/* SPDX-License-Identifier: Apache-2.0 */
/* A wave's rays against the scene's shapes, one shape after the other. */

#include "wave.h"

#include "clock.h"

#include <string.h>

static void closest(wave *w, size_t field, const cw_user_ray *rays, size_t n, cw_hit *hits) {
    cw_rays_to_field(w->scene->heightfields[field].field, rays, n, w->field_rays);
    const double start = clock_seconds();
    w->tracer->closest(w->tracer->context, field, w->field_rays, n, hits);
    w->stats.trace_seconds += clock_seconds() - start;
    w->stats.field_queries += n;
}

static void any(wave *w, size_t field, size_t n, uint8_t *hidden) {
    cw_rays_to_field(w->scene->heightfields[field].field, w->shadow_rays, n, w->field_rays);
    const double start = clock_seconds();
    w->tracer->any(w->tracer->context, field, w->field_rays, n, hidden);
    w->stats.trace_seconds += clock_seconds() - start;
    w->stats.field_queries += n;
}

void wave_trace_paths(wave *w, int current) {
    const scene *s = w->scene;
    cw_user_ray *rays = w->rays[current];
    const size_t n = w->count[current];
    for (size_t k = 0; k < n; k++) w->shape[k] = WAVE_MISS;
    for (size_t f = 0; f < s->heightfield_count; f++) {
        cw_hit *hits = f == 0 ? w->hits : w->other_hits;
        closest(w, f, rays, n, hits);
        for (size_t k = 0; k < n; k++) {
            if (!((double)hits[k].t < rays[k].tmax)) continue;
            rays[k].tmax = (double)hits[k].t;
            w->shape[k] = (int32_t)f;
            if (f > 0) w->hits[k] = hits[k];
        }
    }
    for (size_t c = 0; c < s->cylinder_count; c++)
        for (size_t k = 0; k < n; k++) {
            const double t = cylinder_hit(&s->cylinders[c], &rays[k]);
            if (!(t < rays[k].tmax)) continue;
            rays[k].tmax = t;
            w->shape[k] = (int32_t)(s->heightfield_count + c);
        }
}

void wave_trace_shadows(wave *w) {
    const scene *s = w->scene;
    const size_t n = w->shadow_count;
    if (n == 0) return;
    if (s->heightfield_count == 0) memset(w->hidden, 0, n);
    for (size_t f = 0; f < s->heightfield_count; f++) {
        any(w, f, n, f == 0 ? w->hidden : w->other_hidden);
        for (size_t k = 0; f > 0 && k < n; k++) w->hidden[k] |= w->other_hidden[k];
    }
    for (size_t c = 0; c < s->cylinder_count; c++)
        for (size_t k = 0; k < n; k++)
            if (!w->hidden[k]) w->hidden[k] = cylinder_blocks(&s->cylinders[c], &w->shadow_rays[k]);
    for (size_t k = 0; k < n; k++) {
        if (w->hidden[k]) continue;
        double *sum = w->sum[w->shadows[k].pixel];
        for (int c = 0; c < 3; c++) sum[c] += (double)w->shadows[k].light[c];
    }
    w->stats.shadow_rays += n;
    w->shadow_count = 0;
}
