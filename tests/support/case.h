/* SPDX-License-Identifier: Apache-2.0 */
/* One field, rays of all classes, and the default kernel's hits, for tests that need no others. */
#ifndef CELLWALK_TESTS_CASE_H
#define CELLWALK_TESTS_CASE_H

#include "rays.h"

enum { RAYS = 20000 };
extern test_field shape;
extern cw_field *field;
extern cw_ray rays[RAYS];
extern cw_hit expected[RAYS];

void case_make(field_shape kind, size_t nx, size_t ny, uint64_t seed, size_t ray_count);

/* cmocka's set-up and tear-down of 17 × 17 random samples and all rays. */
int case_begin(void **state);
int case_end(void **state);

#endif
