/* SPDX-License-Identifier: Apache-2.0 */
/* What micro found, for people and as JSON lines. */

#include "micro.h"

#include <stdio.h>
#include <string.h>

void micro_print_field(const micro_field *on) {
    const cw_field_info info = cw_field_describe(on->field);
    const double cells = (double)(info.nx - 1) * (double)(info.ny - 1);
    printf("\nField %s: %zu x %zu samples, heights %g to %g", on->samples.name, info.nx, info.ny, (double)info.low,
           (double)info.high);
    for (size_t p = 0; p < on->peer_count; p++) {
        const peer_info peer = peer_embree_describe(on->peers[p].embree);
        printf("; %s built in %.3g s, %.1f bytes a cell", on->peers[p].name, peer.build_seconds,
               (double)peer.bytes / cells);
    }
    printf("\n");
}

static double mrays(const micro_group *g, double seconds) { return (double)g->ray_count / seconds * 1e-6; }

void micro_print_group(const micro_group *g) {
    printf("\n%s, %s: %zu rays, %.1f %% hit, %s\n", g->on->samples.name, workload_class_name(g->c), g->ray_count,
           100 * g->hit_share, workload_class_is_any(g->c) ? "any hit" : "closest hit");
    printf("  %-30s %9s %7s %7s %9s %9s  %s\n", "contender", "Mrays/s", "CI +-%", "MAD %", "TSC/ray", "/Embree",
           "against the reference");
    for (size_t r = 0; r < g->row_count; r++) {
        const micro_row *row = &g->rows[r];
        if (row->predicted > 0) {
            printf("  %-30s left out: a pass would take %.2g s\n", row->contender.name, row->predicted);
            continue;
        }
        const statistics *s = &row->seconds;
        char ratio_text[16] = "-", agreement_text[160];
        if (row->to_embree > 0) snprintf(ratio_text, sizeof ratio_text, "%.2f", row->to_embree);
        agree_text(&row->agreement, agreement_text, sizeof agreement_text);
        printf("  %-30s %9.3f %6.1f%s %7.1f %9.1f %9s  %s\n", row->contender.name, mrays(g, s->median),
               50 * (s->high - s->low) / s->median,
               row->converged ? " "
               : s->sure      ? "!"
                              : "?",
               100 * s->mad / s->median, row->ticks.median / (double)g->ray_count, ratio_text, agreement_text);
    }
    fflush(stdout);
}

/* ---- JSON ---- */

bool micro_write_line(io_output *out, json_t *line, io_error *error) {
    if (line == NULL) return io_fail(error, "out of memory for a result");
    bool good = true;
    if (out->file) {
        char *text = json_dumps(line, JSON_COMPACT | JSON_PRESERVE_ORDER);
        good = text ? io_output_write(out, text, strlen(text), error) && io_output_write(out, "\n", 1, error)
                    : io_fail(error, "out of memory for a result");
        free(text);
    }
    json_decref(line);
    return good;
}

bool micro_write_field(io_output *out, const micro_field *on, io_error *error) {
    const cw_field_info info = cw_field_describe(on->field);
    if (!micro_write_line(out,
                          json_pack("{s:s, s:s, s:I, s:I, s:f, s:f, s:I, s:f}", "kind", "field", "field",
                                    on->samples.name, "nx", (json_int_t)info.nx, "ny", (json_int_t)info.ny, "low",
                                    (double)info.low, "high", (double)info.high, "bytes_built",
                                    (json_int_t)info.bytes_built, "build_seconds", info.build_seconds),
                          error))
        return false;
    for (size_t p = 0; p < on->peer_count; p++) {
        const peer_info peer = peer_embree_describe(on->peers[p].embree);
        if (!micro_write_line(out,
                              json_pack("{s:s, s:s, s:s, s:f, s:I}", "kind", "peer_build", "field", on->samples.name,
                                        "peer", on->peers[p].name, "build_seconds", peer.build_seconds, "bytes",
                                        (json_int_t)peer.bytes),
                              error))
            return false;
    }
    return true;
}

static json_t *agreement_json(const agreement *a) {
    json_t *why = json_object();
    for (int r = 0; r < AGREE_REASON_COUNT; r++)
        json_object_set_new(why, agree_reason_name((agree_reason)r), json_integer((json_int_t)a->why[r]));
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:o}", "hits_reference", (json_int_t)a->hits_a, "hits",
                     (json_int_t)a->hits_b, "only_reference", (json_int_t)a->only_a, "only_this", (json_int_t)a->only_b,
                     "far", (json_int_t)a->far, "other_triangle", (json_int_t)a->other_triangle, "worst_roundings",
                     a->worst, "why", why);
}

bool micro_write_group(io_output *out, const micro_group *g, io_error *error) {
    for (size_t r = 0; r < g->row_count; r++) {
        const micro_row *row = &g->rows[r];
        json_t *line =
            json_pack("{s:s, s:s, s:s, s:s, s:s, s:i, s:I}", "kind", "result", "field", g->on->samples.name, "rays",
                      workload_class_name(g->c), "query", workload_class_is_any(g->c) ? "any" : "closest", "contender",
                      row->contender.name, "width", (int)row->contender.width, "ray_count", (json_int_t)g->ray_count);
        if (row->predicted > 0) {
            json_object_set_new(line, "left_out_seconds", json_real(row->predicted));
        } else {
            const statistics *s = &row->seconds;
            json_t *figures = json_pack("{s:I, s:f, s:f, s:f, s:f, s:f, s:b, s:b, s:f, s:f, s:s, s:o}", "samples",
                                        (json_int_t)s->n, "seconds_min", s->min, "seconds_median", s->median,
                                        "seconds_mad", s->mad, "seconds_low", s->low, "seconds_high", s->high,
                                        "interval_sure", (int)s->sure, "converged", (int)row->converged, "mrays_per_s",
                                        mrays(g, s->median), "tsc_per_ray", row->ticks.median / (double)g->ray_count,
                                        "reference", g->reference, "agreement", agreement_json(&row->agreement));
            json_object_update(line, figures);
            json_decref(figures);
            if (row->to_embree > 0) json_object_set_new(line, "speed_to_embree_best", json_real(row->to_embree));
        }
        if (!micro_write_line(out, line, error)) return false;
    }
    return true;
}
