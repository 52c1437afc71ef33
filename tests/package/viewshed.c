/* SPDX-License-Identifier: Apache-2.0 */
/* What an observer sees of a ridge and the valley behind it. In what C and C++ have in common. */
#include <cellwalk_terrain.h>

#include <stdio.h>

enum { SIDE = 65, BEHIND = 32 * SIDE + 64 };

static float samples[SIDE * SIDE], needed[SIDE * SIDE];
static uint16_t seen[SIDE * SIDE];
/* All that is not set is zero. */
static cw_field_desc land;
static cw_terrain_desc desc;
static cw_observer observer;
static cw_view view;
static cw_sight line;
static cw_area all;

static int stop(const char *what) {
    fprintf(stderr, "%s: %s\n", what, cw_last_error());
    return 1;
}

int main(void) {
    cw_field *field;
    cw_terrain *terrain;
    cw_sight_answer answer;
    int count = 0, k;
    for (k = 0; k < SIDE * SIDE; k++) samples[k] = k % SIDE == 32 ? 50.0f : 0.0f; /* from north to south */
    land.samples = samples;
    land.nx = land.ny = SIDE;
    land.map[0][0] = 10; /* cells of 10 m; rows from north to south */
    land.map[1][1] = -10;
    land.map[2][2] = 1;
    if (cw_field_create(&land, NULL, &field) != CW_OK) return stop("field");
    desc.field = field;
    if (cw_terrain_create(&desc, NULL, &terrain) != CW_OK) return stop("terrain");
    observer.x = line.from[0] = 20;
    observer.y = line.from[1] = line.to[1] = -320;
    observer.height = line.from[2] = line.to[2] = 2;
    line.to[0] = 640;
    view.seen = seen;
    view.needed = needed;
    if (cw_viewshed(terrain, NULL, &observer, all, &view) != CW_OK) return stop("viewshed");
    if (cw_lines_of_sight(terrain, NULL, 0, &line, 1, &answer) != CW_OK) return stop("line");
    for (k = 0; k < SIDE * SIDE; k++) count += seen[k];
    printf("%d samples in sight; behind the ridge %.1f m are needed; blocked at x = %.1f\n", count, needed[BEHIND],
           answer.blocked[0]);
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
    /* Over 300 m the line rises by 48 m: in line with the ridge's top, 620 m away, by 99.2. */
    return count == 33 * SIDE && needed[BEHIND] > 101.1f && needed[BEHIND] < 101.3f && answer.state == CW_SIGHT_BLOCKED
               ? 0
               : 1;
}
