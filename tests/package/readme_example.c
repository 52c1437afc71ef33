/* SPDX-License-Identifier: Apache-2.0 */
#include <cellwalk.h>
#include <stdio.h>

int main(void) {
    static const float heights[9] = {0, 1, 0, 1, 4, 1, 0, 1, 0}; /* a peak: sample (i, j) is heights[3 * j + i] */
    const cw_field_desc desc = {.samples = heights, .nx = 3, .ny = 3};
    cw_field *field;
    if (cw_field_create(&desc, NULL, &field) != CW_OK) return 1;
    const cw_ray ray = {.org = {-1, 1.25f, 2}, .dir = {1, 0, 0}, .tmax = 100};
    cw_hit hit;
    cw_closest(field, NULL, &ray, 1, &hit); /* any number of rays; NULL: the best kernel, one thread */
    printf("t = %g in cell (%d, %d)\n", (double)hit.t, hit.i, hit.j);
    cw_field_destroy(field);
    return 0;
}
