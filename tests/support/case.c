/* SPDX-License-Identifier: Apache-2.0 */
#include "case.h"

#include "check.h"

test_field shape;
cw_field *field;
cw_ray rays[RAYS];
cw_hit expected[RAYS];

void case_make(field_shape kind, size_t nx, size_t ny, uint64_t seed, size_t ray_count) {
    random_state r = {seed};
    field_make(&shape, kind, nx, ny, seed);
    field = field_open(&shape);
    for (size_t k = 0; k < ray_count; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &shape, &r);
    check_status(cw_closest(field, NULL, rays, ray_count, expected), CW_OK);
}

int case_begin(void **state) {
    (void)state;
    case_make(FIELD_RANDOM, 17, 17, 7, RAYS);
    return 0;
}

int case_end(void **state) {
    (void)state;
    cw_field_destroy(field);
    return 0;
}
