/* SPDX-License-Identifier: Apache-2.0 */
/* Levels of detail. Each ray meets level 0 up to a border, level 1 from there to the next one, and so on. Only x and y are
 * scaled from level to level, by powers of 2, so that rays keep their bits and t means the same.
 *
 * Nothing slips through. At a border a ray leaves one surface and comes to another, which lies elsewhere. Let a ray be *clear*
 * of a surface at a place if its height over it, up or down, is more than E + 2 S delta (papers/numerics.md). There it is
 * proved that a ray which is clear and above at one place of its range, and clear and below at a later one, or the
 * reverse, hits on that level. A ray that is not caught at a border is clear of both surfaces there, and on the same side of both
 * (caught). Now take a ray over a field without holes that hits nothing, and that is clear and above where it begins. It is
 * above at the end of its first range, or there would be a hit in it; so it is above at the begin of the next range, or it
 * would be caught; and so on. So it is nowhere clear and below: no ray gets from above to below without a hit. The same
 * holds from below to above. Over a hole a ray has no side, and is not caught. */

#include "detail.h"

#include <math.h>
#include <string.h>

enum { CELLS_LEAST = 16 };

static const cw_hit miss = {.t = INFINITY, .i = -1, .j = -1};

/* ---- levels ------------------------------------------------------------------------------------------------------- */

/* The largest difference of heights along an edge or a diagonal; comparisons pass over holes. */
static double largest_edge(const cw_field *field, const cw_field_info *info) {
    float most = 0;
    for (size_t j = 0; j < info->ny; j++) {
        const float *z = cw_field_row(field, j), *next = cw_field_row(field, j + 1 < info->ny ? j + 1 : j);
        for (size_t i = 0; i + 1 < info->nx; i++) {
            const float along = fabsf(z[i + 1] - z[i]), up = fabsf(next[i] - z[i]), across = fabsf(next[i + 1] - z[i]);
            most = along > most ? along : most;
            most = up > most ? up : most;
            most = across > most ? across : most;
        }
        const float last = fabsf(next[info->nx - 1] - z[info->nx - 1]);
        most = last > most ? last : most;
    }
    return (double)most * (1 + 0x1p-22); /* differences were rounded */
}

static detail_level level_of(detail *d, const cw_field *field, float scale) {
    const cw_field_info info = cw_field_describe(field);
    const double edge = largest_edge(field, &info);
    d->edge = fmax(d->edge, edge);
    d->steep = fmax(d->steep, edge * (double)scale);
    return (detail_level){.field = field,
                          .z = cw_field_row(field, 0),
                          .samples = cw_field_row(field, 0),
                          .nx = info.nx,
                          .ny = info.ny,
                          .scale = scale};
}

static void add_level(detail *d, const cw_field *field, const cw_difference *apart) {
    detail_level *l = &d->level[d->count];
    *l = level_of(d, field, ldexpf(1, -(int)d->count));
    l->near_above = apart->above;
    l->near_below = apart->below;
    if (d->count > 0) {
        l->above = l[-1].above + apart->above;
        l->below = l[-1].below + apart->below;
    }
    d->count++;
}

static bool fail(detail *d, cw_status status, io_error *error) {
    detail_free(d);
    return io_fail(error, "%s", status == CW_ERROR_CANCELLED ? "cancelled" : cw_last_error());
}

/* Each from the one before: in the inside of a field without holes, the tent over a tent is the tent over all. */
bool detail_make(detail *d, const cw_field *full, const cw_run *run, io_error *error) {
    const cw_field_info info = cw_field_describe(full);
    *d = (detail){.low = {0, 0, info.low}, .high = {(float)(info.nx - 1), (float)(info.ny - 1), info.high}};
    add_level(d, full, &(cw_difference){0});
    while (d->count < DETAIL_LEVELS_MAX) {
        const detail_level *l = &d->level[d->count - 1];
        cw_difference apart;
        if ((l->nx < l->ny ? l->nx : l->ny) - 1 < 2 * CELLS_LEAST) break;
        const cw_status status = cw_field_coarser(l->field, run, 2, CW_FILTER_MEAN, &d->own[d->count], &apart);
        if (status != CW_OK) return fail(d, status, error);
        add_level(d, d->own[d->count], &apart);
    }
    return true;
}

void detail_free(detail *d) {
    for (size_t k = 1; k < DETAIL_LEVELS_MAX; k++) cw_field_destroy(d->own[k]);
    *d = (detail){0};
}

detail_view detail_view_of(const detail *d, double cell, double height, double seen) {
    detail_view view = {{0}};
    for (size_t k = 1; k < d->count; k++) {
        const detail_level *l = &d->level[k];
        view.begin[k] = fmax(cell / (double)l->scale, fmax(l->above, l->below) * height) / seen;
    }
    return view;
}

static inline float fmax_of(float a, float b) { return a > b ? a : b; }
static inline float fmin_of(float a, float b) { return a < b ? a : b; }

/* ---- places ------------------------------------------------------------------------------------------------------- */

/* A place of a ray, in the full field's space. */
typedef struct place {
    double x, y, z;
} place;

static place place_of(const cw_ray *ray, float t) {
    return (place){(double)ray->org[0] + (double)t * (double)ray->dir[0],
                   (double)ray->org[1] + (double)t * (double)ray->dir[1],
                   (double)ray->org[2] + (double)t * (double)ray->dir[2]};
}

/* A ray that is so far over or under a level, at a place of the full field's box, is clear of it. E + 2 S delta is at most
 * u (5 Z + 16.5 SD + |oz|) + 3 delta0 S and some denormals, with u = 2^-24. In cells of the level, Z is at most that height,
 * |t dz| and 3 S; D is |t dx| + |t dy| + 4, at least 2; delta0 is at most 1.5 u times both sides. |t dx| is at most |ox| and a side,
 * |t dz| at most |oz| and the box's height, also of a moved ray. The place and the surface there are computed in double, but
 * for u and v of a hit, floats that move the height by 2 u S. */
static double clear_height(const detail *d, const float org[3]) {
    const double over = 2 * fabs((double)org[2]) + 2 * (fabs((double)d->low[2]) + fabs((double)d->high[2]));
    const double sides = (double)d->high[0] + (double)d->high[1],
                 beside = fabs((double)org[0]) + fabs((double)org[1]) + sides;
    return 0x1p-24 * (8 * over + d->steep * (32 * beside + 8 * sides) + 160 * d->edge) + 0x1p-120;
}

/* The height of a level's surface, and the place on it; false at a hole and outside. */
static bool surface_at(const detail_level *l, const place *p, cw_hit *hit, double *height) {
    cw_field_at(l->field, p->x * (double)l->scale, p->y * (double)l->scale, hit);
    if (hit->i < 0) return false;
    const float *z = cw_field_row(l->field, (size_t)hit->j) + hit->i;
    const float *north = cw_field_row(l->field, (size_t)hit->j + 1) + hit->i;
    const double base = (double)z[0], far = (double)north[1], u = (double)hit->u, v = (double)hit->v;
    *height = hit->triangle == CW_TRIANGLE_A ? base + u * ((double)z[1] - base) + v * (far - base)
                                             : base + u * (far - base) + v * ((double)north[0] - base);
    return true;
}

/* ---- borders ------------------------------------------------------------------------------------------------------ */

/* Is a place farther over or under the cell of level k there than level k - 1 can be off, and by clear? False also at a hole and near
 * the border. */
static bool far_from(const detail_level *l, const place *p, double clear) {
    const double x = p->x * (double)l->scale, y = p->y * (double)l->scale;
    if (!(x >= 0 && y >= 0 && x < (double)(l->nx - 1) && y < (double)(l->ny - 1))) return false;
    const float *z = l->z + (size_t)y * l->nx + (size_t)x, *north = z + l->nx;
    const float high = fmax_of(fmax_of(z[0], z[1]), fmax_of(north[0], north[1]));
    const float low = fmin_of(fmin_of(z[0], z[1]), fmin_of(north[0], north[1]));
    const float sum = (z[0] + z[1]) + (north[0] + north[1]);
    return (sum == sum) &
           ((p->z - (double)high > l->near_below + clear) | ((double)low - p->z > l->near_above + clear));
}

/* Whether a ray that comes from level k - 1 to level k at t is not clear and on the same side of both; then the hit is the place on
 * level k. */
static bool caught(const detail *d, size_t k, const cw_ray *ray, float t, double clear, cw_hit *hit) {
    const detail_level *far = &d->level[k], *near = far - 1;
    const place p = place_of(ray, t);
    double surface;
    if (far_from(far, &p, clear) || !surface_at(far, &p, hit, &surface)) return false;
    const double over_far = p.z - surface;
    cw_hit there;
    if (!surface_at(near, &p, &there, &surface)) return false;
    const double over_near = p.z - surface;
    hit->t = t;
    return !(over_far > clear && over_near > clear) && !(-over_far > clear && -over_near > clear);
}

/* ---- rays --------------------------------------------------------------------------------------------------------- */

/* Where the next level begins for a ray. */
static float until_of(double border, float reach) { return (float)(border * (double)reach); }

static cw_ray on_level(const cw_ray *ray, float scale, float tmin, float tmax) {
    return (cw_ray){.org = {ray->org[0] * scale, ray->org[1] * scale, ray->org[2]},
                    .tmin = tmin,
                    .dir = {ray->dir[0] * scale, ray->dir[1] * scale, ray->dir[2]},
                    .tmax = tmax};
}

/* The part of a ray's range in the full field's box. Each t has three roundings, so it is off by less than 2^-22 of itself; a NaN,
 * of a ray along a side, cuts nothing. */
static void clip(const detail *d, const cw_ray *ray, float *begin, float *end) {
    float from = ray->tmin, to = ray->tmax;
    for (int c = 0; c < 3; c++) {
        const float inverse = 1 / ray->dir[c];
        const float low = (d->low[c] - ray->org[c]) * inverse, high = (d->high[c] - ray->org[c]) * inverse;
        const float in = inverse > 0 ? low : high, out = inverse > 0 ? high : low;
        const float first = in - 0x1p-21f * fabsf(in), last = out + 0x1p-21f * fabsf(out);
        from = first > from ? first : from;
        to = last < to ? last : to;
    }
    *begin = from;
    *end = to;
}

static inline bool same_origin(const float *a, const float b[3]) {
    return a != NULL && a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Asks a level about the rays that begin on it; the others go on, as do those that leave it without a hit. */
static size_t meet_level(const detail *d, size_t level, double border, const scene_tracer *tracer, const cw_ray *rays,
                         const float *reach, cw_hit *hits, uint8_t *levels, size_t *active, detail_room *room) {
    size_t asked = 0, next = 0, kept = 0;
    for (size_t a = 0; a < *active; a++) {
        const size_t k = room->of[a];
        const float until = room->until[k] = until_of(border, reach[k]);
        room->asked[k] = room->begin[k] <= until;
        if (!room->asked[k]) continue;
        room->rays[asked++] =
            on_level(&rays[k], d->level[level].scale, room->begin[k], room->end[k] < until ? room->end[k] : until);
    }
    const float *org = NULL; /* of clear */
    double clear = 0;
    if (asked > 0) tracer->closest(tracer->context, level, room->rays, asked, room->hits);
    for (size_t a = 0; a < *active; a++) {
        const size_t k = room->of[a];
        bool goes_on = !room->asked[k];
        if (room->asked[k]) {
            const float until = room->until[k];
            const cw_hit *hit = &room->hits[next++];
            cw_hit there;
            levels[k] = (uint8_t)level;
            if (hit->i >= 0) {
                hits[k] = *hit;
            } else if (room->end[k] > until) {
                if (!same_origin(org, rays[k].org)) {
                    org = rays[k].org;
                    clear = clear_height(d, org);
                }
                goes_on = !caught(d, level + 1, &rays[k], until, clear, &there);
                if (!goes_on) {
                    hits[k] = there;
                    levels[k] = (uint8_t)(level + 1);
                }
            }
            room->begin[k] = until;
        }
        room->of[kept] = (uint32_t)k;
        kept += goes_on;
    }
    *active = kept;
    return asked;
}

size_t detail_closest(const detail *d, const detail_view *view, const scene_tracer *tracer, const cw_ray *rays,
                      const float *reach, size_t n, cw_hit *hits, uint8_t *levels, detail_room *room) {
    size_t active = 0, sum = 0;
    for (size_t k = 0; k < n; k++) {
        hits[k] = miss;
        levels[k] = 0;
        clip(d, &rays[k], &room->begin[k], &room->end[k]);
        room->of[active] = (uint32_t)k;
        active += room->begin[k] <= room->end[k];
    }
    for (size_t level = 0; active > 0; level++) {
        const double border = level + 1 < d->count ? view->begin[level + 1] : INFINITY;
        sum += meet_level(d, level, border, tracer, rays, reach, hits, levels, &active, room);
    }
    return sum;
}
