/* SPDX-License-Identifier: Apache-2.0 */
/* Grounds on which a walk goes on for long: planes, level ground, and rays that climb. */
#include "lanes_grounds.h"

#include "check.h"

#include <math.h>
#include <string.h>

/* ---- planes ------------------------------------------------------------------------------------------------------ */

cw_field *plane(ground *g, random_state *r) {
    static const field_size sizes[] = {{300, 257}, {66, 66},  {1500, 70}, {70, 1500},
                                       {2049, 9},  {5, 1025}, {513, 400}, {9001, 2}};
    static const int exponents[][8] = {{0, -3, -20, -60, -132, 40, 90, 0}, {0, -3, -20, -60, -132, 40, 90, -140}};
    const bool may_be_high = g->number % 5 > 1;
    const field_size size = sizes[g->number % 8];
    g->nx = size.nx;
    g->ny = size.ny;
    const double longest = (double)(g->nx > g->ny ? g->nx : g->ny);
    g->unit = ldexp(1, exponents[may_be_high][random_below(r, 8)]);
    if (g->unit > 1) g->unit /= longest;
    for (int c = 0; c < 2; c++)
        g->slope[c] = g->unit * (random_below(r, 3) ? random_between(r, -1, 1) : 0.125 * few(r, 4));
    g->base = random_below(r, 2) ? 0 : g->unit * random_between(r, -1000, 1000);
    g->high = may_be_high && random_below(r, 3) > 0;
    if (g->high) {
        const double level = pow(10, random_between(r, -4, 0));
        for (int c = 0; c < 2; c++) g->slope[c] *= level;
        if (g->unit <= 1 && random_below(r, 2)) g->base *= 1000;
    }
    const double ripple = random_below(r, 2) ? 0 : g->unit * pow(10, random_between(r, -8, -2));
    const size_t fin = random_below(r, 2) ? 0 : 20 + random_below(r, 200), holes = random_below(r, 3) ? 0 : 3000;
    const bool along = g->nx > g->ny;
    for (size_t j = 0; j < g->ny; j++)
        for (size_t i = 0; i < g->nx; i++) {
            float *z = &g->z[j * g->nx + i];
            const size_t place = along ? i : j;
            *z = (float)(g->base + g->slope[0] * (double)i + g->slope[1] * (double)j +
                         ripple * random_between(r, -1, 1));
            if (fin > 0 && place % fin == fin - 1 && 2 * place > (along ? g->nx : g->ny)) *z += (float)(g->unit * 0.01);
            if (holes > 0 && random_below(r, holes) == 0) *z = NAN;
        }
    g->z[0] = (float)g->base; /* where the plane begins: no hole */
    return field_of(g->z, g->nx, g->ny);
}

/* Parallel to the plane or nearly so: from within the field, its border, behind it, and from where rays are moved. */
static cw_ray beside_plane(const ground *g, random_state *r) {
    const double side[2] = {(double)(g->nx - 1), (double)(g->ny - 1)};
    double place[2], d[2];
    for (int c = 0; c < 2; c++) {
        place[c] = side[c] * random_unit(r);
        if (random_below(r, 3) == 0) place[c] = side[c] * (double)random_below(r, 2);
        if (random_below(r, 4) == 0) place[c] = rint(place[c]);
        /* mostly along the field */
        d[c] = random_between(r, -1, 1) * (random_below(r, 2) ? side[c] : 1);
        if (place[c] == 0 || place[c] == side[c]) d[c] = place[c] == 0 ? fabs(d[c]) : -fabs(d[c]);
    }
    if (random_below(r, 8) == 0) d[random_below(r, 2)] = 0;
    if (random_below(r, 8) == 0) d[1] = d[0];
    const double steep = fabs(g->slope[0]) + fabs(g->slope[1]) + 0.01 * g->unit, sign = random_below(r, 4) ? 1 : -1;
    double dz = g->slope[0] * d[0] + g->slope[1] * d[1];
    if (random_below(r, 2)) dz += steep * pow(10, random_between(r, -10, -3)) * random_between(r, -1, 1);
    double z = (double)g->z[0] + g->slope[0] * place[0] + g->slope[1] * place[1];
    if (random_below(r, 8)) z += sign * steep * pow(10, random_between(r, -8, -1));
    if (g->high && random_below(r, 4) == 0) z += sign * fabs(g->base) * 0x1p-24 * random_between(r, 0, 8);
    /* Its length: t is as much shorter or longer. */
    const double longest = fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(dz));
    double scale = longest > 0 ? 1 / longest : 1;
    if (random_below(r, 4) == 0) scale *= exp2(random_between(r, -30, 30));
    if (fabs(dz) * scale < 0x1p-126 && fabs(dz) > 0 && random_below(r, 4)) scale = 0x1p-125 / fabs(dz);
    double back = 0;
    if (random_below(r, 4) == 0)
        back = (side[0] + side[1]) * pow(10, random_between(r, -1, 3)) / fmax(fabs(d[0]), fabs(d[1]));
    if (!(back < 1e6)) back = 0;
    cw_ray ray = {.tmax = INFINITY};
    const double org[3] = {place[0], place[1], z}, dir[3] = {d[0], d[1], dz};
    for (int c = 0; c < 3; c++) {
        ray.org[c] = (float)(org[c] - back * dir[c]);
        ray.dir[c] = (float)(dir[c] * scale);
    }
    const size_t range = random_below(r, 4);
    ray.tmin = range == 0 ? -INFINITY : range == 1 ? -(float)exp2((double)random_below(r, 127)) : 0;
    return ray;
}

size_t rays_beside_plane(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const size_t n = g->number % 3 == 0 ? 1 + random_below(r, 40) : most - random_below(r, most / 2);
    const bool alike = random_below(r, 3) == 0;
    for (size_t k = 0; k < n; k++) {
        rays[k] = beside_plane(g, r);
        if (alike && k % 16 != 0) { /* side by side */
            rays[k] = rays[k - 1];
            rays[k].org[k % 2] += (float)random_between(r, -1, 1);
        }
    }
    return n;
}

/* ---- through corners --------------------------------------------------------------------------------------------- */

enum { SHORT = 300, LONG = 2 * SHORT };
static const float level = 1000;

/* The sample's first cell on the ray's way has a hole. */
cw_field *corner_behind_hole(ground *g, random_state *r) {
    const size_t along = g->number & 1, turn_x = g->number & 2, turn_y = g->number & 4,
                 k = 150 + 60 * (g->number / 8 % 3);
    const size_t nx = along ? LONG : SHORT, ny = along ? SHORT : LONG, i = along ? 2 * k : k, j = along ? k : 2 * k;
    for (size_t m = 0; m < nx * ny; m++) g->z[m] = nextafterf(level, 0);
    g->z[(turn_y ? ny - 1 - j : j) * nx + (turn_x ? nx - 1 - i : i)] = level;
    g->z[(turn_y ? ny - j : j - 1) * nx + (turn_x ? nx - i : i - 1)] = NAN;
    g->nx = nx;
    g->ny = ny;
    return field_of(g->z, nx, ny);
}

/* A float's width above the ground, two cells along one axis for each along the other. */
size_t ray_through_corners(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const bool along = g->number & 1, turn_x = g->number & 2, turn_y = g->number & 4;
    rays[0] =
        (cw_ray){.org = {turn_x ? (float)(g->nx - 1) : 0, turn_y ? (float)(g->ny - 1) : 0, level},
                 .dir = {(turn_x ? -1.0f : 1.0f) * (along ? 1 : 0.5f), (turn_y ? -1.0f : 1.0f) * (along ? 0.5f : 1), 0},
                 .tmax = INFINITY};
    return most;
}

/* ---- climbing ---------------------------------------------------------------------------------------------------- */

/* Level ground, with towers next to some corners of nodes, each so high that one float beside the corner its flank is
 * above the ground; holes in some fields. One cell more or less on a ray's way shows. */
static cw_field *towers_of(ground *g, size_t nx, size_t ny, random_state *r) {
    const size_t holes = random_below(r, 3) ? 0 : 200;
    g->nx = nx;
    g->ny = ny;
    g->first = nx > 400 ? nx - 400 : 0;
    memset(g->z, 0, nx * ny * sizeof *g->z);
    for (size_t j = 0; j < ny; j++)
        for (size_t i = g->first; i < nx; i++) {
            float *z = &g->z[j * nx + i];
            const bool beside_x = j % 8 == 0 && (i % 8 == 1 || i % 8 == 7),
                       beside_y = i % 8 == 0 && (j % 8 == 1 || j % 8 == 7);
            *z = (float)random_below(r, 3);
            if ((beside_x || beside_y) && random_below(r, 6) == 0)
                *z = (float)ldexp(random_between(r, 1, 2), 25 + (int)random_below(r, 30));
            if (holes > 0 && random_below(r, holes) == 0) *z = NAN;
        }
    return field_of(g->z, nx, ny);
}

cw_field *towers_beside_nodes(ground *g, random_state *r) {
    const size_t nx = 6 + random_below(r, 85), ny = 6 + random_below(r, 85);
    return towers_of(g, nx, ny, r);
}

cw_field *wide_towers_beside_nodes(ground *g, random_state *r) { return towers_of(g, WIDE, WIDE_ROWS, r); }

static float floats_on(float x, int n) {
    for (; n > 0; n--) x = nextafterf(x, INFINITY);
    for (; n < 0; n++) x = nextafterf(x, -INFINITY);
    return x;
}

/* A place next to a node's corner, and a direction, with zeros of either sign. */
static void aim(const ground *g, cw_ray *ray, random_state *r) {
    const size_t side = random_below(r, 4) ? 8 : 4;
    size_t corner[2] = {(g->first + random_below(r, g->nx - g->first)) / side * side,
                        random_below(r, g->ny) / side * side};
    if (corner[0] < g->ny && random_below(r, 2)) corner[1] = corner[0]; /* floats as far apart along both axes */
    for (int c = 0; c < 2; c++) {
        ray->org[c] = (float)corner[c];
        ray->dir[c] = (float)random_between(r, -1, 1);
        if (random_below(r, 4) == 0) ray->dir[c] = 0.25f * (float)few(r, 4);
    }
    if (random_below(r, 2)) ray->dir[1] = ray->dir[0] * (float)random_between(r, 0.5, 1.5);
    if (random_below(r, 2)) ray->dir[1] = -ray->dir[1];
    if (random_below(r, 12) == 0) ray->dir[random_below(r, 2)] = random_below(r, 2) ? 0 : -0.0f;
    ray->dir[2] = (float)random_between(r, 0, 2);
}

static float way(const ground *g, random_state *r) {
    return g->first > 0 || random_below(r, 4) ? (float)exp2(random_between(r, -3, 4)) : INFINITY;
}

/* Rounding decides in which of the four nodes a ray's beginning lies, and which it enters first. Three of four have
 * ranges that begin less than a float's width before the corner, or behind it: the sum of origin and way rounds. The
 * others are at the corner at some t, also a negative one, and their range begins there, as nearly as floats allow. */
size_t climbing_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    for (size_t k = 0; k < most; k++) {
        cw_ray ray;
        const bool near = random_below(r, 4);
        aim(g, &ray, r);
        if (near) {
            float t = 0;
            for (int c = 0; c < 2; c++) {
                const float speed = fmaxf(fabsf(ray.dir[c]), 0.01f), corner = ray.org[c];
                ray.org[c] = floats_on(corner, random_below(r, 6) ? ray.dir[c] < 0 ? 1 : -1 : few(r, 2));
                if (c == 1 && random_below(r, 2))
                    ray.org[c] = corner - ray.dir[c] * t * (float)random_between(r, 0.5, 1.1);
                t = fmaxf(t, fabsf(corner - ray.org[c]) / speed);
            }
            ray.tmin = t * (float)(random_below(r, 4) ? random_between(r, 0.4, 1.1) : random_between(r, -1, 2));
            ray.tmax = way(g, r);
            ray.org[2] = (float)random_between(r, 1, 4);
        } else {
            const float t = (float)random_between(r, -0.5, 0.5) * (float)g->ny;
            const float high =
                random_below(r, 2) ? (float)random_between(r, 1, 4) : (float)exp2(random_between(r, 0, 24));
            for (int c = 0; c < 2; c++) ray.org[c] = floats_on(ray.org[c] - t * ray.dir[c], few(r, 2));
            if (random_below(r, 2)) ray.dir[2] = (float)exp2(random_between(r, 0, 12));
            ray.org[2] = high - t * ray.dir[2];
            ray.tmin = floats_on(t, few(r, 3));
            ray.tmax = t + way(g, r);
        }
        rays[k] = ray;
    }
    return most;
}
