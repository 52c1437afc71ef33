/* SPDX-License-Identifier: Apache-2.0 */
/* The example of papers/using.md for heights that change. */
#include <cellwalk.h>
#include <math.h>
#include <stdio.h>

enum { SIDE = 1025, POND = 128, AT = 400 };
static float heights[SIDE * SIDE]; /* a plain with a pond in it */

int main(void) {
    const cw_field_desc desc = {.samples = heights, .nx = SIDE, .ny = SIDE, .storage = CW_BORROW};
    const cw_update pond = {.at = {AT, AT, POND, POND}};
    const cw_ray down = {.org = {AT + 10, AT + 10, 100}, .dir = {0, 0, -1}, .tmax = 200};
    cw_field *field;
    if (cw_field_create(&desc, NULL, &field) != CW_OK) return 1;
    for (int frame = 0; frame < 4; frame++) {
        for (int j = AT; j < AT + POND; j++)
            for (int i = AT; i < AT + POND; i++) heights[j * SIDE + i] = sinf(0.25f * (float)(i - AT) - (float)frame);
        if (cw_field_update(field, NULL, &pond) != CW_OK)
            return 1; /* the field borrows its samples: they have changed in place */
        cw_hit hit;
        cw_closest(field, NULL, &down, 1, &hit);
        printf("%s%.2f", frame > 0 ? ", " : "", (double)(100 - hit.t));
    }
    printf("\n");
    cw_field_destroy(field);
    return 0;
}
