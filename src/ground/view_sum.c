/* SPDX-License-Identifier: Apache-2.0 */
#include "view_sum.h"

#include <math.h>

view_sum view_sum_of(const terrain *t, cw_rectangle at, const uint16_t *seen, const uint8_t *within,
                     const double eye[2]) {
    view_sum v = {0, 0, NAN, {NAN, NAN}};
    double metres[2], far = -1;
    cw_terrain_metres(t, eye[0], eye[1], metres);
    const double cell = 1e-6 * fabs(t->map[0][0] * t->map[1][1] - t->map[0][1] * t->map[1][0]);
    for (size_t y = at.j; y < at.j + at.ny; y++) {
        double count = 0, sum = 0, scale[2];
        for (size_t x = at.i; x < at.i + at.nx; x++) {
            if (seen[y * t->nx + x] == 0 || (within && within[y * t->nx + x] == 0)) continue;
            const double dx = (double)x - eye[0], dy = (double)y - eye[1];
            const double away = hypot((t->map[0][0] * dx + t->map[0][1] * dy) * metres[0],
                                      (t->map[1][0] * dx + t->map[1][1] * dy) * metres[1]);
            count++;
            sum += (double)x;
            if (away <= far) continue;
            v.farthest = far = away;
            terrain_to_map(t, (double)x, (double)y, v.farthest_at);
        }
        if (count == 0) continue;
        cw_terrain_metres(t, sum / count, (double)y, scale);
        v.samples += count;
        v.km2 += cell * scale[0] * scale[1] * count;
    }
    return v;
}
