/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_SHADE_INC_H
#define CELLWALK_SCENE_SHADE_INC_H

#include "air.inc.h"
#include "lookup.inc.h"
#include "surface.inc.h"

/* Light and paths that leave a strip's ends: shadow rays, or mirrored paths. Only parts that material, plan and
 * scene require are computed. */

static const float one_by_pi = 0.318309886f;

/* A neighbour's point, at (x, y, z) from a path's, along its own ray into the flat surface. */
LANE_INLINE void slide(wave_strip *s, size_t k, int axis, float x, float y, float z, float facing) {
    const float dx = s->dir[0][k], dy = s->dir[1][k], dz = s->dir[2][k];
    const float further = lane_dot(x, y, z, s->flat[0][k], s->flat[1][k], s->flat[2][k]) * facing;
    const float cx = x - further * dx, cy = y - further * dy, cz = z - further * dz;
    /* A ray that runs along the surface says nothing about the size of the sample's footprint. */
    const int finite = cx * cx + cy * cy + cz * cz <= FLT_MAX;
    s->apart[axis][0][k] = finite ? cx : 0;
    s->apart[axis][1][k] = finite ? cy : 0;
    s->apart[axis][2][k] = finite ? cz : 0;
}

LANE_INLINE float by_facing(const wave_strip *s, size_t k) {
    return 1 / lane_dot(s->dir[0][k], s->dir[1][k], s->dir[2][k], s->flat[0][k], s->flat[1][k], s->flat[2][k]);
}

/* Of camera rays this follows from the picture; the change of a direction along itself drops out. */
LANE_INLINE void spread_camera(wave_strip *restrict s, const plan_shape *shape, const float *restrict depth,
                               bool directions) {
    float step[2][3];
    memcpy(step, shape->step, sizeof step);
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float way = s->t[k], facing = by_facing(s, k);
        for (int a = 0; a < 2; a++) {
            const float x = depth[k] * step[a][0], y = depth[k] * step[a][1], z = depth[k] * step[a][2];
            slide(s, k, a, way * x, way * y, way * z, facing);
            if (!directions) continue;
            s->apart_dir[a][0][k] = x;
            s->apart_dir[a][1][k] = y;
            s->apart_dir[a][2][k] = z;
        }
    }
}

/* How far the points of neighbouring samples are from the strip's, in the flat surface; and how their directions
 * differ, if that is wanted. */
static void spread_on_surface(wave *w, const wave_rays *r, size_t home, const plan_shape *shape, bool in_a_row,
                              bool directions) {
    wave_strip *s = &w->strip;
    if (home == PLAN_CAMERA) {
        const float *depth = fetch(s, in_a_row, r->dir[2], s->in[0]);
        if (directions)
            spread_camera(s, shape, depth, true);
        else
            spread_camera(s, shape, depth, false);
        return;
    }
    const plan_map map = plan_map_to(w->plan, (size_t)(shape - w->plan->shapes), home);
    const wave_spread *spread = r->spread;
    for (int a = 0; a < 2; a++) {
        const float *in[3];
        fetch_vector(s, in_a_row, spread->dir[a], s->in, in);
        turn_vectors(&map, in[0], in[1], in[2], wave_whole(s->n), s->apart_dir[a]);
        fetch_vector(s, in_a_row, spread->org[a], s->in, in);
        turn_vectors(&map, in[0], in[1], in[2], wave_whole(s->n), s->apart[a]);
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float way = s->t[k], facing = by_facing(s, k);
        for (int a = 0; a < 2; a++)
            slide(s, k, a, s->apart[a][0][k] + way * s->apart_dir[a][0][k],
                  s->apart[a][1][k] + way * s->apart_dir[a][1][k], s->apart[a][2][k] + way * s->apart_dir[a][2][k],
                  facing);
    }
}

static const float by_whole_turn = 0.159154943f;

/* The angle of (x, y) as a share of the whole turn, in [-1/2, 1/2], to 2^-22: a tenth of a texel where an image is
 * 400000 texels wide. x and y are on the unit circle, so that no size needs care; the polynomial is within 4·10^-8
 * of atan(x) / 2 pi on [0, 1], with the least error that its degree allows. */
LANE_INLINE float turn_of(float x, float y) {
    const float ax = fabsf(x), ay = fabsf(y);
    const float tangent = ax > ay ? ay / ax : ax / ay, q = tangent * tangent;
    float sum = 0.00108400721f;
    sum = sum * q - 0.00534788379f;
    sum = sum * q + 0.0126720183f;
    sum = sum * q - 0.0210612342f;
    sum = sum * q + 0.0315250382f;
    sum = sum * q - 0.0530262291f;
    sum = sum * q + 0.159154326f;
    float turn = tangent * sum;
    turn = ay >= ax ? 0.25f - turn : turn;
    turn = x < 0 ? 0.5f - turn : turn;
    return y < 0 ? -turn : turn;
}

/* Texture coordinates and their changes. */
static void find_uv(wave_strip *s, const plan_shape *shape) {
    if (shape->field != NULL) {
        for (int a = 0; a < 2; a++) {
            const float scale = shape->uv_scale[a];
            for (size_t k = 0; k < wave_whole(s->n); k++) s->uv[a][k] = s->at[a][k] * scale;
            for (int b = 0; b < 2; b++)
                for (size_t k = 0; k < wave_whole(s->n); k++) s->uv_apart[b][a][k] = s->apart[b][a][k] * scale;
        }
        return;
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        s->uv[0][k] = turn_of(s->at[0][k], s->at[1][k]); /* images repeat: [-1/2, 0) is as good as [1/2, 1) */
        s->uv[1][k] = (s->at[2][k] + 1) * 0.5f;
        for (int b = 0; b < 2; b++) {
            s->uv_apart[b][0][k] = (s->at[0][k] * s->apart[b][1][k] - s->at[1][k] * s->apart[b][0][k]) * by_whole_turn;
            s->uv_apart[b][1][k] = s->apart[b][2][k] * 0.5f;
        }
    }
}

/* The share of each colour that a matte strip reflects, and of that the light that arrives at the pixel. */
static void find_colour(wave *w, const wave_rays *r, size_t home, const plan_shape *shape, bool in_a_row) {
    wave_strip *s = &w->strip;
    const material *m = shape->surface;
    if (m->image != NULL) {
        spread_on_surface(w, r, home, shape, in_a_row, false);
        find_uv(s, shape);
        look_up(w, m->image);
    } else {
        for (int c = 0; c < 3; c++) {
            const float colour = m->colour[c];
            for (size_t k = 0; k < wave_whole(s->n); k++) s->colour[c][k] = colour;
        }
    }
    if (home == PLAN_CAMERA) return;
    for (int c = 0; c < 3; c++) {
        const float *share = fetch(s, in_a_row, r->share[c], s->in[c]);
        for (size_t k = 0; k < wave_whole(s->n); k++) s->colour[c][k] *= share[k];
    }
}

/* Appends the ways to a light whose light would count (Lambert's law, Kd / pi). */
static void send_light(wave *w, const wave_rays *r, const plan_shape *shape, size_t n, size_t light) {
    wave_strip *s = &w->strip;
    wave_shadows *to = &w->shadows[light];
    const size_t count = to->count;
    float place[3];
    plan_light(w->plan, (size_t)(shape - w->plan->shapes), light, place);
    const float lx = place[0], ly = place[1], lz = place[2], offset = shape->offset;
    const float *intensity = w->plan->scene->lights[light].intensity;
    const float ir = intensity[0], ig = intensity[1], ib = intensity[2];
    float g[6], inverse[6];
    memcpy(g, shape->metric.g, sizeof g);
    memcpy(inverse, shape->inverse.g, sizeof inverse);
    int32_t counts[WAVE_STRIP];
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float tx = lx - s->at[0][k], ty = ly - s->at[1][k], tz = lz - s->at[2][k];
        /* Eye and light must be on the same side of the flat surface. */
        const float facing =
            lane_dot(s->dir[0][k], s->dir[1][k], s->dir[2][k], s->flat[0][k], s->flat[1][k], s->flat[2][k]);
        const float lit = lane_dot(tx, ty, tz, s->flat[0][k], s->flat[1][k], s->flat[2][k]);
        const float nx = s->normal[0][k], ny = s->normal[1][k], nz = s->normal[2][k];
        const float distance = lane_square(g, tx, ty, tz), length = lane_square(inverse, nx, ny, nz);
        /* One division for two reciprocals. */
        const float root = sqrtf(length), both = 1 / (sqrtf(distance) * root), near = root * both;
        const float cosine = fabsf(lane_dot(tx, ty, tz, nx, ny, nz)) * both;
        const float share = cosine * (near * near) * one_by_pi;
        const float red = s->colour[0][k] * ir * share, green = s->colour[1][k] * ig * share;
        const float blue = s->colour[2][k] * ib * share;
        counts[k] = (lit * facing < 0) & (share > 0) & ((red > 0) | (green > 0) | (blue > 0));
        to->tmin[count + k] = offset * s->t[k] * near;
        to->light[0][count + k] = red;
        to->light[1][count + k] = green;
        to->light[2][count + k] = blue;
    }
    for (int c = 0; c < 3; c++) memcpy(&to->org[c][count], s->at[c], s->n * sizeof s->at[c][0]);
    for (size_t k = 0; k < wave_whole(s->n); k++) to->pixel[count + k] = r->pixel[s->path[k]];

    int32_t all = 1;
    for (size_t k = 0; k < n; k++) all &= counts[k];
    if (all) {
        to->count += n;
        return;
    }
    size_t kept = count;
    for (size_t k = 0; k < n; k++) {
        const size_t from = count + k;
        for (int c = 0; c < 3; c++) {
            to->org[c][kept] = to->org[c][from];
            to->light[c][kept] = to->light[c][from];
        }
        to->tmin[kept] = to->tmin[from];
        to->pixel[kept] = to->pixel[from];
        kept += (size_t)counts[k];
    }
    to->count = kept;
}

/* Appends the mirrored paths to the next wave. A direction d becomes d - 2 (d · n) n for the unit normal n; in a
 * shape's space, d - 2 (d · N) / (N · m) m, where m is the inverse metric times N. */
static void send_mirrored(wave *w, const wave_rays *r, size_t home, const plan_shape *shape, bool in_a_row, size_t n,
                          wave_rays *next) {
    wave_strip *s = &w->strip;
    const size_t count = next->count;
    const float offset = shape->offset, *colour = shape->surface->colour;
    float inverse[6];
    memcpy(inverse, shape->inverse.g, sizeof inverse);
    for (size_t k = 0; k < wave_whole(s->n); k++) {
        const float nx = s->normal[0][k], ny = s->normal[1][k], nz = s->normal[2][k];
        const float mx = lane_row(inverse, 0, nx, ny, nz), my = lane_row(inverse, 1, nx, ny, nz);
        const float mz = lane_row(inverse, 2, nx, ny, nz);
        const float dx = s->dir[0][k], dy = s->dir[1][k], dz = s->dir[2][k];
        const float twice = 2 * lane_dot(dx, dy, dz, nx, ny, nz) / lane_dot(mx, my, mz, nx, ny, nz);
        next->dir[0][count + k] = dx - twice * mx;
        next->dir[1][count + k] = dy - twice * my;
        next->dir[2][count + k] = dz - twice * mz;
        next->tmin[count + k] = offset * s->t[k];
    }
    for (int c = 0; c < 3; c++) memcpy(&next->org[c][count], s->at[c], s->n * sizeof s->at[c][0]);
    for (int c = 0; c < 3; c++) {
        const float kr = colour[c];
        if (home == PLAN_CAMERA) {
            for (size_t k = 0; k < wave_whole(s->n); k++) next->share[c][count + k] = kr;
        } else {
            const float *share = fetch(s, in_a_row, r->share[c], s->in[c]);
            for (size_t k = 0; k < wave_whole(s->n); k++) next->share[c][count + k] = share[k] * kr;
        }
    }
    for (size_t k = 0; k < wave_whole(s->n); k++) next->pixel[count + k] = r->pixel[s->path[k]];
    next->count += n;
    w->stats.mirror_rays += n;
}

/* How the mirrored paths spread: the same formula differentiated, with the normal's change over the point's. */
static void spread_mirrored(const wave_strip *restrict s, const plan_shape *shape, size_t count,
                            wave_spread *restrict next) {
    const size_t n = wave_whole(s->n);
    float inverse[6];
    memcpy(inverse, shape->inverse.g, sizeof inverse);
    for (int a = 0; a < 2; a++) {
        for (int c = 0; c < 3; c++) memcpy(&next->org[a][c][count], s->apart[a][c], n * sizeof(float));
        for (size_t k = 0; k < n; k++) {
            const float nx = s->normal[0][k], ny = s->normal[1][k], nz = s->normal[2][k];
            const float mx = lane_row(inverse, 0, nx, ny, nz), my = lane_row(inverse, 1, nx, ny, nz);
            const float mz = lane_row(inverse, 2, nx, ny, nz);
            const float dx = s->dir[0][k], dy = s->dir[1][k], dz = s->dir[2][k];
            const float cx = s->apart[a][0][k], cy = s->apart[a][1][k];
            const float tx = cx * s->turn[0][0][k] + cy * s->turn[1][0][k];
            const float ty = cx * s->turn[0][1][k] + cy * s->turn[1][1][k];
            const float tz = cx * s->turn[0][2][k] + cy * s->turn[1][2][k];
            const float wx = lane_row(inverse, 0, tx, ty, tz), wy = lane_row(inverse, 1, tx, ty, tz);
            const float wz = lane_row(inverse, 2, tx, ty, tz);
            const float ex = s->apart_dir[a][0][k], ey = s->apart_dir[a][1][k], ez = s->apart_dir[a][2][k];
            const float square = 1 / lane_dot(mx, my, mz, nx, ny, nz);
            const float along = lane_dot(dx, dy, dz, nx, ny, nz) * square;
            const float along_change = (lane_dot(ex, ey, ez, nx, ny, nz) + lane_dot(dx, dy, dz, tx, ty, tz) -
                                        2 * along * lane_dot(mx, my, mz, tx, ty, tz)) *
                                       square;
            next->dir[a][0][count + k] = ex - 2 * (along * wx + along_change * mx);
            next->dir[a][1][count + k] = ey - 2 * (along * wy + along_change * my);
            next->dir[a][2][count + k] = ez - 2 * (along * wz + along_change * mz);
        }
    }
}

/* The paths of a segment that end on a shape, in order; how many. Neighbours mostly end on the same shape. */
static size_t paths_on(wave *w, const wave_segment *g, size_t shape) {
    const int32_t wanted = (int32_t)shape;
    size_t n = 0, k = g->begin;
    for (; k + WAVE_LANES <= g->end; k += WAVE_LANES) {
        const int32_t *which = &w->shape[k];
        int32_t here = 0;
        for (int q = 0; q < WAVE_LANES; q++) here += which[q] == wanted;
        if (here == 0) continue;
        if (here == WAVE_LANES) {
            for (size_t q = 0; q < WAVE_LANES; q++) w->path[n + q] = (uint32_t)(k + q);
            n += WAVE_LANES;
            continue;
        }
        for (size_t q = 0; q < WAVE_LANES; q++) {
            w->path[n] = (uint32_t)(k + q);
            n += which[q] == wanted;
        }
    }
    for (; k < g->end; k++) {
        w->path[n] = (uint32_t)k;
        n += w->shape[k] == wanted;
    }
    return n;
}

static void shade_strip(wave *w, const wave_rays *r, size_t home, size_t number, const uint32_t *path, size_t n,
                        wave_rays *next) {
    const plan *p = w->plan;
    const plan_shape *shape = &p->shapes[number];
    const bool mirror = shape->surface->kind == MIRROR, turns = mirror && p->spreads;
    const bool in_a_row = begin_strip(w, path, n);
    arrive(w, r, home, number, turns, in_a_row);
    if (shape->field != NULL) {
        on_field(w, shape);
        field_normals(w, turns);
    }
    if (mirror) {
        const size_t count = next->count;
        send_mirrored(w, r, home, shape, in_a_row, n, next);
        if (!turns) return;
        spread_on_surface(w, r, home, shape, in_a_row, true);
        spread_mirrored(&w->strip, shape, count, next->spread);
        return;
    }
    find_colour(w, r, home, shape, in_a_row);
    if (p->scene->haze > 0) add_haze(w, r, home, n);
    for (size_t l = 0; l < p->light_count; l++) send_light(w, r, shape, n, l);
}

/* Collects the shadow rays of the wave at hand and makes the next one of its mirrored rays. No mirror counts in the
 * last bounce. */
static void shade(wave *w, const wave_rays *r, bool last, wave_rays *next) {
    const plan *p = w->plan;
    next->count = next->segment_count = 0;
    for (size_t l = 0; l < p->light_count; l++) w->shadows[l].count = w->shadows[l].segment_count = 0;
    for (size_t shape = 0; shape < p->shape_count; shape++) {
        if (!p->shapes[shape].sends || (last && p->shapes[shape].surface->kind == MIRROR)) continue;
        const size_t begin = next->count;
        for (size_t l = 0; l < p->light_count; l++)
            w->shadows[l].segments[w->shadows[l].segment_count] =
                (wave_segment){plan_home(shape), w->shadows[l].count, w->shadows[l].count};
        for (size_t s = 0; s < r->segment_count; s++) {
            const size_t n = paths_on(w, &r->segments[s], shape);
            for (size_t first = 0; first < n; first += WAVE_STRIP)
                shade_strip(w, r, r->segments[s].home, shape, w->path + first, wave_strip_of(first, n), next);
        }
        for (size_t l = 0; l < p->light_count; l++) {
            wave_shadows *to = &w->shadows[l];
            to->segments[to->segment_count].end = to->count;
            to->segment_count += to->count > to->segments[to->segment_count].begin;
        }
        if (next->count > begin)
            next->segments[next->segment_count++] = (wave_segment){plan_home(shape), begin, next->count};
    }
}

#endif
