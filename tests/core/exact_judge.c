/* SPDX-License-Identifier: Apache-2.0 */
#include "exact.h"

#include "cellwalk_expert.h"
#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { AT_A_TIME = 1024 };

/* Why an answer is what is expected. */
typedef enum outcome {
    AS_EXPECTED,
    SLIPPED,  /* Möller-Trumbore: missed a triangle, or went on to the next surface, within rounding of an edge */
    PARALLEL, /* Möller-Trumbore: off the triangle, which is so nearly parallel that rounding decides */
    OUTCOMES
} outcome;

path exact_paths[PATHS_MAX];
size_t exact_path_count;

static size_t outcomes[PATHS_MAX][OUTCOMES]; /* of the row that runs */

/* To stdout: all that is needed to repeat and to understand a verdict. */
static void explain(const test_field *f, const cw_ray *ray, const cw_hit *hit, const oracle_truth *truth,
                    const judgement *j) {
    printf("%s, |d|/E %g, %g off the triangle (%g), t off by %g (%g), u and v by %g (%g)\n", verdict_name(j->verdict),
           j->at.residual, j->at.apart, j->blur, j->t_error, j->t_bound, j->place_error, j->place_bound);
    field_print(f);
    ray_print(ray);
    hit_print("kernel", hit);
    printf("truth: %s, t %a, %u triangles, first (%d, %d) %u%s", truth->hit ? "hit" : "miss", truth->t, truth->at,
           (int)truth->triangle[0].i, (int)truth->triangle[0].j, (unsigned)truth->triangle[0].triangle,
           truth->coplanar ? ", coplanar" : "");
    if (truth->passes)
        printf(", has passed at t %a, through a triangle %g from its nearest edge (%g)", truth->pass_t,
               truth->pass_edge, truth->pass_blur);
    printf("\n");
}

static bool as_expected(const path *p, const oracle_truth *truth, const judgement *j, outcome *o) {
    *o = AS_EXPECTED;
    if (p->leaf == CW_LEAF_WATERTIGHT) return j->verdict <= VERDICT_TIE && digits_hold(j);
    if (j->verdict <= VERDICT_TIE) return true;
    *o = j->verdict == VERDICT_PHANTOM ? PARALLEL : SLIPPED;
    return j->verdict == VERDICT_PHANTOM ? j->at.apart <= j->blur : truth->pass_edge <= truth->pass_blur;
}

/* Brute force is for small fields, and so is a grid of 64 voxels an axis where all heights but a few are the same. */
static bool takes_part(const path *p, const test_field *f, exact_choice choice) {
    if (choice == EVERY_PATH) return p->strict || f->nx * f->ny <= 400;
    return p->leaf == CW_LEAF_WATERTIGHT && (choice == WATERTIGHT_PATHS || strcmp(p->name, "cell") == 0);
}

static void trace(const cw_field *field, const path *p, const cw_ray *rays, size_t n, cw_hit *hits) {
    static uint8_t occluded[AT_A_TIME];
    memset(hits, 0xff, n * sizeof *hits); /* no hit of any path */
    check_status(cw_closest(field, &p->query, rays, n, hits), CW_OK);
    check_status(cw_occluded(field, &p->query, rays, n, occluded), CW_OK);
    for (size_t k = 0; k < n; k++) {
        if (occluded[k] == (hits[k].i >= 0)) continue;
        ray_print(&rays[k]);
        check(false, "%s with %s: any hit says %d", p->name, cw_leaf_name(p->leaf), occluded[k]);
    }
}

/* A path that takes part, and gave the same answer to ray k, of which no less is expected; p if there is none before it. */
static size_t judged_before(cw_hit hits[PATHS_MAX][AT_A_TIME], const bool part[PATHS_MAX], size_t p, size_t k) {
    size_t first = 0;
    while (first < p &&
           !(part[first] && exact_paths[first].leaf == exact_paths[p].leaf && hit_same(&hits[first][k], &hits[p][k])))
        first++;
    return first;
}

void exact_judge(const test_field *f, const cw_ray *rays, size_t n, exact_choice choice, tie_rule *tie,
                 exact_counts *counts) {
    static cw_hit hits[PATHS_MAX][AT_A_TIME];
    cw_field *field = field_open(f);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    assert_non_null(o);
    bool part[PATHS_MAX];
    for (size_t p = 0; p < exact_path_count; p++) part[p] = takes_part(&exact_paths[p], f, choice);
    for (size_t first = 0; first < n; first += AT_A_TIME) {
        const size_t some = n - first < AT_A_TIME ? n - first : AT_A_TIME;
        for (size_t p = 0; p < exact_path_count; p++)
            if (part[p]) trace(field, &exact_paths[p], rays + first, some, hits[p]);
        for (size_t k = 0; k < some; k++) {
            outcome found[PATHS_MAX] = {AS_EXPECTED};
            const cw_ray *ray = &rays[first + k];
            const oracle_truth *truth = oracle_trace(o, ray);
            for (size_t p = 0; p < exact_path_count; p++) {
                const path *q = &exact_paths[p];
                if (!part[p]) continue;
                const size_t before = judged_before(hits, part, p, k);
                found[p] = found[before];
                if (before == p) {
                    const judgement j = oracle_judge(o, &hits[p][k]);
                    const bool good = as_expected(q, truth, &j, &found[p]) &&
                                      (j.verdict != VERDICT_TIE || tie == NULL || tie(ray, truth));
                    if (!good) explain(f, ray, &hits[p][k], truth, &j);
                    check(good, "%s with %s: %s", q->name, cw_leaf_name(q->leaf), verdict_name(j.verdict));
                    if (q->leaf == CW_LEAF_WATERTIGHT) {
                        counts->rays++;
                        counts->hits += hits[p][k].i >= 0;
                        counts->passes += truth->passes;
                        counts->verdict[j.verdict]++;
                    }
                } else {
                    counts->answers++;
                }
                outcomes[p][found[p]]++;
            }
        }
    }
    oracle_destroy(o);
    cw_field_destroy(field);
}

void exact_expect(const exact_case *c) {
    static test_field f;
    f.shape = FIELD_INTEGERS;
    f.nx = c->nx;
    f.ny = c->ny;
    memcpy(f.z, c->z, f.nx * f.ny * sizeof *f.z);
    cw_field *field = field_open(&f);
    for (size_t p = 0; p < exact_path_count; p++) {
        const path *q = &exact_paths[p];
        const float wanted = q->leaf == CW_LEAF_WATERTIGHT ? c->watertight : c->moller_trumbore;
        const cw_hit miss = {.t = INFINITY, .i = -1, .j = -1};
        cw_hit hit;
        trace(field, q, &c->ray, 1, &hit);
        check(hit.t == wanted && (hit.i >= 0) == (wanted < INFINITY), "%s with %s, %s: t = %g instead of %g", q->name,
              cw_leaf_name(q->leaf), c->what, (double)hit.t, (double)wanted);
        check(wanted < INFINITY || hit_same(&hit, &miss), "%s, %s: a miss with odd fields", q->name, c->what);
        outcomes[p][AS_EXPECTED]++;
    }
    cw_field_destroy(field);
}

void exact_expect_all(const exact_row *row) {
    for (int k = 0; k < row->number; k++) exact_expect(&row->cases[k]);
}

/* Names and texts hold nothing that JSON would have to escape. */
void exact_print_counts(const exact_row *row) {
    for (size_t p = 0; p < exact_path_count && row->expected; p++) {
        const size_t *c = outcomes[p], asked = c[AS_EXPECTED] + c[SLIPPED] + c[PARALLEL];
        printf("{\"kind\": \"extreme\", \"item\": \"%s\", \"expected\": \"%s\", \"kernel\": \"%s\", \"leaf\": \"%s\", "
               "\"asked\": %zu, \"as_expected\": %zu, \"slipped\": %zu, \"parallel\": %zu}\n",
               row->name, row->expected, exact_paths[p].name, cw_leaf_name(exact_paths[p].leaf), asked, c[AS_EXPECTED],
               c[SLIPPED], c[PARALLEL]);
    }
    memset(outcomes, 0, sizeof outcomes);
}
