/* SPDX-License-Identifier: Apache-2.0 */
/* FIELD/build: structures made from a field's samples, and the memory that they hold. Embree's vertex and index arrays are not
 * counted as time. */

#include "clock.h"
#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"

#include <stdio.h>
#include <string.h>

typedef struct builder {
    land *land;
    bool embree, bullet;
    peer_options options;
    cw_pool *pool;
    size_t bytes;
    double seconds;
    bool failed;
} builder;

static bool has(const char *field, const char *item) {
    return strcmp(field, "scenes") != 0 && strcmp(item, "build") == 0;
}

static bool open_build(workload *w, io_error *error) {
    w->own = land_of(w->field, w->options, w->why, error);
    if (w->own == NULL) return w->why[0] != '\0';
    w->items = (double)(((land *)w->own)->samples.nx - 1) * (double)(((land *)w->own)->samples.ny - 1);
    return true;
}

static void build(void *context) {
    builder *b = context;
    if (b->embree) {
        io_error error;
        peer_embree *peer = peer_embree_create(b->land->field, &b->options, &error);
        b->failed = b->failed || peer == NULL;
        if (peer) b->bytes = peer_embree_describe(peer).bytes;
        if (peer) b->seconds = peer_embree_describe(peer).build_cpu_seconds;
        peer_embree_destroy(peer);
        return;
    }
    if (b->bullet) {
        peer_bullet *peer = peer_bullet_create(b->land->field, false);
        b->failed = b->failed || peer == NULL;
        if (peer) b->bytes = peer_bullet_bytes(peer);
        peer_bullet_destroy(peer);
        return;
    }
    const workload_field *s = &b->land->samples;
    const cw_field_desc desc = {.samples = s->z, .nx = s->nx, .ny = s->ny, .storage = CW_BORROW};
    cw_field *field = NULL;
    b->failed = cw_field_create(&desc, &(cw_run){.pool = b->pool}, &field) != CW_OK || b->failed;
    if (field) b->bytes = cw_field_describe(field).bytes_built + s->nx * s->ny * sizeof *s->z;
    cw_field_destroy(field);
}

static bool enter(workload *w, const char *name, io_error *error) {
    entrant *e = measure_enter(w, name, name, error);
    if (e == NULL) return false;
    builder *b = e->own = memory(1, sizeof *b);
    const bool grid = strstr(name, ":grid") != NULL;
    unsigned threads = 1;
    *b = (builder){.land = w->own, .embree = strncmp(name, "embree", 6) == 0, .bullet = strcmp(name, "bullet") == 0};
    b->options = (peer_options){.isa = (cw_isa)w->options->run.isa,
                                .geometry = grid ? PEER_GRID : PEER_TRIANGLES,
                                .quality = strstr(name, ":high") ? PEER_HIGH : PEER_MEDIUM};
    if (!b->embree && !b->bullet && strcmp(name, "default") != 0 && sscanf(name, "default:threads=%u", &threads) != 1)
        return io_fail(
            error, "contender %s: what builds is default, default:threads=N, embree, embree:high, embree:grid, bullet",
            name);
    if (threads > 1 && cw_pool_create(threads, &b->pool) != CW_OK)
        return io_fail(error, "%s: %s", name, cw_last_error());
    if (b->embree && peer_embree_version() == NULL)
        snprintf(e->why, sizeof e->why, "built without Embree (Debian: libembree-dev)");
    else if (b->bullet)
        land_bullet(b->land, false, e->why);
    else if (b->embree)
        run_memory_has(peer_embree_needs(b->land->field, b->options.geometry), e->why);
    e->job =
        (interleave_job){.run = build, .context = b, .by_clock = threads > 1, .counts = b->embree ? &b->seconds : NULL};
    return true;
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    builder *b = e->own;
    (void)metrics;
    build(b);
    results_set_counts(e->line, "bytes", &b->bytes);
    results_set_number(e->line, "bytes_a_cell", (double)b->bytes / w->items);
    return !b->failed || io_fail(error, "%s of %s could not be built", e->name, w->name);
}

static void leave(entrant *e) {
    builder *b = e->own;
    cw_pool_destroy(b->pool);
    free(b);
}

static void close_build(workload *w) { (void)w; }

const workload_kind measure_build = {"FIELD/build", "the structures of a field; bytes hold the samples too",
                                     "cells",       has,
                                     open_build,    enter,
                                     judge,         leave,
                                     close_build};
