/* SPDX-License-Identifier: Apache-2.0 */
/* Making a heading, and queries along it. */

#include "codes.h"
#include "fpenv.h"
#include "samples.h"
#include "sister.h"

#include <float.h>
#include <math.h>

typedef struct maker {
    const double *dir;
    double longest; /* the larger of |dir| */
    double reach, drop_rate;
    cw_crossing *to;
    float *drop; /* NULL: the earth is flat */
    size_t count;
} maker;

/* A crossing at t, at cell (i, j) seen from the start, that fraction of the way along the edge. */
static void add(maker *m, double t, double i, double j, double fraction, cw_crossing_kind kind) {
    if (t > m->reach) return;
    if (m->drop != NULL) m->drop[m->count] = (float)(m->drop_rate * t);
    if (m->to != NULL)
        m->to[m->count] = (cw_crossing){
            .fraction = (float)fraction,
            .inverse = (float)(1 / t),
            .i_kind = (int32_t)i * 4 + (int32_t)kind,
            .j = (int32_t)j,
        };
    m->count++;
}

/* The place along an edge, split into a whole number and a fraction below 1; false at a sample. */
static bool between_samples(const maker *m, double t, double place, double *whole, double *fraction) {
    const double nearest = nearbyint(place);
    const bool between = fabs(place - nearest) > PLACE_ROUNDING * (t * m->longest);
    *whole = between ? floor(place) : nearest;
    *fraction = between ? place - *whole : 0;
    return between;
}

/* Border `number` from the start across an axis (0: x), on either side. Crossings at samples are taken from the
 * borders across the longer axis and skipped at the others. */
static void add_border(maker *m, int axis, double number, double t, bool longer) {
    const double here = m->dir[axis] > 0 ? number : -number, place = t * m->dir[1 - axis];
    double whole, fraction;
    const bool between = between_samples(m, t, place, &whole, &fraction);
    if (!between && !longer) return;
    const cw_crossing_kind kind = !between ? CROSSES_VERTEX : axis == 0 ? CROSSES_COLUMN : CROSSES_ROW;
    add(m, t, axis == 0 ? here : whole, axis == 0 ? whole : here, fraction, kind);
}

/* The diagonal x - y = number, or minus that. */
static void add_diagonal(maker *m, double number, double t) {
    const double c = m->dir[0] > m->dir[1] ? number : -number;
    double whole, fraction;
    if (between_samples(m, t, t * m->dir[0], &whole, &fraction))
        add(m, t, whole, whole - c, fraction, CROSSES_DIAGONAL);
}

/* All crossings up to cell number cells along the longer axis, cell by cell; stretch[k].first is the crossing with
 * which stretch k of 4 cells begins. m->to NULL: they are only counted. */
static size_t make_crossings(maker *m, bool along_x, size_t cells, cw_stretch *stretch) {
    /* Of columns, rows and diagonals: the ray crosses them at t = 1 / rate, 2 / rate, …; the number of the next one. */
    double rate[3] = {fabs(m->dir[0]), fabs(m->dir[1]), fabs(m->dir[0] - m->dir[1])}, next[3] = {1, 1, 1};
    /* A component that is only rounding error crosses no border. */
    if (rate[2] <= PLACE_ROUNDING * m->longest) rate[2] = 0;
    m->count = 0;
    for (size_t k = 1; k <= cells; k++) {
        if (stretch != NULL && (k - 1) % 4 == 0) stretch[(k - 1) / 4].first = (uint32_t)m->count;
        const double until = (double)k / m->longest;
        for (; next[0] <= rate[0] * until; next[0]++) add_border(m, 0, next[0], next[0] / rate[0], along_x);
        for (; next[1] <= rate[1] * until; next[1]++) add_border(m, 1, next[1], next[1] / rate[1], !along_x);
        for (; next[2] <= rate[2] * until; next[2]++) add_diagonal(m, next[2], next[2] / rate[2]);
    }
    return m->count;
}

static int32_t least_index(int32_t a, int32_t b) { return a < b ? a : b; }
static int32_t most_index(int32_t a, int32_t b) { return a > b ? a : b; }

/* Widens the bounds of a stretch to those of a part of it. */
static void widen(cw_stretch *s, const cw_stretch *by) {
    s->inverse_least = lower(by->inverse_least, s->inverse_least);
    s->inverse_most = higher(by->inverse_most, s->inverse_most);
    s->drop = lower(by->drop, s->drop);
    s->i_low = least_index(s->i_low, by->i_low);
    s->i_high = most_index(s->i_high, by->i_high);
    s->j_low = least_index(s->j_low, by->j_low);
    s->j_high = most_index(s->j_high, by->j_high);
}

/* Of stretch k of a level, from its crossings or from the stretches below. */
static void bound_stretch(cw_heading *h, int level, uint32_t k) {
    cw_stretch *s = &h->stretch[level][k];
    /* Without crossings, as the last may be, it lies outside every field; sums with these bounds do not overflow. */
    enum { OUTSIDE = 1 << 30 };
    *s = (cw_stretch){s->first, INFINITY, 0, INFINITY, OUTSIDE, -OUTSIDE, OUTSIDE, -OUTSIDE};
    for (size_t n = s[0].first; level == 0 && n < s[1].first; n++) {
        const cw_crossing *c = &h->crossing[n];
        const int32_t i = c->i_kind >> 2, i_second = i + (c->i_kind & 1), j_second = c->j + (c->i_kind >> 1 & 1);
        widen(s, &(cw_stretch){0, c->inverse, c->inverse, h->drop ? h->drop[n] : 0, i, i_second, c->j, j_second});
    }
    for (uint32_t n = 4 * k; level > 0 && n < 4 * k + 4 && n < h->stretches[level - 1]; n++)
        widen(s, &h->stretch[level - 1][n]);
}

static cw_status make(cw_heading *h, const double dir[2], const cw_heading_desc *desc) {
    const cw_field *f = h->field;
    const double longest = fmax(fabs(dir[0]), fabs(dir[1])), reach = desc->reach > 0 ? desc->reach : INFINITY;
    const double x = (double)(f->nx - 1) / fabs(dir[0]), y = (double)(f->ny - 1) / fabs(dir[1]); /* may be infinite */
    /* Along the longer axis, that a ray can go through inside the field and within its reach, at most. */
    const size_t cells = (size_t)ceil(fmin(fmin(x, y), reach) * longest * (1 + 0x1p-40));
    maker m = {.dir = dir, .longest = longest, .reach = reach, .drop_rate = desc->drop};
    h->along_x = fabs(dir[0]) == longest;
    h->crossings = make_crossings(&m, h->along_x, cells, NULL);
    if (h->crossings > INT32_MAX) return cw_fail_plainly(CW_ERROR_MEMORY);
    h->crossing = m.to = cw_memory_allocate(&h->field->memory, (h->crossings + 1) * sizeof *h->crossing);
    if (h->crossing == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    if (desc->drop > 0) h->drop = m.drop = cw_memory_allocate(&h->field->memory, (h->crossings + 1) * sizeof *h->drop);
    if (desc->drop > 0 && h->drop == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    for (uint32_t n = (uint32_t)((cells + 3) / 4);; n = (n + 3) / 4) {
        cw_stretch *s = cw_memory_clear(&h->field->memory, ((size_t)n + 1) * sizeof *s);
        if (s == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
        const int l = h->levels++;
        h->stretch[l] = s;
        h->stretches[l] = n;
        if (l == 0) make_crossings(&m, h->along_x, cells, s);
        s[n].first = (uint32_t)h->crossings;
        for (uint32_t k = 0; k < n; k++) bound_stretch(h, l, k);
        if (n == 1 || h->levels == PYRAMID_LEVELS_MAX) return CW_OK;
    }
}

cw_status cw_heading_create(const cw_field *field, const cw_heading_desc *desc, cw_heading **heading) {
    FPENV_HERE;
    if (heading == NULL) return cw_fail(CW_ERROR_ARGUMENT, "heading: NULL");
    *heading = NULL;
    if (field == NULL || desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", field ? "desc" : "field");
    const cw_status reserved = cw_check_reserved(desc->reserved, 4, 0, "cw_heading_desc");
    if (reserved != CW_OK) return reserved;
    const double *dir = desc->dir;
    const double longest = fmax(fabs(dir[0]), fabs(dir[1]));
    if (!(isfinite(dir[0]) && isfinite(dir[1]) && longest >= 0x1p-40 && longest <= 0x1p40))
        return cw_fail(CW_ERROR_ARGUMENT, "dir: (%g, %g); its longer component is from 2^-40 to 2^40", dir[0], dir[1]);
    if (!(desc->reach >= 0 && isfinite(desc->reach)))
        return cw_fail(CW_ERROR_ARGUMENT, "reach: %g; it is finite and not negative", desc->reach);
    /* drop t is limited so that sums with rises of heights do not overflow. */
    if (!(desc->drop >= 0 && desc->drop * ((double)CW_SIDE_MAX / longest) <= (double)CW_HEIGHT_MAX))
        return cw_fail(CW_ERROR_ARGUMENT, "drop: %g; it is from 0 to 2^77 times dir's longer component", desc->drop);
    cw_heading *h = cw_memory_clear(&field->memory, sizeof *h);
    if (h == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    h->field = field;
    /* A component that rounding could have made is 0. */
    const double exact[2] = {fabs(dir[0]) <= PLACE_ROUNDING * longest ? 0 : dir[0],
                             fabs(dir[1]) <= PLACE_ROUNDING * longest ? 0 : dir[1]};
    const cw_status status = make(h, exact, desc);
    if (status == CW_OK)
        *heading = h;
    else
        cw_heading_destroy(h);
    return status;
}

void cw_heading_destroy(cw_heading *heading) {
    if (heading == NULL) return;
    const cw_allocator *memory = &heading->field->memory;
    for (int l = 0; l < heading->levels; l++) cw_memory_free(memory, heading->stretch[l]);
    cw_memory_free(memory, heading->drop);
    cw_memory_free(memory, heading->crossing);
    cw_memory_free(memory, heading);
}

/* Work is divided into tiles along the rays, so that the next group of a tile finds its samples in the caches. */
enum { TILE_LONG = 256, TILE_COLUMNS = GROUP_COLUMNS, TILE_ROWS = GROUP_ROWS };

typedef struct tiles {
    cw_heading_job job;
    cw_heading_fn *code;
    size_t columns, rows, across; /* of a tile; tiles in a row */
} tiles;

static void run_tiles(void *context, size_t begin, size_t end) {
    const tiles *t = context;
    for (size_t k = begin; k < end; k++) {
        const cw_heading_job *job = &t->job;
        const size_t i = job->i + k % t->across * t->columns, j = job->j + k / t->across * t->rows;
        const size_t i_end = i + t->columns, j_end = j + t->rows, i_last = job->i + job->nx, j_last = job->j + job->ny;
        t->code(job, i, i_end < i_last ? i_end : i_last, j, j_end < j_last ? j_end : j_last);
    }
}

/* By which rounding can put a place on an edge above both its samples, seen from a third one: sums and products of
 * differences of heights, of which each is off by u = 2^-24; 4 u of the whole range from the crossing, 3 u from the
 * bound. */
static float rounding(const cw_field *f) {
    const float range = f->high - f->low;
    return range >= 0 ? 8 * (FLT_EPSILON / 2) * range + FLT_MIN : 0;
}

/* out: the answers of the job, which has low and high besides. */
static cw_status query_along(cw_heading_job job, const cw_heading *h, const cw_run *run, cw_rectangle at,
                             const void *out, const char *out_name) {
    FPENV_HERE;
    if (h == NULL) return cw_fail(CW_ERROR_ARGUMENT, "heading: NULL");
    const size_t count = at.nx * at.ny;
    if (count > 0 && out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL for %zu samples", out_name, count);
    const cw_field *f = h->field;
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status == CW_OK) status = cw_check_rectangle(f, &at);
    const terrain_code *code;
    if (status == CW_OK) status = cw_terrain_settle(&how, &code);
    if (status != CW_OK || count == 0) return status;
    door_pass in;
    if (!cw_field_enter(f, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    job.heading = h;
    job.i = at.i;
    job.j = at.j;
    job.nx = at.nx;
    job.ny = at.ny;
    job.pad = rounding(f);
    tiles t = {job, code->heading, h->along_x ? TILE_LONG : TILE_COLUMNS, h->along_x ? TILE_ROWS : TILE_LONG, 0};
    t.across = (at.nx + t.columns - 1) / t.columns;
    status = cw_run_work(&how, t.across * ((at.ny + t.rows - 1) / t.rows), 1, 1, run_tiles, &t);
    cw_field_leave(in);
    return status;
}

cw_status cw_heading_steepest(const cw_heading *heading, const cw_run *run, float low, float high, cw_rectangle at,
                              float *slope) {
    if (isnan(low) || isnan(high)) return cw_fail(CW_ERROR_ARGUMENT, "%s: NaN", isnan(low) ? "low" : "high");
    if (low > high) return cw_fail(CW_ERROR_ARGUMENT, "low: %g, above high, %g", (double)low, (double)high);
    return query_along((cw_heading_job){.low = low, .high = high, .steepest = slope}, heading, run, at, slope, "slope");
}

cw_status cw_heading_occluded(const cw_heading *heading, const cw_run *run, float slope, cw_rectangle at,
                              uint8_t *occluded) {
    if (isnan(slope)) return cw_fail(CW_ERROR_ARGUMENT, "slope: NaN");
    const cw_heading_job job = {.low = slope, .high = slope, .occluded = occluded};
    return query_along(job, heading, run, at, occluded, "occluded");
}
