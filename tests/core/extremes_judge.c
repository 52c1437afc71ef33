/* SPDX-License-Identifier: Apache-2.0 */
#include "extremes_judge.h"

#include "check.h"
#include "tally.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ITEMS_MAX = 32 };

/* Why an answer is what is expected. */
typedef enum outcome {
    AS_EXPECTED,
    SLIPPED,  /* Möller-Trumbore: missed a triangle, or went on to the next surface, within rounding of an edge */
    PARALLEL, /* Möller-Trumbore: off the triangle, which is so nearly parallel that rounding decides */
    OUTCOMES
} outcome;

typedef struct item {
    const char *name, *expected;
    size_t asked[PATHS_MAX], count[PATHS_MAX][OUTCOMES];
} item;

path extreme_paths[PATHS_MAX];
size_t extreme_path_count;
static item items[ITEMS_MAX];
static size_t item_count;

void extreme_item(const char *name, const char *expected) {
    check(item_count < ITEMS_MAX, "too many extremes");
    items[item_count++] = (item){.name = name, .expected = expected};
}

static void count(size_t p, size_t asked, outcome o, size_t answers) {
    item *now = &items[item_count - 1];
    now->asked[p] += asked;
    now->count[p][o] += answers;
}

void extreme_count(size_t p, size_t n) { count(p, n, AS_EXPECTED, n); }

/* ---- judging ----------------------------------------------------------------------------------------------------- */

static bool excused(const path *p, const oracle_truth *truth, const judgement *j, outcome *o) {
    *o = AS_EXPECTED;
    if (j->verdict <= VERDICT_TIE) return true;
    if (p->leaf != CW_LEAF_MOLLER_TRUMBORE) return false;
    if (j->verdict == VERDICT_PHANTOM) {
        *o = PARALLEL;
        return j->apart <= j->blur;
    }
    *o = SLIPPED;
    return truth->pass_edge <= truth->pass_blur;
}

/* Brute force is for small fields, and so is a grid of 64 voxels an axis where all heights but a few are the same. */
static bool left_out(const path *p, const test_field *f) { return !p->strict && f->nx * f->ny > 400; }

/* A path with the same answer to ray k of which no less is expected; p if there is none before it. */
static size_t judged_before(cw_hit hits[PATHS_MAX][EXTREME_RAYS], size_t p, size_t k) {
    size_t first = 0;
    while (first < p && !(extreme_paths[first].leaf == extreme_paths[p].leaf && hit_same(&hits[first][k], &hits[p][k])))
        first++;
    return first;
}

static bool has_infinities(const test_field *f) {
    for (size_t k = 0; k < f->nx * f->ny; k++)
        if (isinf(f->z[k])) return true;
    return false;
}

static void trace_all(const test_field *f, const cw_ray *rays, size_t n, cw_hit hits[PATHS_MAX][EXTREME_RAYS]) {
    static uint8_t occluded[EXTREME_RAYS];
    cw_field *field = has_infinities(f) ? field_open_copied(f) : field_open(f);
    for (size_t p = 0; p < extreme_path_count; p++) {
        const path *q = &extreme_paths[p];
        memset(hits[p], 0xff, EXTREME_RAYS * sizeof hits[p][0]); /* no hit of any path */
        if (left_out(q, f)) continue;
        check_status(cw_closest(field, &q->query, rays, n, hits[p]), CW_OK);
        check_status(cw_occluded(field, &q->query, rays, n, occluded), CW_OK);
        for (size_t k = 0; k < n; k++)
            check(occluded[k] == (hits[p][k].i >= 0), "%s: any and closest hit differ", q->name);
    }
    cw_field_destroy(field);
}

size_t extreme_judge(const test_field *f, const cw_ray *rays, size_t n) {
    static cw_hit hits[PATHS_MAX][EXTREME_RAYS];
    outcome found[PATHS_MAX] = {AS_EXPECTED};
    trace_all(f, rays, n, hits);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    assert_non_null(o);
    size_t met = 0;
    for (size_t k = 0; k < n; k++) {
        const oracle_truth *truth = oracle_trace(o, &rays[k]);
        met += truth->hit;
        for (size_t p = 0; p < extreme_path_count; p++) {
            if (left_out(&extreme_paths[p], f)) continue;
            const size_t before = judged_before(hits, p, k);
            if (before < p) {
                found[p] = found[before];
            } else {
                const judgement j = oracle_judge(o, &hits[p][k]);
                const bool good = excused(&extreme_paths[p], truth, &j, &found[p]);
                if (!good) tally_explain(f, &rays[k], &hits[p][k], truth, &j);
                check(good, "%s with %s: %s", extreme_paths[p].name, cw_leaf_name(extreme_paths[p].leaf),
                      verdict_name(j.verdict));
            }
            count(p, 1, found[p], 1);
        }
    }
    oracle_destroy(o);
    return met;
}

void extreme_expect(size_t nx, size_t ny, const float *z, cw_ray ray, float watertight, float moller_trumbore,
                    const char *what) {
    test_field f = {.shape = FIELD_INTEGERS, .nx = nx, .ny = ny};
    memcpy(f.z, z, nx * ny * sizeof *z);
    cw_field *field = has_infinities(&f) ? field_open_copied(&f) : field_open(&f);
    for (size_t p = 0; p < extreme_path_count; p++) {
        const path *q = &extreme_paths[p];
        const float wanted = q->leaf == CW_LEAF_WATERTIGHT ? watertight : moller_trumbore;
        cw_hit hit;
        uint8_t occluded;
        check_status(cw_closest(field, &q->query, &ray, 1, &hit), CW_OK);
        check_status(cw_occluded(field, &q->query, &ray, 1, &occluded), CW_OK);
        check(hit.t == wanted && (hit.i >= 0) == (wanted < INFINITY), "%s with %s, %s: t = %g instead of %g", q->name,
              cw_leaf_name(q->leaf), what, (double)hit.t, (double)wanted);
        const cw_hit miss = {.t = INFINITY, .i = -1, .j = -1};
        check(wanted < INFINITY || hit_same(&hit, &miss), "%s, %s: a miss with odd fields", q->name, what);
        check(occluded == (hit.i >= 0), "%s with %s, %s: any hit says %d", q->name, cw_leaf_name(q->leaf), what,
              occluded);
        extreme_count(p, 1);
    }
    cw_field_destroy(field);
}

size_t extreme_compare(const cw_field *a, const cw_ray *rays, const cw_field *b, const cw_ray *same_rays, size_t n,
                       bool except_grid, const char *what) {
    size_t found = 0;
    static cw_hit hits[EXTREME_RAYS], same[EXTREME_RAYS];
    static uint8_t occluded[EXTREME_RAYS], too[EXTREME_RAYS];
    for (size_t p = 0; p < extreme_path_count; p++) {
        const path *q = &extreme_paths[p];
        if (except_grid && strncmp(q->name, "grid3d", 6) == 0) continue;
        check_status(cw_closest(a, &q->query, rays, n, hits), CW_OK);
        check_status(cw_closest(b, &q->query, same_rays, n, same), CW_OK);
        check_status(cw_occluded(a, &q->query, rays, n, occluded), CW_OK);
        check_status(cw_occluded(b, &q->query, same_rays, n, too), CW_OK);
        for (size_t k = 0; k < n; k++) {
            found += hits[k].i >= 0;
            if (hit_same(&hits[k], &same[k]) && occluded[k] == too[k]) continue;
            ray_print(&rays[k]);
            hit_print("as is", &hits[k]);
            hit_print("the other", &same[k]);
            check(false, "%s with %s: other answers with %s", q->name, cw_leaf_name(q->leaf), what);
        }
        extreme_count(p, n);
    }
    return found;
}

/* ---- counts ------------------------------------------------------------------------------------------------------ */

int extremes_begin(void **state) {
    (void)state;
    extreme_path_count = paths_find(extreme_paths);
    return 0;
}

/* Names and texts hold nothing that JSON would have to escape. */
static void write_counts(FILE *to) {
#ifdef CELLWALK_EMULATES_AVX512
    const bool emulated = true;
#else
    const bool emulated = false;
#endif
    fprintf(to, "{\"kind\": \"run\", \"command\": \"extremes\", \"emulated\": %s}\n", emulated ? "true" : "false");
    for (size_t k = 0; k < item_count; k++)
        for (size_t p = 0; p < extreme_path_count; p++) {
            const size_t *c = items[k].count[p];
            fprintf(to,
                    "{\"kind\": \"extreme\", \"item\": \"%s\", \"expected\": \"%s\", \"kernel\": \"%s\", "
                    "\"leaf\": \"%s\", \"asked\": %zu, \"as_expected\": %zu, \"slipped\": %zu, \"parallel\": %zu}\n",
                    items[k].name, items[k].expected, extreme_paths[p].name, cw_leaf_name(extreme_paths[p].leaf),
                    items[k].asked[p], c[AS_EXPECTED], c[SLIPPED], c[PARALLEL]);
        }
}

int extremes_end(void **state) {
    (void)state;
    const char *where = getenv("CELLWALK_TEST_COUNTS");
    if (where == NULL) return 0;
    FILE *file = fopen(where, "w");
    if (file) write_counts(file);
    if (file && fclose(file) == 0) return 0;
    print_error("%s: %s\n", where, strerror(errno));
    return -1;
}
