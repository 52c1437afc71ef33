/* SPDX-License-Identifier: Apache-2.0 */
/* The smallest program that needs all parts of the installed library: header, threads and a kernel. */

#include <cellwalk_expert.h>

#include <math.h>
#include <stdio.h>

int main(void) {
    static const float samples[4] = {1, 1, 1, 1};
    cw_field_desc desc = {0};
    desc.samples = samples;
    desc.nx = desc.ny = 2;
    cw_field *field;
    cw_pool *pool;
    cw_status status = cw_field_create(&desc, NULL, &field);
    if (status == CW_OK) status = cw_pool_create(2, &pool);
    if (status != CW_OK) {
        fprintf(stderr, "%s\n", cw_status_message(status));
        return 1;
    }
    const cw_ray down = {.org = {0.5f, 0.25f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
    const cw_run query = {.pool = pool};
    cw_hit hit;
    status = cw_closest(field, &query, &down, 1, &hit);
    printf("%s: t = %g\n", cw_kernel_describe(cw_run_kernel(field, &query)).name, (double)hit.t);
    cw_pool_destroy(pool);
    cw_field_destroy(field);
    return status == CW_OK && hit.t == 2 ? 0 : 1;
}
