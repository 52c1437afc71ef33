/* SPDX-License-Identifier: Apache-2.0 */
/* Time and memory of building, on both sides. */

#include "clock.h"
#include "micro/micro.h"

enum { BUILDS_MAX = 5 };
static const double build_seconds_max = 0.5;

/* True if there is to be one more build, when so many have been made since start. */
static bool again(size_t made, double start) {
    return made == 0 || (made < BUILDS_MAX && clock_seconds() - start < build_seconds_max);
}

/* Samples that have not changed take as long as others. */
static bool update_kernel(micro_build *build, cw_field *field, cw_pool *pool) {
    enum { SIDE = 64, UPDATES = 31 };
    const cw_field_info info = cw_field_describe(field);
    double seconds[UPDATES];
    if (info.nx < SIDE || info.ny < SIDE) return true;
    for (size_t k = 0; k < UPDATES; k++) {
        const cw_update update = {
            .at = {k * 7919 % (info.nx - SIDE + 1), k * 104729 % (info.ny - SIDE + 1), SIDE, SIDE}};
        const double begin = clock_seconds();
        if (cw_field_update(field, &update, &(cw_run){.pool = pool}) != CW_OK) return false;
        seconds[k] = clock_seconds() - begin;
    }
    /* Structures that an update drops are built again. */
    if (cw_field_describe(field).bytes_built == info.bytes_built)
        build->update_seconds = statistics_of(seconds, UPDATES).median;
    return true;
}

static bool build_kernel(micro_build *build, const workload_field *samples, const cw_kernel *kernel, cw_pool *pool,
                         bool by_clock, io_error *error) {
    const double start = clock_seconds();
    const cw_run how = {.kernel = kernel, .pool = pool};
    double seconds[BUILDS_MAX];
    *build = (micro_build){.name = cw_kernel_describe(kernel).name, .threads = cw_pool_threads(pool)};
    for (; again(build->builds, start); build->builds++) {
        cw_field *field = NULL;
        cw_status status = workload_field_open(samples, CW_BORROW, true, &field);
        const double begin = by_clock ? clock_seconds() : clock_cpu_seconds();
        if (status == CW_OK) status = cw_field_build(field, &how);
        seconds[build->builds] = (by_clock ? clock_seconds() : clock_cpu_seconds()) - begin;
        if (status == CW_OK) build->bytes = cw_field_describe(field).bytes_built;
        if (status == CW_OK && build->builds == 0 && !update_kernel(build, field, pool)) status = CW_ERROR_BUSY;
        cw_field_destroy(field);
        if (status != CW_OK)
            return io_fail(error, "building for %s on field %s: %s", build->name, samples->name, cw_last_error());
    }
    build->seconds = statistics_of(seconds, build->builds).median;
    return true;
}

bool micro_build_kernels(micro_field *on, const micro_options *o, io_error *error) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (!option_wanted(&o->kernels, k) || !info.needs_build || !info.available) continue;
        for (size_t t = 0; t < o->threads.count && on->build_count < MICRO_BUILDS_MAX; t++) {
            micro_build *build = &on->builds[on->build_count++];
            if (!build_kernel(build, &on->samples, cw_kernel_at(k), o->pools[t], o->by_clock, error)) return false;
        }
    }
    return true;
}

bool micro_build_peer(micro_peer *peer, const cw_field *field, const peer_options *options, io_error *error) {
    const double start = clock_seconds();
    double seconds[BUILDS_MAX];
    for (; again(peer->build.builds, start); peer->build.builds++) {
        peer_embree_destroy(peer->embree);
        peer->embree = peer_embree_create(field, options, error);
        if (peer->embree == NULL) return false;
        seconds[peer->build.builds] = peer_embree_describe(peer->embree).build_cpu_seconds;
    }
    peer->build.seconds = statistics_of(seconds, peer->build.builds).median;
    peer->build.bytes = peer_embree_describe(peer->embree).bytes;
    peer->build.quality = options->quality == PEER_HIGH ? "high" : "medium";
    return true;
}
