/* SPDX-License-Identifier: Apache-2.0 */
/* One class of rays on one field: who takes part, do they agree, how fast are they. */

#include "clock.h"
#include "harness/memory.h"
#include "micro/micro.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The contender, if it can run here, becomes the next row. */
static bool add_row(micro_group *g, const contender *c, cw_status status, io_error *error) {
    if (status == CW_ERROR_KERNEL) return true;
    if (status != CW_OK) return io_fail(error, "%s on field %s: %s", c->name, g->on->samples.name, cw_last_error());
    if (g->row_count == MICRO_CONTENDERS_MAX) return io_fail(error, "more than %d contenders", MICRO_CONTENDERS_MAX);
    g->rows[g->row_count++].contender = *c;
    return true;
}

static bool add_kernel(micro_group *g, const micro_options *o, const cw_kernel *kernel, cw_leaf leaf, io_error *error) {
    for (size_t t = 0; t < o->threads.count; t++) {
        contender c;
        const cw_status status = contender_from_kernel(&c, g->on->field, kernel, leaf);
        c.threads = (unsigned)o->threads.number[t];
        c.query.pool = o->pools[t];
        const size_t used = strlen(c.name);
        if (o->pools[t]) snprintf(c.name + used, sizeof c.name - used, "/t%u", c.threads);
        c.call = o->call;
        if (o->call > 0) snprintf(c.name + strlen(c.name), sizeof c.name - strlen(c.name), "/c%u", o->call);
        if (!add_row(g, &c, status, error)) return false;
    }
    return true;
}

static bool add_kernels(micro_group *g, const micro_options *o, io_error *error) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        if (!option_wanted(&o->kernels, k)) continue;
        if (o->leaves.count == 0 && !add_kernel(g, o, kernel, CW_LEAF_DEFAULT, error)) return false;
        for (size_t leaf = 1; o->leaves.count > 0 && leaf < CW_LEAF_COUNT; leaf++) {
            const bool wanted = option_wanted(&o->leaves, leaf - 1) || option_wanted(&o->leaves, CW_LEAF_COUNT - 1);
            if (wanted && !add_kernel(g, o, kernel, (cw_leaf)leaf, error)) return false;
        }
    }
    return true;
}

static bool add_peers(micro_group *g, io_error *error) {
    for (const micro_peer *peer = g->on->peers; peer < g->on->peers + g->on->peer_count; peer++)
        for (size_t w = 0; w < PEER_WIDTH_COUNT; w++) {
            contender c;
            contender_from_peer(&c, peer->embree, peer_embree_widths[w], workload_class_is_coherent(g->c),
                                peer->build.name);
            if (!add_row(g, &c, CW_OK, error)) return false;
        }
    return true;
}

/* ---- a pass over all rays ---- */

static contender_pass pass_of(const micro_group *g, const contender *of, contender_answers out) {
    return (contender_pass){of, g->rays, g->ray_count, workload_class_is_any(g->c), out};
}

/* Seconds that the pass takes for rays [begin, begin + n). */
static double time_part(const contender_pass *whole, size_t begin, size_t n) {
    contender_pass part = *whole;
    part.rays += begin;
    part.n = n;
    const double start = clock_seconds();
    contender_run(&part);
    return clock_seconds() - start;
}

/* Seconds that a pass over all rays would take: from 16 rays, and if that is not hopeless from an eighth of the rays, in
 * pieces from all over the array, because neighbouring rays cost alike. */
static double predict(const contender_pass *whole, double limit) {
    enum { PIECES = 32, FEW = 16 };
    if (whole->n < (size_t)PIECES * FEW) return 0;
    const double few = time_part(whole, whole->n / 2, FEW) * (double)whole->n / FEW;
    if (few > 20 * limit) return few;
    const size_t distance = whole->n / PIECES, piece = distance / 8;
    double seconds = 0;
    for (size_t k = 0; k < PIECES; k++) seconds += time_part(whole, k * distance, piece);
    return seconds * (double)whole->n / (double)(PIECES * piece);
}

/* Compares all answers with the reference's. Contenders that are too slow are skipped. False if that
 * is everybody. */
static bool verify(micro_group *g, const micro_options *o, contender_answers expected, contender_answers out) {
    const bool any = workload_class_is_any(g->c);
    contender_pass p = pass_of(g, &g->reference, expected);
    contender_run(&p);
    size_t hits = 0, running = 0;
    for (size_t k = 0; k < g->ray_count; k++) hits += any ? expected.occluded[k] : expected.hits[k].i >= 0;
    g->hit_share = (double)hits / (double)g->ray_count;
    for (micro_row *row = g->rows; row < g->rows + g->row_count; row++) {
        p = pass_of(g, &row->contender, out);
        const double predicted = predict(&p, o->pass);
        if (predicted > o->pass) {
            row->predicted = predicted;
            continue;
        }
        running++;
        contender_run(&p);
        if (any)
            agree_any(&row->agreement, g->on->field, g->rays, g->ray_count, expected.occluded, out.occluded,
                      &g->reference, &row->contender);
        else
            agree_closest(&row->agreement, g->on->field, g->rays, g->ray_count, expected.hits, out.hits);
    }
    return running > 0;
}

static void time_all(micro_group *g, const micro_options *o, double seconds, contender_answers out) {
    interleave_job *jobs[MICRO_CONTENDERS_MAX];
    size_t count = 0;
    for (micro_row *row = g->rows; row < g->rows + g->row_count; row++) {
        row->pass = pass_of(g, &row->contender, out);
        row->job = (interleave_job){.run = contender_run, .context = &row->pass, .by_clock = o->by_clock};
        if (row->predicted == 0) jobs[count++] = &row->job;
    }
    const interleave_limits limits = {
        .width = o->width, .seconds = seconds, .least = 3, .most = INTERLEAVE_SAMPLES_MAX, .seed = o->run.seed};
    interleave(jobs, count, &limits);
    double best = INFINITY;
    for (const micro_row *row = g->rows; row < g->rows + g->row_count; row++)
        if (row->predicted == 0 && row->contender.embree) best = fmin(best, row->job.seconds.median);
    for (micro_row *row = g->rows; row < g->rows + g->row_count; row++)
        if (row->predicted == 0 && row->contender.threads == 1 && isfinite(best))
            row->to_embree = best / row->job.seconds.median;
}

static void start_farther_back(const micro_group *g) {
    const double side = (double)(g->on->samples.nx > g->on->samples.ny ? g->on->samples.nx : g->on->samples.ny) - 1;
    for (size_t k = 0; k < g->ray_count; k++)
        for (int c = 0; c < 3; c++)
            g->rays[k].org[c] = (float)((double)g->rays[k].org[c] - g->back * side * (double)g->rays[k].dir[c]);
}

bool micro_group_run(micro_group *g, const micro_options *o, double seconds, io_error *error) {
    const double end = clock_seconds() + seconds;
    const cw_status status =
        contender_from_kernel(&g->reference, g->on->field, cw_kernel_find("cell"), CW_LEAF_WATERTIGHT);
    if (status != CW_OK) return io_fail(error, "the reference kernel cell: %s", cw_last_error());
    if (!add_kernels(g, o, error) || !add_peers(g, error)) return false;
    g->rays = memory(o->count, sizeof *g->rays);
    g->ray_count = workload_rays_make(g->on->field, g->c, o->run.seed, o->count, g->rays);
    start_farther_back(g);
    if (g->ray_count == 0) return io_fail(error, "no rays on field %s", g->on->samples.name);
    const contender_answers expected = answers_make(o->count), out = answers_make(o->count);
    if (verify(g, o, expected, out)) time_all(g, o, fmax(0, end - clock_seconds()), out);
    answers_free(expected);
    answers_free(out);
    return true;
}
