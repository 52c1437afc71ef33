/* SPDX-License-Identifier: Apache-2.0 */
/* Lines of sight between any places, each decided on its own. */
#include "area.h"
#include "fpenv.h"
#include "sight.h"

#include <math.h>

typedef struct looking {
    const terrain *terrain;
    const cw_sight *lines;
    cw_sight_answer *answers;
    double curvature;
} looking;

/* A place in field coordinates, height in the samples' numbers: CW_SIGHT_SEEN if a line can end there. */
static uint32_t find_place(const terrain *t, const double place[3], bool absolute, double at[3]) {
    if (!cw_terrain_find_place(t, place[0], place[1], at)) return CW_SIGHT_TOO_FAR;
    const double metres = terrain_metres_of_height(t), ground = cw_terrain_level(t, at[0], at[1]),
                 level = ground * metres, height = absolute ? place[2] : level + place[2];
    at[2] = (absolute ? 0 : ground) + place[2] / metres;
    if (!absolute && isnan(level)) return CW_SIGHT_NO_GROUND;
    if (height < level - TERRAIN_LEAST_DEPTH) return CW_SIGHT_UNDER_GROUND;
    return fabs(at[2]) <= TERRAIN_HEIGHT_MOST ? CW_SIGHT_SEEN : CW_SIGHT_TOO_FAR;
}

cw_sight_answer cw_sight_settle(const sight *s, const double target[3], const double middle[2], double block,
                                double ends[2][2]) {
    const terrain *t = s->terrain;
    const double *eye = s->eye, height = target[2] - eye[2] - sight_fall(s, target[0], target[1]);
    double metres[2];
    cw_sight_answer a = {NAN, {NAN, NAN, NAN}, NAN, CW_SIGHT_SEEN, 0};
    cw_terrain_metres(t, middle[0], middle[1], metres);
    for (int e = 0; e < 2; e++) terrain_to_map(t, e ? target[0] : eye[0], e ? target[1] : eye[1], ends[e]);
    a.metres = hypot((ends[1][0] - ends[0][0]) * metres[0], (ends[1][1] - ends[0][1]) * metres[1]);
    if (!(block < INFINITY)) return a;
    a.state = CW_SIGHT_BLOCKED;
    for (int c = 0; c < 2; c++) a.blocked[c] = ends[0][c] + block * (ends[1][c] - ends[0][c]);
    /* The line bends up against the lowered surface by as much as that is lowered. */
    const double bend = sight_fall(s, eye[0] + block * (target[0] - eye[0]), eye[1] + block * (target[1] - eye[1]));
    a.blocked[2] = (eye[2] + block * height + bend) * terrain_metres_of_height(t);
    a.distance = block * a.metres;
    return a;
}

static cw_sight_answer look_along(const looking *l, const cw_sight *line) {
    const terrain *t = l->terrain;
    double at[2][3], middle[2], ends[2][2];
    cw_sight_answer a = {NAN, {NAN, NAN, NAN}, NAN, CW_SIGHT_SEEN, 0};
    for (uint32_t e = 0; e < 2; e++) {
        a.state = find_place(t, e ? line->to : line->from, (line->absolute >> e & 1) != 0, at[e]);
        a.end = e;
        if (a.state != CW_SIGHT_SEEN) return a;
    }
    sight s;
    cw_sight_middle(at[0], at[1], middle);
    cw_sight_init_line(&s, t, at[0], middle, l->curvature);
    return cw_sight_settle(&s, at[1], middle, cw_sight_first_block(&s, at[1][0], at[1][1], at[1][2]), ends);
}

static void look_along_some(void *context, size_t begin, size_t end) {
    const looking *l = context;
    for (size_t k = begin; k < end; k++) l->answers[k] = look_along(l, &l->lines[k]);
}

cw_status cw_lines_of_sight(const cw_terrain *t, const cw_run *run, double curvature, const cw_sight *lines, size_t n,
                            cw_sight_answer *answers) {
    FPENV_HERE;
    enum { FEW = 64 };
    cw_run how;
    cw_area all = {0};
    cw_status status = cw_area_begin(t, lines ? lines : n > 0 ? NULL : (const void *)&all, "lines", run, 1, &all, &how);
    if (status == CW_OK) status = cw_check_number("curvature", curvature, 0, 1e9);
    if (status == CW_OK && n > 0 && answers == NULL) status = cw_fail(CW_ERROR_ARGUMENT, "answers: NULL");
    for (size_t k = 0; k < n && status == CW_OK; k++)
        if (lines[k].absolute > 3 || lines[k].zero != 0)
            status =
                cw_fail(CW_ERROR_ARGUMENT, "lines: absolute is %u and zero %u in number %zu; they are 0 to 3 and 0",
                        lines[k].absolute, lines[k].zero, k);
    if (status != CW_OK) return status;
    looking l = {t, lines, answers, curvature};
    door_pass in;
    if (!cw_terrain_enter(t, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    status = cw_run_work(&how, n, FEW, FEW, look_along_some, &l);
    cw_field_leave(in);
    return status;
}
