/* SPDX-License-Identifier: Apache-2.0 */
/* Tables of the papers that are about work: what the walks do for a ray, what their pieces take, where the time goes, and
 * what each lever saves. */

#include "papers.h"
#include "results.h"
#include "statistics.h"
#include "targets.h"

#include <math.h>
#include <string.h>

enum { NAMES_MAX = 96 };

/* ---- counts ---- */

/* Of the kernel, whatever its leaf test; NULL if it was not counted there. */
static const json_t *counts_of(const json_t *lines, const char *field, const char *rays, const char *kernel) {
    const json_t *line;
    size_t index;
    const size_t length = strlen(kernel);
    json_array_foreach(lines, index, line) {
        const char *name = results_text(line, "contender");
        if (results_is(line, "counts", "field", field, "rays", rays, NULL) && strncmp(name, kernel, length) == 0 &&
            name[length] == '/')
            return line;
    }
    return NULL;
}

static double member(const json_t *line, const char *kind, const char *key) {
    return results_number(json_object_get(json_object_get(line, "counts"), kind), key);
}

/* Lanes, or events that a group shares, a ray. */
static double lanes(const json_t *line, const char *kind) {
    return member(line, kind, "lanes") / results_number(line, "ray_count");
}
static double events(const json_t *line, const char *kind) {
    return member(line, kind, "events") / results_number(line, "ray_count");
}

static void put_busy(FILE *to, const json_t *line, const char *kind) {
    const double of = member(line, kind, "events") * results_number(line, "width");
    if (of > 0)
        fprintf(to, " %.2f (%.0f %%) |", lanes(line, kind), 100 * member(line, kind, "lanes") / of);
    else
        fputs(" |", to);
}

/* What one walk does for a ray. */
typedef struct walk_work {
    double places, triangles; /* voxels, cells or nodes come to; triangles tested */
} walk_work;

static walk_work work_of(const json_t *line) {
    return (walk_work){
        events(line, "voxel") + lanes(line, "flat") + lanes(line, "node") + lanes(line, "round") +
            events(line, "shared_node") + events(line, "shared_cell"),
        events(line, "triangle") + 2 * lanes(line, "leaf"),
    };
}

/* Ratios of one walk's work to another's, over all sets of rays. */
typedef struct ratios {
    double places[NAMES_MAX], triangles[NAMES_MAX];
    size_t n;
} ratios;

static void take_ratio(ratios *r, walk_work above, walk_work below) {
    if (r->n == NAMES_MAX || !(above.places > 0 && below.places > 0 && above.triangles > 0 && below.triangles > 0))
        return;
    r->places[r->n] = above.places / below.places;
    r->triangles[r->n++] = above.triangles / below.triangles;
}

static void put_ratios(FILE *to, const ratios *r, const char *above, const char *below) {
    if (r->n == 0) return;
    fprintf(to,
            "- %s comes to %.3g times as many places as %s and tests %.2g times as many triangles (geometric means).\n",
            above, statistics_geometric_mean(r->places, r->n), below, statistics_geometric_mean(r->triangles, r->n));
}

static double largest(const double *of, size_t n) {
    double most = 0;
    for (size_t k = 0; k < n; k++) most = fmax(most, of[k]);
    return most;
}

bool papers_walks(FILE *to, papers_data *d, io_error *error) {
    static const char *const kernels[] = {"grid3d", "cell", "pyramid1"};
    const json_t *lines = papers_lines(d, "counters.json", error);
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct_of(lines, "counts", "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct_of(lines, "counts", "rays", rays, NAMES_MAX);
    ratios to_grid = {.n = 0}, to_cell = {.n = 0}, both = {.n = 0};
    size_t fewer_places = 0, fewer_triangles = 0;
    fputs("A ray, on average. Places are voxels, cells, or nodes and cells.\n\n"
          "| field | rays | `grid3d`: places | triangles | `cell`: places | triangles | `pyramid1`: places | triangles "
          "|\n"
          "|---|---|--:|--:|--:|--:|--:|--:|\n",
          to);
    for (size_t f = 0; f < field_count; f++)
        for (size_t r = 0; r < ray_count; r++) {
            walk_work work[3] = {{0, 0}};
            fprintf(to, "| %s | %s |", fields[f], rays[r]);
            for (size_t k = 0; k < 3; k++) {
                const json_t *line = counts_of(lines, fields[f], rays[r], kernels[k]);
                if (line) work[k] = work_of(line);
                fprintf(to, line ? " %.1f | %.2f |" : " | |", work[k].places, work[k].triangles);
            }
            fputc('\n', to);
            take_ratio(&to_grid, work[1], work[0]);
            take_ratio(&both, (walk_work){work[1].places, 2 * work[1].places}, work[0]);
            fewer_places += work[1].places < work[0].places;
            fewer_triangles += work[1].triangles < work[0].triangles;
            take_ratio(&to_cell, work[2], work[1]);
        }
    fputc('\n', to);
    put_ratios(to, &to_grid, "The cell walk", "the 3D grid");
    if (both.n > 0)
        fprintf(to,
                "- It comes to fewer places than the grid in %zu of %zu rows and tests fewer triangles in %zu. If it "
                "tested "
                "both triangles wherever it comes, these would be %.2g times the grid's (geometric mean), at most %.3g "
                "times.\n",
                fewer_places, both.n, fewer_triangles, statistics_geometric_mean(both.triangles, both.n),
                largest(both.triangles, both.n));
    put_ratios(to, &to_cell, "The pyramid", "the cell walk");
    return true;
}

/* ---- pieces ---- */

/* Nanoseconds of a piece; 0 if it was not timed. */
static double piece(const json_t *lines, const char *part, const char *kernel) {
    const json_t *line = results_find(lines, "part", "part", part, "kernel", kernel, NULL);
    const double operations = line ? results_number(line, "operations") : 0;
    return operations > 0 ? 1e9 * results_number(line, "seconds_median") / operations : 0;
}

/* Of a turn of the lane walk, without the refills that were timed with it. */
static double turn_of(const json_t *lines, const char *kernel) {
    const json_t *line = results_find(lines, "part", "part", "node step", "kernel", kernel, NULL);
    if (line == NULL || !(results_number(line, "turns") > 0)) return 0;
    const double refills = results_number(line, "refills") * piece(lines, "refill", kernel);
    return (1e9 * results_number(line, "seconds_median") - refills) / results_number(line, "turns");
}

bool papers_pieces(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "parts.json", error), *line;
    if (lines == NULL) return false;
    const char *kernels[NAMES_MAX], *names[NAMES_MAX], *memories[NAMES_MAX + 1];
    const size_t kernel_count = results_distinct_of(lines, "part", "kernel", kernels, NAMES_MAX);
    const size_t name_count = results_distinct_of(lines, "part", "part", names, NAMES_MAX);
    const size_t memory_count = results_distinct_of(lines, "part", "memory", memories, NAMES_MAX);
    memories[memory_count] = "";
    fputs("Millions a second, medians; one for each lane.\n\n| piece | of |", to);
    for (size_t k = 0; k < kernel_count; k++) fprintf(to, " %s |", kernels[k]);
    fputs("\n|---|---|", to);
    for (size_t k = 0; k < kernel_count; k++) fputs("--:|", to);
    fputc('\n', to);
    for (size_t n = 0; n < name_count; n++)
        for (size_t m = 0; m <= memory_count; m++) {
            const json_t *of[NAMES_MAX], *any = NULL;
            for (size_t k = 0; k < kernel_count; k++) {
                size_t index;
                of[k] = NULL;
                json_array_foreach(lines, index, line) {
                    if (results_is(line, "part", "part", names[n], "kernel", kernels[k], NULL) &&
                        strcmp(results_text(line, "memory"), memories[m]) == 0)
                        of[k] = any = line;
                }
            }
            if (any == NULL) continue;
            fprintf(to, "| %s%s%s | %s |", names[n], *memories[m] ? ", " : "", memories[m], results_text(any, "unit"));
            for (size_t k = 0; k < kernel_count; k++)
                fprintf(to, of[k] ? " %.4g |" : " |", of[k] ? results_number(of[k], "per_second") * 1e-6 : 0.0);
            fputc('\n', to);
        }
    size_t index;
    fputs(
        "\nBuilding the pyramid and copying the samples, gigabytes of samples a second:\n\n| field | build | memcpy |\n"
        "|---|--:|--:|\n",
        to);
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "part", "part", "pyramid build", NULL)) continue;
        const char *field = results_text(line, "field");
        const json_t *copy = results_find(lines, "part", "part", "memcpy", "field", field, NULL);
        fprintf(to, "| %s | %.2f | %.2f |\n", field, results_number(line, "per_second") * 1e-9,
                copy ? results_number(copy, "per_second") * 1e-9 : 0.0);
    }
    return true;
}

/* ---- limits ---- */

/* Instructions a ray with every lever on; 0 where they were not counted for this kernel. */
static double instructions_of(const json_t *ablation, const char *field, const char *rays, const char *kernel) {
    const json_t *line = ablation ? results_find(ablation, "ablation", "variant", "as it is", "field", field, "rays",
                                                 rays, "kernel", kernel, NULL)
                                  : NULL;
    return line ? results_number(line, "instructions") / results_number(line, "ray_count") : 0;
}

static void put_number(FILE *to, double value, const char *format) {
    if (value > 0)
        fprintf(to, format, value);
    else
        fputs(" |", to);
}

bool papers_limits(FILE *to, papers_data *d, io_error *error) {
    const char *isa = "";
    const json_t *speeds = papers_speeds(d, &isa, error), *ablation = NULL;
    const json_t *counters = speeds ? papers_lines(d, "counters.json", error) : NULL;
    const json_t *parts = counters ? papers_lines(d, "parts.json", error) : NULL;
    if (parts == NULL || !papers_lines_if_there(d, "ablation.json", &ablation, error)) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX];
    const size_t field_count = results_distinct(speeds, "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct(speeds, "rays", rays, NAMES_MAX);
    fprintf(
        to,
        "With %s, one thread, a ray on average; in brackets the share of the lanes that took part. *Pieces* is what\n"
        "making the ray ready, the turns of the lane walk, refills, and leaf tests beyond these take where each runs "
        "alone on\na field of 257 × 257 samples.\n\n"
        "| field | rays | kernel | ns | ticks | instructions | a tick | cell steps | turns | ns a turn, alone | node "
        "steps "
        "| leaf tests | refills | nodes shared | pieces, ns | of all |\n"
        "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
        isa);
    for (size_t f = 0; f < field_count; f++)
        for (size_t r = 0; r < ray_count; r++) {
            const json_t *own = targets_own(speeds, fields[f], rays[r]);
            const char *name = own ? results_text(own, "contender") : "";
            char kernel[64];
            snprintf(kernel, sizeof kernel, "%.*s", (int)strcspn(name, "/"), name);
            const json_t *line = own ? counts_of(counters, fields[f], rays[r], kernel) : NULL;
            if (line == NULL) continue;
            const double ns = 1e3 / results_number(own, "mrays_per_s"), ticks = results_number(own, "tsc_per_ray");
            const double instructions = instructions_of(ablation, fields[f], rays[r], kernel);
            const double prepare = piece(parts, "prepare", kernel), refill = piece(parts, "refill", kernel);
            const double leaf = piece(parts, "leaf watertight", kernel), turn = turn_of(parts, kernel);
            const double apart = fmax(0, lanes(line, "leaf") - lanes(line, "round"));
            const double pieces =
                prepare + events(line, "stream") * turn + events(line, "refill") * refill + apart * leaf;
            fprintf(to, "| %s | %s | %s | %.1f | %.0f |", fields[f], rays[r], kernel, ns, ticks);
            put_number(to, instructions, " %.0f |");
            put_number(to, instructions / ticks, " %.2f |");
            put_busy(to, line, "flat");
            put_number(to, events(line, "stream"), " %.2f |");
            put_number(to, turn, " %.1f |");
            put_busy(to, line, "node");
            put_busy(to, line, "leaf");
            put_number(to, events(line, "refill"), " %.2f |");
            put_number(to, events(line, "shared_node"), " %.2f |");
            put_number(to, turn > 0 ? pieces : 0, " %.1f |");
            put_number(to, turn > 0 ? 100 * pieces / ns : 0, " %.0f %% |");
            fputc('\n', to);
        }
    return true;
}

/* ---- ablation ---- */

bool papers_ablation(FILE *to, papers_data *d, io_error *error) {
    const json_t *lines = papers_lines(d, "ablation.json", error);
    if (lines == NULL) return false;
    const char *fields[NAMES_MAX], *rays[NAMES_MAX], *variants[NAMES_MAX];
    const size_t field_count = results_distinct_of(lines, "ablation", "field", fields, NAMES_MAX);
    const size_t ray_count = results_distinct_of(lines, "ablation", "rays", rays, NAMES_MAX);
    const size_t variant_count = results_distinct_of(lines, "ablation", "variant", variants, NAMES_MAX);
    const json_t *first = results_find(lines, "ablation", NULL);
    if (first == NULL) return io_fail(error, "%s/ablation.json: has no counts", d->folder);
    fprintf(
        to,
        "Instructions a ray inside the query, `%s`, in brackets over those of the code as it is; counted by callgrind, "
        "%.0f rays a\nclass. All variants gave the same answers.\n",
        results_text(first, "kernel"), results_number(first, "ray_count"));
    for (size_t f = 0; f < field_count; f++) {
        fprintf(to, "\n**%s**\n\n| |", fields[f]);
        for (size_t r = 0; r < ray_count; r++) fprintf(to, " %s |", rays[r]);
        fputs("\n|---|", to);
        for (size_t r = 0; r < ray_count; r++) fputs("--:|", to);
        fputc('\n', to);
        for (size_t v = 0; v < variant_count; v++) {
            fprintf(to, "| %s |", variants[v]);
            for (size_t r = 0; r < ray_count; r++) {
                const json_t *line =
                    results_find(lines, "ablation", "variant", variants[v], "field", fields[f], "rays", rays[r], NULL);
                const double base = instructions_of(lines, fields[f], rays[r], results_text(first, "kernel"));
                const double is = line ? results_number(line, "instructions") / results_number(line, "ray_count") : 0;
                put_number(to, is, " %.0f");
                if (is > 0) fprintf(to, v && base > 0 ? " (%.2f) |" : " |", is / base);
            }
            fputc('\n', to);
        }
    }
    return true;
}
