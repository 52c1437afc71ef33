/* SPDX-License-Identifier: Apache-2.0 */
/* Every path and leaf test against brute force and the exact oracle on small fields. Each disagreement gets a name and is
 * counted: tie on a shared edge or vertex, leak, phantom, wrong surface. What a path promises is zero, the rest printed:
 *  - Watertight: no leak, no phantom, no wrong surface.
 *  - Möller-Trumbore: leaks (or a wrong surface behind one) only where the exact ray goes through a triangle within
 *    rounding of an edge; phantoms only on triangles that the ray is so nearly parallel to that rounding decides. */

#include "cellwalk_expert.h"
#include "check.h"
#include "tally.h"

#include <stdio.h>
#include <string.h>

enum { RAYS = 300, PATHS_MAX = 64 };

/* One path of those that are not one another's bits (lanes.c): all but packets and pyramids. */
typedef struct path {
    const cw_kernel *kernel;
    cw_leaf leaf;
    tally tally;
    size_t agree, other_triangle, only_brute, only_here, other_hit; /* with brute force */
    size_t unexcused;                                               /* what rounding does not explain */
} path;

static size_t find_paths(path *paths) {
    static const char *const names[] = {"brute", "grid3d", "cell"};
    size_t n = 0;
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_kernel *kernel = cw_kernel_find(names[k]);
            if (leaf == CW_LEAF_WATERTIGHT && cw_kernel_describe(kernel).default_leaf != CW_LEAF_WATERTIGHT) continue;
            paths[n++] = (path){.kernel = kernel, .leaf = (cw_leaf)leaf};
        }
    return n;
}

/* How a path's answer compares with brute force's; either may be right. */
static void compare(path *p, const cw_hit *brute, const cw_hit *here) {
    if (brute->i < 0 || here->i < 0) {
        if (brute->i < 0 && here->i < 0)
            p->agree++;
        else if (here->i < 0)
            p->only_brute++;
        else
            p->only_here++;
    } else if (brute->i == here->i && brute->j == here->j && brute->triangle == here->triangle) {
        p->agree++;
    } else if (abs(brute->i - here->i) <= 1 && abs(brute->j - here->j) <= 1) {
        p->other_triangle++;
    } else {
        p->other_hit++;
    }
}

static void judge(path *p, const test_field *f, const cw_ray *ray, const cw_hit *hit, oracle *o,
                  const oracle_truth *truth, size_t *explained) {
    const judgement j = oracle_judge(o, hit);
    tally_add(&p->tally, hit, truth, &j);
    if (j.verdict <= VERDICT_TIE) return;
    if (p->leaf == CW_LEAF_MOLLER_TRUMBORE) {
        if (j.verdict == VERDICT_PHANTOM ? j.apart <= j.blur : truth->pass_edge <= truth->pass_blur) return;
    }
    p->unexcused++;
    if (++*explained > 4) return;
    printf("%s with %s: ", cw_kernel_describe(p->kernel).name, cw_leaf_name(p->leaf));
    tally_explain(f, ray, hit, truth, &j);
}

static void print_path(const path *p) {
    char what[64];
    snprintf(what, sizeof what, "%s %s", cw_kernel_describe(p->kernel).name,
             p->leaf == CW_LEAF_WATERTIGHT ? "wt" : "mt");
    tally_print(what, &p->tally);
    printf("    against brute force: %zu the same, %zu a neighbouring triangle, %zu far apart, %zu hit only there, %zu "
           "only here\n",
           p->agree, p->other_triangle, p->other_hit, p->only_brute, p->only_here);
}

static void test_every_path(void **state) {
    (void)state;
    static const field_size sizes[] = {{2, 2}, {3, 9}, {12, 2}, {9, 9}, {17, 13}};
    static test_field shape;
    static cw_ray rays[RAYS];
    static cw_hit brute[RAYS], hits[RAYS];
    path paths[PATHS_MAX];
    const size_t count = find_paths(paths), rounds = test_rounds(), rays_each = test_share(RAYS, 5);
    random_state r = {4242};
    size_t explained = 0;
    for (size_t k = 0; k < rounds * 5 * FIELD_SHAPES * RAY_CLASSES; k++) {
        const field_size size = sizes[k % 5];
        field_make(&shape, (field_shape)(k / 5 % FIELD_SHAPES), size.nx, size.ny, k);
        cw_field *field = field_open(&shape);
        oracle *o = oracle_create(shape.z, shape.nx, shape.ny);
        assert_non_null(o);
        for (size_t n = 0; n < rays_each; n++)
            rays[n] = ray_make((ray_class)(k / 5 / FIELD_SHAPES % RAY_CLASSES), &shape, &r);
        for (size_t p = 0; p < count; p++) {
            const cw_run query = {.expert.kernel = paths[p].kernel, .expert.leaf = paths[p].leaf};
            check_status(cw_closest(field, &query, rays, rays_each, p == 0 ? brute : hits), CW_OK);
            for (size_t n = 0; n < rays_each; n++) {
                const cw_hit *hit = p == 0 ? &brute[n] : &hits[n];
                compare(&paths[p], &brute[n], hit);
                judge(&paths[p], &shape, &rays[n], hit, o, oracle_trace(o, &rays[n]), &explained);
            }
        }
        oracle_destroy(o);
        cw_field_destroy(field);
    }
    for (size_t p = 0; p < count; p++) print_path(&paths[p]);
    for (size_t p = 0; p < count; p++) {
        const path *q = &paths[p];
        const size_t *v = q->tally.verdict;
        const char *name = cw_kernel_describe(q->kernel).name;
        check(q->unexcused == 0, "%s: %zu wrong answers that rounding does not explain", name, q->unexcused);
        if (q->leaf == CW_LEAF_WATERTIGHT)
            check(v[VERDICT_LEAK] + v[VERDICT_PHANTOM] + v[VERDICT_WRONG_SURFACE] + q->tally.digits == 0,
                  "%s: watertight, and wrong", name);
    }
    check(paths[0].tally.passes > paths[0].tally.rays / 10, "too few rays pass for the test to mean anything");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_path)};
    return cmocka_run_group_tests_name("brute", tests, NULL, NULL);
}
