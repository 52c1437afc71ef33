/* SPDX-License-Identifier: Apache-2.0 */
/* What building costs each side, in time and memory. */

#include "clock.h"
#include "micro/micro.h"

#include <string.h>

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
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples->z;
    desc.nx = samples->nx;
    desc.ny = samples->ny;
    desc.storage = CW_BORROW;
    desc.bare = true;
    size_t bytes = 0;
    builds b = {.start = clock_seconds()};
    while (go_on(&b)) {
        cw_field *field = NULL;
        cw_status status = cw_field_create(&desc, &field);
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
        bool wanted = o->kernels.count == 0;
        for (size_t n = 0; n < o->kernels.count; n++) wanted = wanted || strcmp(o->kernels.items[n], info.name) == 0;
        if (!wanted || !info.needs_build || !info.available || on->build_count == MICRO_KERNELS_MAX) continue;
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
