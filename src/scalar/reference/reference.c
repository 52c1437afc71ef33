/* SPDX-License-Identifier: Apache-2.0 */
/* Two paths to compare the kernels with, by other operations: Möller and Trumbore's test (1997) without the gate. */

#include "reference.h"

#include "error.h"
#include "field.h"
#include "kernels.h"
#include "memory.h"
#include "moller_trumbore.h"
#include "ray.h"
#include "refine.h"

#include <float.h>

/* One ray's hit. */
typedef bool trace_one(const cw_field *f, const cw_ray *given, bool any, cw_hit *hit);

static inline __attribute__((always_inline)) void trace_each(const cw_field *f, const cw_ray *rays, size_t n,
                                                             cw_hit *hits, uint8_t *occluded, trace_one *one) {
    cw_hit unused;
    for (size_t k = 0; k < n && hits == NULL; k++) occluded[k] = one(f, &rays[k], true, &unused);
    for (size_t k = 0; k < n && hits != NULL; k++)
        if (!one(f, &rays[k], false, &hits[k])) hits[k] = miss();
}

/* ---- brute: every ray against every triangle --------------------------------------------------------------------- */

/* Tests compare the other kernels with it on small fields, up to the rounding of the test; for exactness they use an
 * oracle in exact arithmetic. The nearest hit; among equally near ones the first in row order. */
static inline bool trace_brute(const cw_field *f, const cw_ray *given, bool any, cw_hit *best) {
    bool found = false;
    ray_start ray;
    if (!ray_init(&ray, f, given)) return false;
    for (size_t j = 0; j + 1 < f->ny; j++) {
        for (size_t i = 0; i + 1 < f->nx; i++) {
            const float *h = f->z + j * f->stride + i;
            const mt_range range = {ray.tmin, ray.tmax, -INFINITY, INFINITY};
            cw_hit hit;
            if (!mt_cell(ray.org, ray.dir, &range, i, j, h[0], h[1], h[f->stride], h[f->stride + 1], &hit)) continue;
            if (found && !(hit.t < best->t)) continue;
            *best = hit;
            found = true;
            ray.tmax = hit.t;
            if (any) return true;
        }
    }
    if (found) *best = refine_place(f, &ray, best);
    return found;
}

static void trace_all_brute(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_each(f, rays, n, hits, occluded, trace_brute);
}

/* ---- grid3d ------------------------------------------------------------------------------------------------------ */

/* A uniform grid of voxels over the field's triangles, walked by 3D-DDA (Amanatides and Woo
 * 1987), with the resolution rule of the coursework's renderer (Pharr and Humphreys, "Physically Based Rendering",
 * 2nd ed., 4.3): voxels per unit length = 3 · cbrt(triangles) / longest side, at most 64 an axis.
 *
 * Invariant: a hit counts only if it lies inside the current voxel's t-range. A triangle is listed in every voxel
 * that its box touches, so a ray may find a hit beyond the current voxel although a later voxel has a nearer one.
 * Rejected: returning the first hit found, as the coursework did (papers/tradeoff.md). */

enum { VOXELS_MAX = 64, TRIANGLE_BITS = 1 };

/* Guest of a field. */
struct cw_grid3d {
    int n[3];
    float low[3], high[3], size[3], inverse_size[3]; /* of the grid; of a voxel */
    uint32_t *begin;                                 /* voxel v lists entries [begin[v], begin[v + 1]) */
    uint32_t *entry;                                 /* (sample number of (i, j)) · 2 + triangle */
};

static size_t voxel_number(const struct cw_grid3d *g, const int v[3]) {
    return ((size_t)v[2] * (size_t)g->n[1] + (size_t)v[1]) * (size_t)g->n[0] + (size_t)v[0];
}

static int voxel_of(const struct cw_grid3d *g, float position, int axis) {
    const float v = (position - g->low[axis]) * g->inverse_size[axis];
    return !(v > 0) ? 0 : v >= (float)g->n[axis] ? g->n[axis] - 1 : (int)v; /* NaN, in a flat grid, is voxel 0 */
}

static void set_resolution(struct cw_grid3d *g, const cw_field *f) {
    const float low[3] = {0, 0, f->low}, high[3] = {(float)(f->nx - 1), (float)(f->ny - 1), f->high};
    float longest = 0;
    /* The difference of two heights may overflow. */
    for (int a = 0; a < 3; a++) longest = fmaxf(longest, fminf(high[a] - low[a], FLT_MAX));
    const double triangles = 2.0 * (double)(f->nx - 1) * (double)(f->ny - 1);
    const float per_unit = 3 * (float)cbrt(triangles) / longest;
    for (int a = 0; a < 3; a++) {
        const float extent = fminf(high[a] - low[a], FLT_MAX);
        const float wanted = rintf(extent * per_unit);
        g->n[a] = wanted < 1 ? 1 : wanted > VOXELS_MAX ? VOXELS_MAX : (int)wanted;
        g->low[a] = low[a];
        g->high[a] = high[a];
        g->size[a] = extent / (float)g->n[a];
        g->inverse_size[a] = g->size[a] > 0 ? 1 / g->size[a] : 0;
    }
}

/* The box of voxels that a triangle's box touches, slightly enlarged; false for a triangle with a hole. A hit on a
 * voxel's face is then found from either side, and the rounding of voxel_of needs no analysis. */
static bool voxels_of_triangle(const struct cw_grid3d *g, const cw_field *f, size_t i, size_t j, uint32_t triangle,
                               int first[3], int last[3]) {
    const float *h = f->z + j * f->stride + i;
    const float third = triangle == CW_TRIANGLE_A ? h[1] : h[f->stride], h00 = h[0], h11 = h[f->stride + 1];
    if (isnan(h00) || isnan(third) || isnan(h11)) return false;
    const float low[3] = {(float)i, (float)j, fminf(h00, fminf(third, h11))};
    const float high[3] = {(float)(i + 1), (float)(j + 1), fmaxf(h00, fmaxf(third, h11))};
    for (int a = 0; a < 3; a++) {
        const float slack = g->size[a] * 1e-4f;
        first[a] = voxel_of(g, low[a] - slack, a);
        last[a] = voxel_of(g, high[a] + slack, a);
    }
    return true;
}

/* Counts each voxel's triangles into begin[voxel + 1] or, once begin holds the sums, writes them. */
static void enter_triangles(struct cw_grid3d *g, const cw_field *f, bool write) {
    for (size_t j = 0; j + 1 < f->ny; j++)
        for (size_t i = 0; i + 1 < f->nx; i++)
            for (uint32_t triangle = 0; triangle < 2; triangle++) {
                int first[3], last[3], v[3];
                if (!voxels_of_triangle(g, f, i, j, triangle, first, last)) continue;
                const uint32_t number = (uint32_t)(j * f->nx + i) << TRIANGLE_BITS | triangle;
                for (v[2] = first[2]; v[2] <= last[2]; v[2]++)
                    for (v[1] = first[1]; v[1] <= last[1]; v[1]++)
                        for (v[0] = first[0]; v[0] <= last[0]; v[0]++) {
                            uint32_t *slot = &g->begin[voxel_number(g, v)];
                            if (write)
                                g->entry[(*slot)++] = number;
                            else
                                slot[1]++;
                        }
            }
}

static void destroy(const cw_allocator *memory, void *grid) {
    struct cw_grid3d *g = grid;
    cw_memory_free(memory, g->begin);
    cw_memory_free(memory, g->entry);
    cw_memory_free(memory, g);
}

static cw_status build_grid3d(cw_field *field) {
    struct cw_grid3d *g = cw_memory_clear(&field->memory, sizeof *g);
    if (g == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    set_resolution(g, field);
    const size_t voxels = (size_t)g->n[0] * (size_t)g->n[1] * (size_t)g->n[2];
    g->begin = cw_memory_clear(&field->memory, (voxels + 2) * sizeof *g->begin);
    if (g->begin == NULL) goto no_memory;
    enter_triangles(g, field, false);
    uint64_t entries = 0;
    for (size_t v = 0; v < voxels; v++) {
        entries += g->begin[v + 1];
        if (entries > UINT32_MAX) goto no_memory;
        g->begin[v + 1] = (uint32_t)entries;
    }
    g->entry = cw_memory_allocate(&field->memory, entries * sizeof *g->entry);
    if (g->entry == NULL) goto no_memory;
    enter_triangles(g, field, true);
    /* Writing moved each begin to its end, which is the next one's begin. */
    for (size_t v = voxels; v > 0; v--) g->begin[v] = g->begin[v - 1];
    g->begin[0] = 0;
    field->guest = (cw_guest){
        .structure = g,
        .destroy = destroy,
        .bytes = sizeof *g + (voxels + 2) * sizeof *g->begin + entries * sizeof *g->entry,
    };
    return CW_OK;
no_memory:
    destroy(&field->memory, g);
    return cw_fail_plainly(CW_ERROR_MEMORY);
}

/* The state of a ray's walk through the grid. */
typedef struct grid_walk {
    int voxel[3], step[3], end[3];
    float next[3]; /* t of the next crossing on each axis */
    float org[3], inverse[3];
} grid_walk;

static float crossing(const struct cw_grid3d *g, const grid_walk *w, int axis) {
    const int border = w->voxel[axis] + (w->step[axis] > 0);
    /* The outermost borders are the box itself, so that rounding puts no hit beyond the last voxel. */
    const float at = border == g->n[axis] ? g->high[axis] : g->low[axis] + (float)border * g->size[axis];
    return (at - w->org[axis]) * w->inverse[axis];
}

/* Slab test with the box padded by the rounding error at its faces (Ize 2013: 2 ulp of the far t). */
static bool enter_grid(const struct cw_grid3d *g, const ray_start *ray, grid_walk *w) {
    float t0 = ray->tmin, t1 = ray->tmax;
    for (int a = 0; a < 3; a++) {
        const float inverse = 1 / ray->dir[a];
        w->org[a] = ray->org[a];
        w->inverse[a] = inverse;
        if (!(fabsf(inverse) <= FLT_MAX)) {
            if (!(ray->org[a] >= g->low[a] && ray->org[a] <= g->high[a])) return false;
            w->inverse[a] = 0;
            continue;
        }
        const float ta = (g->low[a] - ray->org[a]) * inverse, tb = (g->high[a] - ray->org[a]) * inverse;
        const float near = fminf(ta, tb), far = fmaxf(ta, tb);
        t0 = fmaxf(t0, near - fabsf(near) * 4 * FLT_EPSILON);
        t1 = fminf(t1, far + fabsf(far) * 4 * FLT_EPSILON);
    }
    if (!(t0 <= t1)) return false;
    for (int a = 0; a < 3; a++) {
        w->voxel[a] = voxel_of(g, ray->org[a] + t0 * ray->dir[a], a);
        w->step[a] = w->inverse[a] > 0 ? 1 : -1;
        w->end[a] = w->inverse[a] > 0 ? g->n[a] : -1;
        w->next[a] = w->inverse[a] == 0 ? INFINITY : crossing(g, w, a);
    }
    return true;
}

/* Nearest hit among the voxel's triangles. */
static bool test_voxel(const struct cw_grid3d *g, const cw_field *f, const ray_start *ray, const grid_walk *w,
                       cw_hit *best) {
    const size_t v = voxel_number(g, w->voxel);
    const mt_range range = {ray->tmin, ray->tmax, -INFINITY, INFINITY};
    bool found = false;
    for (uint32_t k = g->begin[v]; k < g->begin[v + 1]; k++) {
        const size_t number = g->entry[k] >> TRIANGLE_BITS, i = number % f->nx, j = number / f->nx;
        const float *h = f->z + j * f->stride + i;
        const float h00 = h[0], h11 = h[f->stride + 1];
        const float o[3] = {ray->org[0] - (float)i, ray->org[1] - (float)j, ray->org[2] - h00};
        const bool a = (g->entry[k] & 1) == CW_TRIANGLE_A;
        cw_hit hit = {.i = (int32_t)i, .j = (int32_t)j, .triangle = a ? CW_TRIANGLE_A : CW_TRIANGLE_B};
        if (!(a ? mt_triangle(o, ray->dir, false, h[1] - h00, true, h11 - h00, &range, &hit)
                : mt_triangle(o, ray->dir, true, h11 - h00, false, h[f->stride] - h00, &range, &hit)))
            continue;
        if (found && !(hit.t < best->t)) continue;
        *best = hit;
        found = true;
    }
    return found;
}

static inline bool walk(const cw_field *f, const ray_start *ray, bool any, cw_hit *hit) {
    const struct cw_grid3d *g = f->guest.structure;
    grid_walk w;
    bool found = false;
    if (!enter_grid(g, ray, &w)) return false;
    for (;;) { /* at most n[0] + n[1] + n[2] voxels */
        const int axis = w.next[0] <= w.next[1] ? (w.next[0] <= w.next[2] ? 0 : 2) : (w.next[1] <= w.next[2] ? 1 : 2);
        cw_hit candidate;
        if (test_voxel(g, f, ray, &w, &candidate) && (!found || candidate.t < hit->t)) {
            *hit = candidate;
            found = true;
            if (any) return true;
        }
        /* A hit beyond this voxel waits: a voxel in between may hold a nearer one. */
        if (found && hit->t <= w.next[axis]) return true;
        if (w.next[axis] > ray->tmax) return found;
        w.voxel[axis] += w.step[axis];
        if (w.voxel[axis] == w.end[axis]) return found;
        w.next[axis] = crossing(g, &w, axis);
    }
}

static inline bool trace_grid3d(const cw_field *f, const cw_ray *given, bool any, cw_hit *hit) {
    ray_start ray;
    if (!ray_init(&ray, f, given) || !walk(f, &ray, any, hit)) return false;
    if (!any) *hit = refine_place(f, &ray, hit);
    return true;
}

/* For occluded it returns at the first triangle hit, also if a later voxel has a nearer one. */
static void trace_all_grid3d(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_each(f, rays, n, hits, occluded, trace_grid3d);
}

/* ---- their names ------------------------------------------------------------------------------------------------- */

static const cw_kernel_code brute = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_all_brute}};
static const cw_kernel_code grid3d = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_all_grid3d}};

static const cw_kernel kernels[] = {
    {"brute", "every triangle: the ground truth for small fields", CW_ISA_SCALAR, 1, &brute, .to_field = cw_to_field1},
    {"grid3d", "uniform 3D grid, 3D-DDA", CW_ISA_SCALAR, 1, &grid3d, cw_to_field1, .build = build_grid3d},
};

void cw_reference_add(void) { cw_kernels_add(kernels, sizeof kernels / sizeof kernels[0]); }
