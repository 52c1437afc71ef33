/* SPDX-License-Identifier: Apache-2.0 */
/* What one observer sees, in numbers. */
#ifndef CELLWALK_GROUND_VIEW_SUM_H
#define CELLWALK_GROUND_VIEW_SUM_H

#include "terrain.h"

typedef struct view_sum {
    double samples, km2;             /* in sight; each with the area of a cell in its row */
    double farthest, farthest_at[2]; /* metres, and where on the map; NaN: nothing is in sight */
} view_sum;

/* Of the samples of a rectangle of the terrain that are not 0, and not 0 in within unless that is NULL, as seen from eye in field
 * coordinates. */
view_sum view_sum_of(const terrain *t, cw_rectangle at, const uint16_t *seen, const uint8_t *within,
                     const double eye[2]);

#endif
