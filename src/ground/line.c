/* SPDX-License-Identifier: Apache-2.0 */
#include "line.h"

#include <math.h>

bool line_find(line *l, const terrain *t, const io_place places[2], double curvature, io_error *error) {
    if (!ground_find_place(t, &places[0], l->eye, NULL, error) ||
        !ground_find_place(t, &places[1], l->target, NULL, error))
        return false;
    double middle[2];
    cw_sight_middle(l->eye, l->target, middle);
    cw_sight_init_line(&l->sight, t, l->eye, middle, curvature);
    const double block = cw_sight_first_block(&l->sight, l->target[0], l->target[1], l->target[2]);
    l->answer = cw_sight_settle(&l->sight, l->target, middle, block, l->ends);
    return true;
}

/* ---- by pieces --------------------------------------------------------------------------------------------------- */

/* The samples around the way between two places in the raster's field coordinates, and two more; none if outside. */
static cw_rectangle around(const terrain *whole, const double from[2], const double to[2]) {
    const size_t sides[2] = {whole->nx, whole->ny};
    size_t first[2], count[2];
    for (int a = 0; a < 2; a++) {
        const double low = fmax(floor(fmin(from[a], to[a])) - 2, 0),
                     high = fmin(ceil(fmax(from[a], to[a])) + 2, (double)(sides[a] - 1));
        if (!(low < high)) return (cw_rectangle){0};
        first[a] = (size_t)low;
        count[a] = (size_t)(high - low) + 1;
    }
    return (cw_rectangle){first[0], first[1], count[0], count[1]};
}

/* An end of the line, from the samples around it. */
static bool find_end(ground *g, const io_place *place, double at[3], io_error *error) {
    double near[2] = {0, 0};
    cw_terrain_find_place(&g->whole, place->x, place->y, near);
    cw_rectangle piece = around(&g->whole, near, near);
    if (piece.nx == 0) piece = (cw_rectangle){0, 0, 2, 2};
    if (!ground_read(g, piece, false, error) || !ground_find_place(&g->terrain, place, at, NULL, error)) return false;
    at[0] += (double)piece.i;
    at[1] += (double)piece.j;
    return true;
}

bool line_find_on(line *l, ground *g, const io_place places[2], double curvature, profile *p, io_error *error) {
    const cw_rectangle all = ground_all(g);
    const bool whole = g->about.z != NULL;
    if (whole || (g->piece.nx == all.nx && g->piece.ny == all.ny && g->terrain.z != NULL)) {
        if (g->terrain.z == NULL && !ground_read(g, all, false, error)) return false;
        return line_find(l, &g->terrain, places, curvature, error) && (p == NULL || line_profile(l, p, error));
    }
    if (!find_end(g, &places[0], l->eye, error) || !find_end(g, &places[1], l->target, error)) return false;
    const double cells = fmax(fabs(l->target[0] - l->eye[0]), fabs(l->target[1] - l->eye[1]));
    const size_t pieces = (size_t)fmax(ceil(cells / LINE_PIECE), 1);
    double block = INFINITY, middle[2];
    bool good = true;
    cw_sight_middle(l->eye, l->target, middle);
    if (p) p->count = 0;
    for (size_t k = 0; k < pieces && good && (p != NULL || block == INFINITY); k++) {
        const double parts[2] = {(double)k / (double)pieces, (double)(k + 1) / (double)pieces};
        double ends[2][2], eye[3] = {l->eye[0], l->eye[1], l->eye[2]}, target[2] = {l->target[0], l->target[1]};
        for (int e = 0; e < 2; e++)
            for (int a = 0; a < 2; a++) ends[e][a] = l->eye[a] + parts[e] * (l->target[a] - l->eye[a]);
        const cw_rectangle piece = around(&g->whole, ends[0], ends[1]);
        if (piece.nx == 0) continue;
        if (!(good = ground_check(g, piece, 0, error) && ground_read(g, piece, false, error))) break;
        eye[0] -= (double)piece.i;
        eye[1] -= (double)piece.j;
        target[0] -= (double)piece.i;
        target[1] -= (double)piece.j;
        sight s;
        const double here[2] = {middle[0] - (double)piece.i, middle[1] - (double)piece.j};
        cw_sight_init_line(&s, &g->terrain, eye, here, curvature);
        if (block == INFINITY) block = cw_sight_first_block(&s, target[0], target[1], l->target[2]);
        if (p == NULL) continue;
        good = cw_profile_add(p, &s, target[0], target[1], l->target[2], parts[0], parts[1]) == CW_OK ||
               io_fail(error, "out of memory");
    }
    if (!good) return false;
    cw_sight_init_line(&l->sight, &g->whole, l->eye, middle, curvature);
    l->answer = cw_sight_settle(&l->sight, l->target, middle, block, l->ends);
    if (p) cw_profile_finish(p, &l->sight, l->target[0], l->target[1], l->target[2]);
    return true;
}

/* ---- radio ------------------------------------------------------------------------------------------------------- */

/* The first Fresnel zone's radius in metres at a share of the way. */
static double line_fresnel_radius(const line *l, double megahertz, double where) {
    const double share = fmin(fmax(where, 0), 1);
    const double wavelength = 299.792458 / megahertz;
    const double rise = (l->target[2] - l->eye[2]) * terrain_metres_of_height(l->sight.terrain);
    return sqrt(wavelength * hypot(l->answer.metres, rise) * share * (1 - share));
}

bool line_profile(const line *l, profile *p, io_error *error) {
    return cw_profile_make(p, &l->sight, l->target[0], l->target[1], l->target[2]) == CW_OK ||
           io_fail(error, "out of memory");
}

static void look_at_clearance(const line *l, double megahertz, double share, double gap, clearance *c) {
    const double radius = line_fresnel_radius(l, megahertz, share);
    if (!(radius > 0) || gap / radius >= c->share) return;
    *c = (clearance){gap / radius, share * l->answer.metres, radius};
}

void line_clearance(const line *l, double megahertz, const profile *p, clearance *c) {
    const double metres = terrain_metres_of_height(l->sight.terrain);
    *c = (clearance){.share = INFINITY, .distance = NAN, .radius = NAN};
    for (size_t k = 0; k < p->count; k++) {
        const profile_point *a = &p->points[k], *b = k + 1 < p->count ? a + 1 : a;
        const double gap = (a->line - a->ground) * metres, next = (b->line - b->ground) * metres;
        if (!isnan(gap)) look_at_clearance(l, megahertz, a->share, gap, c);
        /* Between two crossings the gap is linear. Its share of the radius is least where the gaps of that straight
         * line at the two ends of the way are as the distances to them, if that is between the two. */
        const double slope = (next - gap) / (b->share - a->share), first = gap - slope * a->share;
        const double least = first / (2 * first + slope);
        if (least > a->share && least < b->share) look_at_clearance(l, megahertz, least, first + slope * least, c);
    }
    if (isinf(c->share)) c->share = NAN;
}

line_row line_row_of(const line *l, double megahertz, const profile_point *at) {
    const double metres = terrain_metres_of_height(l->sight.terrain);
    double xy[2];
    for (int e = 0; e < 2; e++) xy[e] = l->ends[0][e] + at->share * (l->ends[1][e] - l->ends[0][e]);
    return (line_row){at->share * l->answer.metres,
                      xy[0],
                      xy[1],
                      at->ground * metres,
                      at->line * metres,
                      at->seen,
                      megahertz > 0 ? line_fresnel_radius(l, megahertz, at->share) : NAN};
}
