/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_SURFACE_INC_H
#define CELLWALK_SCENE_SURFACE_INC_H

#include "lanes.h"
#include "wave.h"

#include <string.h>

/* A strip of paths that end on one shape: where, and how the surface lies there, in the shape's space. */

/* The elements of a wave's array that belong to a strip's paths: in place if they are consecutive, which is the
 * rule, else copied to room. */
static const float *fetch(const wave_strip *s, bool in_a_row, const float *from, float *room) {
    if (in_a_row) return from + s->path[0];
    for (size_t k = 0; k < wave_whole(s->n); k++) room[k] = from[s->path[k]];
    return room;
}

/* The same for loops of which compilers can tell the less that nothing overlaps, the more pointers there are. */
static void copy(const wave_strip *s, bool in_a_row, const float *from, float *to) {
    const float *there = fetch(s, in_a_row, from, to);
    if (there != to) memcpy(to, there, s->n * sizeof *to);
}

/* The same of three coordinates. */
static void fetch_vector(const wave_strip *s, bool in_a_row, const wave_vector from, float room[3][WAVE_STRIP],
                         const float *to[3]) {
    for (int c = 0; c < 3; c++) to[c] = fetch(s, in_a_row, from[c], room[c]);
}

/* Takes up to WAVE_STRIP paths; the last one fills up the last lanes. */
static bool begin_strip(wave *w, const uint32_t *path, size_t n) {
    wave_strip *s = &w->strip;
    s->n = wave_lanes(n);
    for (size_t k = 0; k < wave_whole(s->n); k++) s->path[k] = path[k < n ? k : n - 1];
    return !w->plan->general && s->n == n && s->path[n - 1] - s->path[0] == n - 1;
}

/* Vectors of one space in another one. */
LANE_INLINE void turn_vectors(const plan_map *map, const float *restrict x, const float *restrict y,
                              const float *restrict z, size_t n, float (*restrict to)[WAVE_STRIP]) {
    for (int c = 0; c < 3; c++) {
        const float row[4] = {map->m[c][0], map->m[c][1], map->m[c][2], 0};
        for (size_t k = 0; k < n; k++) to[c][k] = lane_turn(row, x[k], y[k], z[k]);
    }
}

/* The rays that came, and for a cylinder where they ended and its normals, which are (x, y, 0). */
static void arrive(wave *w, const wave_rays *r, size_t home, size_t shape, bool turns, bool in_a_row) {
    wave_strip *s = &w->strip;
    const plan_map map = plan_map_to(w->plan, shape, home);
    const float *in[3];
    fetch_vector(s, in_a_row, r->dir, s->in, in);
    turn_vectors(&map, in[0], in[1], in[2], wave_whole(s->n), s->dir);
    copy(s, in_a_row, w->t, s->t);
    if (w->plan->shapes[shape].field != NULL) return;

    if (home == PLAN_CAMERA) {
        for (int c = 0; c < 3; c++)
            for (size_t k = 0; k < wave_whole(s->n); k++) s->at[c][k] = map.m[c][3] + s->t[k] * s->dir[c][k];
    } else {
        fetch_vector(s, in_a_row, r->org, s->in, in);
        for (size_t k = 0; k < wave_whole(s->n); k++)
            for (int c = 0; c < 3; c++)
                s->at[c][k] = lane_move(map.m[c], in[0][k], in[1][k], in[2][k]) + s->t[k] * s->dir[c][k];
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        s->flat[0][k] = s->normal[0][k] = s->at[0][k];
        s->flat[1][k] = s->normal[1][k] = s->at[1][k];
        s->flat[2][k] = s->normal[2][k] = 0;
    }
    if (!turns) return;
    memset(s->turn, 0, sizeof s->turn);
    for (size_t k = 0; k < wave_whole(s->n); k++) s->turn[0][0][k] = s->turn[1][1][k] = 1;
}

/* ---- height fields ----------------------------------------------------------------------------------------------- */

LANE_INLINE ptrdiff_t clamp(ptrdiff_t x, ptrdiff_t last) { return x < 0 ? 0 : x > last ? last : x; }

/* Four samples of a row of last + 1, from i on, which is -1 at least and last - 2 at most. */
LANE_INLINE void copy_row(const float *row, ptrdiff_t i, ptrdiff_t last, float *to) {
    if (i >= 0 && i + 3 <= last) {
        memcpy(to, row + i, 4 * sizeof *to);
    } else if (i >= 0) {
        memcpy(to, row + i, 3 * sizeof *to);
        to[3] = row[last];
    } else {
        to[0] = row[0];
        for (ptrdiff_t c = 0; c < 3; c++) to[1 + c] = row[clamp(c, last)];
    }
}

/* The 4 x 4 samples around each cell. Each row of four is copied as it stands for sixteen paths; putting the even
 * places first, twice, sorts these by sample. In place of a sample beyond the border stands the one there. */
static void fetch_window(wave_strip *s, const plan_shape *shape) {
    const float *samples = shape->field->samples;
    const ptrdiff_t nx = (ptrdiff_t)shape->field->nx, last_i = nx - 1, last_j = (ptrdiff_t)shape->field->ny - 1;
    for (size_t first = 0; first < wave_whole(s->n); first += WAVE_LANES) {
        enum { ROW = 4 * WAVE_LANES };
        float row[4][ROW];
        for (size_t k = 0; k < WAVE_LANES; k++) {
            const ptrdiff_t i = s->i[first + k] - 1, j = s->j[first + k] - 1;
            for (int r = 0; r < 4; r++) copy_row(samples + clamp(j + r, last_j) * nx, i, last_i, &row[r][4 * k]);
        }
        for (size_t r = 0; r < 4; r++) {
            float half[ROW], sorted[ROW];
            lane_unweave(row[r], ROW, half);
            lane_unweave(half, ROW, sorted);
            for (size_t c = 0; c < 4; c++)
                memcpy(&s->window[4 * r + c][first], sorted + c * WAVE_LANES, WAVE_LANES * sizeof *sorted);
        }
    }
}

/* The sample of a window at (x, y) from its cell's first corner. */
enum { WINDOW_CELL = 5 };
LANE_INLINE float window_sample(const wave_strip *s, int x, int y, size_t k) {
    return s->window[WINDOW_CELL + 4 * y + x][k];
}

/* On which sides of each cell the field does not end. */
static void find_sides(wave_strip *s, const plan_shape *shape) {
    const int32_t last_i = (int32_t)shape->field->nx - 2, last_j = (int32_t)shape->field->ny - 2;
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const int32_t i = s->i[k], j = s->j[k];
        s->goes_on[EAST][k] = (float)(i < last_i);
        s->goes_on[NORTH][k] = (float)(j < last_j);
        s->goes_on[WEST][k] = (float)(i != 0);
        s->goes_on[SOUTH][k] = (float)(j != 0);
    }
}

/* The cell's corners (0, 0), (1, 0), (0, 1), (1, 1), the point and the normal of the flat triangle, which is long as
 * many times its area as every other one's. */
static void on_field(wave *w, const plan_shape *shape) {
    wave_strip *s = &w->strip;
    const float *samples = shape->field->samples;
    const cw_hit *answers = w->answers[shape - w->plan->shapes];
    const size_t nx = shape->field->nx;
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const cw_hit *hit = &answers[w->hit[s->path[k]]];
        s->i[k] = hit->i;
        s->j[k] = hit->j;
        s->lower[k] = hit->triangle == CW_TRIANGLE_A;
        s->u[k] = hit->u;
        s->v[k] = hit->v;
    }
    if (w->plan->smooth) {
        find_sides(s, shape);
        fetch_window(s, shape);
    } else {
        for (size_t k = 0; k < wave_whole(s->n); k++) {
            const float *z = samples + (size_t)s->j[k] * nx + (size_t)s->i[k];
            s->window[WINDOW_CELL][k] = z[0];
            s->window[WINDOW_CELL + 1][k] = z[1];
            s->window[WINDOW_CELL + 4][k] = z[nx];
            s->window[WINDOW_CELL + 5][k] = z[nx + 1];
        }
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float z = window_sample(s, 0, 0, k), east = window_sample(s, 1, 0, k);
        const float north = window_sample(s, 0, 1, k), far = window_sample(s, 1, 1, k);
        const float u = s->u[k], v = s->v[k], sum = u + v;
        const int32_t lower = s->lower[k];
        const float x = lower ? sum : u, y = lower ? v : sum;
        const float along_x = lower ? east - z : far - north, along_y = lower ? far - east : north - z;
        s->at[0][k] = (float)s->i[k] + x;
        s->at[1][k] = (float)s->j[k] + y;
        s->at[2][k] = z + (along_x * x + along_y * y);
        s->flat[0][k] = -along_x;
        s->flat[1][k] = -along_y;
        s->flat[2][k] = 1;
    }
}

/* Vertices of a normal: the cell's corners at both ends of its diagonal, and the third corner of the triangle. */
enum { VERTEX_FIRST, VERTEX_LAST, VERTEX_THIRD };

/* A vertex's normal is the sum of those of its triangles, at most six: both of the cells to the north-east and the
 * south-west, the lower one to the north-west, the upper one to the south-east. n, e, w and s are 1 or 0 as these
 * cells are there. */
typedef struct vertex {
    float x, y, z;
} vertex;

LANE_INLINE vertex vertex_from(float c, float e, float n, float w, float s, float ne, float sw, float has_e,
                               float has_n, float has_w, float has_s) {
    const float to_ne = has_n * has_e, to_sw = has_s * has_w, to_nw = has_n * has_w, to_se = has_s * has_e;
    const float x = (to_ne * ((e - c) + (ne - n)) + to_sw * ((s - sw) + (c - w))) + (to_nw * (c - w) + to_se * (e - c));
    const float y = (to_ne * ((ne - e) + (n - c)) + to_sw * ((c - s) + (w - sw))) + (to_nw * (n - c) + to_se * (c - s));
    return (vertex){-x, -y, 2 * (to_ne + to_sw) + (to_nw + to_se)};
}

/* A sample at (dx, dy) from a vertex in the window. */
LANE_INLINE float beside(const wave_strip *s, int q, int dx, int dy, size_t k) {
    if (q == VERTEX_FIRST) return window_sample(s, dx, dy, k);
    if (q == VERTEX_LAST) return window_sample(s, 1 + dx, 1 + dy, k);
    const float east = window_sample(s, 1 + dx, dy, k), north = window_sample(s, dx, 1 + dy, k);
    return s->lower[k] == 1 ? east : north;
}

LANE_INLINE vertex vertex_of(const wave_strip *s, int q, size_t k) {
    const float c = beside(s, q, 0, 0, k), e = beside(s, q, 1, 0, k), n = beside(s, q, 0, 1, k);
    const float west = beside(s, q, -1, 0, k), south = beside(s, q, 0, -1, k);
    const float ne = beside(s, q, 1, 1, k), sw = beside(s, q, -1, -1, k);
    /* Towards the cell the field goes on in any case. */
    const bool at_east = q == VERTEX_LAST, at_west = q == VERTEX_FIRST;
    const bool east_corner = s->lower[k] == 1;
    const float has_e = at_west ? 1 : at_east || east_corner ? s->goes_on[EAST][k] : 1;
    const float has_w = at_east ? 1 : at_west || !east_corner ? s->goes_on[WEST][k] : 1;
    const float has_n = at_west ? 1 : at_east || !east_corner ? s->goes_on[NORTH][k] : 1;
    const float has_s = at_east ? 1 : at_west || east_corner ? s->goes_on[SOUTH][k] : 1;
    return vertex_from(c, e, n, west, south, ne, sw, has_e, has_n, has_w, has_s);
}

LANE_INLINE void set_turn(wave_strip *s, size_t k, int axis, float x, float y, float z) {
    s->turn[axis][0][k] = x;
    s->turn[axis][1][k] = y;
    s->turn[axis][2][k] = z;
}

/* The normals of the triangle's vertices, interpolated by the hit's barycentric coordinates. */
LANE_INLINE void barycentric(wave_strip *restrict s, bool turns) {
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const int32_t lower = s->lower[k];
        const vertex first = vertex_of(s, VERTEX_FIRST, k);
        const vertex last = vertex_of(s, VERTEX_LAST, k);
        const vertex third = vertex_of(s, VERTEX_THIRD, k);
        const float u = s->u[k], v = s->v[k], a = 1 - u - v, b = lower ? v : u, c = lower ? u : v;
        s->normal[0][k] = a * first.x + b * last.x + c * third.x;
        s->normal[1][k] = a * first.y + b * last.y + c * third.y;
        s->normal[2][k] = a * first.z + b * last.z + c * third.z;
        if (!turns) continue;
        /* From the first vertex to the third one leads a step along x in the lower triangle, along y in the upper
         * one. */
        const vertex to = {third.x - first.x, third.y - first.y, third.z - first.z};
        const vertex on = {last.x - third.x, last.y - third.y, last.z - third.z};
        set_turn(s, k, 0, lower ? to.x : on.x, lower ? to.y : on.y, lower ? to.z : on.z);
        set_turn(s, k, 1, lower ? on.x : to.x, lower ? on.y : to.y, lower ? on.z : to.z);
    }
}

/* Normals for shading and, for mirrored spreads, how they turn. The constants pick the code that is compiled. */
static void field_normals(wave *w, bool turns) {
    wave_strip *s = &w->strip;
    if (!w->plan->smooth) {
        memcpy(s->normal, s->flat, sizeof s->normal);
        if (turns) memset(s->turn, 0, sizeof s->turn);
    } else {
        turns ? barycentric(s, true) : barycentric(s, false);
    }
}

#endif
