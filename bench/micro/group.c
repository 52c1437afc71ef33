/* SPDX-License-Identifier: Apache-2.0 */
/* One class of rays on one field: who takes part, do they agree, how fast are they. */

#include "clock.h"
#include "micro/micro.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static micro_row *new_row(micro_group *g) {
    if (g->row_count == MICRO_CONTENDERS_MAX) return NULL;
    micro_row *row = &g->rows[g->row_count];
    memset(row, 0, sizeof *row);
    return row;
}

static bool add_kernel(micro_group *g, const micro_options *o, const cw_kernel *kernel, cw_leaf leaf, io_error *error) {
    for (size_t t = 0; t < o->threads.count; t++) {
        micro_row *row = new_row(g);
        if (row == NULL) return io_fail(error, "more than %d contenders", MICRO_CONTENDERS_MAX);
        const cw_status status = contender_from_kernel(&row->contender, g->on->field, kernel, leaf);
        if (status == CW_ERROR_UNAVAILABLE || status == CW_ERROR_UNSUPPORTED) return true;
        if (status != CW_OK)
            return io_fail(error, "%s on field %s: %s", cw_kernel_describe(kernel).name, g->on->samples.name,
                           cw_status_message(status));
        row->contender.threads = o->thread_counts[t];
        row->contender.query.pool = o->pools[t];
        if (o->pools[t]) {
            const size_t used = strlen(row->contender.name);
            snprintf(row->contender.name + used, sizeof row->contender.name - used, "/t%u", o->thread_counts[t]);
        }
        g->row_count++;
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
    for (size_t p = 0; p < g->on->peer_count; p++)
        for (size_t w = 0; w < PEER_WIDTH_COUNT; w++) {
            const micro_peer *peer = &g->on->peers[p];
            micro_row *row = new_row(g);
            if (row == NULL) return io_fail(error, "more than %d contenders", MICRO_CONTENDERS_MAX);
            contender_from_peer(&row->contender, peer->embree, peer_embree_widths[w], workload_class_is_coherent(g->c),
                                peer->build.name);
            g->row_count++;
        }
    return true;
}

/* ---- a pass over all rays ---- */

typedef struct answers {
    cw_hit *hits;
    uint8_t *occluded;
} answers;

static contender_pass pass_of(const micro_group *g, const contender *of, answers out) {
    return (contender_pass){of, g->rays, g->ray_count, workload_class_is_any(g->c), out.hits, out.occluded};
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

/* Shadow, ambient occlusion: any. Other classes: closest. The reference is the plain cell walk with the watertight test. */
static bool verify(micro_group *g, const micro_options *o, const contender *reference, answers expected, answers out) {
    const bool any = workload_class_is_any(g->c);
    contender_pass p = pass_of(g, reference, expected);
    contender_run(&p);
    size_t hits = 0, running = 0;
    for (size_t k = 0; k < g->ray_count; k++) hits += any ? expected.occluded[k] : expected.hits[k].i >= 0;
    g->hit_share = g->ray_count ? (double)hits / (double)g->ray_count : 0;
    for (size_t r = 0; r < g->row_count; r++) {
        micro_row *row = &g->rows[r];
        p = pass_of(g, &row->contender, out);
        const double predicted = predict(&p, o->pass);
        if (predicted > o->pass) {
            row->predicted = predicted;
            continue;
        }
        running++;
        counters_reset();
        contender_run(&p);
        counters_add(row->counts);
        if (any)
            agree_any(&row->agreement, g->on->field, g->rays, g->ray_count, expected.occluded, out.occluded, reference,
                      &row->contender);
        else
            agree_closest(&row->agreement, g->on->field, g->rays, g->ray_count, expected.hits, out.hits);
    }
    return running > 0;
}

static bool time_all(micro_group *g, const micro_options *o, double seconds, answers out) {
    interleave_job *jobs[MICRO_CONTENDERS_MAX];
    size_t count = 0;
    for (size_t r = 0; r < g->row_count; r++) {
        micro_row *row = &g->rows[r];
        row->pass = pass_of(g, &row->contender, out);
        row->job = (interleave_job){.run = contender_run, .context = &row->pass, .by_clock = o->by_clock};
        if (row->predicted == 0) jobs[count++] = &row->job;
    }
    const interleave_limits limits = {
        .width = o->width, .seconds = seconds, .least = 3, .most = INTERLEAVE_SAMPLES_MAX, .seed = o->run.seed};
    if (!interleave(jobs, count, &limits)) return false;
    double best = 0;
    for (size_t r = 0; r < g->row_count; r++) {
        const double median = g->rows[r].job.seconds.median;
        if (g->rows[r].contender.embree && median > 0 && (best == 0 || median < best)) best = median;
    }
    for (size_t r = 0; r < g->row_count; r++) {
        micro_row *row = &g->rows[r];
        if (row->predicted == 0 && row->contender.threads == 1) row->to_embree = best / row->job.seconds.median;
    }
    return true;
}

bool micro_group_run(micro_group *g, const micro_options *o, double seconds, io_error *error) {
    const double end = clock_seconds() + seconds;
    g->row_count = 0;
    const size_t n = (size_t)o->count;
    contender reference;
    if (contender_from_kernel(&reference, g->on->field, cw_kernel_find("cell"), CW_LEAF_WATERTIGHT) != CW_OK)
        return io_fail(error, "the reference kernel cell does not run");
    memcpy(g->reference, reference.name, sizeof g->reference);
    if (!add_kernels(g, o, error) || !add_peers(g, error)) return false;

    g->rays = malloc(n * sizeof *g->rays);
    answers expected = {malloc(n * sizeof(cw_hit)), malloc(n)}, out = {malloc(n * sizeof(cw_hit)), malloc(n)};
    bool good = g->rays && expected.hits && expected.occluded && out.hits && out.occluded;
    if (good) g->ray_count = workload_rays_make(g->on->field, g->c, o->run.seed, n, g->rays);
    good = good && g->ray_count > 0;
    if (good && verify(g, o, &reference, expected, out) && !o->counters) {
        const double left = end - clock_seconds();
        good = time_all(g, o, left > 0 ? left : 0, out);
    }
    free(expected.hits);
    free(expected.occluded);
    free(out.hits);
    free(out.occluded);
    return good || io_fail(error, "out of memory for %zu rays", n);
}

void micro_group_free(micro_group *g) {
    free(g->rays);
    g->rays = NULL;
}
