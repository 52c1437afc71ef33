/* SPDX-License-Identifier: Apache-2.0 */
/* The results of micro, as text and as JSON lines. */

#include "harness/results.h"
#include "micro/micro.h"

#include <stdio.h>

/* ---- a field ---- */

static void print_build(const micro_build *b, double cells) {
    printf("; %s built in %.3g s", b->name, b->seconds);
    if (b->threads > 1) printf(" on %u threads", b->threads);
    printf(", %.1f bytes a cell", (double)b->bytes / cells);
    if (b->update_seconds > 0) printf(", 64 x 64 samples updated in %.3g s", b->update_seconds);
}

void micro_print_field(const micro_field *on) {
    const cw_field_info info = cw_field_describe(on->field);
    const double cells = (double)(info.nx - 1) * (double)(info.ny - 1);
    printf("\nField %s: %zu x %zu samples, heights %g to %g", on->samples.name, info.nx, info.ny, (double)info.low,
           (double)info.high);
    for (size_t b = 0; b < on->build_count; b++) print_build(&on->builds[b], cells);
    for (size_t p = 0; p < on->peer_count; p++) print_build(&on->peers[p].build, cells);
    printf("\n");
}

static bool write_build(io_output *out, const micro_field *on, const char *kind, const char *key, const micro_build *b,
                        io_error *error) {
    json_t *line = json_object();
    results_set_texts(line, "kind field", (const char *[]){kind, on->samples.name});
    results_set_text(line, key, b->name);
    results_set_number(line, "build_seconds", b->seconds);
    results_set_counts(line, "builds bytes", (size_t[]){b->builds, b->bytes});
    if (b->quality) results_set_text(line, "quality", b->quality);
    if (b->threads) results_set_count(line, "threads", b->threads);
    if (b->update_seconds > 0) results_set_number(line, "update_seconds", b->update_seconds);
    return results_write(out, line, error);
}

bool micro_write_field(io_output *out, const micro_field *on, io_error *error) {
    const cw_field_info info = cw_field_describe(on->field);
    json_t *line = json_object();
    results_set_texts(line, "kind field", (const char *[]){"field", on->samples.name});
    results_set_counts(line, "nx ny", (size_t[]){info.nx, info.ny});
    results_set_numbers(line, "low high", (double[]){(double)info.low, (double)info.high});
    results_set_text(line, "default_kernel", on->default_kernel);
    results_set_count(line, "bytes_samples", info.nx * info.ny * sizeof *on->samples.z);
    bool good = results_write(out, line, error);
    for (size_t b = 0; good && b < on->build_count; b++)
        good = write_build(out, on, "kernel_build", "kernel", &on->builds[b], error);
    for (size_t p = 0; good && p < on->peer_count; p++)
        good = write_build(out, on, "peer_build", "peer", &on->peers[p].build, error);
    return good;
}

static double mrays(const micro_group *g, const micro_row *row) {
    return (double)g->ray_count / row->job.seconds.median * 1e-6;
}
static double ticks(const micro_group *g, const micro_row *row) { return row->job.ticks.median / (double)g->ray_count; }

static void print_times(const micro_group *g, const micro_row *row) {
    const statistics *s = &row->job.seconds;
    char ratio_text[16] = "-", agreement_text[AGREE_TEXT];
    if (row->to_embree > 0) snprintf(ratio_text, sizeof ratio_text, "%.2f", row->to_embree);
    agree_text(&row->agreement, agreement_text);
    printf(" %9.3f %6.1f%s %7.1f %9.1f %9s  %s\n", mrays(g, row), 50 * (s->high - s->low) / s->median,
           row->job.converged ? " "
           : s->sure          ? "!"
                              : "?",
           100 * s->mad / s->median, ticks(g, row), ratio_text, agreement_text);
}

static void set_times(json_t *line, const micro_group *g, const micro_row *row) {
    results_set_seconds(line, &row->job.seconds);
    results_set_bool(line, "converged", row->job.converged);
    results_set_numbers(line, "cpu_share mrays_per_s tsc_per_ray",
                        (double[]){row->job.cpu_share, mrays(g, row), ticks(g, row)});
    if (row->to_embree > 0) results_set_number(line, "speed_to_embree_best", row->to_embree);
}

/* ---- a group ---- */

void micro_print_group(const micro_group *g) {
    printf("\n%s, %s: %zu rays, %.1f %% hit, %s\n", g->on->samples.name, g->name, g->ray_count, 100 * g->hit_share,
           workload_class_is_any(g->c) ? "any hit" : "closest hit");
    printf("  %-30s %9s %7s %7s %9s %9s  %s\n", "contender", "Mrays/s", "CI +-%", "MAD %", "TSC/ray", "/Embree",
           "against the reference");
    for (const micro_row *row = g->rows; row < g->rows + g->row_count; row++) {
        printf("  %-30s", row->contender.name);
        if (row->predicted > 0)
            printf(" left out: a pass would take %.2g s\n", row->predicted);
        else
            print_times(g, row);
    }
    fflush(stdout);
}

bool micro_write_group(io_output *out, const micro_group *g, io_error *error) {
    bool good = true;
    for (const micro_row *row = g->rows; good && row < g->rows + g->row_count; row++) {
        json_t *line = json_object();
        results_set_texts(line, "kind field rays query contender",
                          (const char *[]){"result", g->on->samples.name, g->name,
                                           workload_class_is_any(g->c) ? "any" : "closest", row->contender.name});
        results_set_counts(line, "width threads ray_count",
                           (size_t[]){row->contender.width, row->contender.threads, g->ray_count});
        if (row->predicted > 0) {
            results_set_number(line, "left_out_seconds", row->predicted);
        } else {
            results_set_text(line, "reference", g->reference.name);
            json_object_set_new(line, "agreement", results_agreement(&row->agreement));
            set_times(line, g, row);
            results_set_number(line, "hit_share", g->hit_share);
        }
        good = results_write(out, line, error);
    }
    return good;
}
