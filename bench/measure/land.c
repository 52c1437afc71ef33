/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/measure.h"

#include "build_info.h"
#include "cellwalk_terrain.h"
#include "harness/harness_memory.h"
#include "inputs.h"
#include "large.h"
#include "number.h"
#include "raster.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static land *present;

static void warn(void *context, const char *text) {
    (void)context;
    fprintf(stderr, "warning: %s\n", text);
}

/* A raster's heights in cells. A degree counts 111 320 m along both axes: these rays are for timing. */
static bool read_raster(land *l, const char *path, double cell_size, io_error *error) {
    const io_raster_options options = {.cellsize = cell_size, .north_up = true, .warn = {warn, NULL}};
    io_raster raster;
    if (!io_raster_read(path, &options, &raster, error)) return false;
    const io_georef *g = &raster.georef;
    const double unit = g->geographic ? 111320 : g->unit > 0 ? g->unit : 1;
    const double cell = hypot(raster.map[0][0], raster.map[1][0]) * unit;
    const double height = g->height_unit > 0 ? g->height_unit : 1;
    l->samples = (workload_field){.name = l->name, .nx = raster.nx, .ny = raster.ny};
    l->samples.z = large_allocate(raster.nx * raster.ny * sizeof *l->samples.z);
    if (l->samples.z == NULL) memory_end();
    for (size_t k = 0; k < raster.nx * raster.ny; k++) l->samples.z[k] = (float)((double)raster.z[k] * height / cell);
    io_raster_free(&raster);
    return true;
}

/* Fractal land of any size, a field of the workloads, or a file. */
static bool make_samples(land *l, const measure_options *o, char why[192], io_error *error) {
    char *end;
    const double side = number_read(l->name, &end);
    /* The land itself, its bounds, and a third of both for coarser ones. */
    if (*end == '\0' && !run_memory_has(8.5 * side * side, why)) return true;
    if (workload_field_make(l->name, &l->samples)) return true;
    if (l->samples.name) return io_fail(error, "out of memory for field %s", l->name);
    if (strcmp(l->name, "jacksboro") != 0) return read_raster(l, l->name, o->cell_size, error);
    /* Real land. Its cells are 3 seconds of arc: 93 m along y, 74 m along x; 83 is the mean. */
    if (!read_raster(l, BUILD_INFO_JACKSBORO, 83, error)) snprintf(why, 192, "the build found no python3-matplotlib");
    return true;
}

land *land_of(const char *name, const measure_options *o, char why[192], io_error *error) {
    if (present != NULL && strcmp(present->name, name) == 0) return present;
    land_end();
    land *l = memory(1, sizeof *l);
    snprintf(l->name, sizeof l->name, "%s", name);
    fprintf(stderr, "field %s\n", name);
    bool good = make_samples(l, o, why, error);
    if (good && why[0] == '\0' && workload_field_open(&l->samples, &l->field) != CW_OK)
        good = io_fail(error, "field %s: %s", name, cw_last_error());
    if (good && why[0] == '\0') return present = l;
    land_close(l);
    free(l);
    return NULL;
}

bool land_check(const char *name, const measure_options *o, io_error *error) {
    const io_raster_options options = {.cellsize = o->cell_size, .north_up = true, .no_samples = true};
    io_raster raster;
    if (strcmp(name, "jacksboro") == 0) return io_inputs_note_path(BUILD_INFO_JACKSBORO);
    if (workload_field_exists(name)) return true;
    if (!io_raster_read(name, &options, &raster, error)) return false;
    io_raster_free(&raster);
    return true;
}

static void forget_peers(land *l) {
    for (size_t k = 0; k < PEER_KINDS; k++)
        for (size_t o = 0; o < PEER_OPTIONS; o++) {
            if (l->peers[k][o]) peer_kinds[k]->destroy(l->peers[k][o]);
            l->peers[k][o] = NULL;
        }
}

void land_close(land *l) {
    errors_forget(l);
    forget_peers(l);
    for (size_t k = 0; k <= FACTOR_MAX; k++) cw_field_destroy(l->coarser[k]);
    if (l->borrowed) return;
    cw_field_destroy(l->field);
    workload_field_free(&l->samples);
}

void land_end(void) {
    if (present == NULL) return;
    land_close(present);
    free(present);
    present = NULL;
}

cw_field *land_coarser(land *l, size_t factor, io_error *error) {
    if (factor == 1) return l->field;
    if (l->coarser[factor] == NULL &&
        cw_field_coarser(l->field, NULL, factor, CW_FILTER_MEAN, &l->coarser[factor], NULL, 0) != CW_OK)
        io_fail(error, "field %s, every %zu. sample: %s", l->name, factor, cw_last_error());
    return l->coarser[factor];
}

bool land_has_peer(const land *l, const peer_kind *kind, unsigned options, char why[192]) {
    const cw_field_info info = cw_field_describe(l->field);
    if (kind->version)
        return run_memory_has((double)(info.nx - 1) * (double)(info.ny - 1) * kind->needs[(options & PEER_GRID) != 0],
                              why);
    snprintf(why, 192, "built without it (Debian: %s)", kind->package);
    return false;
}

const void *land_peer(land *l, size_t kind, cw_isa isa, unsigned options, char why[192], io_error *error) {
    void **peer = &l->peers[kind][options];
    if (isa != l->peers_isa) forget_peers(l);
    l->peers_isa = isa;
    io_fail(error, "field %s: %s could not be built on it", l->name, peer_kinds[kind]->name);
    if (*peer == NULL && land_has_peer(l, peer_kinds[kind], options, why))
        *peer = peer_kinds[kind]->create(l->field, isa, options, error);
    return *peer;
}
