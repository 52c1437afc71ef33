/* SPDX-License-Identifier: Apache-2.0 */
/* Results as text. */

#include "harness/results.h"
#include "measure/measure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What was found beside times, in few words. */
static void print_findings(const json_t *line) {
    const json_t *a = json_object_get(line, "agreement");
    if (a) {
        const double differ =
            results_number(a, "only_reference") + results_number(a, "only_this") + results_number(a, "far");
        const json_t *why = json_object_get(a, "why");
        const double rays = results_number(a, "rays"), other = results_number(why, "other"),
                     unjudged = results_number(why, "unjudged");
        if (differ > 0)
            printf(", %.0f of %.0f rays differ by rounding", differ - other - unjudged, rays);
        else
            printf(results_number(a, "same_bits") == rays ? ", same bits" : ", all agree");
        if (unjudged > 0) printf(", %.0f are unjudged", unjudged);
        if (other > 0) printf(", %.0f are WRONG", other);
    }
    static const char *const found[][2] = {
        {"leaks_per_million", "leaks a million"}, {"phantoms_per_million", "phantoms a million"},
        {"wrong_per_million", "wrong a million"}, {"t_99", "of t (99 %)"},
        {"degrees_rms", "degrees (RMS)"},         {"share_rms", "of the sky (RMS)"},
        {"bytes_a_cell", "bytes a cell"}};
    for (size_t k = 0; k < sizeof found / sizeof *found; k++) {
        const json_t *value = json_object_get(line, found[k][0]);
        if (value && (k > 2 || json_number_value(value) > 0))
            printf(", %.3g %s", json_number_value(value), found[k][1]);
    }
}

void print_workload(const workload *w) {
    if (w->why[0]) {
        printf("\n%s is left out: %s\n", w->name, w->why);
        return;
    }
    printf("\n%s, %s, %.0f %s\n  %-28s %13s  %-26s\n", w->name, cw_isa_name((cw_isa)w->options->run.isa), w->items,
           w->kind->unit, "contender", "M a second", "time, first = 1 (95 %)");
    for (const entrant *e = w->entrants; e < w->entrants + w->count; e++) {
        printf("  %-28s", e->name);
        if (e->why[0]) {
            printf(" left out: %s\n", e->why);
            continue;
        }
        if (json_object_get(e->line, "per_second")) {
            char times[64];
            if (!e->job.best)
                snprintf(times, sizeof times, "%.3g", results_number(e->line, "time_to_first"));
            else if (e->job.converged)
                snprintf(times, sizeof times, "%.3g (%.3g to %.3g)", results_number(e->line, "time_to_first"),
                         results_number(e->line, "time_to_first_low"), results_number(e->line, "time_to_first_high"));
            else
                snprintf(times, sizeof times, "not converged");
            printf(" %13.4g  %-26s", results_number(e->line, "per_second") * 1e-6, times);
        }
        const char *by = results_text(e->line, "by");
        printf("%s%s", *by ? " by " : "", by);
        print_findings(e->line);
        printf("\n");
    }
    fflush(stdout);
}

/* The line of a scene and a contender. */
static const json_t *line_of(const json_t *lines, const char *of, const char *by) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "item"), of) == 0 && strcmp(results_text(line, "contender"), by) == 0)
            return line;
    }
    return NULL;
}

static void put_time(FILE *to, const json_t *line, const json_t *embree) {
    const double seconds = results_number(line, "seconds_median");
    if (line == NULL || json_object_get(line, "left_out") || seconds <= 0) {
        fputs(" – |", to);
        return;
    }
    fprintf(to, seconds >= 9.995 ? " %.1f" : seconds >= 0.9995 ? " %.2f" : " %.3f", seconds);
    const double share = results_number(line, "time_to_first") / results_number(embree, "time_to_first");
    if (!json_is_true(json_object_get(line, "converged")))
        fputs(" (not converged) |", to);
    else if (line == embree || !json_is_true(json_object_get(embree, "converged")))
        fputs(" |", to);
    else
        fprintf(to, " (%.2f) |", share);
}

void print_scenes(FILE *to, const json_t *lines) {
    const char *contenders[ENTRANTS_MAX];
    char machine[512];
    size_t count = 0;
    /* The run's line comes first, then those of the first scene. */
    for (const json_t *line; (line = json_array_get(lines, count + 1)) != NULL; count++) {
        if (strcmp(results_text(line, "item"), results_text(json_array_get(lines, 1), "item")) != 0) break;
        contenders[count] = results_text(line, "contender");
    }
    run_record_text(json_array_get(lines, 0), machine, sizeof machine);
    fprintf(to,
            "%s.\n\nSeconds to render, median CPU time of one thread, building excluded. In brackets: time relative to "
            "embree, its triangle mesh with the same normals; below 1 is faster than Embree. *default* is the "
            "library's kernel.\n\n| scene |",
            machine);
    for (size_t k = 0; k < count; k++) fprintf(to, " %s |", contenders[k]);
    fputs("\n|---|", to);
    for (size_t k = 0; k < count; k++) fputs("--:|", to);
    for (size_t s = 0; scene_names(s); s++) {
        if (line_of(lines, scene_names(s), contenders[0]) == NULL) continue;
        fprintf(to, "\n| %s |", scene_names(s));
        for (size_t k = 0; k < count; k++)
            put_time(to, line_of(lines, scene_names(s), contenders[k]), line_of(lines, scene_names(s), "embree"));
    }
    fputs("\n", to);
}
