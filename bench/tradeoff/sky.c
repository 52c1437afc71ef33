/* SPDX-License-Identifier: Apache-2.0 */
/* The sky-view factor: its error against the number of directions, the distance that counts, and resolution. */
#include "tradeoff/tradeoff.h"

#include "clock.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "horizon.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Rows that are compared: some strips, spread over the land. */
enum { STRIPS = 8, STRIP_SHARE = 8, BORDER = 16, TRUTH = 256 };

typedef struct choice {
    const char *what;
    size_t directions;
    double cells; /* of distance; 0: no limit */
    size_t factor;
} choice;

static const choice choices[] = {
    {"exact", 4, 0, 1},          {"exact", 8, 0, 1},    {"exact", 16, 0, 1},
    {"exact", 32, 0, 1},         {"exact", 64, 0, 1},   {"exact", 128, 0, 1},
    {"grid", 8, 0, 1},           {"grid", 16, 0, 1},    {"grid", 32, 0, 1},
    {"max-distance", 64, 30, 1}, {"coarser", 32, 0, 2}, {"max-distance", 64, 100, 1},
    {"coarser", 32, 0, 4},       {"coarser", 32, 0, 8}, {"max-distance", 64, 300, 1},
};
enum { CHOICES = sizeof choices / sizeof *choices };

static size_t strip_of(size_t ny, size_t s) { return s * (ny / STRIPS); }
static size_t strip_rows(size_t ny) { return ny / (STRIPS * STRIP_SHARE) + 1; }

/* Of the strips alone, or of all rows: the grid and coarser land. Returns seconds for a row of the full land, below 0 on failure. */
static double compute(const terrain *t, const horizon_desc *desc, bool all, float *shares) {
    const double begin = clock_cpu_seconds();
    horizon *h;
    bool done = true;
    cw_status status = horizon_create(t, desc, &h);
    if (all && status == CW_OK) status = horizon_sky_view(h, NULL, 0, t->ny, shares, NULL, NULL, &done);
    for (size_t s = 0; s < STRIPS && !all && status == CW_OK; s++)
        status = horizon_sky_view(h, NULL, strip_of(t->ny, s), strip_rows(t->ny), shares + strip_of(t->ny, s) * t->nx,
                                  NULL, NULL, &done);
    horizon_destroy(h);
    const double rows = (double)(all ? t->ny : STRIPS * strip_rows(t->ny));
    return status == CW_OK ? (clock_cpu_seconds() - begin) / rows : -1;
}

static tradeoff_spread compare(const terrain *t, const float *shares, size_t factor, const float *truth, size_t nx,
                               size_t ny, double *errors) {
    size_t count = 0;
    for (size_t s = 0; s < STRIPS; s++)
        for (size_t j = strip_of(ny, s); j < strip_of(ny, s) + strip_rows(ny); j++)
            for (size_t i = BORDER; i < nx - BORDER; i++) {
                if (j < BORDER || j >= ny - BORDER) continue;
                const double share =
                    factor > 1 ? tradeoff_between(shares, t->nx, t->ny, factor, i, j) : (double)shares[j * nx + i];
                errors[count++] = fabs(share - (double)truth[j * nx + i]);
            }
    return tradeoff_spread_of(errors, count);
}

static bool measure(const choice *c, const tradeoff_land *land, const float *truth, json_t *lines, float *shares,
                    double *errors, io_error *error) {
    cw_field *own = NULL;
    float *z = NULL;
    const size_t nx = land->samples.nx, ny = land->samples.ny;
    terrain t = tradeoff_terrain_of(land->field, land->samples.z, 1);
    if (c->factor > 1) {
        if (cw_field_coarser(land->field, NULL, c->factor, CW_FILTER_MEAN, &own, NULL) != CW_OK)
            return io_fail(error, "coarser land: %s", cw_last_error());
        z = tradeoff_samples_of(own);
        t = tradeoff_terrain_of(own, z, c->factor);
    }
    const horizon_desc desc = {
        .count = c->directions, .grid = c->what[0] == 'g', .max_distance = c->cells * TRADEOFF_CELL};
    double times[3], worst = 0;
    for (int k = 0; k < 3; k++) {
        times[k] = compute(&t, &desc, desc.grid || c->factor > 1, shares) * (double)t.ny / (double)(nx * ny);
        worst = fmin(worst, times[k]);
    }
    json_t *line = json_object();
    results_set_texts(line, "kind field method", (const char *[]){"sky", land->samples.name, c->what});
    results_set_counts(line, "directions factor", (size_t[]){c->directions, c->factor});
    results_set_numbers(line, "max_distance_cells ns_a_place",
                        (double[]){c->cells, statistics_of(times, 3).median * 1e9});
    const tradeoff_spread spread = compare(&t, shares, c->factor, truth, nx, ny, errors);
    tradeoff_set_spread(line, "share", &spread);
    results_append(lines, line);
    cw_field_destroy(own);
    free(z);
    return worst == 0 || io_fail(error, "the sky-view factor of land %s cannot be computed", land->samples.name);
}

bool tradeoff_sky_run(const char *name, const tradeoff_options *o, json_t *lines, io_error *error) {
    tradeoff_land land;
    bool skipped, good = tradeoff_land_open(name, &land, &skipped, error);
    if (!good || skipped) return good;
    fprintf(stderr, "land %s: sky-view factor\n", name);
    const size_t samples = land.samples.nx * land.samples.ny;
    float *truth = memory(samples, sizeof *truth), *shares = memory(samples, sizeof *shares);
    double *errors = memory(samples, sizeof *errors);
    const terrain t = tradeoff_terrain_of(land.field, land.samples.z, 1);
    /* None of these directions is among those that are compared. */
    const horizon_desc many = {.start = 0.3, .count = o->quick ? TRUTH / 4 : TRUTH};
    good = compute(&t, &many, false, truth) >= 0 || io_fail(error, "no sky-view factor of land %s", name);
    for (size_t k = 0; good && k < CHOICES; k++)
        good = measure(&choices[k], &land, truth, lines, shares, errors, error);
    free(truth);
    free(shares);
    free(errors);
    tradeoff_land_close(&land);
    return good;
}
