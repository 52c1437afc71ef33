/* SPDX-License-Identifier: Apache-2.0 */
/* FIELD/build: structures made from a field's samples, and their memory. Filling Embree's arrays is not timed. */

#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"

#include <string.h>

typedef struct builder {
    land *land;
    const peer_kind *peer; /* NULL: a field */
    unsigned options;
    cw_isa isa;
    cw_pool *pool;
    size_t bytes;
    double seconds;
    bool failed;
} builder;

static bool open_build(workload *w, io_error *error) {
    w->own = land_of(w->field, w->options, w->why, error);
    if (w->own == NULL) return w->why[0] != '\0';
    w->items = (double)(((land *)w->own)->samples.nx - 1) * (double)(((land *)w->own)->samples.ny - 1);
    return true;
}

static void build(void *context) {
    builder *b = context;
    if (b->peer) {
        void *peer = b->peer->create(b->land->field, b->isa, b->options, NULL);
        b->failed = b->failed || peer == NULL;
        if (peer) b->bytes = b->peer->bytes(peer, &b->seconds);
        if (peer) b->peer->destroy(peer);
        return;
    }
    const workload_field *s = &b->land->samples;
    const cw_field_desc desc = {.samples = s->z, .nx = s->nx, .ny = s->ny, .storage = CW_BORROW};
    cw_field *field = NULL;
    b->failed = cw_field_create(&desc, &(cw_run){.pool = b->pool}, &field) != CW_OK || b->failed;
    if (field) b->bytes = cw_field_describe(field).bytes_built + s->nx * s->ny * sizeof *s->z;
    cw_field_destroy(field);
}

static bool knows(const char *name, io_error *error) {
    contender_spec s;
    return contenders_parse(&s, name, error) &&
           ((s.kind < PEER_KINDS ? s.width == 0 : strcmp(s.base, "default") == 0 && s.call == 0 && s.leaf == 0) ||
            io_fail(error, "contender %s: what builds is default, default:threads=N, embree, embree:grid, bullet",
                    name));
}

static bool enter(workload *w, const char *name, io_error *error) {
    contender_spec s;
    entrant *e = measure_enter(w, name, name, error);
    if (e == NULL || !contenders_parse(&s, name, error)) return false;
    builder *b = e->own = memory(1, sizeof *b);
    *b = (builder){.land = w->own, .peer = s.kind < PEER_KINDS ? peer_kinds[s.kind] : NULL};
    b->isa = (cw_isa)w->options->run.isa;
    b->options = s.options | PEER_MEDIUM;
    if (s.threads > 1 && cw_pool_create(s.threads, &b->pool) != CW_OK)
        return io_fail(error, "%s: %s", name, cw_last_error());
    if (b->peer) land_has_peer(b->land, b->peer, b->options, e->why);
    /* Embree tells its own time. */
    const bool tells = b->peer && (b->peer->options & PEER_MEDIUM);
    e->job =
        (interleave_job){.run = build, .context = b, .by_clock = s.threads > 1, .counts = tells ? &b->seconds : NULL};
    return true;
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    builder *b = e->own;
    (void)metrics;
    build(b);
    results_set_counts(e->line, "bytes", &b->bytes);
    results_set_numbers(e->line, "bytes_a_cell", &(double){(double)b->bytes / w->items});
    return !b->failed || io_fail(error, "%s of %s could not be built", e->name, w->name);
}

static void leave(entrant *e) {
    builder *b = e->own;
    cw_pool_destroy(b->pool);
    free(b);
}

const workload_kind measure_build = {.form = "FIELD/build",
                                     .what = "the structures of a field; bytes hold the samples too",
                                     .unit = "cells",
                                     .item = "build",
                                     .knows = knows,
                                     .open = open_build,
                                     .enter = enter,
                                     .judge = judge,
                                     .leave = leave};
