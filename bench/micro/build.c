/* SPDX-License-Identifier: Apache-2.0 */
/* What building costs each side, in time and memory. */

#include "clock.h"
#include "micro/micro.h"

enum { BUILDS_MAX = 5 };
static const double build_seconds_max = 0.5;

typedef struct builds {
    double seconds[BUILDS_MAX], start;
    size_t count;
} builds;

/* True if there is to be one more. */
static bool go_on(const builds *b) {
    return b->count == 0 || (b->count < BUILDS_MAX && clock_seconds() - b->start < build_seconds_max);
}

static void finish(micro_build *build, builds *b, size_t bytes) {
    build->builds = b->count;
    build->bytes = bytes;
    build->seconds = statistics_of(b->seconds, b->count).median;
}

static bool build_kernel(micro_build *build, const workload_field *samples, const cw_kernel *kernel, io_error *error) {
    const char *name = cw_kernel_describe(kernel).name;
    size_t bytes = 0;
    builds b = {.start = clock_seconds()};
    while (go_on(&b)) {
        cw_field *field = NULL;
        cw_status status = workload_field_open(samples, CW_BORROW, true, &field);
        const double start = clock_cpu_seconds();
        if (status == CW_OK) status = cw_field_build(field, kernel);
        b.seconds[b.count] = clock_cpu_seconds() - start;
        if (status == CW_OK) {
            bytes = cw_field_describe(field).bytes_built;
            b.count++;
        }
        cw_field_destroy(field);
        if (status != CW_OK)
            return io_fail(error, "building for %s on field %s: %s", name, samples->name, cw_status_message(status));
    }
    *build = (micro_build){.name = name};
    finish(build, &b, bytes);
    return true;
}

bool micro_build_kernels(micro_field *on, const micro_options *o, io_error *error) {
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel *kernel = cw_kernel_at(k);
        const cw_kernel_info info = cw_kernel_describe(kernel);
        if (!option_wanted(&o->kernels, k) || !info.needs_build || !info.available ||
            on->build_count == MICRO_KERNELS_MAX)
            continue;
        if (!build_kernel(&on->builds[on->build_count], &on->samples, kernel, error)) return false;
        on->build_count++;
    }
    return true;
}

bool micro_build_peer(micro_peer *peer, const cw_field *field, const peer_options *options, io_error *error) {
    builds b = {.start = clock_seconds()};
    while (go_on(&b)) {
        peer_embree_destroy(peer->embree);
        peer->embree = peer_embree_create(field, options, error);
        if (peer->embree == NULL) return false;
        b.seconds[b.count++] = peer_embree_describe(peer->embree).build_cpu_seconds;
    }
    peer->build.quality = options->quality == PEER_HIGH ? "high" : "medium";
    finish(&peer->build, &b, peer_embree_describe(peer->embree).bytes);
    return true;
}
