/* SPDX-License-Identifier: Apache-2.0 */
/* Rays on coarser fields: the promised and the actual distance of their surfaces, and the gain in speed. */
#include "tradeoff/tradeoff.h"

#include "accuracy/judge.h"
#include "clock.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "peers/embree.h"
#include "workload/random.h"
#include "workload/ray_classes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LEVELS = 4, CONTENDERS_MAX = 1 + LEVELS + 2 * PEER_WIDTH_COUNT };
static const size_t factors[LEVELS] = {2, 4, 8, 16};
static const char *const filters[] = {"mean", "highest", "lowest"};

/* ---- asked against got ---- */

/* The surface's height at a place, in double. */
static double height_at(const cw_field *field, const cw_field_info *info, double x, double y) {
    const size_t i = (size_t)fmin(x, (double)(info->nx - 2)), j = (size_t)fmin(y, (double)(info->ny - 2));
    const float *z = cw_field_row(field, j) + i, *north = cw_field_row(field, j + 1) + i;
    const double u = x - (double)i, v = y - (double)j, low = (double)z[0], high = (double)north[1];
    return u >= v ? low + u * ((double)z[1] - low) + v * (high - (double)z[1])
                  : low + v * ((double)north[0] - low) + u * (high - (double)north[0]);
}

typedef struct apart {
    double above, below, squares;
    size_t places;
} apart;

static void look(apart *a, double coarser, double full) {
    const double d = coarser - full;
    a->above = fmax(a->above, d);
    a->below = fmax(a->below, 0 - d);
    a->squares += d * d;
    a->places++;
}

/* At random places and, on all but the largest fields, at all samples. The root mean square is that of the places alone. */
static apart compare_surfaces(const cw_field *full, const cw_field *coarser, size_t factor, const tradeoff_options *o) {
    const cw_field_info f = cw_field_describe(full), c = cw_field_describe(coarser);
    const double scale = 1 / (double)factor;
    const size_t step = f.nx * f.ny >> 27 ? 64 : 1, places = o->quick ? 4096 : 1 << 20;
    random_state r = {o->run.seed};
    apart random = {0}, samples = {0};
    for (size_t k = 0; k < places; k++) {
        const double x = random_unit(&r) * (double)(f.nx - 1), y = random_unit(&r) * (double)(f.ny - 1);
        look(&random, height_at(coarser, &c, x * scale, y * scale), height_at(full, &f, x, y));
    }
    for (size_t j = 0; j < f.ny; j += step) {
        const float *z = cw_field_row(full, j);
        for (size_t i = 0; i < f.nx; i++)
            look(&samples, height_at(coarser, &c, (double)i * scale, (double)j * scale), (double)z[i]);
    }
    random.above = fmax(random.above, samples.above);
    random.below = fmax(random.below, samples.below);
    random.places += samples.places;
    random.squares = sqrt(random.squares / (double)places);
    return random;
}

static bool compare_coarser(const char *land, const cw_field *full, size_t factor, cw_filter filter,
                            const tradeoff_options *o, json_t *lines, io_error *error) {
    cw_difference d;
    cw_field *coarser;
    const double start = clock_cpu_seconds();
    const cw_status status = cw_field_coarser(full, NULL, factor, filter, &coarser, &d);
    const double seconds = clock_cpu_seconds() - start;
    if (status != CW_OK) return io_fail(error, "land %s, every %zu-th sample: %s", land, factor, cw_last_error());
    const apart got = compare_surfaces(full, coarser, factor, o);
    cw_field_destroy(coarser);
    json_t *line = json_object();
    results_set_texts(line, "kind field filter", (const char *[]){"coarser", land, filters[filter]});
    results_set_counts(line, "factor places", (size_t[]){factor, got.places});
    results_set_numbers(line, "above below rms got_above got_below got_rms seconds",
                        (double[]){d.above, d.below, d.rms, got.above, got.below, got.squares, seconds});
    results_append(lines, line);
    return true;
}

/* ---- speed and error of a view ---- */

typedef struct runner {
    contender contender;
    const char *what;
    size_t factor; /* 0: Embree */
    cw_ray *rays;
    contender_pass pass;
    interleave_job job;
} runner;

typedef struct bout {
    const tradeoff_land *land;
    cw_field *levels[LEVELS];
    peer_embree *peers[2];
    runner *runners;
    size_t count;
} bout;

/* t is the same on all levels, and factors are powers of two, so that nothing is rounded. */
static cw_ray *rays_on(const cw_ray *rays, size_t n, size_t factor) {
    cw_ray *out = memory(n, sizeof *out);
    const float scale = 1 / (float)factor;
    for (size_t k = 0; k < n; k++) {
        out[k] = rays[k];
        for (int c = 0; c < 2; c++) {
            out[k].org[c] *= scale;
            out[k].dir[c] *= scale;
        }
    }
    return out;
}

static json_t *ray_line(const bout *b, const runner *r, size_t n, const cw_hit *truth, const double *exact,
                        const cw_hit *hits, double *shares, double *cells) {
    size_t both = 0, differ = 0;
    for (size_t k = 0; k < n; k++) {
        differ += (hits[k].i < 0) != (truth[k].i < 0);
        if (hits[k].i < 0 || truth[k].i < 0) continue;
        cells[both] = fabs((double)hits[k].t - exact[k]); /* directions have unit length */
        shares[both] = exact[k] > 0 ? cells[both] / exact[k] : 0;
        both++;
    }
    json_t *line = json_object();
    results_set_texts(line, "kind field rays contender kernel",
                      (const char *[]){"rays", b->land->samples.name, workload_class_name(WORKLOAD_PRIMARY), r->what,
                                       r->contender.name});
    results_set_counts(line, "factor width ray_count", (size_t[]){r->factor, r->contender.width, n});
    results_set_number(line, "differ_per_million", 1e6 * (double)differ / (double)n);
    const tradeoff_spread share = tradeoff_spread_of(shares, both), cell = tradeoff_spread_of(cells, both);
    tradeoff_set_spread(line, "t", &share);
    tradeoff_set_spread(line, "cells", &cell);
    results_set_seconds(line, &r->job.seconds);
    results_set_number(line, "mrays_per_s", (double)n / r->job.seconds.median * 1e-6);
    return line;
}

static void fight(bout *b, const tradeoff_options *o, double seconds, json_t *lines) {
    const tradeoff_land *land = b->land;
    cw_ray *rays = memory(o->count, sizeof *rays);
    const size_t n = workload_rays_make(land->field, WORKLOAD_PRIMARY, o->run.seed, o->count, rays);
    contender_answers answers = answers_make(n);
    cw_hit *truth = memory(n, sizeof *truth);
    double *exact = memory(n, sizeof *exact), *shares = memory(n, sizeof *shares), *cells = memory(n, sizeof *cells);
    interleave_job *jobs[CONTENDERS_MAX];
    for (size_t k = 0; k < b->count; k++) {
        runner *r = &b->runners[k];
        r->rays = r->factor > 1 ? rays_on(rays, n, r->factor) : rays;
        r->pass = (contender_pass){&r->contender, r->rays, n, false, answers};
        r->job = (interleave_job){.run = contender_run, .context = &r->pass};
        jobs[k] = &r->job;
    }
    const interleave_limits limits = {
        .width = 0.02, .seconds = seconds, .least = 3, .most = INTERLEAVE_SAMPLES_MAX, .seed = o->run.seed};
    contender_run(&b->runners[0].pass);
    interleave(jobs, b->count, &limits);
    /* The first is strict. Its cell is right, and its t is computed again. */
    const true_surface surface = {.z = land->samples.z, .nx = land->samples.nx, .ny = land->samples.ny};
    b->runners[0].contender.closest(&b->runners[0].contender, rays, n, truth);
    for (size_t k = 0; k < n; k++) {
        exact_hit hit = {.t = (double)truth[k].t};
        if (truth[k].i >= 0) exact_meet(&surface, &rays[k], truth[k].i, truth[k].j, truth[k].triangle, &hit);
        exact[k] = hit.t;
    }
    for (size_t k = 0; k < b->count; k++) {
        runner *r = &b->runners[k];
        contender_run(&r->pass);
        results_append(lines, ray_line(b, r, n, truth, exact, answers.hits, shares, cells));
        if (r->rays != rays) free(r->rays);
    }
    answers_free(answers);
    free(rays);
    free(truth);
    free(exact);
    free(shares);
    free(cells);
}

static bool add_field(bout *b, cw_field *field, size_t factor, io_error *error) {
    runner *r = &b->runners[b->count++];
    const cw_status status = contender_from_kernel(&r->contender, field, cw_run_kernel(field, NULL), CW_LEAF_DEFAULT);
    r->what = factor > 1 ? "coarser" : "strict";
    r->factor = factor;
    return status == CW_OK || io_fail(error, "land %s: %s", b->land->samples.name, cw_last_error());
}

static bool add_coarser(bout *b, int level, io_error *error) {
    const cw_status status =
        cw_field_coarser(b->land->field, NULL, factors[level], CW_FILTER_MEAN, &b->levels[level], NULL);
    if (status != CW_OK)
        return io_fail(error, "land %s, every %zu-th sample: %s", b->land->samples.name, factors[level],
                       cw_last_error());
    return add_field(b, b->levels[level], factors[level], error);
}

/* A mesh of triangles where it is built in seconds, else grids. */
static bool add_embree(bout *b, const tradeoff_options *o, io_error *error) {
    const char *name = b->land->samples.name;
    const peer_geometry geometry = b->land->samples.nx <= 1025 ? PEER_TRIANGLES : PEER_GRID;
    for (int robust = 0; robust < 2 && peer_embree_version(); robust++) {
        const peer_options options = {
            .isa = (cw_isa)o->run.isa, .geometry = geometry, .quality = PEER_HIGH, .robust = robust};
        if (b->land->samples.nx > 8193 || !run_memory_has(peer_embree_needs(b->land->field, geometry), "Embree", name))
            return true;
        b->peers[robust] = peer_embree_create(b->land->field, &options, error);
        if (b->peers[robust] == NULL) return false;
        for (size_t w = 1; w < PEER_WIDTH_COUNT; w++) { /* one ray at a time is never the fastest */
            runner *r = &b->runners[b->count++];
            r->what = geometry == PEER_TRIANGLES ? robust ? "embree-robust" : "embree"
                      : robust                   ? "embree-grid-robust"
                                                 : "embree-grid";
            contender_from_peer(&r->contender, b->peers[robust], peer_embree_widths[w], true, r->what);
        }
    }
    return true;
}

bool tradeoff_resolution_run(const char *name, const tradeoff_options *o, double seconds, json_t *lines,
                             io_error *error) {
    tradeoff_land land;
    bool skipped, good = tradeoff_land_open(name, &land, &skipped, error);
    if (!good || skipped) return good;
    fprintf(stderr, "land %s: rays\n", name);
    bout b = {.land = &land, .runners = memory(CONTENDERS_MAX, sizeof *b.runners)};
    good = add_field(&b, land.field, 1, error);
    for (int k = 0; good && k < LEVELS; k++)
        good = compare_coarser(name, land.field, factors[k], CW_FILTER_MEAN, o, lines, error);
    for (int k = 0; good && k < LEVELS; k++) good = add_coarser(&b, k, error);
    good = good && add_embree(&b, o, error);
    if (good) fight(&b, o, seconds, lines);
    for (int k = 0; k < LEVELS; k++) cw_field_destroy(b.levels[k]);
    for (int k = 0; k < 2; k++) peer_embree_destroy(b.peers[k]);
    /* The other filters serve promises, not speed. */
    for (int k = 0; good && k < LEVELS && land.samples.nx <= 4097; k++)
        for (int f = CW_FILTER_HIGHEST; good && f <= CW_FILTER_LOWEST; f++)
            good = compare_coarser(name, land.field, factors[k], (cw_filter)f, o, lines, error);
    free(b.runners);
    tradeoff_land_close(&land);
    return good;
}
