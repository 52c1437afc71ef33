/* SPDX-License-Identifier: Apache-2.0 */
/* micro --counters: what the kernels do for a ray, for people and as JSON lines. */

#include "harness/results.h"
#include "micro/micro.h"

#include <stdio.h>

static bool counted(const micro_row *row) {
    for (size_t k = 0; k < counters_count(); k++)
        if (row->counts[k].events > 0) return true;
    return false;
}

/* Lanes of an event a ray. */
static double per_ray(const micro_group *g, const micro_row *row, const char *name) {
    return (double)counters_find(row->counts, name)->lanes / (double)g->ray_count;
}

/* Per cent of the vector's lanes that take part; below 0 where there was no such event. */
static double busy(const micro_row *row, const char *name) {
    const counter *c = counters_find(row->counts, name);
    return c->events ? 100 * (double)c->lanes / (double)(c->events * row->contender.width) : -1;
}

static void print_cell(double value, const char *format, int width) {
    char text[32] = "-";
    if (value > 0) snprintf(text, sizeof text, format, value);
    printf(" %*s", width, text);
}

void micro_print_counts(const micro_group *g) {
    printf("\n%s, %s: %zu rays, %.1f %% hit, %s\n", g->on->samples.name, workload_class_name(g->c), g->ray_count,
           100 * g->hit_share, workload_class_is_any(g->c) ? "any hit" : "closest hit");
    printf("  %-28s %8s %5s %8s %5s %8s %5s %7s %7s %7s %7s %7s %8s\n", "a ray:", "cells", "busy%", "nodes", "busy%",
           "tests", "busy%", "refills", "sh.node", "sh.cell", "apart", "voxels", "triangles");
    for (size_t r = 0; r < g->row_count; r++) {
        const micro_row *row = &g->rows[r];
        if (row->predicted == 0 && !counted(row)) continue; /* brute */
        if (row->predicted > 0) {
            printf("  %-28s left out: a pass would take %.2g s\n", row->contender.name, row->predicted);
            continue;
        }
        static const char *const walks[] = {"flat", "node", "leaf"};
        const double rays = (double)g->ray_count;
        printf("  %-28s", row->contender.name);
        for (size_t w = 0; w < 3; w++) {
            print_cell(per_ray(g, row, walks[w]), "%.3f", 8);
            print_cell(busy(row, walks[w]), "%.0f", 5);
        }
        print_cell(per_ray(g, row, "refill"), "%.3f", 7);
        print_cell((double)counters_find(row->counts, "shared_node")->events / rays, "%.3f", 7);
        print_cell((double)counters_find(row->counts, "shared_cell")->events / rays, "%.3f", 7);
        print_cell(per_ray(g, row, "apart"), "%.3f", 7);
        print_cell(per_ray(g, row, "voxel"), "%.3f", 7);
        print_cell(per_ray(g, row, "triangle") + 2 * per_ray(g, row, "leaf"), "%.3f", 8);
        printf("\n");
    }
    fflush(stdout);
}

bool micro_write_counts(io_output *out, const micro_group *g, io_error *error) {
    bool good = true;
    for (size_t r = 0; good && r < g->row_count; r++) {
        const micro_row *row = &g->rows[r];
        if (row->predicted > 0 || !counted(row)) continue;
        json_t *line = micro_row_line(g, row, "counts");
        results_set_number(line, "hit_share", g->hit_share);
        json_object_set_new(line, "counts", counters_json(row->counts));
        good = results_write(out, line, error);
    }
    return good;
}
