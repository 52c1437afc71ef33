/* SPDX-License-Identifier: Apache-2.0 */
/* One class of rays on one field: everybody's errors, then everybody's speed. */

#include "accuracy/accuracy.h"
#include "clock.h"
#include "harness/memory.h"
#include "harness/results.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool accuracy_mode_wanted(size_t number, const accuracy_options *o) {
    return o->modes.count ? option_wanted(&o->modes, number) : o->longer || !accuracy_mode_at(number)->longer;
}

/* ---- a field ---- */

void accuracy_field_close(accuracy_field *on) {
    for (size_t s = 0; s < on->stage_count; s++) accuracy_stage_close(&on->stages[s]);
    cw_field_destroy(on->field);
    workload_field_free(&on->samples);
    *on = (accuracy_field){0};
}

bool accuracy_field_open(accuracy_field *on, const char *name, const accuracy_options *o, io_error *error) {
    *on = (accuracy_field){0};
    if (!workload_field_make(name, &on->samples)) return io_fail(error, "out of memory for field %s", name);
    on->surface = true_surface_of(on->samples.z, on->samples.nx, on->samples.ny);
    cw_status status = workload_field_open(&on->samples, CW_COPY, false, &on->field);
    if (status == CW_OK) status = cw_field_build(on->field, &(cw_run){.kernel = cw_kernel_find("cell")});
    bool good = status == CW_OK || io_fail(error, "field %s: %s", name, cw_last_error());
    for (size_t m = 0; good && accuracy_mode_at(m); m++) {
        const accuracy_mode *mode = accuracy_mode_at(m);
        if (!accuracy_mode_wanted(m, o) || on->stage_count == ACCURACY_MODES_MAX) continue;
        if (mode->embree && (peer_embree_version() == NULL ||
                             !run_memory_has(peer_embree_needs(on->field, mode->geometry), mode->name, name)))
            continue;
        good =
            accuracy_stage_open(&on->stages[on->stage_count], mode, on->field, &on->surface, (cw_isa)o->run.isa, error);
        on->stage_count += good;
    }
    if (!good) accuracy_field_close(on);
    return good;
}

/* ---- contenders ---- */

typedef struct row row;
struct row {
    const accuracy_stage *stage;
    contender contender;
    unsigned thin, thin_errors; /* of the rays that are timed, and of those whose errors are looked for */
    double left_out;            /* seconds for a pass over the thinnest set if too many, else 0 */
    accuracy_errors errors;
    const row *same_as; /* whose errors these are, because it gives the same bits; or NULL */
    contender_pass pass;
    interleave_job job;
};

enum { THIN_MAX = 6, RAYS_SPARE = 32 }; /* of a thinned set at most a run is more than its share */

typedef struct group {
    const accuracy_field *on;
    workload_class c;
    bool any;
    cw_ray *rays[THIN_MAX + 1]; /* thinned; NULL until asked for */
    size_t counts[THIN_MAX + 1];
    contender_answers answers, of_leader; /* and those of the row that others are held against */
    accuracy_truth truth;
    row *rows;
    size_t row_count;
} group;

/* A contender, if the mode has it here, becomes the next row. */
static bool add_row(group *g, const accuracy_stage *stage, const cw_kernel *kernel, unsigned width, io_error *error) {
    if (g->row_count == ACCURACY_ROWS_MAX) return io_fail(error, "more than %d contenders", ACCURACY_ROWS_MAX);
    row *r = &g->rows[g->row_count];
    cw_status status = CW_OK;
    if (kernel)
        status = accuracy_stage_kernel(stage, kernel, &r->contender);
    else
        contender_from_peer(&r->contender, stage->peer, width, workload_class_is_coherent(g->c), stage->mode->name);
    r->stage = stage;
    g->row_count += status == CW_OK;
    return status == CW_OK || status == CW_ERROR_KERNEL ||
           io_fail(error, "%s with %s on field %s: %s", stage->mode->name, cw_kernel_describe(kernel).name,
                   g->on->samples.name, cw_last_error());
}

static bool add_rows(group *g, const accuracy_options *o, io_error *error) {
    for (size_t s = 0; s < g->on->stage_count; s++) {
        const accuracy_stage *stage = &g->on->stages[s];
        for (size_t w = 0; stage->mode->embree && w < PEER_WIDTH_COUNT; w++)
            if (!add_row(g, stage, NULL, peer_embree_widths[w], error)) return false;
        for (size_t k = 0; !stage->mode->embree && k < cw_kernel_count(); k++)
            if (option_wanted(&o->kernels, k) && !add_row(g, stage, cw_kernel_at(k), 0, error)) return false;
    }
    return g->row_count > 0 || io_fail(error, "none of the given kernels has any of the given modes");
}

/* ---- passes ---- */

static contender_pass pass_of(const group *g, const row *r, unsigned thin, contender_answers out) {
    return (contender_pass){&r->contender, g->rays[thin], g->counts[thin], g->any, out};
}

/* The thinnest set that takes at most about this long, of those that take longer than the thinnest of all. */
static unsigned thin_for(double seconds, double limit) {
    unsigned thin = THIN_MAX;
    for (; thin > 0 && 2 * seconds <= limit; thin--) seconds *= 2;
    return thin;
}

/* The slow ones take fewer of the rays, so that a pass takes at most about limit seconds. Errors are rarer than
 * speed is uneven and need one pass alone, so they get more time. The first pass only warms up. */
static void choose_thin(const group *g, row *r, double limit) {
    enum { ERRORS_LONGER = 4 };
    contender_pass p = pass_of(g, r, THIN_MAX, g->answers);
    double seconds = 0;
    for (int repeat = 0; repeat < 2 && seconds <= limit; repeat++) {
        const double start = clock_cpu_seconds();
        contender_run(&p);
        seconds = clock_cpu_seconds() - start;
    }
    if (seconds > limit) r->left_out = seconds;
    r->thin = thin_for(seconds, limit);
    r->thin_errors = thin_for(seconds, limit * ERRORS_LONGER);
}

/* ---- errors ---- */

/* Lets the row answer the rays whose errors are looked for. */
static void answer(const group *g, const row *r, contender_answers out) {
    contender_pass p = pass_of(g, r, r->thin_errors, out);
    contender_run(&p);
}

static void judge(const group *g, row *r, contender_answers out) {
    const accuracy_stage *s = r->stage;
    if (g->any) out.hits = NULL;
    r->errors = accuracy_errors_of(&g->truth, r->thin_errors, &s->claim, s->field, out);
}

/* The answers that lie there for a thinned set are bit for bit those that the leader gave for the same rays. */
static bool same_as_leader(const group *g, const row *leader, const row *r) {
    if (r->thin_errors < leader->thin_errors) return false;
    for (size_t m = 0; m < g->counts[r->thin_errors]; m++) {
        const size_t of = accuracy_thinned_at(m, r->thin_errors - leader->thin_errors);
        if (g->any ? g->answers.occluded[m] != g->of_leader.occluded[of]
                   : memcmp(&g->answers.hits[m], &g->of_leader.hits[of], sizeof(cw_hit)) != 0)
            return false;
    }
    return true;
}

/* Of a mode's kernels the one that takes most rays is judged; and each other one that does not give the same bits. So
 * kernels that only walk differently have the same errors, however few rays the slow ones take. */
static void find_errors_of(group *g, const accuracy_stage *stage) {
    row *leader = NULL;
    for (row *r = g->rows; r < g->rows + g->row_count; r++)
        if (r->stage == stage && r->left_out == 0 && (leader == NULL || r->thin_errors <= leader->thin_errors))
            leader = r;
    if (leader == NULL) return;
    answer(g, leader, g->of_leader);
    judge(g, leader, g->of_leader);
    for (row *r = g->rows; r < g->rows + g->row_count; r++) {
        if (r->stage != stage || r == leader || r->left_out > 0) continue;
        answer(g, r, g->answers);
        if (same_as_leader(g, leader, r)) {
            r->errors = leader->errors;
            r->same_as = leader;
        } else {
            judge(g, r, g->answers);
        }
    }
}

/* ---- speed ---- */

static void time_all(group *g, const accuracy_options *o, double seconds) {
    interleave_job *jobs[ACCURACY_ROWS_MAX];
    size_t count = 0;
    for (row *r = g->rows; r < g->rows + g->row_count; r++) {
        r->pass = pass_of(g, r, r->thin, g->answers);
        r->job = (interleave_job){.run = contender_run, .context = &r->pass};
        if (r->left_out == 0) jobs[count++] = &r->job;
    }
    const interleave_limits limits = {
        .width = 0.02, .seconds = seconds, .least = 3, .most = INTERLEAVE_SAMPLES_MAX, .seed = o->run.seed};
    interleave(jobs, count, &limits);
}

/* ---- JSON ---- */

static void set_errors(json_t *line, const accuracy_errors *e) {
    const double million = e->rays ? 1e6 / (double)e->rays : 0;
    const size_t *v = e->verdicts;
    results_set_counts(line, "ray_count hits ties leaks phantoms wrong broken",
                       (size_t[]){e->rays, e->hits, v[ACCURACY_TIE], v[ACCURACY_LEAK], v[ACCURACY_PHANTOM],
                                  v[ACCURACY_WRONG], e->broken});
    results_set_numbers(line, "leaks_per_million phantoms_per_million wrong_per_million broken_per_million",
                        (double[]){(double)v[ACCURACY_LEAK] * million, (double)v[ACCURACY_PHANTOM] * million,
                                   (double)v[ACCURACY_WRONG] * million, (double)e->broken * million});
    if (e->right_hits == 0) return;
    results_set_count(line, "right_hits", e->right_hits);
    for (int k = 0; k < ACCURACY_ERROR_KINDS; k++) {
        static const char *const names[ACCURACY_ERROR_KINDS] = {"t_ulp",      "t_cells", "off_cells",  "normal_degrees",
                                                                "t_relative", "uv",      "point_cells"};
        char keys[80];
        snprintf(keys, sizeof keys, "%s_median %s_most %s_worst", names[k], names[k], names[k]);
        results_set_numbers(line, keys, (double[]){e->median[k], e->most[k], e->worst[k]});
    }
}

static json_t *row_line(const group *g, const row *r) {
    const char *name = r->contender.name;
    json_t *line = json_object();
    results_set_texts(line, "kind field rays query contender mode kernel",
                      (const char *[]){"result", g->on->samples.name, workload_class_name(g->c),
                                       g->any ? "any" : "closest", name, r->stage->mode->name, strchr(name, '/') + 1});
    results_set_count(line, "width", r->contender.width);
    if (r->left_out > 0) {
        results_set_number(line, "left_out_seconds", r->left_out);
        return line;
    }
    results_set_numbers(line, "claim_height", (double[]){r->stage->claim.height});
    set_errors(line, &r->errors);
    if (r->same_as) results_set_text(line, "same_bits_as", r->same_as->contender.name);
    if (g->c >= WORKLOAD_CLASS_COUNT) return line;
    results_set_seconds(line, &r->job.seconds);
    results_set_bool(line, "converged", r->job.converged);
    results_set_number(line, "mrays_per_s", (double)g->counts[r->thin] / r->job.seconds.median * 1e-6);
    return line;
}

/* ---- all together ---- */

static bool make_rays(group *g, const accuracy_options *o, io_error *error) {
    const size_t n = o->count;
    g->answers = answers_make(n);
    g->of_leader = answers_make(n);
    for (unsigned thin = 0; thin <= THIN_MAX; thin++)
        g->rays[thin] = memory((n >> thin) + RAYS_SPARE, sizeof *g->rays[thin]);
    g->counts[0] = workload_rays_make(g->on->field, g->c, o->run.seed, n, g->rays[0]);
    if (g->counts[0] == 0) return io_fail(error, "no rays on field %s", g->on->samples.name);
    for (unsigned thin = 1; thin <= THIN_MAX; thin++)
        g->counts[thin] = accuracy_thin(g->rays[0], g->counts[0], thin, g->rays[thin]);
    const cw_status status = accuracy_truth_make(&g->truth, &g->on->surface, g->on->field, g->rays[0], g->counts[0]);
    return status == CW_OK || io_fail(error, "the reference kernel cell: %s", cw_last_error());
}

bool accuracy_group_run(const accuracy_field *on, workload_class c, const accuracy_options *o, double seconds,
                        json_t *lines, io_error *error) {
    const double end = clock_seconds() + seconds;
    group g = {.on = on, .c = c, .any = workload_class_is_any(c)};
    g.rows = memory(ACCURACY_ROWS_MAX, sizeof *g.rows);
    const bool good = make_rays(&g, o, error) && add_rows(&g, o, error);
    if (good) {
        for (size_t k = 0; k < g.row_count; k++) choose_thin(&g, &g.rows[k], o->pass);
        for (size_t k = 0; k < on->stage_count; k++) find_errors_of(&g, &on->stages[k]);
        if (c < WORKLOAD_CLASS_COUNT) time_all(&g, o, fmax(0, end - clock_seconds()));
        for (size_t k = 0; k < g.row_count; k++) results_append(lines, row_line(&g, &g.rows[k]));
    }
    for (unsigned thin = 0; thin <= THIN_MAX; thin++) free(g.rays[thin]);
    answers_free(g.answers);
    answers_free(g.of_leader);
    accuracy_truth_free(&g.truth);
    free(g.rows);
    return good;
}
