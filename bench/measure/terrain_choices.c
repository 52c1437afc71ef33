/* SPDX-License-Identifier: Apache-2.0 */
/* FIELD/horizon and FIELD/sky: choices between speed and accuracy of horizons and of the sky-view factor, on land of
 * 10 m cells. Contenders are directions:N, coarser:FACTOR and distance:CELLS. Only strips of the land's rows count. */

#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"
#include "terrain.h"

#include <limits.h>
#include <math.h>
#include <string.h>

enum { CELL = 10, STRIPS = 2, BORDER = 16, ANGLES = 8, SKY_TRUTH = 256, SKY_DEFAULT = 64 };

typedef struct choice {
    land *land;
    terrain terrain; /* the land, or coarser */
    cw_horizon desc;
    bool sky;
    size_t factor;
    float *out; /* of all rows computed; of horizons, a direction behind the other */
    bool failed;
} choice;

typedef struct choices {
    land *land;
    choice truth;
    bool judged; /* the truth is computed */
} choices;

/* Strips of the land's rows, and which rows of a choice they are: with those that coarser land is interpolated from. */
static size_t strip_rows(const choice *c) { return c->land->samples.ny / (4 * STRIPS) + 1; }
static size_t strip_of(const choice *c, size_t s) { return s * (c->land->samples.ny / STRIPS); }
static size_t begin_of(const choice *c, size_t s) { return strip_of(c, s) / c->factor; }
static size_t end_of(const choice *c, size_t s) {
    const size_t end = (strip_of(c, s) + strip_rows(c) - 1) / c->factor + (c->factor > 1 ? 2 : 1);
    return end < c->terrain.ny ? end : c->terrain.ny;
}

static void compute(void *context) {
    choice *c = context;
    const size_t nx = c->terrain.nx;
    cw_status status = CW_OK;
    for (size_t s = 0; s < STRIPS && status == CW_OK; s++) {
        const size_t row = begin_of(c, s);
        const cw_area strip = {{0, row, nx, end_of(c, s) - row}, 0};
        float *out = c->out + row * nx;
        if (c->sky) status = cw_sky_view(&c->terrain, NULL, &c->desc, strip, out);
        for (uint32_t k = 0; k < c->desc.count && !c->sky && status == CW_OK; k++)
            status = cw_horizon_angles(&c->terrain, NULL, &c->desc, k, strip, out + k * nx * c->terrain.ny, NULL);
    }
    c->failed = status != CW_OK || c->failed;
}

/* Takes the name apart. */
static bool parse(choice *c, const char *name, bool sky, io_error *error) {
    unsigned number = 0;
    *c = (choice){.sky = sky, .factor = 1};
    c->desc = (cw_horizon){.start = sky ? 0 : 11.25, .count = sky ? SKY_DEFAULT : ANGLES};
    if (strcmp(name, "default") == 0 || (sky && contenders_number(name, "directions:", UINT_MAX, &c->desc.count)) ||
        (contenders_number(name, "coarser:", FACTOR_MAX, &number) && number > 1 && (c->factor = number)))
        return true;
    if (!contenders_number(name, "distance:", UINT_MAX, &number))
        return io_fail(
            error, "contender %s: horizons have default, coarser:FACTOR and distance:CELLS, the sky also directions:N",
            name);
    c->desc.max_distance = (double)number * CELL;
    return true;
}

static bool knows_horizon(const char *name, io_error *error) { return parse(&(choice){0}, name, false, error); }
static bool knows_sky(const char *name, io_error *error) { return parse(&(choice){0}, name, true, error); }

static bool prepare(choice *c, land *l, const char *name, bool sky, io_error *error) {
    if (!parse(c, name, sky, error)) return false;
    c->land = l;
    cw_field *field = land_coarser(l, c->factor, error);
    if (field == NULL) return false;
    const cw_field_info info = cw_field_describe(field);
    const double step = (double)(CELL * c->factor), map[3][4] = {{step, 0, 0, 0}, {0, step, 0, 0}, {0, 0, CELL, 0}};
    const float *z = cw_field_row(field, 0);
    const size_t stride = (size_t)(cw_field_row(field, 1) - z);
    c->terrain = (terrain){.nx = info.nx, .ny = info.ny, .stride = stride, .z = z};
    cw_terrain_place(&c->terrain, map, &(cw_terrain_desc){.field = field, .unit = 1});
    c->out = memory(info.nx * info.ny * (sky ? 1 : ANGLES), sizeof *c->out);
    return true;
}

/* Of coarser land's values, bilinear between its samples. */
static double value_at(const choice *c, size_t layer, size_t i, size_t j) {
    const size_t nx = c->terrain.nx, ny = c->terrain.ny;
    const float *values = c->out + layer * nx * ny;
    if (c->factor == 1) return (double)values[j * nx + i];
    const double x = (double)i / (double)c->factor, y = (double)j / (double)c->factor;
    const size_t a = (size_t)x < nx - 1 ? (size_t)x : nx - 2, b = (size_t)y < ny - 1 ? (size_t)y : ny - 2;
    const double u = x - (double)a, v = y - (double)b;
    const float *at = values + b * nx + a;
    return (1 - v) * ((1 - u) * (double)at[0] + u * (double)at[1]) +
           v * ((1 - u) * (double)at[nx] + u * (double)at[nx + 1]);
}

static void compare(const choice *c, const choice *truth, json_t *line) {
    const size_t nx = truth->terrain.nx, ny = truth->terrain.ny, layers = c->sky ? 1 : ANGLES;
    double *errors = memory(layers * nx * strip_rows(truth) * STRIPS, sizeof *errors);
    size_t count = 0;
    for (size_t layer = 0; layer < layers; layer++)
        for (size_t s = 0; s < STRIPS; s++)
            for (size_t j = strip_of(truth, s); j < strip_of(truth, s) + strip_rows(truth); j++)
                for (size_t i = BORDER; i + BORDER < nx; i++)
                    if (j >= BORDER && j + BORDER < ny)
                        errors[count++] = fabs(value_at(c, layer, i, j) - value_at(truth, layer, i, j));
    errors_set_spread(line, c->sky ? "share" : "degrees", errors, count);
    free(errors);
}

/* ---- the kinds ---- */

static bool open_choices(workload *w, io_error *error) {
    choices *all = w->own = memory(1, sizeof *all);
    all->land = land_of(w->field, w->options, w->why, error);
    if (all->land == NULL) return w->why[0] != '\0';
    if (!prepare(&all->truth, all->land, "default", w->kind == &measure_sky, error)) return false;
    /* None of these directions is among those that are compared. */
    if (all->truth.sky) all->truth.desc = (cw_horizon){.start = 0.3, .count = SKY_TRUTH};
    w->items = (double)(strip_rows(&all->truth) * STRIPS * all->truth.terrain.nx);
    return true;
}

static bool enter(workload *w, const char *name, io_error *error) {
    choices *all = w->own;
    entrant *e = measure_enter(w, name, name, error);
    if (e == NULL) return false;
    choice *c = e->own = memory(1, sizeof *c);
    e->job = (interleave_job){.run = compute, .context = c};
    return prepare(c, all->land, name, w->kind == &measure_sky, error);
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    choices *all = w->own;
    choice *c = e->own;
    compute(c);
    results_set_counts(e->line, "directions factor", (size_t[]){c->desc.count, c->factor});
    if ((metrics & METRIC_ERROR) && !all->judged) compute(&all->truth), all->judged = true;
    if (metrics & METRIC_ERROR) compare(c, &all->truth, e->line);
    return !(c->failed || all->truth.failed) || io_fail(error, "%s of %s: %s", e->name, w->name, cw_last_error());
}

static void leave(entrant *e) {
    free(((choice *)e->own)->out);
    free(e->own);
}

static void close_choices(workload *w) {
    free(((choices *)w->own)->truth.out);
    free(w->own);
}

#define CHOICES(word, what, knows)                                                                                     \
    { "FIELD/" word, what, "places", word, NULL, knows, open_choices, enter, judge, leave, close_choices }

const workload_kind measure_horizon = CHOICES("horizon", "horizons in eight directions", knows_horizon);
const workload_kind measure_sky = CHOICES("sky", "the sky-view factor, against 256 directions", knows_sky);
