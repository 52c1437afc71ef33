/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk_stability MILLIONS [FILE]: aimed rays, the same ones for every kernel and, with a file, for Embree, judged
 * with the exact oracle, on one thread. Counts go to FILE as JSON lines: one of kind "run", and one of kind "result"
 * for each contender and class. The test runs it without a file: no leak, no phantom, the same bits, and rays that do
 * pass. CELLWALK_TEST_DIVIDE = n takes an nth of the rays. */

#include "harness/harness_run.h"
#include "harness/results.h"
#include "oracle.h"
#include "peers/peer.h"
#include "rays.h"
#include "stability/aimed.h"
#include "workload/fields.h"
#include "workload/fractal_terrain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A round has a batch for each class and field; all of its rays start alike: over the field, afar, near or behind. */
enum { FIELDS = 10, BATCH_RAYS = 4096, ROUND_BATCHES = AIM_COUNT * FIELDS, CONTENDERS_MAX = 48 };

typedef enum counted {
    TRACED,
    HITS,
    OTHER,    /* rays whose closest or any hit is not the reference's closest */
    PASS,     /* rays that are known to pass */
    LEAKS,    /* misses of those */
    PHANTOMS, /* of all hits */
    SAMPLED,  /* judged in full by the oracle, with these verdicts: */
    RIGHT,
    WHATS = RIGHT + VERDICTS
} counted;

typedef struct counts {
    size_t of[WHATS];
    double residual; /* worst |d| / E of hits that hold */
    double apart;    /* worst distance off the triangle over delta of hits that hold */
    double t_error;  /* worst error of t over its bound */
} counts;

typedef enum role {
    REFERENCE, /* the default kernel, watertight: before all rays, closest and any, all its hits checked */
    SAME_BITS, /* another kernel with the same rules: closest and any hit compared with the reference */
    OWN_RULES, /* judged without a reference */
    BLIND      /* finds nothing, so that misses are seen to count */
} role;

typedef struct tested {
    role role;
    unsigned every,
        turn;    /* takes part in one round of that many; which one does not depend on the machine's other contenders */
    size_t rays; /* with that many rays of each batch, the first */
    contender on[FIELDS];
    counts count[AIM_COUNT];
} tested;

/* All of it lasts until the program ends. */
static struct place {
    cw_field *field;
    aimed_field aimed;
    oracle *oracle;
} places[FIELDS];
static tested contenders[CONTENDERS_MAX];
static unsigned contender_count, others, sample; /* others: every; sample: one ray in so many is judged in full */
static size_t faults;

/* ---- fields and contenders --------------------------------------------------------------------------------------- */

/* From smooth land to whole numbers and cliffs, planes that hardly rise and heights that are denormal. */
static bool make_place(size_t n) {
    enum { LAND, SEA, SWELL };
    static const struct {
        field_shape shape;
        size_t nx, ny;
    } rows[FIELDS] = {{FIELD_FLAT, 2, 2},      {FIELD_FLAT, 200, 200},   {FIELD_RANDOM, 255, 255},
                      {FIELD_RANDOM, 65, 65},  {FIELD_INTEGERS, 64, 33}, {FIELD_CLIFF, 48, 48},
                      {FIELD_PLANE, 129, 129}, {FIELD_FLAT, 33, 33},     {FIELD_GENTLE, 255, 255},
                      {FIELD_FAINT, 65, 65}};
    static test_field made[FIELDS];
    test_field *f = &made[n];
    field_make(f, rows[n].shape, rows[n].nx, rows[n].ny, n);
    workload_field samples = {.nx = f->nx, .ny = f->ny, .z = f->z};
    if (n == LAND && !workload_field_make("513", &samples)) return false;
    if (n == SEA) terrain_sea(f->z, f->nx, f->ny, 5, 0.2f);
    for (size_t k = 0; n == SWELL && k < f->nx * f->ny; k++)
        f->z[k] = 0.3f * (float)(k % f->nx) + 0.1f * (float)(k / f->nx) + 1e-4f * f->z[k];
    struct place *p = &places[n];
    if (workload_field_open(&samples, &p->field) != CW_OK) return false;
    p->aimed = aimed_field_of(p->field);
    p->oracle = oracle_create(samples.z, samples.nx, samples.ny);
    return p->oracle != NULL;
}

static tested *add(role as, size_t turn, size_t rays) {
    tested *t = &contenders[contender_count++];
    *t = (tested){.role = as, .every = as == REFERENCE ? 1 : others, .turn = (unsigned)turn, .rays = rays};
    return t;
}

static bool add_kernels(void) {
    for (int leaf = CW_LEAF_WATERTIGHT; leaf >= CW_LEAF_MOLLER_TRUMBORE; leaf--) {
        bool first = true;
        for (size_t k = cw_kernel_count(); k-- > 0;) { /* the default first */
            const cw_kernel *kernel = cw_kernel_at(k);
            const cw_run run = {.expert = {.kernel = kernel, .leaf = (cw_leaf)leaf}};
            const cw_kernel_info info = cw_kernel_describe(kernel);
            const bool watertight = leaf == CW_LEAF_WATERTIGHT, walks = info.default_leaf == CW_LEAF_WATERTIGHT;
            /* Brute force tests each triangle as grid3d does, and takes thousands of times as long on these fields.
             * Kernels with the cell walk differ in no bit (lanes.c): one of them speaks for Möller-Trumbore. */
            if (strcmp(info.name, "brute") == 0 || cw_run_check(NULL, &run) != CW_OK ||
                (walks && !watertight && !first))
                continue;
            tested *t = add(!watertight ? OWN_RULES
                            : first     ? REFERENCE
                                        : SAME_BITS,
                            k, walks ? BATCH_RAYS : BATCH_RAYS / 64);
            first = first && !walks;
            for (size_t f = 0; f < FIELDS; f++)
                if (contender_from_kernel(&t->on[f], places[f].field, kernel, run.expert.leaf) != CW_OK) return false;
        }
    }
    return true;
}

static bool add_embree(io_error *error) {
    for (unsigned n = 0; n < 4; n++) {
        const bool robust = n / 2;
        const unsigned width = n % 2 ? 8 : 1;
        tested *t = add(OWN_RULES, n, BATCH_RAYS);
        for (size_t f = 0; f < FIELDS; f++) {
            void *peer = peer_embree.create(places[f].field, cw_isa_best(), robust ? PEER_ROBUST : 0, error);
            if (peer == NULL) return false;
            peer_embree.enter(&t->on[f], peer, width, false);
            snprintf(t->on[f].name, sizeof t->on[f].name, "embree%s/w%u", robust ? "-robust" : "", width);
        }
    }
    return true;
}

static void miss(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    (void)self, (void)rays;
    for (size_t k = 0; k < n; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
}

static bool make_all(bool with_embree, io_error *error) {
    for (size_t f = 0; f < FIELDS; f++)
        if (!make_place(f)) return io_fail(error, "out of memory");
    if (!add_kernels()) return io_fail(error, "a kernel could not be prepared");
    if (with_embree && peer_embree.version && !add_embree(error)) return false;
    tested *blind = add(BLIND, 0, BATCH_RAYS);
    for (size_t f = 0; f < FIELDS; f++) blind->on[f] = (contender){.name = "blind", .closest = miss};
    return true;
}

/* ---- a batch ----------------------------------------------------------------------------------------------------- */

static struct batch {
    struct place *place;
    aim kind;
    aim_start start;
    uint64_t number;
    bool passes[BATCH_RAYS];
    cw_ray rays[BATCH_RAYS];
    cw_hit reference[BATCH_RAYS], hits[BATCH_RAYS];
    uint8_t occluded[BATCH_RAYS];
} b;

/* Whether the exact oracle's bounds say, without tracing anything, that the ray passes: so a miss is a leak. */
static bool passes(oracle *o, const aimed_ray *a) {
    if (!oracle_ray(o, &a->ray)) return false;
    for (int end = 0; end < 2; end++) {
        const cw_hit *h = &a->over[end];
        const oracle_triangle over = {h->i, h->j, h->triangle};
        if (!oracle_clear(o, end ? a->to : a->from, end ? -a->side : a->side, h->i < 0 ? NULL : &over)) return false;
    }
    return true;
}

/* Which field, class and rays follows from the number alone. */
static void make_batch(uint64_t number) {
    b.number = number;
    b.kind = (aim)(number % AIM_COUNT);
    b.place = &places[number / AIM_COUNT % FIELDS];
    const uint64_t round = number / ROUND_BATCHES;
    b.start = (aim_start)((round + round / others) % START_COUNT); /* so that in time each contender sees each */
    random_state r = {number * 0x9e3779b97f4a7c15u};
    r.state = random_bits(&r); /* so that neighbours do not share numbers */
    for (size_t k = 0; k < BATCH_RAYS; k++) {
        b.passes[k] = false; /* nothing is known about a miss */
        /* Rounding may spoil one; many of those that graze cannot be proved. */
        for (int tries = b.kind == AIM_GRAZING ? 1 : 8; tries > 0 && !b.passes[k]; tries--) {
            const aimed_ray a = aimed_ray_make(b.kind, b.start, &b.place->aimed, &r);
            b.rays[k] = a.ray;
            b.passes[k] = passes(b.place->oracle, &a);
        }
    }
}

/* Counts a fault and prints the first eight. Contenders that promise less than cell may have faults. */
static void fault(const tested *t, size_t k, const cw_hit *hit, const char *what) {
    if (t->role > SAME_BITS || faults++ >= 8) return;
    printf("%s: %s, field %zu, class %s, start %d, batch %llu, ray %zu\n", t->on[0].name, what,
           (size_t)(b.place - places), aim_name(b.kind), (int)b.start, (unsigned long long)b.number, k);
    ray_print(&b.rays[k]);
    hit_print("hit", hit);
}

/* Without tracing: a leak of a ray that is known to pass, or a phantom. */
static void check_answer(const tested *t, counts *c, size_t k, const cw_hit *hit) {
    if (hit->i < 0) {
        if (!b.passes[k]) return;
        c->of[LEAKS]++;
        fault(t, k, hit, "leak");
        return;
    }
    oracle_ray(b.place->oracle, &b.rays[k]);
    const hit_check check = oracle_check(b.place->oracle, hit);
    if (check.holds) {
        c->residual = fmax(c->residual, check.residual);
        c->apart = fmax(c->apart, check.apart / check.apart_most);
        return;
    }
    c->of[PHANTOMS]++;
    fault(t, k, hit, "phantom");
}

static void judge_in_full(const tested *t, counts *c, size_t k, const cw_hit *hit) {
    const oracle_truth *truth = oracle_trace(b.place->oracle, &b.rays[k]);
    const judgement j = oracle_judge(b.place->oracle, hit);
    c->of[SAMPLED]++;
    c->of[RIGHT + j.verdict]++;
    if (b.passes[k] && !truth->passes) fault(t, k, hit, "no pass, although it was to be one");
    if (j.verdict > VERDICT_TIE) fault(t, k, hit, verdict_name(j.verdict));
    if (j.verdict != VERDICT_RIGHT || hit->i < 0 || !isfinite(j.t_bound) || !(j.t_error > 0)) return;
    c->t_error = fmax(c->t_error, j.t_error / j.t_bound);
    if (j.t_error > j.t_bound) fault(t, k, hit, "t is off");
}

static void trace(tested *t) {
    const contender *on = &t->on[b.place - places];
    counts *c = &t->count[b.kind];
    cw_hit *hits = t->role == REFERENCE ? b.reference : b.hits;
    on->closest(on, b.rays, t->rays, hits);
    if (t->role <= SAME_BITS) on->any(on, b.rays, t->rays, b.occluded);
    c->of[TRACED] += t->rays;
    for (size_t k = 0; k < t->rays; k++) {
        c->of[HITS] += hits[k].i >= 0;
        if (t->role <= SAME_BITS &&
            (!hit_same(&hits[k], &b.reference[k]) || b.occluded[k] != (b.reference[k].i >= 0))) {
            c->of[OTHER]++;
            fault(t, k, &hits[k], "not the reference's answer");
        }
        if (t->role == SAME_BITS) continue;
        c->of[PASS] += b.passes[k];
        check_answer(t, c, k, &hits[k]);
        if (k % sample == b.number % sample) judge_in_full(t, c, k, &hits[k]);
    }
}

static void run_batch(uint64_t number) {
    make_batch(number);
    for (tested *t = contenders; t < contenders + contender_count; t++) {
        /* Embree requires tmin >= 0, and aborts where it is compiled with assertions. */
        if (number / ROUND_BATCHES % t->every == t->turn % t->every && !(t->on[0].peer && b.start == START_BEHIND))
            trace(t);
    }
}

/* ---- what was found ---------------------------------------------------------------------------------------------- */

/* Prints sums; false if too few rays pass, a kernel took no part or misses do not count, so that they mean little. */
static bool print_sums(size_t batches) {
    bool good = true;
    for (int kind = 0; kind < AIM_COUNT; kind++) {
        const counts *c = &contenders[0].count[kind];
        printf("%-9s %9zu rays, %9zu known to pass, %zu leaks, %zu phantoms; worst |d| / E %.3f, off the triangle / "
               "delta %.3f, error of t / bound %.3f\n",
               aim_name((aim)kind), c->of[TRACED], c->of[PASS], c->of[LEAKS], c->of[PHANTOMS], c->residual, c->apart,
               c->t_error);
        good &= c->of[PASS] >= (kind == AIM_GRAZING ? c->of[TRACED] / 8 : c->of[TRACED] - c->of[TRACED] / 100);
    }
    for (unsigned n = 1; n < contender_count; n++) {
        const tested *t = &contenders[n];
        size_t sum[WHATS] = {0};
        for (int k = 0; k < AIM_COUNT * WHATS; k++) sum[k % WHATS] += t->count[k / WHATS].of[k % WHATS];
        printf("%-26s %9zu rays, %zu leaks, %zu phantoms, %zu other bits\n", t->on[0].name, sum[TRACED], sum[LEAKS],
               sum[PHANTOMS], sum[OTHER]);
        good &= sum[TRACED] > 0 || batches < 2 * t->every * (size_t)ROUND_BATCHES;
        good &= t->role != BLIND || (sum[LEAKS] == sum[PASS] && sum[PASS] > 0);
    }
    return good;
}

static bool write_lines(io_output *out, size_t batches, io_error *error) {
    static const char *const roles[] = {"reference", "same-bits", "own-rules"};
    json_t *run = run_record("stability", 0, -1);
    results_set_counts(run, "batches sample", (size_t[]){batches, sample});
    bool good = results_write(out, run, error);
    for (const tested *t = contenders; t->role != BLIND; t++)
        for (int kind = 0; good && kind < AIM_COUNT; kind++) {
            const counts *c = &t->count[kind];
            json_t *line = json_object(), *verdicts = json_object();
            results_set_texts(line, "kind contender role rays",
                              (const char *[]){"result", t->on[0].name, roles[t->role], aim_name((aim)kind)});
            results_set_counts(line, "traced hits other_bits pass leaks phantoms sampled", c->of);
            results_set_numbers(line, "residual apart t_error", (double[]){c->residual, c->apart, c->t_error});
            results_set_counts(verdicts, "right tie leak phantom wrong_surface", c->of + RIGHT);
            json_object_set_new(line, "verdicts", verdicts);
            good = results_write(out, line, error);
        }
    return good;
}

int main(int argc, char **argv) {
    const bool keeps = argc > 2;
    const char *by = getenv("CELLWALK_TEST_DIVIDE");
    const double millions = argc > 1 ? strtod(argv[1], NULL) : 0, divisor = by ? fmax(1, strtod(by, NULL)) : 1;
    const size_t batches = (size_t)(millions * 1e6 / divisor / BATCH_RAYS / ROUND_BATCHES + 1) * ROUND_BATCHES;
    io_error error = {{0}};
    io_output out = {0};
    if (millions < 1) {
        fputs("usage: cellwalk_stability MILLIONS [FILE]\n", stderr);
        return EXIT_FAILURE;
    }
    run_record_begin(argv + 1, argc - 1);
    others = keeps ? 16 : 8;
    sample = keeps ? 1024 : 512;
    bool good = io_output_open(&out, keeps ? argv[2] : "/dev/null", &error) && make_all(keeps, &error), means = false;
    if (good) {
        for (size_t n = 0; n < batches; n++) run_batch(n);
        means = print_sums(batches);
        good = write_lines(&out, batches, &error) && io_output_commit(&out, &error);
    }
    if (!good) fprintf(stderr, "cellwalk_stability: %s\n", error.text);
    printf("%zu faults%s\n", faults, means ? "" : "; too few rays or contenders for that to mean anything");
    return good && means && faults == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
