/* SPDX-License-Identifier: Apache-2.0 */
/* Three claims of the coursework that Cellwalk grew from, each answered by what was counted. */

#include "results.h"
#include "statistics.h"
#include "tradeoff_summary.h"

#include <stdio.h>
#include <string.h>

static bool is_kind(const json_t *line, const char *kind) { return strcmp(results_text(line, "kind"), kind) == 0; }

static bool add_answer(json_t *lines, const char *name, const char *claim, const char *outcome, const char *text) {
    json_t *line = json_object();
    results_set_text(line, "kind", "hypothesis");
    results_set_text(line, "name", name);
    results_set_text(line, "claim", claim);
    results_set_text(line, "verdict", outcome);
    results_set_text(line, "text", text);
    return json_array_append_new(lines, line) == 0;
}

/* ---- early return ---- */

typedef struct tally {
    double wrong, rays, worst; /* answers; rays; highest rate a million; of the timed classes, which are not aimed */
    const json_t *worst_at;
} tally;

static tally tally_of(const json_t *lines, const char *name) {
    tally t = {0};
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "result") || strcmp(results_text(line, "contender"), name) != 0 ||
            strcmp(results_text(line, "query"), "closest") != 0 || !json_object_get(line, "mrays_per_s") ||
            json_object_get(line, "left_out_seconds"))
            continue;
        const double wrong =
            results_number(line, "leaks") + results_number(line, "phantoms") + results_number(line, "wrong");
        const double rays = results_number(line, "ray_count"), rate = rays > 0 ? 1e6 * wrong / rays : 0;
        t.wrong += wrong;
        t.rays += rays;
        if (t.worst_at != NULL && rate <= t.worst) continue;
        t.worst = rate;
        t.worst_at = line;
    }
    return t;
}

static bool answer_early(json_t *lines) {
    static const char *const claim = "return at the first triangle hit in the 3D grid is safe";
    const tally early = tally_of(lines, "early/grid3d-early"), exact = tally_of(lines, "moller-trumbore/grid3d");
    if (early.rays <= 0 || exact.rays <= 0)
        return add_answer(lines, "early", claim, "not measured",
                          "The modes early and moller-trumbore did not both run.");
    char text[512];
    snprintf(text, sizeof text,
             "grid3d-early gives a wrong answer for %.0f of %.0f rays, at worst %.0f in a million (field %s, %s rays); "
             "grid3d, which goes on until no nearer hit can follow, for %.0f of %.0f.",
             early.wrong, early.rays, early.worst, results_text(early.worst_at, "field"),
             results_text(early.worst_at, "rays"), exact.wrong, exact.rays);
    /* Both use the same leaf test, whose own leaks are not the early return's fault. */
    const bool safe = early.wrong / early.rays <= exact.wrong / exact.rays;
    return add_answer(lines, "early", claim, safe ? "no counterexample found" : "refuted", text);
}

/* ---- cells and triangles ---- */

static bool answer_cells(json_t *lines) {
    static const char *const claim = "2D-DDA tests fewer cells but more triangles";
    enum { MOST = 256 };
    double cells[MOST], triangles[MOST], ungated[MOST];
    size_t n = 0, fewer = 0, more = 0, more_ungated = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "count") || n == MOST || results_number(line, "voxels") <= 0 ||
            results_number(line, "voxel_triangles") <= 0 || results_number(line, "cell_triangles") <= 0)
            continue;
        cells[n] = results_number(line, "cells") / results_number(line, "voxels");
        triangles[n] = results_number(line, "cell_triangles") / results_number(line, "voxel_triangles");
        ungated[n] = 2 * results_number(line, "cells") / results_number(line, "voxel_triangles");
        fewer += cells[n] < 1;
        more += triangles[n] > 1;
        more_ungated += ungated[n] > 1;
        n++;
    }
    if (n == 0) return add_answer(lines, "cells", claim, "not measured", "Nothing was counted.");
    char text[640];
    snprintf(
        text, sizeof text,
        "The cell walk visits fewer cells than the 3D grid voxels in %zu of %zu sets of rays (%.3g times as many, "
        "geometric mean). It tests more triangles in %zu of them (%.3g times as many) with its comparison of heights "
        "before the test, and in %zu (%.3g times as many) if it tested both triangles of every cell that it visits.",
        fewer, n, statistics_geometric_mean(cells, n), more, statistics_geometric_mean(triangles, n), more_ungated,
        statistics_geometric_mean(ungated, n));
    const bool all = fewer == n && more == n, none = fewer == 0 || more == 0;
    return add_answer(lines, "cells", claim, all ? "confirmed" : none ? "refuted" : "true only in part", text);
}

/* ---- normals ---- */

static double member(const json_t *line, const char *of, const char *key) {
    return results_number(json_object_get(line, of), key);
}

static bool answer_normals(json_t *lines) {
    static const char *const claim = "barycentric Phong beats bilinear";
    enum { MOST = 64 };
    double errors[MOST], costs[MOST];
    size_t n = 0, better = 0, cheaper = 0, index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (!is_kind(line, "normal") || n == MOST) continue;
        errors[n] = member(line, "barycentric", "degrees_rms") / member(line, "bilinear", "degrees_rms");
        costs[n] = member(line, "barycentric", "nanoseconds") / member(line, "bilinear", "nanoseconds");
        better += errors[n] < 1;
        cheaper += costs[n] < 1;
        n++;
    }
    if (n == 0) return add_answer(lines, "normals", claim, "not measured", "No normals were measured.");
    char text[512];
    snprintf(
        text, sizeof text,
        "The barycentric normal is nearer to the true one on %zu of %zu waves (root mean square error %.3g times that "
        "of the bilinear one, geometric mean), and cheaper on %zu (%.3g times the time).",
        better, n, statistics_geometric_mean(errors, n), cheaper, statistics_geometric_mean(costs, n));
    const char *outcome = better == n   ? "confirmed"
                          : better == 0 ? (cheaper > n / 2 ? "refuted for accuracy, confirmed for cost" : "refuted")
                                        : "true only in part";
    return add_answer(lines, "normals", claim, outcome, text);
}

bool tradeoff_answer_claims(json_t *lines) {
    return answer_early(lines) && answer_cells(lines) && answer_normals(lines);
}
