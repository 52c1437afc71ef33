/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes and offsets that programs are compiled with. C and C++, of any standard; also with -fshort-enums. */
#include "cellwalk_terrain.h"

#include <stddef.h>

#define SIZE(TYPE, BYTES)          typedef char TYPE##_has_size[sizeof(TYPE) == (BYTES) ? 1 : -1];
#define PLACE(TYPE, MEMBER, BYTES) typedef char TYPE##_has_##MEMBER[offsetof(TYPE, MEMBER) == (BYTES) ? 1 : -1];

SIZE(cw_difference, 40)
PLACE(cw_difference, made, 32)
SIZE(cw_terrain_desc, 112)
PLACE(cw_terrain_desc, scale, 8)
PLACE(cw_terrain_desc, unit, 16)
PLACE(cw_terrain_desc, inverse_flattening, 32)
PLACE(cw_terrain_desc, geographic, 40)
PLACE(cw_terrain_desc, reserved, 48)
SIZE(cw_area, 40)
PLACE(cw_area, stride, 32)
SIZE(cw_light, 104)
PLACE(cw_light, strips, 32)
PLACE(cw_light, hillshade, 36)
PLACE(cw_light, reserved, 40)
SIZE(cw_horizon, 96)
PLACE(cw_horizon, count, 24)
PLACE(cw_horizon, flags, 28)
PLACE(cw_horizon, reserved, 32)
SIZE(cw_observer, 160)
PLACE(cw_observer, curvature, 32)
PLACE(cw_observer, azimuths, 56)
PLACE(cw_observer, verticals, 72)
PLACE(cw_observer, absolute, 88)
PLACE(cw_observer, reserved, 96)
SIZE(cw_view, 104)
PLACE(cw_view, weight, 16)
PLACE(cw_view, needed, 32)
PLACE(cw_view, reserved, 40)
SIZE(cw_sight, 56)
PLACE(cw_sight, absolute, 48)
SIZE(cw_sight_answer, 48)
PLACE(cw_sight_answer, distance, 32)
PLACE(cw_sight_answer, state, 40)
SIZE(cw_visibility_desc, 104)
PLACE(cw_visibility_desc, directions, 32)
PLACE(cw_visibility_desc, reserved, 40)
SIZE(cw_visibility_answers, 96)
PLACE(cw_visibility_answers, reserved, 32)
