/* SPDX-License-Identifier: Apache-2.0 */
/* Fields, holes, strides, rays and options made of the input's bytes. Every kernel of the cell walks gives the bits that
 * `cell` gives, and any hit agrees with the closest. */

#include "cellwalk.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SIDE_MAX = 40, RAYS_MAX = 64 };

typedef struct source {
    const uint8_t *data;
    size_t size;
} source;

static uint8_t byte(source *s) {
    if (s->size == 0) return 0;
    s->size--;
    return *s->data++;
}

/* Small numbers, which make ties, or any bits at all. */
static float number(source *s) {
    const uint8_t kind = byte(s);
    if (kind < 160) return 0.25f * (float)((int)kind - 80);
    if (kind < 176) return (float)((int)byte(s) - 128);
    if (kind < 192) return ldexpf(1 + (float)byte(s) / 256, (int)byte(s) - 128);
    uint32_t bits = 0;
    for (int k = 0; k < 4; k++) bits = bits << 8 | byte(s);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void make_rays(source *s, cw_ray *rays, size_t n) {
    for (size_t k = 0; k < n; k++) {
        /* Neighbours that differ in one number are what the shared walk is for. */
        if (k > 0 && byte(s) < 128) {
            float all[8];
            memcpy(all, &rays[k - 1], sizeof all);
            all[byte(s) % 8] = number(s);
            memcpy(&rays[k], all, sizeof all);
            continue;
        }
        rays[k] = (cw_ray){.tmin = 0, .tmax = INFINITY};
        for (int c = 0; c < 3; c++) rays[k].org[c] = number(s);
        for (int c = 0; c < 3; c++) rays[k].dir[c] = number(s);
        if (byte(s) < 64) rays[k].tmin = number(s);
        if (byte(s) < 64) rays[k].tmax = number(s);
    }
}

static void differ(const char *kernel, const char *what, size_t ray) {
    fprintf(stderr, "%s: %s of ray %zu is another than that of cell\n", kernel, what, ray);
    abort();
}

static void compare(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n,
                    const cw_hit *expected) {
    cw_hit hits[RAYS_MAX];
    uint8_t occluded[RAYS_MAX];
    const cw_kernel_info info = cw_kernel_describe(query->kernel);
    if (cw_closest(field, query, rays, n, hits) != CW_OK || cw_any(field, query, rays, n, occluded) != CW_OK) return;
    for (size_t k = 0; expected && k < n; k++) {
        if (memcmp(&hits[k], &expected[k], sizeof hits[k]) != 0) differ(info.name, "the hit", k);
        if (occluded[k] != (expected[k].i >= 0)) differ(info.name, "any hit", k);
    }
    double v[3];
    for (size_t k = 0; k < n; k++) {
        cw_hit_point(field, &hits[k], v);
        cw_hit_phong_normal(field, &hits[k], v);
    }
}

static bool is_walk(const cw_kernel_info *info) { return info->available && info->default_leaf == CW_LEAF_WATERTIGHT; }

static void ask_all(cw_field *field, source *s) {
    cw_ray rays[RAYS_MAX];
    cw_hit expected[RAYS_MAX];
    const size_t n = 1 + byte(s) % RAYS_MAX;
    cw_query query = {.coherence = (cw_coherence)(byte(s) % 3), .leaf = (cw_leaf)(byte(s) % 4)};
    const bool tolerant = byte(s) < 32;
    make_rays(s, rays, n);
    query.kernel = cw_kernel_find("cell");
    const bool asked = cw_closest(field, &query, rays, n, expected) == CW_OK;
    if (tolerant) {
        query.tolerance = fabsf(number(s));
        query.cone = fabsf(number(s));
    }
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        query.kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(query.kernel);
        if (!info.available || cw_field_build(field, query.kernel) != CW_OK) continue;
        compare(field, &query, rays, n, asked && !tolerant && is_walk(&info) ? expected : NULL);
    }
}

/* Some samples change, or are refused. What is then found is what is found on a field made anew. */
static void change(cw_field *field, const cw_field_desc *desc, float *samples, source *s) {
    const size_t stride = desc->stride ? desc->stride : desc->nx;
    cw_update u = {.i = byte(s) % desc->nx, .j = byte(s) % desc->ny};
    u.nx = 1 + byte(s) % (desc->nx - u.i);
    u.ny = 1 + byte(s) % (desc->ny - u.j);
    float *to = samples + u.j * stride + u.i;
    if (desc->storage == CW_COPY) u.samples = to;
    u.stride = stride;
    for (size_t j = 0; j < u.ny; j++)
        for (size_t i = 0; i < u.nx; i++) to[j * stride + i] = byte(s) < 128 ? number(s) : to[j * stride + i];
    cw_field *anew;
    const cw_status status = cw_field_update(field, &u), made = cw_field_create(desc, &anew);
    if (status != CW_OK) return;
    if (made != CW_OK) {
        fprintf(stderr, "updated to what cannot be made: %s\n", cw_status_message(made));
        abort();
    }
    const cw_field_info got = cw_field_describe(field), wanted = cw_field_describe(anew);
    cw_ray rays[RAYS_MAX];
    cw_hit hits[2][RAYS_MAX];
    make_rays(s, rays, RAYS_MAX);
    bool same = got.low == wanted.low && got.high == wanted.high && got.holes == wanted.holes;
    for (int k = 0; k < 2; k++) cw_closest(k ? anew : field, NULL, rays, RAYS_MAX, hits[k]);
    same = same && memcmp(hits[0], hits[1], sizeof hits[0]) == 0;
    cw_field_destroy(anew);
    if (same) return;
    fprintf(stderr, "an updated field is not what is made anew\n");
    abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    source s = {data, size};
    const size_t nx = 2 + byte(&s) % (SIDE_MAX - 1), ny = 2 + byte(&s) % (SIDE_MAX - 1), gap = byte(&s) % 4;
    const size_t stride = nx + gap, count = (ny - 1) * stride + nx, period = 1 + byte(&s);
    float *samples = malloc(count * sizeof *samples);
    if (samples == NULL) return 0;
    /* A few samples of the input's, repeated: inputs stay short. */
    for (size_t k = 0; k < count; k++) samples[k] = k < period ? number(&s) : samples[k - period];
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples;
    desc.nx = nx;
    desc.ny = ny;
    desc.stride = gap ? stride : 0;
    desc.storage = (cw_storage)(byte(&s) % 2);
    desc.bare = byte(&s) % 2;
    cw_field *field;
    if (cw_field_create(&desc, &field) == CW_OK) {
        ask_all(field, &s);
        if (s.size > 0) change(field, &desc, samples, &s);
    }
    cw_field_destroy(field);
    free(samples);
    return 0;
}
