/* SPDX-License-Identifier: Apache-2.0 */
/* What an observer sees of a ridge and the valley behind it. */
#include <cellwalk_terrain.h>

#include <stdio.h>

enum { SIDE = 65 };

static int stop(const char *what) {
    fprintf(stderr, "%s: %s\n", what, cw_last_error());
    return 1;
}

int main(void) {
    static float samples[SIDE * SIDE];
    static uint16_t seen[SIDE * SIDE];
    static float needed[SIDE * SIDE];
    for (int k = 0; k < SIDE * SIDE; k++) samples[k] = k % SIDE == 32 ? 50 : 0; /* from north to south */
    /* Cells of 10 m; rows from north to south. */
    const cw_field_desc field_desc = {.samples = samples, .nx = SIDE, .ny = SIDE, .map = {{10}, {0, -10}, {0, 0, 1}}};
    cw_field *field;
    cw_terrain *terrain;
    if (cw_field_create(&field_desc, NULL, &field) != CW_OK) return stop("field");
    if (cw_terrain_create(&(cw_terrain_desc){.field = field}, NULL, &terrain) != CW_OK) return stop("terrain");
    const cw_observer observer = {.x = 20, .y = -320, .height = 2};
    const cw_view view = {.seen = seen, .needed = needed};
    if (cw_viewshed(terrain, NULL, &observer, (cw_area){0}, &view) != CW_OK) return stop("viewshed");
    cw_sight line = {.from = {20, -320, 2}, .to = {640, -320, 2}};
    cw_sight_answer answer;
    if (cw_lines_of_sight(terrain, NULL, 0, &line, 1, &answer) != CW_OK) return stop("line");
    int count = 0;
    for (int k = 0; k < SIDE * SIDE; k++) count += seen[k];
    printf("%d samples in sight; behind the ridge %.1f m are needed; blocked at x = %.1f\n", count,
           (double)needed[32 * SIDE + 64], answer.blocked[0]);
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
    /* Over 300 m the line rises by 48 m: in line with the ridge's top, 620 m away, by 99.2. */
    return count == 33 * SIDE && needed[32 * SIDE + 64] > 101.1f && needed[32 * SIDE + 64] < 101.3f &&
                   answer.state == CW_SIGHT_BLOCKED
               ? 0
               : 1;
}
