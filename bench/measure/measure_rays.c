/* SPDX-License-Identifier: Apache-2.0 */
/* FIELD/CLASS: the rays of a class on a field. */

#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"
#include "workload/ray_classes.h"

#include <string.h>

typedef struct group {
    land *land;
    bool any, coherent;
    cw_ray *rays;
    size_t n;
    contender reference;
    contender_answers expected, out;
} group;

typedef struct at {
    group *in;
    ray_contender c;
    cw_ray *scaled; /* of coarser land; else NULL */
    contender_pass pass;
} at;

/* WORKLOAD_NAMES: none. */
static workload_class class_of(const char *item) {
    int k = 0;
    while (k < WORKLOAD_NAMES && strcmp(workload_class_name((workload_class)k), item) != 0) k++;
    return (workload_class)k;
}

static bool has(const char *field, const char *item) {
    return strcmp(field, "scenes") != 0 && class_of(item) < WORKLOAD_NAMES;
}

static bool open_group(workload *w, io_error *error) {
    const workload_class c = class_of(w->item);
    const measure_options *o = w->options;
    group *g = w->own = memory(1, sizeof *g);
    g->land = land_of(w->field, o, w->why, error);
    if (g->land == NULL) return w->why[0] != '\0';
    g->any = workload_class_is_any(c);
    g->coherent = workload_class_is_coherent(c);
    g->rays = memory(o->count, sizeof *g->rays);
    g->n = workload_rays_make(g->land->field, c, o->run.seed, o->count, g->rays);
    if (g->n == 0) return io_fail(error, "%s: no rays", w->name);
    if (contender_from_kernel(&g->reference, g->land->field, cw_kernel_find("cell"), CW_LEAF_WATERTIGHT) != CW_OK)
        return io_fail(error, "%s: the reference kernel: %s", w->name, cw_last_error());
    for (int k = 0; k < 2; k++)
        *(k ? &g->out : &g->expected) = (contender_answers){memory(g->n, sizeof(cw_hit)), memory(g->n, 1)};
    contender_run(&(contender_pass){&g->reference, g->rays, g->n, g->any, g->expected});
    w->items = (double)g->n;
    return true;
}

static bool enter(workload *w, const char *name, io_error *error) {
    group *g = w->own;
    ray_contender found[WIDTHS_MAX];
    char why[192] = "";
    size_t count;
    if (!contenders_of(g->land, name, g->coherent, (cw_isa)w->options->run.isa, found, &count, why, error))
        return false;
    for (size_t k = 0; k < (count ? count : 1); k++) {
        entrant *e = measure_enter(w, name, count ? found[k].contender.name : name, error);
        if (e == NULL) return false;
        memcpy(e->why, why, sizeof why);
        if (count == 0) return true;
        at *a = e->own = memory(1, sizeof *a);
        *a = (at){.in = g, .c = found[k]};
        if (a->c.factor > 1) {
            /* t is the same on all levels. */
            a->scaled = memory(g->n, sizeof *a->scaled);
            for (size_t r = 0; r < g->n; r++) {
                a->scaled[r] = g->rays[r];
                for (int c = 0; c < 2; c++) {
                    a->scaled[r].org[c] /= (float)a->c.factor;
                    a->scaled[r].dir[c] /= (float)a->c.factor;
                }
            }
        }
        a->pass = (contender_pass){&a->c.contender, a->scaled ? a->scaled : g->rays, g->n, g->any, g->out};
        e->job = (interleave_job){.run = contender_run, .context = &a->pass, .by_clock = a->c.contender.threads > 1};
    }
    return true;
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    group *g = w->own;
    at *a = e->own;
    if ((metrics & METRIC_ERROR) && cw_field_describe(g->land->field).holes > 0)
        return io_fail(error, "%s: errors are judged on fields without holes only", w->name);
    if (metrics & METRIC_INSTRUCTIONS) {
        measure_counted(&a->pass);
        results_set_counts(e->line, "counted", &g->n);
    } else
        contender_run(&a->pass);
    results_set_counts(e->line, "width threads", (size_t[]){a->c.contender.width, a->c.contender.threads});
    if (a->c.contender.query.expert.kernel)
        json_object_set_new(e->line, "kernel",
                            json_string(cw_kernel_describe(a->c.contender.query.expert.kernel).name));
    if ((metrics & METRIC_AGREE) && a->c.factor == 1) {
        agreement sum = {0};
        if (g->any)
            agree_any(&sum, g->land->field, g->rays, g->n, g->expected.occluded, g->out.occluded, &g->reference,
                      &a->c.contender);
        else
            agree_closest(&sum, g->land->field, g->rays, g->n, g->expected.hits, g->out.hits);
        json_object_set_new(e->line, "agreement", results_agreement(&sum));
    }
    if ((metrics & METRIC_ERROR) && a->c.factor > 1 && !g->any)
        errors_of_choice(g->expected.hits, g->out.hits, g->n, e->line);
    else if (metrics & METRIC_ERROR)
        return errors_of_rays(g->land, &a->c.contender, g->rays, g->n, g->out, g->any, e->line, error);
    return true;
}

__attribute__((noinline)) void measure_counted(contender_pass *pass) { contender_run(pass); }

static void leave(entrant *e) {
    at *a = e->own;
    contenders_leave(&a->c);
    free(a->scaled);
    free(a);
}

static void close_group(workload *w) {
    group *g = w->own;
    for (int k = 0; k < 2; k++) {
        free((k ? g->out : g->expected).hits);
        free((k ? g->out : g->expected).occluded);
    }
    free(g->rays);
    free(g);
}

const workload_kind measure_rays = {
    "FIELD/CLASS", "rays: primary, shadow, ao, bounce, random, grazing, afar; beside, vertices, edges, within-2",
    "rays",        NULL,
    has,           contenders_know,
    open_group,    enter,
    judge,         leave,
    close_group};
