/* SPDX-License-Identifier: Apache-2.0 */
/* The targets as Markdown and as CSV. */
#include "targets.h"

#include "results.h"
#include "run_record.h"

#include <string.h>

enum { NAMES_MAX = 32 };

static void put_measured(FILE *to, const target *t) {
    if (!(t->measured > 0)) {
        fputs(" not measured |", to);
        return;
    }
    fprintf(to, " %.2f", t->measured);
    if (*t->where) fprintf(to, " (%s)", t->where);
    fprintf(to, "%s |", target_is_met(t) ? "" : " **missed**");
}

void targets_put_table(FILE *to, const targets_data *d) {
    fputs("|", to);
    for (size_t k = 0; k < TARGETS_ISAS; k++)
        if (d->speed[k]) fprintf(to, " | %s, wanted | measured", targets_isa(k));
    fputs(" |\n|---|", to);
    for (size_t k = 0; k < TARGETS_ISAS; k++)
        if (d->speed[k]) fputs("--:|---|", to);
    fputc('\n', to);
    for (int kind = 0; kind < TARGET_COUNT; kind++) {
        fprintf(to, "| %s |", target_title((target_kind)kind));
        bool said = false;
        for (size_t k = 0; k < TARGETS_ISAS; k++) {
            if (d->speed[k] == NULL) continue;
            const target t = target_of(d, k, (target_kind)kind);
            if (target_is_general((target_kind)kind) && said) {
                fputs(" | |", to);
                continue;
            }
            said = true;
            fprintf(to, " %s %g |", t.at_most ? "≤" : "≥", t.wanted);
            put_measured(to, &t);
        }
        fputc('\n', to);
    }
}

/* "1.37 (20.9 / 15.3 w8)": the ratio, both speeds, and Embree's width. */
static void put_speed(FILE *to, const json_t *lines, const char *field, const char *rays) {
    const json_t *own = targets_own(lines, field, rays), *embree = targets_embree(lines, field, rays);
    if (own == NULL) {
        fputs(" |", to);
        return;
    }
    const double speed = results_number(own, "mrays_per_s");
    if (embree == NULL) {
        fprintf(to, " (%.3g / -) |", speed);
        return;
    }
    const double other = results_number(embree, "mrays_per_s");
    const char *width = strrchr(results_text(embree, "contender"), '/') + 1;
    fprintf(to, " %.2f (%.3g / %.3g %.*s) |", speed / other, speed, other, (int)strcspn(width, "-"), width);
}

static void put_speeds(FILE *to, const json_t *lines, const char *isa) {
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
    char machine[512];
    run_record_text(json_array_get(lines, 0), machine, sizeof machine);
    fprintf(to, "%s: speed over that of Embree's best width, in brackets both in millions of rays a second.\n%s.\n\n|",
            isa, machine);
    for (size_t f = 0; f < field_count; f++) fprintf(to, " | %s", fields[f]);
    fputs(" |\n|---|", to);
    for (size_t f = 0; f < field_count; f++) fputs("---|", to);
    fputc('\n', to);
    for (size_t r = 0; r < ray_count; r++) {
        fprintf(to, "| %s |", rays[r]);
        for (size_t f = 0; f < field_count; f++) put_speed(to, lines, fields[f], rays[r]);
        fputc('\n', to);
    }
}

/* A row a build: whose, bytes a cell with the samples, seconds. */
void targets_put_building(FILE *to, const targets_data *d) {
    const json_t *lines = d->building;
    if (lines == NULL) return;
    fputs("Memory with the samples, and CPU seconds of one thread to build.\n\n| field | | bytes a cell | s |\n"
          "|---|---|--:|--:|\n",
          to);
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        const bool kernel = results_is(line, "kernel_build", NULL);
        if (!kernel && !results_is(line, "peer_build", NULL)) continue;
        const char *field = results_text(line, "field"), *quality = results_text(line, "quality");
        const json_t *about = results_find(lines, "field", "field", field, NULL);
        if (about == NULL) continue;
        const double cells = (results_number(about, "nx") - 1) * (results_number(about, "ny") - 1);
        const double samples = kernel ? results_number(about, "bytes_samples") : 0; /* Embree holds a copy of its own */
        fprintf(to, "| %s | %s%s%s | %.1f | %.3g |\n", field, results_text(line, kernel ? "kernel" : "peer"),
                *quality ? ", quality " : "", quality, (samples + results_number(line, "bytes")) / cells,
                results_number(line, "build_seconds"));
    }
}

void targets_put_speeds(FILE *to, const targets_data *d) {
    for (size_t k = 0, put = 0; k < TARGETS_ISAS; k++) {
        if (d->speed[k] == NULL) continue;
        if (put++) fputc('\n', to);
        put_speeds(to, d->speed[k], targets_isa(k));
    }
}

void targets_markdown(FILE *to, const targets_data *d) {
    targets_put_table(to, d);
    fputc('\n', to);
    targets_put_speeds(to, d);
    if (d->building) fputc('\n', to);
    targets_put_building(to, d);
}

void targets_csv(FILE *to, const targets_data *d) {
    fputs("row,isa,field,rays,wanted,measured,met,where,own,own_mrays_per_s,embree,embree_mrays_per_s\n", to);
    for (size_t k = 0; k < TARGETS_ISAS; k++) {
        const json_t *lines = d->speed[k];
        if (lines == NULL) continue;
        for (int kind = 0; kind < TARGET_COUNT; kind++) {
            const target t = target_of(d, k, (target_kind)kind);
            fprintf(to, "\"%s\",%s,,,%g,", target_title((target_kind)kind), targets_isa(k), t.wanted);
            if (t.measured > 0)
                fprintf(to, "%.9g,%s,\"%s\",,,,\n", t.measured, target_is_met(&t) ? "yes" : "no", t.where);
            else
                fputs(",,,,,,\n", to);
        }
        const char *fields[NAMES_MAX], *rays[NAMES_MAX];
        const size_t field_count = results_distinct(lines, "field", fields, NAMES_MAX);
        const size_t ray_count = results_distinct(lines, "rays", rays, NAMES_MAX);
        for (size_t f = 0; f < field_count; f++)
            for (size_t r = 0; r < ray_count; r++) {
                const json_t *own = targets_own(lines, fields[f], rays[r]);
                const json_t *embree = targets_embree(lines, fields[f], rays[r]);
                if (own == NULL) continue;
                const double speed = results_number(own, "mrays_per_s");
                fprintf(to, "speed,%s,%s,%s,,", targets_isa(k), fields[f], rays[r]);
                if (embree)
                    fprintf(to, "%.9g,,,%s,%.9g,%s,%.9g\n", speed / results_number(embree, "mrays_per_s"),
                            results_text(own, "contender"), speed, results_text(embree, "contender"),
                            results_number(embree, "mrays_per_s"));
                else
                    fprintf(to, ",,,%s,%.9g,,\n", results_text(own, "contender"), speed);
            }
    }
}
