/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/accuracy.h"

#include "harness/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* clang-format off: a row a mode */
static const accuracy_mode modes[] = {
    {"strict", "the default: watertight leaf test, IEEE operations alone", CW_LEAF_WATERTIGHT, .change = NULL},
    {"moller-trumbore", "strict operations, each triangle separately (Möller and Trumbore 1997)",
     CW_LEAF_MOLLER_TRUMBORE, .change = NULL},
    {"samples-16", "strict on samples rounded to 16 bits beforehand", CW_LEAF_WATERTIGHT, .change = accuracy_quantise},
    {"embree", "Embree, a mesh of triangles", .embree = true},
    {"embree-robust", "Embree, a mesh of triangles, ROBUST", .embree = true, .robust = true},
    {"embree-grid", "Embree, its grid geometry", .embree = true, .geometry = PEER_GRID, .longer = true},
    {"embree-grid-robust", "Embree, its grid geometry, ROBUST", .embree = true, .geometry = PEER_GRID, .robust = true,
     .longer = true},
};
/* clang-format on */
enum { MODE_COUNT = sizeof modes / sizeof modes[0] };

const accuracy_mode *accuracy_mode_at(size_t number) { return number < MODE_COUNT ? &modes[number] : NULL; }

accuracy_claim accuracy_quantise(float *z, size_t count) {
    float lowest = INFINITY, highest = -INFINITY; /* in double, GCC 12 for aarch64 breaks down */
    for (size_t k = 0; k < count; k++) {
        if (!isfinite(z[k])) continue;
        lowest = fminf(lowest, z[k]);
        highest = fmaxf(highest, z[k]);
    }
    const double low = (double)lowest, high = (double)highest;
    const double step = (high - low) / UINT16_MAX;
    if (!(step > 0)) return (accuracy_claim){0};
    for (size_t k = 0; k < count; k++)
        if (isfinite(z[k])) z[k] = (float)(low + step * rint(((double)z[k] - low) / step));
    return (accuracy_claim){.height = step / 2 + 0x1p-24 * fmax(fabs(low), fabs(high))};
}

static bool own_field(accuracy_stage *s, cw_field *base, const true_surface *surface, io_error *error) {
    const accuracy_mode *mode = s->mode;
    s->field = base;
    if (mode->change == NULL) return true;
    const size_t count = surface->nx * surface->ny;
    s->z = memory(count, sizeof *s->z);
    memcpy(s->z, surface->z, count * sizeof *s->z);
    const accuracy_claim more = mode->change(s->z, count);
    s->claim.height += more.height;
    const workload_field changed = {.nx = surface->nx, .ny = surface->ny, .z = s->z};
    const cw_status status = workload_field_open(&changed, CW_COPY, false, &s->own);
    if (status != CW_OK) return io_fail(error, "the field of mode %s: %s", mode->name, cw_last_error());
    s->field = s->own;
    return true;
}

bool accuracy_stage_open(accuracy_stage *stage, const accuracy_mode *mode, cw_field *base, const true_surface *surface,
                         cw_isa isa, io_error *error) {
    *stage = (accuracy_stage){.mode = mode};
    bool good = own_field(stage, base, surface, error);
    if (good && mode->embree) {
        const peer_options options = {
            .isa = isa, .geometry = mode->geometry, .quality = PEER_HIGH, .robust = mode->robust};
        stage->peer = peer_embree_create(base, &options, error);
        good = stage->peer != NULL;
    }
    if (!good) accuracy_stage_close(stage);
    return good;
}

void accuracy_stage_close(accuracy_stage *stage) {
    peer_embree_destroy(stage->peer);
    cw_field_destroy(stage->own);
    free(stage->z);
    *stage = (accuracy_stage){0};
}

cw_status accuracy_stage_kernel(const accuracy_stage *stage, const cw_kernel *kernel, contender *c) {
    const accuracy_mode *mode = stage->mode;
    const char *name = cw_kernel_describe(kernel).name;
    if (mode->embree) return CW_ERROR_KERNEL;
    const cw_status status = contender_from_kernel(c, stage->field, kernel, mode->leaf);
    if (status != CW_OK) return status;
    snprintf(c->name, sizeof c->name, "%s/%s", mode->name, name);
    return cw_closest(stage->field, &c->query, NULL, 0, NULL);
}
