/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench measure: a plan is lines "workloads contenders metrics". Each workload is work that all its contenders
 * do; they are compared, then timed in turns. A new one is a workload_kind in a file and a row in plan_lines.c. */
#ifndef CELLWALK_BENCH_MEASURE_MEASURE_H
#define CELLWALK_BENCH_MEASURE_MEASURE_H

#include "harness/harness_run.h"
#include "harness/interleave.h"
#include "peers/peer.h"
#include "scene.h"
#include "workload/fields.h"

#include <jansson.h>

/* METRIC_AGREE: answers are compared with the reference's. METRIC_ERROR: they are held against the truth. METRIC_TIME:
 * contenders are timed, after the comparison. METRIC_INSTRUCTIONS: they run once, in measure_counted, for callgrind. */
enum { METRIC_AGREE = 1, METRIC_ERROR = 2, METRIC_TIME = 4, METRIC_INSTRUCTIONS = 8 };
enum { MEASURE_NAME = 256, ENTRANTS_MAX = 48, FACTOR_MAX = 64 };

typedef struct measure_options {
    run_options run;
    const char *out, *field, *scenes;
    unsigned count;                   /* rays of a pass */
    double seconds, width, cell_size; /* for all; of intervals; of a raster, 0: its own */
} measure_options;

/* A contender at one workload. */
typedef struct entrant {
    char name[MEASURE_NAME], group[MEASURE_NAME]; /* "embree:w8"; as the plan has it, "embree" */
    char why[192];                                /* it is left out; else empty */
    void *own;                                    /* the kind's */
    interleave_job job;
    json_t *line; /* of the result */
} entrant;

typedef struct workload workload;
typedef struct workload_kind {
    const char *form, *what, *unit; /* for the help: "FIELD/primary", …; what a pass counts: "rays" */
    const char *item;               /* that of the only work of the kind on fields; NULL: as has says */
    bool (*has)(const char *field, const char *item);
    /* Whether there is such a contender, wherever it can run; else the error. */
    bool (*knows)(const char *contender, io_error *error);
    /* own and items. Where memory is missing for it, why is set. */
    bool (*open)(workload *w, io_error *error);
    /* Adds one entrant or more by measure_enter, of which some may be left out. */
    bool (*enter)(workload *w, const char *contender, io_error *error);
    /* Lets the entrant work once and adds what was found to its line. */
    bool (*judge)(workload *w, entrant *e, unsigned metrics, io_error *error);
    void (*leave)(entrant *e);
    void (*close)(workload *w); /* NULL: nothing is left to do */
} workload_kind;

struct workload {
    const char *name, *field, *item; /* "257/primary", "257", "primary" */
    const workload_kind *kind;
    const measure_options *options;
    char why[192]; /* all of it is left out; else empty */
    double items;  /* of a pass */
    void *own;
    entrant *entrants;
    size_t count;
};

/* The next entrant; its name begins with the contender's in the plan. NULL with the error if there is no room. */
entrant *measure_enter(workload *w, const char *group, const char *name, io_error *error);

/* ---- plan_lines.c ---- */

extern const workload_kind measure_rays, measure_scene, measure_build, measure_horizon, measure_sky;
/* NULL from the count on. */
const workload_kind *measure_kind(size_t number);

/* A line of a plan, taken apart: one workload. */
typedef struct plan_line {
    char workload[MEASURE_NAME], field[MEASURE_NAME], item[MEASURE_NAME];
    const workload_kind *kind;
    char *contenders[ENTRANTS_MAX];
    size_t count;
    unsigned metrics;
    size_t number; /* of the line in the file; what stands in one was measured in turns */
    int isa;       /* a cw_isa; below 0: that of the run */
} plan_line;
typedef struct plan {
    plan_line *lines;
    size_t count;
    char *text;    /* that the lines point into */
    size_t number; /* of the line that was read last */
} plan;
/* From a file or, without one of that name, the plan of that name that ships. All that its lines name is looked for,
 * and the files that they will read are known as inputs. The error names file and line. */
bool measure_plan_read(plan *p, const char *name, const measure_options *options, io_error *error);
void measure_plan_free(plan *p);

/* ---- land.c: a field and what contenders make of it, kept while lines of a plan need it ---- */

typedef struct land {
    char name[MEASURE_NAME];
    workload_field samples; /* of land_of */
    cw_field *field;
    cw_field *coarser[FACTOR_MAX + 1];
    void *peers[PEER_KINDS][PEER_OPTIONS]; /* all up to one instruction set */
    cw_isa peers_isa;
    struct oracle *oracle; /* errors.c */
    bool borrowed;
} land;

/* The land of that name, a workload field or a raster's file; the same one until another is named. NULL with the error;
 * why is set where memory is missing. */
land *land_of(const char *name, const measure_options *options, char why[192], io_error *error);
void land_close(land *l);
/* Whether there is such land, of whose file only the header is read; else the error. */
bool land_check(const char *name, const measure_options *options, io_error *error);
/* Releases the last one of land_of. */
void land_end(void);
/* Each is made once. NULL with the error, or with why if memory is missing. */
cw_field *land_coarser(land *l, size_t factor, io_error *error);
const void *land_peer(land *l, size_t kind, cw_isa isa, unsigned options, char why[192], io_error *error);
/* True if a peer of that kind can be made; else why says what is missing. */
bool land_has_peer(const land *l, const peer_kind *kind, unsigned options, char why[192]);

/* ---- contenders.c: of rays, by name ---- */

/* A name taken apart: BASE:OPTION…, as the help has them. kind is PEER_KINDS if it is no peer. */
typedef struct contender_spec {
    char base[64];
    size_t kind;
    unsigned options; /* of the peer */
    unsigned width, threads, call;
    size_t factor;
    cw_leaf leaf;
    const cw_kernel *kernel;
} contender_spec;
bool contenders_parse(contender_spec *s, const char *name, io_error *error);
/* N from 1 to most, of a text that is KEY and N. */
bool contenders_number(const char *text, const char *key, unsigned most, unsigned *number);
bool contenders_know(const char *name, io_error *error);

/* Contenders of that name on the land: one, or one for each packet width of a peer. count is 0, with why, where it
 * cannot run here. False for an unknown name. */
enum { WIDTHS_MAX = PEER_WIDTHS };
typedef struct ray_contender {
    contender contender;
    size_t factor; /* of coarser land; else 1 */
    cw_pool *pool;
} ray_contender;
bool contenders_of(land *l, const char *name, bool coherent, cw_isa isa, ray_contender out[WIDTHS_MAX], size_t *count,
                   char why[192], io_error *error);
void contenders_leave(ray_contender *c);
/* contender_run under a name that callgrind finds. */
void measure_counted(contender_pass *pass);
extern const char contenders_help[];

/* ---- errors.c: answers to rays before the exact oracle ---- */

/* Adds what is wrong with the answers to rays on the land, and how far their t is off, to the line. */
bool errors_of_rays(land *l, const contender *of, const cw_ray *rays, size_t n, contender_answers answers, bool any,
                    json_t *line, io_error *error);
/* The same of a named choice, which is held against the strict hits. */
void errors_of_choice(const cw_hit *truth, const cw_hit *hits, size_t n, json_t *line);
void errors_forget(land *l);

/* Errors, none below 0: mean, root mean square, 99 %, worst, to the member name. Sorts them. */
void errors_set_spread(json_t *line, const char *name, double *errors, size_t count);

/* ---- measure_scene.c ---- */

const char *scene_names(size_t number);
/* Of the folder with all that it includes; NULL with the error. */
scene *scene_of(const char *name, const measure_options *options, io_error *error);

/* ---- print.c ---- */

void print_workload(const workload *w);
/* The scenes' table: a row a scene, a column a contender, seconds and their ratio to Embree's. */
void print_scenes(FILE *to, const json_t *lines);

#endif
