/* SPDX-License-Identifier: Apache-2.0 */
#include "stability/run.h"
#include "workload/fractal_terrain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- fields ------------------------------------------------------------------------------------------------------ */

/* Small, from smooth land to whole numbers and cliffs, planes that hardly rise and heights that are denormal. */
typedef enum shape { LAND, SEA, NOISE, INTEGERS, CLIFFS, SLOPE, SWELL, FLAT, GENTLE, FAINT } shape;

/* amount: the relief of land, the roughness of water. */
static const struct {
    const char *name, *text;
    size_t nx, ny;
    shape shape;
    float amount;
    uint32_t seed;
} fields[AIMED_FIELDS] = {
    {"fractal", "fractal land, 513 x 513, relief a tenth of the side", 513, 513, LAND, 0.1f, 5},
    {"noise", "uniform in [0, 1), 65 x 65", 65, 65, NOISE, 0, 1},
    {"integers", "whole numbers from -2 to 2, 64 x 33", 64, 33, INTEGERS, 0, 2},
    {"cliffs", "0 beside 10^6, 48 x 48", 48, 48, CLIFFS, 0, 0},
    {"slope", "one plane, exactly, 129 x 129", 129, 129, SLOPE, 0, 0},
    {"swell", "a slope of 0.3 with ripples of 10^-4, 257 x 257", 257, 257, SWELL, 0, 5},
    {"flat", "one height, 33 x 33", 33, 33, FLAT, 0, 0},
    {"sea", "waves, 200 x 200", 200, 200, SEA, 0.2f, 5},
    {"gentle", "a plane of slopes 5·10^-5 and 3·10^-5, 257 x 257", 257, 257, GENTLE, 0, 0},
    {"faint", "uniform in [0, 1) times 2^-136, 65 x 65", 65, 65, FAINT, 0, 6},
};

static double sample(shape kind, size_t i, size_t j, random_state *r) {
    const double x = random_unit(r);
    switch (kind) {
    case NOISE:
        return x;
    case INTEGERS:
        return floor(5 * x) - 2;
    case CLIFFS:
        return (i + j) / 2 % 2 ? 1e6 : 0;
    case SLOPE:
        return 3 * (double)i - 2 * (double)j;
    case SWELL:
        return 0.3 * (double)i + 0.1 * (double)j + 1e-4 * x;
    case GENTLE:
        return 5e-5 * (double)i + 3e-5 * (double)j;
    case FAINT:
        return ldexp(x, -136);
    default:
        return 0.375;
    }
}

static bool make_samples(size_t number, workload_field *field) {
    const size_t nx = fields[number].nx, ny = fields[number].ny;
    const shape kind = fields[number].shape;
    float *z = malloc(nx * ny * sizeof *z);
    random_state r = {fields[number].seed};
    *field = (workload_field){fields[number].name, fields[number].text, nx, ny, z};
    if (z && kind == LAND)
        terrain_fractal(z, nx, ny, fields[number].seed, fields[number].amount);
    else if (z && kind == SEA)
        terrain_sea(z, nx, ny, fields[number].seed, fields[number].amount);
    else
        for (size_t k = 0; z && k < nx * ny; k++) z[k] = (float)sample(kind, k % nx, k / nx, &r);
    return z != NULL;
}

static bool make_field(stability_field *f, size_t number) {
    workload_field *samples = &f->samples;
    if (!make_samples(number, samples) || workload_field_open(samples, &f->field) != CW_OK) return false;
    f->aimed = aimed_field_of(f->field);
    f->oracle = oracle_create(samples->z, samples->nx, samples->ny);
    return f->oracle != NULL;
}

/* ---- contenders -------------------------------------------------------------------------------------------------- */

static bool is_slow(const char *kernel) { return strncmp(kernel, "grid3d", 6) == 0; }

static bool add_kernels(stability *s, size_t f, const stability_shares *shares, unsigned *n) {
    for (int leaf = CW_LEAF_WATERTIGHT; leaf >= CW_LEAF_MOLLER_TRUMBORE; leaf--) {
        const cw_kernel *best = NULL; /* of those with the cell walk: by default, or with this leaf test */
        for (size_t k = cw_kernel_count(); k-- > 0;) { /* the default first */
            const cw_kernel *kernel = cw_kernel_at(k);
            const cw_kernel_info info = cw_kernel_describe(kernel);
            const bool watertight = leaf == CW_LEAF_WATERTIGHT;
            /* Brute force tests each triangle as grid3d does, and takes thousands of times as long on these fields. */
            if (!info.available || strcmp(info.name, "brute") == 0) continue;
            if (cw_run_check(NULL, &(cw_run){.expert.kernel = kernel, .expert.leaf = (cw_leaf)leaf}) != CW_OK) continue;
            if (best == NULL && !is_slow(info.name)) best = kernel;
            /* Kernels with the cell walk differ in no bit (lanes.c): one of them speaks for Möller-Trumbore. */
            if (!watertight && kernel != best && !is_slow(info.name)) continue;
            tested *t = &s->tested[f][*n];
            t->role = !watertight ? ROLE_OTHER_RULES : kernel == best ? ROLE_REFERENCE : ROLE_SAME_BITS;
            t->rays = is_slow(info.name) ? BATCH_RAYS / 8 : BATCH_RAYS;
            t->every = kernel == best && watertight ? 1 : is_slow(info.name) ? shares->slow : shares->others;
            t->turn = (unsigned)k;
            if (contender_from_kernel(&t->contender, s->field[f].field, kernel, (cw_leaf)leaf) != CW_OK) return false;
            (*n)++;
        }
    }
    return s->tested[f][0].role == ROLE_REFERENCE;
}

static bool add_peers(stability *s, size_t f, const stability_shares *shares, unsigned *n, io_error *error) {
    for (int robust = 0; robust < 2; robust++) {
        s->peers[f][robust] = peer_embree.create(s->field[f].field, cw_isa_best(), robust ? PEER_ROBUST : 0, error);
        if (s->peers[f][robust] == NULL) return false;
        for (unsigned width = 1; width <= 8; width += 7) {
            tested *t = &s->tested[f][(*n)++];
            peer_embree.enter(&t->contender, s->peers[f][robust], width, false);
            snprintf(t->contender.name, sizeof t->contender.name, "embree%s/w%u", robust ? "-robust" : "", width);
            t->role = ROLE_OTHER_RULES;
            t->every = shares->peers;
            t->turn = 2 * (unsigned)robust + width / 8;
            t->rays = BATCH_RAYS;
        }
    }
    return true;
}

bool stability_make(stability *s, stability_shares shares, unsigned sample, io_error *error) {
    *s = (stability){.sample = sample};
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        unsigned n = 0;
        if (!make_field(&s->field[f], f)) return io_fail(error, "out of memory");
        if (!add_kernels(s, f, &shares, &n)) return io_fail(error, "a kernel could not be prepared");
        if (shares.peers && !add_peers(s, f, &shares, &n, error)) return false;
        s->contenders = n;
    }
    return true;
}

void stability_free(stability *s) {
    for (size_t f = 0; f < AIMED_FIELDS; f++) {
        for (int robust = 0; robust < 2 && peer_embree.version; robust++) peer_embree.destroy(s->peers[f][robust]);
        cw_field_destroy(s->field[f].field);
        oracle_destroy(s->field[f].oracle);
        workload_field_free(&s->field[f].samples);
    }
}

/* ---- a batch ----------------------------------------------------------------------------------------------------- */

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

/* True if it passes; else nothing is known about a miss. */
static bool make_ray(aim kind, aim_start start, const stability_field *f, random_state *r, cw_ray *ray) {
    /* Rounding may spoil one; many of those that graze cannot be proved. */
    for (int tries = kind == AIM_GRAZING ? 1 : 8; tries > 0; tries--) {
        const aimed_ray a = aimed_ray_make(kind, start, &f->aimed, r);
        *ray = a.ray;
        if (passes(f->oracle, &a)) return true;
    }
    return false;
}

typedef struct batch {
    stability *s;
    const stability_field *field;
    aim kind;
    aim_start start;
    uint64_t number;
    bool passes[BATCH_RAYS];
    cw_ray rays[BATCH_RAYS];
    cw_hit reference[BATCH_RAYS], hits[BATCH_RAYS];
} batch;

static void explain(batch *b, const tested *t, size_t k, const cw_hit *hit, const char *what) {
    if (b->s->explained++ >= 8) return;
    printf("%s: %s, field %s, class %s, starting %s, batch %llu, ray %zu\n", t->contender.name, what,
           b->field->samples.name, aim_name(b->kind), aim_start_name(b->start), (unsigned long long)b->number, k);
    const cw_ray *r = &b->rays[k];
    printf("ray org {%a, %a, %a} dir {%a, %a, %a} t [%a, %a]\n", (double)r->org[0], (double)r->org[1],
           (double)r->org[2], (double)r->dir[0], (double)r->dir[1], (double)r->dir[2], (double)r->tmin,
           (double)r->tmax);
    printf("hit t %a u %a v %a cell (%d, %d) triangle %u\n", (double)hit->t, (double)hit->u, (double)hit->v,
           (int)hit->i, (int)hit->j, (unsigned)hit->triangle);
}

/* Faults that are found without the oracle: leaks of rays known to pass through the surface, and phantoms. */
static void check_all(batch *b, const tested *t, const cw_hit *hits, counts *c) {
    oracle *o = b->field->oracle;
    for (size_t k = 0; k < t->rays; k++) {
        const bool pass = b->passes[k];
        c->of[PASS] += pass;
        if (hits[k].i < 0) {
            if (!pass) continue;
            c->of[LEAKS]++;
            if (t->role == ROLE_REFERENCE) explain(b, t, k, &hits[k], "leak");
            continue;
        }
        c->of[HITS]++;
        oracle_ray(o, &b->rays[k]);
        const hit_check check = oracle_check(o, &hits[k]);
        if (check.holds) {
            c->residual = fmax(c->residual, check.residual);
            c->apart = fmax(c->apart, check.apart / check.apart_most);
            continue;
        }
        c->of[PHANTOMS]++;
        if (t->role == ROLE_REFERENCE) explain(b, t, k, &hits[k], "phantom");
    }
}

/* One ray in so many, in full. */
static void judge_sample(batch *b, const tested *t, const cw_hit *hits, counts *c) {
    oracle *o = b->field->oracle;
    for (size_t k = (size_t)(b->number % b->s->sample); k < t->rays; k += b->s->sample) {
        const oracle_truth *truth = oracle_trace(o, &b->rays[k]);
        const judgement j = oracle_judge(o, &hits[k]);
        c->of[SAMPLED]++;
        c->of[RIGHT + j.verdict]++;
        if (b->passes[k] && !truth->passes) {
            c->of[UNFOUNDED]++;
            explain(b, t, k, &hits[k], "no pass, although it was to be one");
        }
        if (j.verdict > VERDICT_TIE && t->role == ROLE_REFERENCE) explain(b, t, k, &hits[k], verdict_name(j.verdict));
        if (j.verdict != VERDICT_RIGHT || hits[k].i < 0) continue;
        if (isfinite(j.t_bound) && j.t_error > 0) c->t_error = fmax(c->t_error, j.t_error / j.t_bound);
    }
}

/* Closest hits, and any hit, against the reference's closest hits. */
static void compare(batch *b, const tested *t, const cw_hit *hits, counts *c) {
    static _Thread_local uint8_t occluded[BATCH_RAYS];
    t->contender.any(&t->contender, b->rays, t->rays, occluded);
    for (size_t k = 0; k < t->rays; k++) {
        const bool same =
            memcmp(&hits[k], &b->reference[k], sizeof hits[k]) == 0 && occluded[k] == (b->reference[k].i >= 0);
        if (same) continue;
        c->of[OTHER]++;
        explain(b, t, k, &hits[k], "not the reference's answer");
    }
}

void stability_batch(stability *s, uint64_t number) {
    static _Thread_local batch b;
    b.s = s;
    b.number = number;
    b.kind = (aim)(number % AIM_COUNT);
    const size_t f = number / AIM_COUNT % AIMED_FIELDS;
    const uint64_t round = number / ROUND_BATCHES;
    b.start = (aim_start)(round % START_COUNT);
    b.field = &s->field[f];
    random_state r = {number * 0x9e3779b97f4a7c15u};
    r.state = random_bits(&r); /* so that neighbours do not share numbers */
    for (size_t k = 0; k < BATCH_RAYS; k++) b.passes[k] = make_ray(b.kind, b.start, b.field, &r, &b.rays[k]);
    for (unsigned n = 0; n < s->contenders; n++) {
        const tested *t = &s->tested[f][n];
        if (round % t->every != t->turn % t->every) continue;
        /* Embree requires tmin >= 0, and aborts where it is compiled with assertions. */
        if (t->contender.peer != NULL && b.start == START_BEHIND) continue;
        counts *c = &s->count[n][b.kind][b.start];
        cw_hit *hits = t->role == ROLE_REFERENCE ? b.reference : b.hits;
        t->contender.closest(&t->contender, b.rays, t->rays, hits);
        c->of[RAYS] += t->rays;
        if (t->role != ROLE_OTHER_RULES) compare(&b, t, hits, c);
        if (t->role == ROLE_SAME_BITS) {
            for (size_t k = 0; k < t->rays; k++) c->of[HITS] += hits[k].i >= 0;
            continue;
        }
        check_all(&b, t, hits, c);
        judge_sample(&b, t, hits, c);
    }
}

counts stability_sum(const stability *s, unsigned which, aim kind) {
    counts sum = {.residual = 0};
    for (aim k = 0; k < AIM_COUNT; k++)
        for (int start = 0; start < START_COUNT && (k == kind || kind == AIM_COUNT); start++) {
            const counts *c = &s->count[which][k][start];
            for (int w = 0; w < WHATS; w++) sum.of[w] += c->of[w];
            sum.residual = fmax(sum.residual, c->residual);
            sum.apart = fmax(sum.apart, c->apart);
            sum.t_error = fmax(sum.t_error, c->t_error);
        }
    return sum;
}

size_t stability_faults(const stability *s) {
    size_t faults = 0;
    for (unsigned n = 0; n < s->contenders; n++) {
        const counts c = stability_sum(s, n, AIM_COUNT);
        faults += c.of[OTHER] + c.of[UNFOUNDED];
        if (s->tested[0][n].role == ROLE_REFERENCE)
            faults += c.of[LEAKS] + c.of[PHANTOMS] + c.of[RIGHT + VERDICT_LEAK] + c.of[RIGHT + VERDICT_PHANTOM] +
                      c.of[RIGHT + VERDICT_WRONG_SURFACE] + (c.t_error > 1);
    }
    return faults;
}
