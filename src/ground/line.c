/* SPDX-License-Identifier: Apache-2.0 */
#include "line.h"

#include <math.h>
#include <string.h>

bool line_find(line *l, const terrain *t, const ground_place places[2], double curvature, io_error *error) {
    double metres[2];
    if (!ground_find_place(t, &places[0], l->eye, NULL, error) ||
        !ground_find_place(t, &places[1], l->target, NULL, error))
        return false;
    const double *eye = l->eye, *target = l->target;
    sight *s = &l->sight;
    sight_init(s, t, NULL, eye, curvature);
    const double height = target[2] - s->eye[2] - sight_fall(s, target[0], target[1]);
    const double block = sight_first_block(s, target[0], target[1], target[2]);
    terrain_metres(t, eye[0], eye[1], metres);
    for (int e = 0; e < 2; e++) terrain_to_map(t, e ? target[0] : eye[0], e ? target[1] : eye[1], l->ends[e]);
    l->length = hypot((l->ends[1][0] - l->ends[0][0]) * metres[0], (l->ends[1][1] - l->ends[0][1]) * metres[1]);
    l->blocked = block < INFINITY;
    if (!l->blocked) return true;
    for (int e = 0; e < 2; e++) l->block[e] = l->ends[0][e] + block * (l->ends[1][e] - l->ends[0][e]);
    /* The line bends up against the lowered surface by as much as that is lowered. */
    const double bend = sight_fall(s, eye[0] + block * (target[0] - eye[0]), eye[1] + block * (target[1] - eye[1]));
    l->block_height = (eye[2] + block * height + bend) * terrain_metres_of_height(t);
    l->block_distance = block * l->length;
    return true;
}

/* ---- radio ------------------------------------------------------------------------------------------------------------- */

double line_fresnel_radius(const line *l, double megahertz, double where) {
    const double share = fmin(fmax(where, 0), 1);
    const double wavelength = 299.792458 / megahertz;
    const double rise = (l->target[2] - l->eye[2]) * terrain_metres_of_height(l->sight.terrain);
    return sqrt(wavelength * hypot(l->length, rise) * share * (1 - share));
}

static bool find_profile(const line *l, profile *p, io_error *error) {
    return profile_make(p, &l->sight, l->target[0], l->target[1], l->target[2]) == CW_OK ||
           io_fail(error, "out of memory");
}

static void look_at_clearance(const line *l, double megahertz, double share, double gap, clearance *c) {
    const double radius = line_fresnel_radius(l, megahertz, share);
    if (!(radius > 0) || gap / radius >= c->share) return;
    *c = (clearance){gap / radius, share * l->length, radius};
}

bool line_clearance(const line *l, double megahertz, profile *p, clearance *c, io_error *error) {
    const double metres = terrain_metres_of_height(l->sight.terrain);
    *c = (clearance){.share = INFINITY, .distance = NAN, .radius = NAN};
    if (!find_profile(l, p, error)) return false;
    for (size_t k = 0; k < p->count; k++) {
        const profile_point *a = &p->points[k], *b = k + 1 < p->count ? a + 1 : a;
        const double gap = (a->line - a->ground) * metres, next = (b->line - b->ground) * metres;
        if (!isnan(gap)) look_at_clearance(l, megahertz, a->share, gap, c);
        /* Between two crossings the gap is linear. Its share of the radius is least where the gaps of that straight line at the
         * two ends of the way are as the distances to them, if that is between the two. */
        const double slope = (next - gap) / (b->share - a->share), first = gap - slope * a->share;
        const double least = first / (2 * first + slope);
        if (least > a->share && least < b->share) look_at_clearance(l, megahertz, least, first + slope * least, c);
    }
    if (isinf(c->share)) c->share = NAN;
    return true;
}

/* ---- profiles ---------------------------------------------------------------------------------------------------------- */

/* A number that three decimals round to 0 has no sign. */
static double no_minus(double x) { return fabs(x) < 0.0005 ? 0 : x; }

bool line_head_profiles(double megahertz, io_output *to, io_error *error) {
    return io_output_print(to, error, "pair,distance,x,y,ground,line,seen%s\n", megahertz > 0 ? ",fresnel_radius" : "");
}

bool line_write_profile(const line *l, size_t number, double megahertz, profile *p, io_output *to, io_error *error) {
    const double metres = terrain_metres_of_height(l->sight.terrain);
    if (!find_profile(l, p, error)) return false;
    for (size_t k = 0; k < p->count; k++) {
        const profile_point *at = &p->points[k];
        double xy[2];
        for (int e = 0; e < 2; e++) xy[e] = l->ends[0][e] + at->share * (l->ends[1][e] - l->ends[0][e]);
        const double distance = at->share * l->length, over = no_minus(at->line * metres);
        bool good = io_output_print(to, error, "%zu,%.3f,%.12g,%.12g,", number, distance, xy[0], xy[1]);
        good = good && (isnan(at->ground) ? io_output_print(to, error, ",%.3f,", over)
                                          : io_output_print(to, error, "%.3f,%.3f,%d", no_minus(at->ground * metres),
                                                            over, at->seen));
        if (megahertz > 0)
            good = good && io_output_print(to, error, ",%.3f", line_fresnel_radius(l, megahertz, at->share));
        if (!good || !io_output_write(to, "\n", 1, error)) return false;
    }
    return true;
}
