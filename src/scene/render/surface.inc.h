/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_SURFACE_INC_H
#define CELLWALK_SCENE_SURFACE_INC_H

#include "lanes.h"
#include "wave.h"

#include <string.h>

/* A strip of paths that end on one shape: where, and how the surface lies there, in the shape's space. */

/* Copies what a strip's paths have in an array of the wave. Paths in a row, which are the rule, need no indices. */
static void fetch(const wave_strip *s, bool in_a_row, const float *from, float *to) {
    if (in_a_row)
        memcpy(to, from + s->path[0], s->n * sizeof *to);
    else
        for (size_t k = 0; k < s->n; k++) to[k] = from[s->path[k]];
}

/* Takes up to WAVE_STRIP paths; the last one fills up the last lanes. */
static bool begin_strip(wave *w, const uint32_t *path, size_t n) {
    wave_strip *s = &w->strip;
    s->n = wave_lanes(n);
    for (size_t k = 0; k < s->n; k++) s->path[k] = path[k < n ? k : n - 1];
    return !w->plan->general && s->n == n && s->path[n - 1] - s->path[0] == n - 1;
}

/* The rays that came, and for a cylinder where they ended and its normals, which are (x, y, 0). */
static void arrive(wave *w, const wave_rays *r, size_t home, size_t shape, bool turns, bool in_a_row) {
    wave_strip *s = &w->strip;
    float m[3][4];
    memcpy(m, plan_map_to(w->plan, shape, home)->m, sizeof m);
    for (int c = 0; c < 3; c++) fetch(s, in_a_row, r->dir[c], s->in[c]);
    fetch(s, in_a_row, w->t, s->t);
    for (size_t k = 0; k < s->n; k++)
        for (int c = 0; c < 3; c++) s->dir[c][k] = lane_turn(m[c], s->in[0][k], s->in[1][k], s->in[2][k]);
    if (w->plan->shapes[shape].field != NULL) return;

    if (home == PLAN_CAMERA) {
        for (int c = 0; c < 3; c++)
            for (size_t k = 0; k < s->n; k++) s->at[c][k] = m[c][3] + s->t[k] * s->dir[c][k];
    } else {
        for (int c = 0; c < 3; c++) fetch(s, in_a_row, r->org[c], s->in[c]);
        for (size_t k = 0; k < s->n; k++)
            for (int c = 0; c < 3; c++)
                s->at[c][k] = lane_move(m[c], s->in[0][k], s->in[1][k], s->in[2][k]) + s->t[k] * s->dir[c][k];
    }
    for (size_t k = 0; k < s->n; k++) {
        s->flat[0][k] = s->normal[0][k] = s->at[0][k];
        s->flat[1][k] = s->normal[1][k] = s->at[1][k];
        s->flat[2][k] = s->normal[2][k] = 0;
    }
    if (!turns) return;
    memset(s->turn, 0, sizeof s->turn);
    for (size_t k = 0; k < s->n; k++) s->turn[0][0][k] = s->turn[1][1][k] = 1;
}

/* ---- height fields ------------------------------------------------------------------------------------------------ */

/* The cell's corners (0, 0), (1, 0), (0, 1), (1, 1), the point and the normal of the flat triangle, which is long as many
 * times its area as every other one's. */
static void on_field(wave *w, const plan_shape *shape) {
    wave_strip *s = &w->strip;
    const float *samples = shape->field->samples;
    const cw_hit *answers = w->answers[shape - w->plan->shapes];
    const size_t nx = shape->field->nx;
    for (size_t k = 0; k < s->n; k++) {
        const cw_hit *hit = &answers[w->hit[s->path[k]]];
        const float *z = samples + (size_t)hit->j * nx + (size_t)hit->i;
        s->i[k] = hit->i;
        s->j[k] = hit->j;
        s->lower[k] = hit->triangle == CW_TRIANGLE_A;
        s->u[k] = hit->u;
        s->v[k] = hit->v;
        s->corner[0][k] = z[0];
        s->corner[1][k] = z[1];
        s->corner[2][k] = z[nx];
        s->corner[3][k] = z[nx + 1];
        s->third[k] = z[hit->triangle == CW_TRIANGLE_A ? 1 : nx];
    }
    for (size_t k = 0; k < s->n; k++) {
        const float z = s->corner[0][k], east = s->corner[1][k], north = s->corner[2][k], far = s->corner[3][k];
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

/* Vertices that a normal is made from: the cell's corners at both ends of its diagonal, the third corner of the triangle,
 * and the fourth of the cell. */
enum { VERTEX_FIRST, VERTEX_LAST, VERTEX_THIRD, VERTEX_FOURTH };
enum { EAST, NORTH, WEST, SOUTH, NORTH_EAST, SOUTH_WEST };

/* The samples around some of these vertices; none of them stands at the border. */
static void fetch_around(wave *w, const plan_shape *shape, int vertices) {
    wave_strip *s = &w->strip;
    const float *samples = shape->field->samples;
    const ptrdiff_t nx = (ptrdiff_t)shape->field->nx;
    for (size_t k = 0; k < s->n; k++) {
        const float *z = samples + s->j[k] * nx + s->i[k];
        const float *vertex[4] = {z, z + nx + 1, z + (s->lower[k] ? 1 : nx), z + (s->lower[k] ? nx : 1)};
        for (int q = 0; q < vertices; q++) {
            const float *c = vertex[q];
            s->around[q][EAST][k] = c[1];
            s->around[q][NORTH][k] = c[nx];
            s->around[q][WEST][k] = c[-1];
            s->around[q][SOUTH][k] = c[-nx];
            s->around[q][NORTH_EAST][k] = c[nx + 1];
            s->around[q][SOUTH_WEST][k] = c[-nx - 1];
        }
    }
}

/* The same where a vertex may stand at the border: a sample that is not there is one that is, and there says so. */
static void fetch_around_border(wave *w, const plan_shape *shape, int vertices) {
    wave_strip *s = &w->strip;
    const float *samples = shape->field->samples;
    const int32_t nx = (int32_t)shape->field->nx, last_i = nx - 1, last_j = (int32_t)shape->field->ny - 1;
    for (int q = 0; q < vertices; q++) {
        /* Where the vertex is in its cell: the same for all paths, or as in the lower triangle, or as in the upper one. */
        const int32_t last = q == VERTEX_LAST, third = q == VERTEX_THIRD, fourth = q == VERTEX_FOURTH;
        int32_t i[WAVE_STRIP], j[WAVE_STRIP], step[4][WAVE_STRIP];
        for (size_t k = 0; k < s->n; k++) {
            const int32_t lower = s->lower[k], upper = lower ^ 1;
            i[k] = s->i[k] + (last | (third & lower) | (fourth & upper));
            j[k] = s->j[k] + (last | (third & upper) | (fourth & lower));
            const int32_t east = i[k]<last_i, north = j[k]<last_j, west = i[k]> 0, south = j[k]> 0;
            s->there[q][EAST][k] = (float)east;
            s->there[q][NORTH][k] = (float)north;
            s->there[q][WEST][k] = (float)west;
            s->there[q][SOUTH][k] = (float)south;
            step[EAST][k] = east;
            step[NORTH][k] = nx * north;
            step[WEST][k] = -west;
            step[SOUTH][k] = -nx * south;
        }
        for (size_t k = 0; k < s->n; k++) {
            const float *c = samples + (ptrdiff_t)j[k] * nx + i[k];
            for (int side = 0; side < 4; side++) s->around[q][side][k] = c[step[side][k]];
            s->around[q][NORTH_EAST][k] = c[step[NORTH][k] + step[EAST][k]];
            s->around[q][SOUTH_WEST][k] = c[step[SOUTH][k] + step[WEST][k]];
        }
    }
}

static bool at_border(const wave_strip *s, const plan_shape *shape) {
    const int32_t last_i = (int32_t)shape->field->nx - 2, last_j = (int32_t)shape->field->ny - 2;
    int32_t border = 0;
    for (size_t k = 0; k < s->n; k++)
        border |= (s->i[k] == 0) | (s->j[k] == 0) | (s->i[k] == last_i) | (s->j[k] == last_j);
    return border != 0;
}

/* A vertex's normal is the sum of those of its triangles, at most six: both of the cells to the north-east and the
 * south-west, the lower one to the north-west, the upper one to the south-east. n, e, w and s are 1 or 0 as these cells are
 * there; multiplied by 1 all bits stay, so that a vertex inside needs no such factor. */
typedef struct vertex {
    float x, y, z;
} vertex;

LANE_INLINE vertex vertex_inside(float c, float e, float n, float w, float s, float ne, float sw) {
    const float x = (((e - c) + (ne - n)) + ((s - sw) + (c - w))) + ((c - w) + (e - c));
    const float y = (((ne - e) + (n - c)) + ((c - s) + (w - sw))) + ((n - c) + (c - s));
    return (vertex){-x, -y, 6};
}

LANE_INLINE vertex vertex_at_border(float c, float e, float n, float w, float s, float ne, float sw, float has_e,
                                    float has_n, float has_w, float has_s) {
    const float to_ne = has_n * has_e, to_sw = has_s * has_w, to_nw = has_n * has_w, to_se = has_s * has_e;
    const float x = (to_ne * ((e - c) + (ne - n)) + to_sw * ((s - sw) + (c - w))) + (to_nw * (c - w) + to_se * (e - c));
    const float y = (to_ne * ((ne - e) + (n - c)) + to_sw * ((c - s) + (w - sw))) + (to_nw * (n - c) + to_se * (c - s));
    return (vertex){-x, -y, 2 * (to_ne + to_sw) + (to_nw + to_se)};
}

/* Central differences; at the border the difference to the one neighbour. Scaled by 1 where both are there. */
LANE_INLINE vertex vertex_central(float e, float n, float w, float s, float has_e, float has_n, float has_w,
                                  float has_s) {
    return (vertex){(w - e) / (has_e + has_w), (s - n) / (has_n + has_s), 1};
}

LANE_INLINE vertex vertex_of(const wave_strip *s, int q, float c, size_t k, bool border, bool central) {
    const float(*a)[WAVE_STRIP] = s->around[q], (*has)[WAVE_STRIP] = s->there[q];
    if (central && border)
        return vertex_central(a[EAST][k], a[NORTH][k], a[WEST][k], a[SOUTH][k], has[EAST][k], has[NORTH][k],
                              has[WEST][k], has[SOUTH][k]);
    if (central) return vertex_central(a[EAST][k], a[NORTH][k], a[WEST][k], a[SOUTH][k], 1, 1, 1, 1);
    if (border)
        return vertex_at_border(c, a[EAST][k], a[NORTH][k], a[WEST][k], a[SOUTH][k], a[NORTH_EAST][k], a[SOUTH_WEST][k],
                                has[EAST][k], has[NORTH][k], has[WEST][k], has[SOUTH][k]);
    return vertex_inside(c, a[EAST][k], a[NORTH][k], a[WEST][k], a[SOUTH][k], a[NORTH_EAST][k], a[SOUTH_WEST][k]);
}

LANE_INLINE void set_turn(wave_strip *s, size_t k, int axis, float x, float y, float z) {
    s->turn[axis][0][k] = x;
    s->turn[axis][1][k] = y;
    s->turn[axis][2][k] = z;
}

/* The normals of the triangle's vertices, interpolated by the hit's barycentric coordinates. */
LANE_INLINE void barycentric(wave_strip *restrict s, bool border, bool central, bool turns) {
    for (size_t k = 0; k < s->n; k++) {
        const int32_t lower = s->lower[k];
        const vertex first = vertex_of(s, VERTEX_FIRST, s->corner[0][k], k, border, central);
        const vertex last = vertex_of(s, VERTEX_LAST, s->corner[3][k], k, border, central);
        const vertex third = vertex_of(s, VERTEX_THIRD, s->third[k], k, border, central);
        const float u = s->u[k], v = s->v[k], a = 1 - u - v, b = lower ? v : u, c = lower ? u : v;
        s->normal[0][k] = a * first.x + b * last.x + c * third.x;
        s->normal[1][k] = a * first.y + b * last.y + c * third.y;
        s->normal[2][k] = a * first.z + b * last.z + c * third.z;
        if (!turns) continue;
        /* From the first vertex to the third one leads a step along x in the lower triangle, along y in the upper one. */
        const vertex to = {third.x - first.x, third.y - first.y, third.z - first.z};
        const vertex on = {last.x - third.x, last.y - third.y, last.z - third.z};
        set_turn(s, k, 0, lower ? to.x : on.x, lower ? to.y : on.y, lower ? to.z : on.z);
        set_turn(s, k, 1, lower ? on.x : to.x, lower ? on.y : to.y, lower ? on.z : to.z);
    }
}

/* Those of the cell's four corners, interpolated along x and y. */
LANE_INLINE void bilinear(wave_strip *restrict s, bool border, bool turns) {
    for (size_t k = 0; k < s->n; k++) {
        const int32_t lower = s->lower[k];
        const vertex first = vertex_of(s, VERTEX_FIRST, 0, k, border, true);
        const vertex last = vertex_of(s, VERTEX_LAST, 0, k, border, true);
        const vertex third = vertex_of(s, VERTEX_THIRD, 0, k, border, true);
        const vertex fourth = vertex_of(s, VERTEX_FOURTH, 0, k, border, true);
        const vertex east = {lower ? third.x : fourth.x, lower ? third.y : fourth.y, 1};
        const vertex north = {lower ? fourth.x : third.x, lower ? fourth.y : third.y, 1};
        const float u = s->u[k], v = s->v[k], sum = u + v, x = lower ? sum : u, y = lower ? v : sum;
        const vertex below = {first.x + x * (east.x - first.x), first.y + x * (east.y - first.y), 1};
        const vertex above = {north.x + x * (last.x - north.x), north.y + x * (last.y - north.y), 1};
        s->normal[0][k] = below.x + y * (above.x - below.x);
        s->normal[1][k] = below.y + y * (above.y - below.y);
        s->normal[2][k] = 1;
        if (!turns) continue;
        set_turn(s, k, 0, (1 - y) * (east.x - first.x) + y * (last.x - north.x),
                 (1 - y) * (east.y - first.y) + y * (last.y - north.y), 0);
        set_turn(s, k, 1, above.x - below.x, above.y - below.y, 0);
    }
}

/* Normals for shading and, for mirrored spreads, how they turn. The constants pick the code that is compiled. */
static void field_normals(wave *w, const plan_shape *shape, bool turns) {
    wave_strip *s = &w->strip;
    const scene_normals kind = w->plan->normals;
    if (kind == SCENE_NORMALS_FLAT) {
        memcpy(s->normal, s->flat, sizeof s->normal);
        if (turns) memset(s->turn, 0, sizeof s->turn);
        return;
    }
    const bool border = w->plan->general || at_border(s, shape);
    const int vertices = kind == SCENE_NORMALS_BILINEAR ? 4 : 3;
    if (border)
        fetch_around_border(w, shape, vertices);
    else
        fetch_around(w, shape, vertices);
    switch (kind) {
    case SCENE_NORMALS_AREA:
        if (border && turns)
            barycentric(s, true, false, true);
        else if (border)
            barycentric(s, true, false, false);
        else if (turns)
            barycentric(s, false, false, true);
        else
            barycentric(s, false, false, false);
        break;
    case SCENE_NORMALS_CENTRAL:
        if (border && turns)
            barycentric(s, true, true, true);
        else if (border)
            barycentric(s, true, true, false);
        else if (turns)
            barycentric(s, false, true, true);
        else
            barycentric(s, false, true, false);
        break;
    default:
        if (border && turns)
            bilinear(s, true, true);
        else if (border)
            bilinear(s, true, false);
        else if (turns)
            bilinear(s, false, true);
        else
            bilinear(s, false, false);
    }
}

#endif
