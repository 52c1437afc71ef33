/* SPDX-License-Identifier: Apache-2.0 */
#include "line.h"

#include "../cancel.h"

#include <math.h>
#include <string.h>

bool line_find(line *l, const ground *g, const ground_place places[2], double curvature, io_error *error) {
    const terrain *t = &g->terrain;
    double metres[2];
    if (!ground_find_place(t, &places[0], l->eye, NULL, error) ||
        !ground_find_place(t, &places[1], l->target, NULL, error))
        return false;
    const double *eye = l->eye, *target = l->target;
    const double k = isnan(curvature) ? g->file.raster.georef.placed ? 6.0 / 7 : 0 : curvature;
    sight *s = &l->sight;
    sight_init(s, t, NULL, eye, k);
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

bool line_head_profiles(io_output *to, io_error *error) {
    static const char head[] = "pair,distance,x,y,ground,line,seen\n";
    return io_output_write(to, head, sizeof head - 1, error);
}

bool line_write_profile(const line *l, size_t number, profile *p, io_output *to, io_error *error) {
    const double metres = terrain_metres_of_height(l->sight.terrain);
    if (profile_make(p, &l->sight, l->target[0], l->target[1], l->target[2]) != CW_OK)
        return io_fail(error, "out of memory");
    for (size_t k = 0; k < p->count; k++) {
        const profile_point *at = &p->points[k];
        double xy[2];
        for (int e = 0; e < 2; e++) xy[e] = l->ends[0][e] + at->share * (l->ends[1][e] - l->ends[0][e]);
        const double distance = at->share * l->length, over = at->line * metres;
        bool good = io_output_print(to, error, "%zu,%.3f,%.12g,%.12g,", number, distance, xy[0], xy[1]);
        good = good &&
               (isnan(at->ground) ? io_output_print(to, error, ",%.3f,\n", over)
                                  : io_output_print(to, error, "%.3f,%.3f,%d\n", at->ground * metres, over, at->seen));
        if (!good) return false;
    }
    return !atomic_load(cancel_flag()) || io_fail(error, "interrupted");
}
