/* SPDX-License-Identifier: Apache-2.0 */
/* The example of README.md, which shows it word for word from here on (readme_text.cmake compares them). */
#include <cellwalk.h>
#include <stdio.h>

int main(void) {
    static const float heights[3 * 3] = {0, 1, 0, /* a peak in the middle */
                                         1, 4, 1, /* sample (i, j) is heights[3 * j + i] */
                                         0, 1, 0};
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = heights;
    desc.nx = desc.ny = 3;
    cw_field *field;
    const cw_status status = cw_field_create(&desc, &field);
    if (status != CW_OK) {
        fprintf(stderr, "%s\n", cw_status_message(status));
        return 1;
    }
    const cw_ray ray = {.org = {-1, 1.25f, 2}, .tmin = 0, .dir = {1, 0, 0}, .tmax = 100};
    cw_hit hit;
    cw_closest(field, NULL, &ray, 1, &hit); /* any number of rays; NULL: the best kernel, one thread */
    double point[3];
    if (hit.i < 0) return 1;
    cw_hit_point(field, &hit, point);
    printf("t = %g in cell (%d, %d), at (%g, %g, %g)\n", (double)hit.t, hit.i, hit.j, point[0], point[1], point[2]);
    cw_field_destroy(field);
    return 0;
}
