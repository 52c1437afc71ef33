/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes and places of what the public headers declare, which never change within a major version; C99 and C++98. */
#include <cellwalk_expert.h>
#include <cellwalk_terrain.h>

#define SAME(name, is)     typedef char name[(is) ? 1 : -1]
#define SIZE(type, bytes)  SAME(type##_size, sizeof(type) == (bytes))
#define AT(type, m, place) SAME(type##_##m, offsetof(type, m) == (place))

SIZE(cw_status, 4);
SIZE(cw_storage, 4);
SIZE(cw_isa, 4);
SIZE(cw_leaf, 4);
SIZE(cw_ray, 32);
AT(cw_ray, tmin, 12);
AT(cw_ray, dir, 16);
AT(cw_ray, tmax, 28);
SIZE(cw_user_ray, 64);
AT(cw_user_ray, tmin, 24);
AT(cw_user_ray, dir, 32);
AT(cw_user_ray, tmax, 56);
SIZE(cw_hit, 24);
AT(cw_hit, i, 4);
AT(cw_hit, j, 8);
AT(cw_hit, triangle, 12);
AT(cw_hit, u, 16);
AT(cw_hit, v, 20);
SIZE(cw_rectangle, 32);
AT(cw_rectangle, j, 8);
AT(cw_rectangle, nx, 16);
AT(cw_rectangle, ny, 24);
SIZE(cw_tasks, 56);
AT(cw_tasks, context, 8);
AT(cw_tasks, threads, 16);
AT(cw_tasks, reserved, 24);
SIZE(cw_expert, 16);
AT(cw_expert, leaf, 8);
AT(cw_expert, isa, 12);
SIZE(cw_run, 88);
AT(cw_run, watch, 8);
AT(cw_run, watch_context, 16);
AT(cw_run, expert, 24);
AT(cw_run, reserved, 40);
SIZE(cw_allocator, 56);
AT(cw_allocator, release, 8);
AT(cw_allocator, context, 16);
AT(cw_allocator, reserved, 24);
SIZE(cw_field_desc, 208);
AT(cw_field_desc, nx, 8);
AT(cw_field_desc, ny, 16);
AT(cw_field_desc, stride, 24);
AT(cw_field_desc, map, 32);
AT(cw_field_desc, allocator, 128);
AT(cw_field_desc, storage, 136);
AT(cw_field_desc, reserved, 144);
SIZE(cw_update, 112);
AT(cw_update, samples, 32);
AT(cw_update, stride, 40);
AT(cw_update, wait, 48);
AT(cw_update, reserved, 56);
SIZE(cw_field_info, 144);
AT(cw_field_info, low, 16);
AT(cw_field_info, high, 20);
AT(cw_field_info, holes, 24);
AT(cw_field_info, bytes_samples, 32);
AT(cw_field_info, bytes_built, 40);
AT(cw_field_info, map, 48);
SIZE(cw_difference, 40);
AT(cw_difference, made, 32);
SIZE(cw_terrain_desc, 112);
AT(cw_terrain_desc, scale, 8);
AT(cw_terrain_desc, unit, 16);
AT(cw_terrain_desc, inverse_flattening, 32);
AT(cw_terrain_desc, geographic, 40);
AT(cw_terrain_desc, reserved, 48);
SIZE(cw_area, 40);
AT(cw_area, stride, 32);
SIZE(cw_light, 104);
AT(cw_light, strips, 32);
AT(cw_light, hillshade, 36);
AT(cw_light, reserved, 40);
SIZE(cw_horizon, 96);
AT(cw_horizon, count, 24);
AT(cw_horizon, flags, 28);
AT(cw_horizon, reserved, 32);
SIZE(cw_observer, 160);
AT(cw_observer, curvature, 32);
AT(cw_observer, azimuths, 56);
AT(cw_observer, verticals, 72);
AT(cw_observer, absolute, 88);
AT(cw_observer, reserved, 96);
SIZE(cw_view, 104);
AT(cw_view, weight, 16);
AT(cw_view, needed, 32);
AT(cw_view, reserved, 40);
SIZE(cw_sight, 56);
AT(cw_sight, absolute, 48);
SIZE(cw_sight_answer, 48);
AT(cw_sight_answer, distance, 32);
AT(cw_sight_answer, state, 40);
SIZE(cw_visibility_desc, 104);
AT(cw_visibility_desc, directions, 32);
AT(cw_visibility_desc, reserved, 40);
SIZE(cw_visibility_answers, 96);
AT(cw_visibility_answers, reserved, 32);
SAME(statuses, CW_ERROR_ARGUMENT == 1 && CW_ERROR_SAMPLE == 2 && CW_ERROR_KERNEL == 3 && CW_ERROR_NOT_BUILT == 4 &&
                   CW_ERROR_MEMORY == 5 && CW_ERROR_BUSY == 6 && CW_ERROR_CANCELLED == 7);
SAME(zeros, CW_OK == 0 && CW_COPY == 0 && CW_ISA_ANY == 0 && CW_LEAF_DEFAULT == 0 && CW_TRIANGLE_A == 0);
