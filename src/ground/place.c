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

bool ground_parse_place(const char *text, double height, ground_place *p, io_error *error) {
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
    *p = (ground_place){text, numbers[0], numbers[1], numbers[2], absolute, 1};
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

static void find_extent(const terrain *t, double low[2], double high[2]) {
    for (int k = 0; k < 4; k++) {
        double xy[2];
        terrain_to_map(t, k & 1 ? (double)(t->nx - 1) : 0, k & 2 ? (double)(t->ny - 1) : 0, xy);
        for (int c = 0; c < 2; c++) {
            low[c] = k == 0 ? xy[c] : fmin(low[c], xy[c]);
            high[c] = k == 0 ? xy[c] : fmax(high[c], xy[c]);
        }
    }
}

static bool looks_like_degrees(const terrain *t, const ground_place *p, const double low[2], const double high[2]) {
    const bool far = low[0] > 360 || high[0] < -360 || low[1] > 360 || high[1] < -360;
    return !t->geographic && far && fabs(p->x) <= 360 && fabs(p->y) <= 360;
}

/* Why a place has no ground. */
static bool tell_no_ground(const terrain *part, const ground_place *p, const double there[2], io_error *error) {
    const terrain *t = terrain_whole(part);
    const double at[2] = {there[0] + (double)part->column, there[1] + (double)part->row};
    double low[2], high[2], swapped[2];
    if (is_inside(t, at, 0))
        return io_fail(error, "%s: there is no data at that place; X,Y,=Z gives the height itself", p->text);
    find_extent(t, low, high);
    terrain_from_map(t, p->y, p->x, swapped);
    const char *why = is_inside(t, at, 0.5) ? "lies in the outer half of a pixel, beyond the outermost centres"
                      : looks_like_degrees(t, p, low, high)
                          ? "lies outside and looks like longitude and latitude, which this map does not have"
                      : is_inside(t, swapped, 0.5) ? "lies outside, but with X and Y exchanged it would not"
                                                   : "lies outside";
    return io_fail(error,
                   "%s: %s: the samples, which are the pixels' centres, go from X %.10g to %.10g and Y %.10g to %.10g",
                   p->text, why, low[0], high[0], low[1], high[1]);
}

/* Heights as floats are known to half a millimetre at 8000 m. */
static const double least_depth = 1e-3;

bool ground_find_place(const terrain *t, const ground_place *p, double at[3], double *level_there, io_error *error) {
    const bool near = cw_terrain_find_place(t, p->x, p->y, at);
    const double level = near ? cw_terrain_height(t, at[0], at[1]) : NAN;
    if (level_there) *level_there = level;
    if (!p->absolute && isnan(level)) return tell_no_ground(t, p, at, error);
    if (!near) return io_fail(error, "%s: is too far away from the terrain", p->text);
    const double height = p->absolute ? p->z : level + p->z;
    if (height < level - least_depth)
        return io_fail(error, "%s: is under the ground, which is %.3f m high there: %s", p->text, level,
                       p->absolute ? "X,Y,H counts H from the ground" : "H counts from the ground");
    at[2] = height / terrain_metres_of_height(t);
    return isfinite(at[2]) || io_fail(error, "%s: is too high", p->text);
}
