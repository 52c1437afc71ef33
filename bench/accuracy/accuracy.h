/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench accuracy: speed against error, for every mode of accuracy, leaf test, walk and width, and for
 * Embree. The printed table is made from the saved JSON lines. */
#ifndef CELLWALK_BENCH_ACCURACY_ACCURACY_H
#define CELLWALK_BENCH_ACCURACY_ACCURACY_H

#include "accuracy/judge.h"
#include "harness/interleave.h"
#include "harness/run.h"
#include "peers/contender.h"
#include "peers/embree.h"
#include "workload/fields.h"
#include "workload/ray_classes.h"

#include <jansson.h>

enum { ACCURACY_MODES_MAX = 32, ACCURACY_ROWS_MAX = 192 };

typedef struct accuracy_options {
    run_options run;
    option_list modes, kernels, rays, fields; /* numbers: of modes, kernels, classes, fields */
    const char *out;
    unsigned count;
    double seconds, pass;
    bool longer;
} accuracy_options;

/* ---- modes.c: the modes that are measured ---- */

/* A new mode is a new row. Members left out have their default: the strict query on the field's own samples. */
typedef struct accuracy_mode {
    const char *name; /* "strict"; a contender is called NAME/KERNEL, or NAME/wWIDTH with Embree */
    const char *what; /* one line for a person */
    cw_leaf leaf;
    accuracy_claim (*change)(float *z, size_t count); /* changes the samples of the mode's own field, and says by how
                                                       * much at most */
    bool longer;                                      /* only with --long, or if asked for by name */
    bool embree, robust;                              /* Embree instead of a kernel */
    peer_geometry geometry;
} accuracy_mode;

/* NULL from the count on. */
const accuracy_mode *accuracy_mode_at(size_t number);

/* A mode on one field, with all that it needs. */
typedef struct accuracy_stage {
    const accuracy_mode *mode;
    cw_field *field; /* the given one, or: */
    cw_field *own;   /* made from: */
    float *z;
    accuracy_claim claim;
    peer_embree *peer;
} accuracy_stage;

/* base has the samples of surface; both must stay until the stage is closed. isa is the widest that Embree may use.
 * On failure the stage needs no closing. */
bool accuracy_stage_open(accuracy_stage *stage, const accuracy_mode *mode, cw_field *base, const true_surface *surface,
                         cw_isa isa, io_error *error);
void accuracy_stage_close(accuracy_stage *stage);

/* The mode's contender with a kernel, named as above. CW_ERROR_KERNEL where there is none. */
cw_status accuracy_stage_kernel(const accuracy_stage *stage, const cw_kernel *kernel, contender *c);

/* Rounds samples to 2^16 levels from the lowest to the highest; holes stay. The claim is half a step and the
 * rounding of the result to float. */
accuracy_claim accuracy_quantise(float *z, size_t count);

/* ---- errors.c ---- */

/* Errors of t in ULP and in cells, heights off the surface, angles of normals; errors of t relative to it, of u and
 * v, and of the point that cw_hit_points makes of a hit, in cells. */
enum { ACCURACY_ERROR_KINDS = 7 };

/* The figures of a mode's answers. */
typedef struct accuracy_errors {
    size_t rays, hits;
    /* Compared with the true surface: differences that only the mode's claim explains count as errors here, not as
     * ties. */
    size_t verdicts[ACCURACY_VERDICT_COUNT];
    size_t broken; /* of them, those beyond the claim */
    /* Of the right hits; none where only "any hit" was asked. */
    size_t right_hits;
    double median[ACCURACY_ERROR_KINDS], most[ACCURACY_ERROR_KINDS], worst[ACCURACY_ERROR_KINDS]; /* most: of 99.9 % */
} accuracy_errors;

/* The reference's answers to n rays, made once; degrees are measured with the Phong normals of field, which has the
 * surface's samples. */
typedef struct accuracy_truth {
    const true_surface *surface;
    const cw_field *field;
    const cw_ray *rays;
    size_t n;
    cw_hit *hits;                          /* the strict answer */
    exact_hit *exact;                      /* where hits[k] is one */
    double *scratch[ACCURACY_ERROR_KINDS]; /* n numbers each */
} accuracy_truth;

/* field must have been built for the kernel cell. To be freed in any case. */
cw_status accuracy_truth_make(accuracy_truth *truth, const true_surface *surface, const cw_field *field,
                              const cw_ray *rays, size_t n);
void accuracy_truth_free(accuracy_truth *truth);

/* Of answers to every (2^thin)-th run of 16 rays, as accuracy_thin picks them: of hits, or where these are NULL of
 * occluded. field: whose normals the answer has. */
accuracy_errors accuracy_errors_of(const accuracy_truth *truth, unsigned thin, const accuracy_claim *claim,
                                   const cw_field *field, contender_answers answers);

/* Between two unit vectors; from their difference, since the cosine of a small angle is 1. */
double accuracy_degrees(const double a[3], const double b[3]);

/* The number in the whole set of ray m of a thinned one. Runs of 16 stay together, so that packets do. */
size_t accuracy_thinned_at(size_t m, unsigned thin);
/* Copies the rays of those runs and returns how many they are; out may be NULL. */
size_t accuracy_thin(const cw_ray *rays, size_t n, unsigned thin, cw_ray *out);

/* ---- group.c ---- */

/* A field with its modes. */
typedef struct accuracy_field {
    workload_field samples;
    true_surface surface;
    cw_field *field;
    accuracy_stage stages[ACCURACY_MODES_MAX];
    size_t stage_count;
} accuracy_field;

bool accuracy_field_open(accuracy_field *on, const char *name, const accuracy_options *options, io_error *error);
void accuracy_field_close(accuracy_field *on);

/* One class of rays on one field: appends a line of kind "result" a contender. */
bool accuracy_group_run(const accuracy_field *on, workload_class c, const accuracy_options *options, double seconds,
                        json_t *lines, io_error *error);

/* True if the mode is to be measured. */
bool accuracy_mode_wanted(size_t number, const accuracy_options *options);

/* ---- normals.c: "barycentric Phong beats bilinear" ---- */

/* Normals interpolated between the vertices of the triangle hit, and between the four of its cell, held against
 * those of a smooth surface that is known by its formula. */
typedef enum accuracy_normal {
    ACCURACY_FACET,       /* the triangle's own */
    ACCURACY_BARYCENTRIC, /* as in cw_hit_phong_normals */
    ACCURACY_BILINEAR,    /* of the cell's four vertex normals */
    /* The same of vertex normals by central differences. */
    ACCURACY_CENTRAL_BARYCENTRIC,
    ACCURACY_CENTRAL_BILINEAR,
    ACCURACY_NORMAL_COUNT
} accuracy_normal;

/* Unit normal at a hit, in field space, of samples without holes. The vertex normals are those of cw_hit_phong_normal;
 * hits in the cells at the field's border are not to be asked for. */
void accuracy_normal_at(const true_surface *surface, const cw_hit *hit, accuracy_normal kind, double normal[3]);

/* Appends a line of kind "normal" for each of several waves, from steep and short to flat and long. */
void accuracy_normals_run(uint32_t seed, json_t *lines);

/* ---- print.c ---- */

/* One contender over all groups (a field and a class of rays) in which it ran. */
typedef struct accuracy_sums {
    const char *name;
    size_t groups;
    double speed;         /* geometric mean, millions of rays a second */
    double rates[3];      /* leaks, wrong and phantoms in a million rays: means over the classes that are not aimed */
    double aimed, beyond; /* all of these over the classes that are; those beyond the claim, over all */
    double off;           /* worst height off the surface, but for rays from afar, whose t is too coarse a float */
} accuracy_sums;
accuracy_sums accuracy_sums_of(const json_t *lines, const char *name);

/* A line a contender, fastest first. */
void accuracy_print(const json_t *lines);

#endif
