/* SPDX-License-Identifier: Apache-2.0 */
#include "place.h"

#include "number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

size_t ground_numbers(const char *text, double *numbers, size_t least, size_t most) {
    for (size_t count = 0; count < most;) {
        char *end;
        numbers[count] = number_read(text, &end);
        if (end == text || !isfinite(numbers[count])) return 0;
        count++;
        if (*end == '\0') return count >= least ? count : 0;
        if (*end != ',') return 0;
        text = end + 1;
    }
    return 0;
}

const char *ground_number(double number, char text[GROUND_NUMBER]) {
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, GROUND_NUMBER, "%.*g", digits, number);
        if (number_read(text, NULL) == number) break;
    }
    return text;
}

bool ground_parse_place(const char *text, double height, io_place *p, io_error *error) {
    enum { LONGEST = 200 };
    char copy[LONGEST];
    double numbers[3] = {0, 0, height};
    const size_t length = strlen(text);
    const char *comma = strrchr(text, ',');
    const bool absolute = comma != NULL && comma[1] == '=' && comma != strchr(text, ',');
    size_t count = 0;
    if (length < LONGEST) {
        snprintf(copy, sizeof copy, "%s", text);
        if (absolute) memmove(copy + (comma - text) + 1, comma + 2, strlen(comma + 2) + 1);
        count = ground_numbers(copy, numbers, absolute ? 3 : 2, 3);
    }
    *p = (io_place){.x = numbers[0],
                    .y = numbers[1],
                    .z = numbers[2],
                    .weight = 1,
                    .along = NAN,
                    .absolute = absolute,
                    .text = text};
    return count > 0 ||
           io_fail(error,
                   "a place is X,Y or X,Y,H with H metres above ground, or X,Y,=Z with an absolute height, "
                   "not '%s'",
                   text);
}

static bool is_inside(const terrain *t, const double at[2], double beyond) {
    return at[0] >= -beyond && at[1] >= -beyond && at[0] <= (double)(t->nx - 1) + beyond &&
           at[1] <= (double)(t->ny - 1) + beyond;
}

static bool looks_like_degrees(const terrain *t, const io_place *p, const double low[2], const double high[2]) {
    const bool far = low[0] > 360 || high[0] < -360 || low[1] > 360 || high[1] < -360;
    return !t->geographic && far && fabs(p->x) <= 360 && fabs(p->y) <= 360;
}

double ground_round(const terrain *t) { return t->geographic ? 2 * 3.14159265358979323846 / t->unit : 0; }

/* A longitude outside the raster, as the raster counts it: up to two rounds nearer its middle. More is no longitude. */
static double turned(const terrain *t, double x) {
    double low[2], high[2];
    ground_extent(t, low, high);
    const double round = ground_round(t), rounds = round > 0 ? nearbyint((x - 0.5 * (low[0] + high[0])) / round) : 0;
    return (x < low[0] || x > high[0]) && fabs(rounds) <= 2 ? x - rounds * round : x;
}

/* Why a place has no ground. */
static bool tell_no_ground(const terrain *part, const io_place *p, const double there[2], io_error *error) {
    const terrain *t = terrain_whole(part);
    const double at[2] = {there[0] + (double)part->column, there[1] + (double)part->row};
    double low[2], high[2], swapped[2], round[2];
    char text[IO_PLACE_ROOM];
    if (is_inside(t, at, 0))
        return io_fail(error, "%s: there is no data at that place; X,Y,=Z gives the height itself",
                       io_place_text(p, text));
    ground_extent(t, low, high);
    terrain_from_map(t, p->y, p->x, swapped);
    terrain_from_map(t, turned(t, p->x), p->y, round);
    const char *why = is_inside(t, at, 0.5) ? "lies in the outer half of a pixel, beyond the outermost centres"
                      : looks_like_degrees(t, p, low, high)
                          ? "lies outside and looks like longitude and latitude, which this map does not have"
                      : is_inside(t, swapped, 0.5) ? "lies outside, but with X and Y exchanged it would not"
                      : is_inside(t, round, 0.5)   ? "lies outside, but with X 360 degrees away it would not"
                                                   : "lies outside";
    return io_fail(error,
                   "%s: %s: the samples, which are the pixels' centres, go from X %.10g to %.10g and Y %.10g to %.10g",
                   io_place_text(p, text), why, low[0], high[0], low[1], high[1]);
}

place_state ground_try_place(const terrain *t, const io_place *p, double at[3], double *level_there) {
    const bool near = cw_terrain_find_place(t, p->x, p->y, at);
    const double metres = terrain_metres_of_height(t), own = near ? cw_terrain_level(t, at[0], at[1]) : NAN;
    const double level = *level_there = own * metres;
    if (!near) return PLACE_FAR;
    if (!p->absolute && isnan(level)) return PLACE_NO_GROUND;
    const double height = p->absolute ? p->z : level + p->z;
    if (height < level - TERRAIN_LEAST_DEPTH) return PLACE_UNDER;
    at[2] = (p->absolute ? 0 : own) + p->z / metres;
    return fabs(at[2]) <= TERRAIN_HEIGHT_MOST ? PLACE_GOOD : PLACE_HIGH;
}

bool ground_find_place(const terrain *t, const io_place *p, double at[3], double *level_there, io_error *error) {
    char text[IO_PLACE_ROOM];
    double unused, *level = level_there ? level_there : &unused;
    const place_state state = ground_try_place(t, p, at, level);
    if (state == PLACE_GOOD) return true;
    if (state == PLACE_NO_GROUND || (state == PLACE_FAR && !p->absolute)) return tell_no_ground(t, p, at, error);
    const char *words = io_place_text(p, text);
    if (state == PLACE_UNDER)
        return io_fail(error, "%s: is under the ground, which is %.3f m high there: %s", words, *level,
                       p->absolute ? "X,Y,H counts H from the ground" : "H counts from the ground");
    return io_fail(error, "%s: is too %s", words, state == PLACE_FAR ? "far away from the terrain" : "high");
}

/* Metres between two places, by the scale halfway. */
static double length_between(const terrain *t, const io_place *a, const io_place *b) {
    double at[2], metres[2];
    terrain_from_map(t, 0.5 * (a->x + b->x), 0.5 * (a->y + b->y), at);
    cw_terrain_metres(t, at[0], at[1], metres);
    return hypot((b->x - a->x) * metres[0], (b->y - a->y) * metres[1]);
}

static bool fail_many(io_error *error) { return io_fail(error, "there are more than %d observers", OBSERVERS_MOST); }

/* Observers from one corner up to the next, and there too if it is the last. *step: how far the next one stands from
 * the line's beginning, in steps; before: the corner's distance from there. */
static bool put_between(io_points *o, const io_place *a, double before, double length, double every, double *step,
                        io_error *error) {
    const io_place *b = a + 1;
    const double end = before + length;
    /* A length that is some steps but for rounding has them all. */
    const double least = 0x1p-40 * end;
    for (; *step * every <= end + least; ++*step) {
        const double way = *step * every, share = length > 0 ? fmin((way - before) / length, 1) : 0;
        io_place next = *a;
        next.x += share * (b->x - a->x);
        next.y += share * (b->y - a->y);
        next.z += share * (b->z - a->z);
        next.weight += share * (b->weight - a->weight);
        next.along = way;
        if (o->count == OBSERVERS_MOST) return fail_many(error);
        if (!io_points_add(o, &next)) return io_fail(error, "out of memory");
    }
    return true;
}

/* Observers along the lines of which the places are corners. */
static bool put_along(io_points *o, const io_points *corners, double every, const terrain *t, io_error *error) {
    double before = 0, step = 0;
    char text[IO_PLACE_ROOM];
    for (size_t k = 0; k + 1 < corners->count; k++) {
        const io_place *a = &corners->list[k], *b = a + 1;
        if (a->part != b->part) {
            before = step = 0;
            continue;
        }
        if (a->absolute != b->absolute)
            return io_fail(error, "%s: heights along a line are all above ground, or all absolute",
                           io_place_text(b, text));
        const double length = length_between(t, a, b);
        if (!isfinite(length) || before + length > OBSERVERS_MOST * every) return fail_many(error);
        if (!put_between(o, a, before, length, every, &step, error)) return false;
        before += length;
    }
    return o->count > 0 || io_fail(error, "%s: a line has two corners or more", io_place_text(&corners->list[0], text));
}

bool observers_find(io_points *o, const observers_from *from, const ground *g, io_error *error) {
    const io_points_options reading = {
        .height = from->height, .layer = from->layer, .crs = g->about.georef.crs, .warn = g->watch.warn};
    io_points given = {0};
    if (from->file && !io_points_read(from->file, &reading, &given, error)) return false;
    bool good = true;
    for (size_t k = 0; good && k < from->place_count; k++)
        good = io_points_add(&given, &from->places[k]) || io_fail(error, "out of memory");
    if (from->lines && given.has_lines && from->every == 0)
        good = io_fail(error, "%s: holds lines, and --every D says where on them observers stand", from->file);
    if (good && given.count > OBSERVERS_MOST) good = fail_many(error);
    for (size_t k = 0; k < given.count; k++) given.list[k].x = turned(&g->whole, given.list[k].x);
    *o = (io_points){.has_weight = given.has_weight};
    if (good && from->every > 0)
        good = put_along(o, &given, from->every, &g->whole, error);
    else if (good) {
        *o = given;
        return true;
    }
    io_points_free(&given);
    if (!good) io_points_free(o);
    return good;
}

view_sum view_sum_of(const terrain *t, cw_rectangle at, const uint16_t *seen, const uint8_t *within,
                     const double eye[2]) {
    view_sum v = {0, 0, NAN, {NAN, NAN}};
    double metres[2], far = -1;
    cw_terrain_metres(t, eye[0], eye[1], metres);
    const double cell = 1e-6 * fabs(t->map[0][0] * t->map[1][1] - t->map[0][1] * t->map[1][0]);
    for (size_t y = at.j; y < at.j + at.ny; y++) {
        double count = 0, sum = 0, scale[2];
        for (size_t x = at.i; x < at.i + at.nx; x++) {
            if (seen[y * t->nx + x] == 0 || (within && within[y * t->nx + x] == 0)) continue;
            const double dx = (double)x - eye[0], dy = (double)y - eye[1];
            const double away = hypot((t->map[0][0] * dx + t->map[0][1] * dy) * metres[0],
                                      (t->map[1][0] * dx + t->map[1][1] * dy) * metres[1]);
            count++;
            sum += (double)x;
            if (away <= far) continue;
            v.farthest = far = away;
            terrain_to_map(t, (double)x, (double)y, v.farthest_at);
        }
        if (count == 0) continue;
        cw_terrain_metres(t, sum / count, (double)y, scale);
        v.samples += count;
        v.km2 += cell * scale[0] * scale[1] * count;
    }
    return v;
}
