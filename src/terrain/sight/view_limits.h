/* SPDX-License-Identifier: Apache-2.0 */
/* Which targets count as seen from a place: those between two distances, in a sector of azimuths, between two vertical
 * angles. The terrain blocks the view wherever it is. */
#ifndef CELLWALK_TERRAIN_VIEW_LIMITS_H
#define CELLWALK_TERRAIN_VIEW_LIMITS_H

#include "sight.h"

/* Limits made ready for one place. */
typedef struct view_limits {
    bool any;
    cw_observer given; /* of which its limits are used */
    bool has_sector, has_verticals;
    const sight *sight;
    double metres[2];    /* in one of the map's x and y, at the place */
    double sector[2][2]; /* the two azimuths as east and north */
    bool narrow;         /* less than half of the round */
    double tangents[2];  /* of the vertical angles */
} view_limits;

/* False if a number is none or out of range. */
bool cw_view_limits_init(view_limits *l, const sight *s, const cw_observer *given);

/* Whether a target counts. rise: its height over the eye in the samples' numbers, lowered. */
bool cw_view_limits_have(const view_limits *l, double i, double j, double rise);

/* The angle above the eye's horizontal in degrees; at the place itself -90, 0 or 90. */
double cw_view_limits_angle(const view_limits *l, double i, double j, double rise);

/* False if no direction between a and b, in field coordinates and less than half the round apart, is in the sector. */
bool cw_view_limits_meet(const view_limits *l, const double a[2], const double b[2]);

#endif
