/* SPDX-License-Identifier: Apache-2.0 */
/* Visibility from a place: for each sample, whether the straight line from the observer's eye to it, or to something of
 * a given height on it, passes above the surface. A line that touches it on the way is blocked. */
#ifndef CELLWALK_TERRAIN_VIEWSHED_H
#define CELLWALK_TERRAIN_VIEWSHED_H

#include "view_limits.h"

/* What the eye of a sight, which has bounds, sees: as cw_viewshed. Of the observer only target and limits are used. */
cw_status cw_viewshed_from(const sight *s, const cw_observer *from, const cw_run *run, cw_area area,
                           const cw_view *view);

#endif
