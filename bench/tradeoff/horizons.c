/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons in all directions from all samples: exact, along the grid, near ones alone, and of coarser land. */
#include "tradeoff/tradeoff.h"

#include "harness/memory.h"
#include "harness/results.h"
#include "horizon.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { DIRECTIONS = 8, BORDER = 16, STRIPS = 8, RUNNERS_MAX = 16 };

/* Between those of the grid. */
static const double start = 11.25;

typedef struct runner {
    const char *what;
    horizon_desc desc;
    size_t factor;
    terrain terrain;
    cw_field *field; /* own, or NULL; z likewise */
    float *z;
    bool strips; /* a part of the rows, spread over all, stands for all */
    float *angles;
    cw_status status;
    interleave_job job;
} runner;

static size_t strip_rows(const runner *r) { return r->strips ? r->terrain.ny / (4 * STRIPS) : r->terrain.ny; }

/* All directions, from making the horizon on. A direction's angles stand behind those of the one before where they are kept. */
static void compute(void *context) {
    runner *r = context;
    const size_t nx = r->terrain.nx, ny = r->terrain.ny, rows = strip_rows(r);
    const bool kept = !r->strips && r->desc.count == DIRECTIONS;
    horizon *h;
    r->status = horizon_create(&r->terrain, &r->desc, &h);
    for (size_t k = 0; r->status == CW_OK && k < r->desc.count; k++)
        for (size_t s = 0; r->status == CW_OK && s < (r->strips ? STRIPS : 1); s++)
            r->status = horizon_angles(h, NULL, k, s * (ny / STRIPS), rows, r->angles + (kept ? k * nx * ny : 0));
    horizon_destroy(h);
}

/* Against the angles of all directions on the full land; their number is *count. */
static tradeoff_spread compare(const runner *r, const float *truth, size_t nx, size_t ny, double *errors) {
    const size_t cells = r->terrain.nx * r->terrain.ny, step = nx * ny * DIRECTIONS / (1 << 20) | 1;
    size_t count = 0;
    for (size_t k = 0; k < DIRECTIONS * nx * ny; k += step) {
        const size_t direction = k / (nx * ny), at = k % (nx * ny), i = at % nx, j = at / nx;
        if (i < BORDER || j < BORDER || i >= nx - BORDER || j >= ny - BORDER) continue;
        const float *angles = r->angles + direction * cells;
        const double angle = r->factor > 1 ? tradeoff_between(angles, r->terrain.nx, r->terrain.ny, r->factor, i, j)
                                           : (double)angles[at];
        errors[count++] = fabs(angle - (double)truth[k]);
    }
    return tradeoff_spread_of(errors, count);
}

static runner *add(runner *runners, size_t *count, const char *what, horizon_desc desc, const tradeoff_land *land) {
    runner *r = &runners[(*count)++];
    *r = (runner){.what = what, .desc = desc, .factor = 1};
    r->terrain = tradeoff_terrain_of(land->field, land->samples.z, 1);
    return r;
}

static bool add_coarser(runner *runners, size_t *count, size_t factor, const tradeoff_land *land, io_error *error) {
    runner *r = add(runners, count, "coarser", (horizon_desc){.start = start, .count = DIRECTIONS}, land);
    const cw_status status = cw_field_coarser(land->field, NULL, factor, CW_FILTER_MEAN, &r->field, NULL);
    if (status != CW_OK) return io_fail(error, "coarser land: %s", cw_last_error());
    r->factor = factor;
    r->z = tradeoff_samples_of(r->field);
    r->terrain = tradeoff_terrain_of(r->field, r->z, factor);
    return true;
}

static json_t *line_of(const runner *r, const tradeoff_land *land) {
    const double rows = r->strips ? (double)(STRIPS * strip_rows(r)) : (double)land->samples.ny;
    json_t *line = json_object();
    results_set_texts(line, "kind field method", (const char *[]){"horizon", land->samples.name, r->what});
    results_set_counts(line, "directions factor", (size_t[]){r->desc.count, r->factor});
    results_set_number(line, "max_distance_cells", r->desc.max_distance / TRADEOFF_CELL);
    results_set_seconds(line, &r->job.seconds);
    results_set_number(line, "ns_an_angle",
                       r->job.seconds.median / (rows * (double)land->samples.nx * (double)r->desc.count) * 1e9);
    return line;
}

/* Eight exact directions, then near ones and coarser land, whose angles are kept for errors; then the grid's directions, and as
 * many exact ones as the first eight of the grid have, which are the same directions. */
static bool enter(runner *runners, size_t *count, bool timed_alone, const tradeoff_land *land, io_error *error) {
    static const double cells[] = {30, 100, 300};
    const double reach = (double)land->samples.nx / 3;
    add(runners, count, "exact", (horizon_desc){.start = start, .count = DIRECTIONS}, land)->strips = timed_alone;
    for (int k = 0; k < 3 && !timed_alone && cells[k] < reach; k++)
        add(runners, count, "max-distance",
            (horizon_desc){.start = start, .count = DIRECTIONS, .max_distance = cells[k] * TRADEOFF_CELL}, land);
    for (size_t factor = 2; factor <= 8 && !timed_alone; factor *= 2)
        if (!add_coarser(runners, count, factor, land, error)) return false;
    for (size_t k = 8; k <= 32; k *= 2) add(runners, count, "grid", (horizon_desc){.count = k, .grid = true}, land);
    return true;
}

bool tradeoff_horizons_run(const char *name, bool timed_alone, const tradeoff_options *o, double seconds, json_t *lines,
                           io_error *error) {
    tradeoff_land land;
    bool skipped, good = tradeoff_land_open(name, &land, &skipped, error);
    if (!good || skipped) return good;
    fprintf(stderr, "land %s: horizons\n", name);
    const size_t nx = land.samples.nx, ny = land.samples.ny, samples = nx * ny;
    runner *runners = memory(RUNNERS_MAX, sizeof *runners);
    size_t count = 0;
    good = enter(runners, &count, timed_alone, &land, error);
    interleave_job *jobs[RUNNERS_MAX];
    for (size_t k = 0; k < count; k++) {
        runner *r = &runners[k];
        r->angles = memory((!r->strips && r->desc.count == DIRECTIONS ? DIRECTIONS : 1) * r->terrain.nx * r->terrain.ny,
                           sizeof *r->angles);
        r->job = (interleave_job){.run = compute, .context = r};
        jobs[k] = &r->job;
    }
    const interleave_limits limits = {
        .width = 0.02, .seconds = seconds, .least = timed_alone ? 1 : 3, .most = 50, .seed = o->run.seed};
    if (good) interleave(jobs, count, &limits);
    double *errors = memory(1 << 21, sizeof *errors);
    for (size_t k = 0; good && k < count; k++) {
        const runner *r = &runners[k];
        good = r->status == CW_OK || io_fail(error, "horizons of land %s: %s", name, cw_status_message(r->status));
        json_t *line = line_of(r, &land);
        if (good && !timed_alone && !r->desc.grid && k > 0) {
            const tradeoff_spread spread = compare(r, runners[0].angles, nx, ny, errors);
            tradeoff_set_spread(line, "degrees", &spread);
        }
        if (good && !timed_alone && r->desc.grid && r->desc.count == DIRECTIONS) {
            /* The only two that are computed differently and are to be the same. */
            runner other = {.desc = {.count = DIRECTIONS}, .terrain = r->terrain, .factor = 1};
            other.angles = memory(DIRECTIONS * samples, sizeof *other.angles);
            compute(&other);
            const tradeoff_spread spread = compare(&other, r->angles, nx, ny, errors);
            tradeoff_set_spread(line, "degrees", &spread);
            free(other.angles);
        }
        results_append(lines, line);
    }
    free(errors);
    for (size_t k = 0; k < count; k++) {
        cw_field_destroy(runners[k].field);
        free(runners[k].z);
        free(runners[k].angles);
    }
    free(runners);
    tradeoff_land_close(&land);
    return good;
}
