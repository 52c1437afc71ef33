/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain.h"

#include "samples.h"

#include <math.h>
#include <string.h>

static const double pi = 3.141592653589793;

bool cw_terrain_place(terrain *t, const double (*map)[4], const cw_terrain_desc *d) {
    t->field = d->field;
    t->geographic = d->geographic;
    memcpy(t->map, map, sizeof t->map);
    t->unit = d->unit > 0 ? d->unit : d->geographic ? pi / 180 : 1;
    t->scale = d->geographic ? NULL : (const map_scale *)d->scale;
    const double flattening = d->inverse_flattening > 0 ? 1 / d->inverse_flattening : 0;
    const bool known = d->semi_major > 0;
    t->radius = known ? d->semi_major : 6378137;
    const double f = known ? flattening : 1 / 298.257223563;
    t->eccentricity2 = f * (2 - f);
    if (!d->geographic) t->map[2][2] *= t->unit;

    const double a = t->map[0][0], b = t->map[0][1], c = t->map[1][0], e = t->map[1][1], determinant = a * e - b * c;
    if (!(isfinite(determinant) && determinant != 0)) return false;
    const double inverse[2][2] = {{e / determinant, -b / determinant}, {-c / determinant, a / determinant}};
    for (int k = 0; k < 2; k++) {
        t->back[k][0] = inverse[k][0];
        t->back[k][1] = inverse[k][1];
        t->back[k][2] = -(inverse[k][0] * t->map[0][3] + inverse[k][1] * t->map[1][3]);
    }
    /* Metres that a file calls degrees lie far from the globe; at a pole the last row may lie a cell beyond. */
    for (int k = 0; k < 4 && t->geographic; k++) {
        double xy[2];
        terrain_to_map(t, k & 1 ? (double)(t->nx - 1) : 0, k & 2 ? (double)(t->ny - 1) : 0, xy);
        if (!(fabs(xy[1]) * t->unit <= pi / 2 + (fabs(c) + fabs(e)) * t->unit)) return false;
    }
    return isfinite(t->back[0][2]) && isfinite(t->back[1][2]);
}

/* On an ellipsoid the meridian's radius of curvature is a (1 - e²) / w³, across it a / w, w² = 1 - e² sin² latitude. */
void cw_terrain_metres(const terrain *t, double i, double j, double metres[2]) {
    metres[0] = metres[1] = t->unit;
    if (!terrain_has_rows(t)) return;
    if (t->whole) { /* coordinates are sums of whole numbers and fractions that have room in double */
        cw_terrain_metres(t->whole, i + (double)t->column, j + (double)t->row, metres);
        return;
    }
    if (t->scale != NULL) {
        map_scale_at(t->scale, t->nx, t->ny, i, j, metres);
        return;
    }
    double xy[2];
    terrain_to_map(t, i, j, xy);
    double latitude = xy[1] * t->unit;
    latitude = latitude > pi / 2 ? pi / 2 : latitude < -pi / 2 ? -pi / 2 : latitude;
    const double sine = sin(latitude), w2 = 1 - t->eccentricity2 * sine * sine, w = sqrt(w2);
    /* At the poles a degree of longitude has no length: a millimetre keeps directions finite. */
    metres[0] = fmax(t->unit * t->radius / w * cos(latitude), 1e-3);
    metres[1] = t->unit * t->radius * (1 - t->eccentricity2) / (w2 * w);
}

void cw_terrain_sine_cosine(double degrees, double *sine, double *cosine) {
    const double turn = remainder(degrees, 360); /* exact */
    const double quarter = nearbyint(turn / 90), rest = (turn - 90 * quarter) * (pi / 180);
    const double s = sin(rest), c = cos(rest);
    const double diagonal = fabs(rest) == pi / 4 ? c : fabs(s);
    const double low = s < 0 ? -diagonal : diagonal; /* the same number for both on a diagonal */
    const double sines[4] = {low, c, -low, -c};      /* a quarter of the round apart */
    *sine = sines[(int)quarter & 3];
    *cosine = sines[((int)quarter + 1) & 3];
}

double cw_terrain_direction(const terrain *t, double i, double j, double azimuth, double dir[2]) {
    double metres[2], sine, cosine;
    cw_terrain_metres(t, i, j, metres);
    cw_terrain_sine_cosine(azimuth, &sine, &cosine);
    const double x = sine / metres[0], y = cosine / metres[1]; /* a metre on the map */
    double rounding[2]; /* along an axis or a diagonal, as far as azimuth and map are known, it is that exactly */
    for (int k = 0; k < 2; k++) {
        const double sum = t->back[k][0] * x + t->back[k][1] * y;
        rounding[k] = PLACE_ROUNDING * (fabs(t->back[k][0]) + fabs(t->back[k][1])) * (fabs(x) + fabs(y));
        dir[k] = fabs(sum) > rounding[k] ? sum : 0;
    }
    if (fabs(dir[0] - dir[1]) <= rounding[0] + rounding[1]) dir[1] = dir[0];
    const double length = 1 / fmax(fabs(dir[0]), fabs(dir[1])); /* metres in a cell along the longer axis */
    dir[0] *= length;
    dir[1] *= length;
    return length;
}

double cw_terrain_steps_out(const terrain *t, const double at[2], const double dir[2]) {
    const terrain *whole = terrain_whole(t);
    const double from[2] = {at[0] + (double)t->column, at[1] + (double)t->row};
    double steps = INFINITY;
    for (int a = 0; a < 2; a++) {
        const double last = (double)((a ? whole->ny : whole->nx) - 1);
        if (dir[a] != 0) steps = fmin(steps, ((dir[a] > 0 ? last : 0) - from[a]) / dir[a] + 1);
    }
    return steps;
}

double cw_terrain_height(const terrain *t, double i, double j) { return cw_terrain_level(t, i, j) * t->map[2][2]; }

double cw_terrain_level(const terrain *t, double i, double j) {
    if (!(i >= 0 && j >= 0 && i <= (double)(t->nx - 1) && j <= (double)(t->ny - 1))) return NAN;
    const size_t ci = i < (double)(t->nx - 1) ? (size_t)i : t->nx - 2,
                 cj = j < (double)(t->ny - 1) ? (size_t)j : t->ny - 2;
    const float *z = terrain_row(t, cj) + ci;
    const double x = i - (double)ci, y = j - (double)cj;
    const double across = x > y ? x : y, along = x > y ? y : x;
    const double weight[3] = {1 - across, across - along, along};
    const float *const corner[3] = {z, x > y ? z + 1 : z + t->stride, z + t->stride + 1};
    double height = 0;
    for (int k = 0; k < 3; k++) /* on an edge or at a sample the cells beyond do not count, hole or not */
        if (weight[k] > 0) height += weight[k] * (double)*corner[k];
    return isfinite(height) ? height : NAN;
}

size_t cw_terrain_rows_alike(const terrain *t, size_t row) {
    if (!terrain_has_rows(t)) return t->ny;
    size_t rows = 1;
    double here[2], there[2];
    cw_terrain_metres(t, 0.5 * (double)(t->nx - 1), (double)row, here);
    for (; row + rows < t->ny && rows < 256; rows++) {
        cw_terrain_metres(t, 0.5 * (double)(t->nx - 1), (double)(row + rows), there);
        if (fabs(there[0] / here[0] - 1) > 1e-4 || (t->scale && fabs(there[1] / here[1] - 1) > 1e-4)) break;
    }
    return rows;
}

/* Moves a place to the sample that is within a millimetre of it on the ground; of cells of some millimetres, within a
 * part of them that no place is written for. */
static void snap_to_sample(const terrain *whole, double at[2]) {
    static const double near = 1e-3, part = 0x1p-6;
    const double sample[2] = {nearbyint(at[0]), nearbyint(at[1])}, i = at[0] - sample[0], j = at[1] - sample[1];
    if (!(fabs(i) <= part && fabs(j) <= part)) return;
    double metres[2];
    cw_terrain_metres(whole, sample[0], sample[1], metres);
    const double x = whole->map[0][0] * i + whole->map[0][1] * j, y = whole->map[1][0] * i + whole->map[1][1] * j;
    if (hypot(x * metres[0], y * metres[1]) <= near) memcpy(at, sample, sizeof sample);
}

bool cw_terrain_find_place(const terrain *t, double x, double y, double at[2]) {
    static const double unit = 0x1p-28;
    const terrain *whole = terrain_whole(t);
    double slack[2];
    terrain_from_map(whole, x, y, at);
    const bool near = fabs(at[0]) <= 0x1p24 && fabs(at[1]) <= 0x1p24; /* lines of sight can be computed */
    for (int c = 0; c < 2 && near; c++) {
        /* Coordinates and the map's numbers are off by half a last digit each, and so are their products and sums. */
        const double *b = whole->back[c];
        slack[c] = fmax(unit, 0x1p-51 * (fabs(b[0] * x) + fabs(b[1] * y) + fabs(b[2])));
        at[c] = nearbyint(at[c] / unit) * unit;
        if (fabs(at[c] - nearbyint(at[c])) <= slack[c]) at[c] = nearbyint(at[c]);
    }
    const double diagonal = at[0] - at[1];
    if (near && fabs(diagonal - nearbyint(diagonal)) <= fmax(slack[0], slack[1])) at[0] = at[1] + nearbyint(diagonal);
    if (near) snap_to_sample(whole, at);
    at[0] -= (double)t->column;
    at[1] -= (double)t->row;
    return near;
}
