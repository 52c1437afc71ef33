/* SPDX-License-Identifier: Apache-2.0 */
/* Fields, holes, strides, rays and options made of the input's bytes, and where they end, of a random sequence that
 * they begin: so that some bytes make hundreds of rays. Every kernel of the cell walks gives the bits that `cell`
 * gives, any hit agrees with the closest, and what follows from hits is where it belongs. Each array is a separate
 * block, whose ends AddressSanitizer guards. */

#include "cellwalk_expert.h"
#include "reference.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Some rays are answered by all kernels, many by one: so that neither a kernel nor a long array is left out. */
enum { SIDE_MAX = 72, SOME = 64, MANY = 4000 };

/* Rays that were compared, and how many answers of kernels they got beside that of `cell`. */
static unsigned long long rays_done, answers_done;

static void tell(void) { fprintf(stderr, "rays: %llu\npairs: %llu\n", rays_done, answers_done); }

int LLVMFuzzerInitialize(int *count, char ***arguments) {
    cw_reference_add();
    atexit(tell);
    return 0;
}

typedef struct source {
    const uint8_t *data;
    size_t size;
    uint64_t state, bits; /* of the random sequence (xorshift, Marsaglia 2003), and what is left of its last word */
    int left;
} source;

static uint8_t byte(source *s) {
    if (s->size > 0) {
        s->size--;
        return *s->data++;
    }
    if (s->left == 0) {
        s->state ^= s->state << 13;
        s->state ^= s->state >> 7;
        s->state ^= s->state << 17;
        s->bits = s->state;
        s->left = 8;
    }
    s->left--;
    const uint8_t value = (uint8_t)s->bits;
    s->bits >>= 8;
    return value;
}

/* Small numbers, which make ties, or any bits at all. */
static float number(source *s) {
    const uint8_t kind = byte(s);
    if (kind < 200) return 0.25f * (float)((int)kind - 80);
    if (kind < 216) return (float)((int)byte(s) - 128);
    if (kind < 232) return ldexpf(1 + (float)byte(s) / 256, (int)byte(s) - 128);
    if (kind < 248) return (float)byte(s) * 0.125f + (float)byte(s) * 0x1p-12f;
    uint32_t bits = 0;
    for (int k = 0; k < 4; k++) bits = bits << 8 | byte(s);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void make_rays(source *s, cw_ray *rays, size_t n) {
    for (size_t k = 0; k < n; k++) {
        /* Neighbours that differ in one number are what the shared walk is for. */
        if (k > 0 && byte(s) < 160) {
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

static void *block(size_t bytes) {
    void *memory = malloc(bytes);
    if (memory == NULL) abort();
    return memory;
}

static void wrong(const char *kernel, const char *what, size_t at) {
    fprintf(stderr, "%s: %s %zu\n", kernel, what, at);
    abort();
}

static bool is_walk(const cw_kernel_info *info) { return info->available && info->default_leaf == CW_LEAF_WATERTIGHT; }

typedef struct work {
    cw_field *field;
    cw_run query;
    size_t n;
    cw_ray *rays;
    cw_hit *expected, *hits; /* expected: what cell finds, if it was asked */
    bool known, slow;        /* slow: brute force and grid3d are also compared */
    uint8_t *occluded;
} work;

/* Answers of a kernel, before those of cell. */
static void ask(work *w, const cw_kernel *kernel, bool any) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    if (!info.available || (!is_walk(&info) && !w->slow) ||
        cw_field_build(w->field, &(cw_run){.expert.kernel = kernel}) != CW_OK)
        return;
    w->query.expert.kernel = kernel;
    const bool comparable = w->known && is_walk(&info);
    if (cw_closest(w->field, &w->query, w->rays, w->n, w->hits) == CW_OK) {
        answers_done += w->n;
        for (size_t k = 0; comparable && k < w->n; k++)
            if (memcmp(&w->hits[k], &w->expected[k], sizeof w->hits[k]) != 0)
                wrong(info.name, "another hit than cell's of ray", k);
    }
    if (any && cw_occluded(w->field, &w->query, w->rays, w->n, w->occluded) == CW_OK) {
        answers_done += w->n;
        for (size_t k = 0; comparable && k < w->n; k++)
            if (w->occluded[k] != (w->expected[k].i >= 0)) wrong(info.name, "any hit is not the closest of ray", k);
    }
}

/* What follows from hits: from some of them. */
static void look_at_hits(work *w) {
    w->query.expert.kernel = cw_kernel_find("cell");
    if (cw_closest(w->field, &w->query, w->rays, w->n, w->hits) != CW_OK) return;
    for (size_t k = 0; k < w->n; k += 1 + w->n / 8) {
        double point[3], normal[3];
        cw_hit_points(w->field, NULL, &w->hits[k], 1, point);
        cw_hit_normals(w->field, NULL, &w->hits[k], 1, normal);
        cw_hit_phong_normals(w->field, NULL, &w->hits[k], 1, normal);
        if (isnan(point[0]) != (w->hits[k].i < 0)) wrong("hit", "a point without a hit, or none with it, of ray", k);
    }
}

static void ask_user(work *w, source *s) {
    const size_t n = w->n < SOME ? w->n : SOME;
    cw_user_ray *rays = block(n * sizeof *rays);
    cw_hit *hits = block(n * sizeof *hits);
    for (size_t k = 0; k < n; k++) {
        const cw_ray *r = &w->rays[k];
        rays[k] = (cw_user_ray){.tmin = r->tmin, .tmax = r->tmax};
        for (int c = 0; c < 3; c++) rays[k].org[c] = r->org[c] * (byte(s) < 8 ? 1e300 : 1), rays[k].dir[c] = r->dir[c];
    }
    if (cw_closest_user(w->field, &w->query, rays, n, hits) == CW_OK) rays_done += n;
    for (int k = 0; k < 4; k++) {
        cw_surface_at(w->field, NULL, (double[2]){(double)number(s), (double)number(s)}, 1, hits);
        const double point[3] = {(double)number(s), (double)number(s), (double)number(s)};
        if (cw_surface_at_user(w->field, NULL, point, 1, hits) != CW_OK) wrong("surface_at_user", "an error", 0);
    }
    free(hits);
    free(rays);
}

/* Every instruction set gives the same slopes. */
static void ask_heading(const work *w, source *s) {
    const cw_field_info info = cw_field_describe(w->field);
    const cw_heading_desc desc = {.dir = {(double)number(s), (double)number(s)}};
    const float low = number(s), high = byte(s) < 128 ? INFINITY : number(s);
    cw_heading *heading;
    if (cw_heading_create(w->field, &desc, &heading) != CW_OK) return;
    cw_rectangle at = {byte(s) % info.nx, byte(s) % info.ny, 1, 1};
    at.nx += byte(s) % (info.nx - at.i);
    at.ny += byte(s) % (info.ny - at.j);
    const size_t size = at.nx * at.ny * sizeof(float);
    float *slopes = block(size), *first = NULL;
    uint8_t *seen = block(at.nx * at.ny);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run q = {.expert.kernel = cw_kernel_at(k)};
        if (cw_heading_steepest(heading, &q, low, high, at, slopes) != CW_OK) continue;
        if (first == NULL) first = memcpy(block(size), slopes, size);
        if (memcmp(first, slopes, size) != 0)
            wrong(cw_kernel_describe(q.expert.kernel).name, "other slopes among", size);
        cw_heading_occluded(heading, &q, low, at, seen);
    }
    free(first);
    free(slopes);
    free(seen);
    cw_heading_destroy(heading);
}

static void ask_all(cw_field *field, source *s) {
    const uint8_t size = byte(s);
    work w = {.field = field, .n = size < SOME ? size + 1u : MANY - 1u * size, .slow = size < SOME && byte(s) < 32};
    w.rays = block(w.n * sizeof *w.rays);
    w.expected = block(w.n * sizeof *w.expected);
    w.hits = block(w.n * sizeof *w.hits);
    w.occluded = block(w.n);
    (void)byte(s); /* the corpus has a byte here */
    w.query.expert.leaf = (cw_leaf)(byte(s) % 4 % 3);
    (void)byte(s);
    make_rays(s, w.rays, w.n);
    w.query.expert.kernel = cw_kernel_find("cell");
    w.known = cw_closest(field, &w.query, w.rays, w.n, w.expected) == CW_OK;
    rays_done += w.n;
    const size_t kernels = cw_kernel_count();
    if (w.n <= SOME)
        for (size_t k = 0; k < kernels; k++) ask(&w, cw_kernel_at(k), true);
    else
        ask(&w, cw_kernel_at(byte(s) % kernels), byte(s) < 96);
    look_at_hits(&w);
    if (byte(s) < 16) ask_user(&w, s);
    if (byte(s) < 8) ask_heading(&w, s);
    free(w.rays);
    free(w.expected);
    free(w.hits);
    free(w.occluded);
}

/* Some samples change, or are refused. */
static void change(cw_field *field, const cw_field_desc *desc, float *samples, source *s) {
    const size_t stride = desc->stride ? desc->stride : desc->nx;
    cw_update u = {.at = {.i = byte(s) % desc->nx, .j = byte(s) % desc->ny}, .stride = stride};
    u.at.nx = 1 + byte(s) % (desc->nx - u.at.i);
    u.at.ny = 1 + byte(s) % (desc->ny - u.at.j);
    float *to = samples + u.at.j * stride + u.at.i;
    if (desc->storage == CW_COPY) u.samples = to;
    for (size_t j = 0; j < u.at.ny; j++)
        for (size_t i = 0; i < u.at.nx; i++)
            if (byte(s) < 128) to[j * stride + i] = number(s);
    if (cw_field_update(field, NULL, &u) == CW_OK) ask_all(field, s);
}

static uint64_t seed(const uint8_t *data, size_t size) { /* FNV-1a */
    uint64_t hash = 0xcbf29ce484222325;
    for (size_t k = 0; k < size; k++) hash = (hash ^ data[k]) * 0x100000001b3;
    return hash | 1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    source s = {.data = data, .size = size, .state = seed(data, size)};
    const size_t nx = 2 + byte(&s) % (SIDE_MAX - 1), ny = 2 + byte(&s) % (SIDE_MAX - 1), gap = byte(&s) % 4;
    const size_t stride = nx + gap, count = (ny - 1) * stride + nx, period = 1 + byte(&s);
    float *samples = block(count * sizeof *samples);
    const bool any_height = byte(&s) < 16;
    /* A few samples of the input's, repeated: inputs stay short. */
    for (size_t k = 0; k < count; k++) {
        samples[k] = k < period ? number(&s) : samples[k - period];
        if (!any_height && !(fabsf(samples[k]) <= CW_HEIGHT_MAX)) samples[k] = NAN;
    }
    cw_field_desc desc = {.map = {{1}, {0, 1}, {0, 0, 1}}};
    desc.samples = samples;
    desc.nx = nx;
    desc.ny = ny;
    desc.stride = gap ? stride : 0;
    desc.storage = (cw_storage)(byte(&s) % 2);
    const cw_run bare = {.expert.kernel = cw_kernel_find("cell")}, *how = byte(&s) % 2 ? &bare : NULL;
    if (byte(&s) < 64)
        for (int k = 0; k < 12; k++) desc.map[k / 4][k % 4] += byte(&s) < 64 ? (double)number(&s) : 0;
    cw_field *field;
    if (cw_field_create(&desc, how, &field) == CW_OK) {
        ask_all(field, &s);
        if (s.size > 0) change(field, &desc, samples, &s);
    }
    cw_field_destroy(field);
    free(samples);
    return 0;
}
