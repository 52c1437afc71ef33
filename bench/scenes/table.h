/* SPDX-License-Identifier: Apache-2.0 */
/* The six scenes before contenders, and cellwalk-bench table: each rendered by every path, timed against Embree ("Default") in
 * one process. Everything that is printed or saved is made from the JSON lines, so that no two of them can disagree. */
#ifndef CELLWALK_BENCH_SCENES_TABLE_H
#define CELLWALK_BENCH_SCENES_TABLE_H

#include "harness/run.h"
#include "peers/contender.h"
#include "scene.h"

#include <jansson.h>

/* ---- tracer.c: rays of the scenes before a contender for each of their height fields, and how their pictures differ ---- */

/* "hftest" …; NULL from the count on. */
enum { SCENES = 6, SCENE_FIELDS_MAX = 16 };
const char *scene_names(size_t number);

/* folder/NAME.pbrt. NULL, with the reason in error, if it cannot be read or has more than SCENE_FIELDS_MAX fields. */
scene *scene_open(const char *folder, const char *name, io_error *error);

/* The tracer, and how many rays it was given. */
typedef struct field_tracer {
    contender on[SCENE_FIELDS_MAX];
    uint64_t rays;
} field_tracer;

/* The tracer for scene_render; on has a contender for each field. */
scene_tracer field_tracer_of(field_tracer *tracer);

/* How two pictures of equal size differ. */
typedef struct picture_difference {
    size_t pixels, differ; /* in any bit */
    size_t visible;        /* where an eye could see it: by more than half a step of 8-bit linear colour */
    double rmse, worst;    /* over all colour values, clamped to [0, 1] as on a screen */
    size_t worst_x, worst_y;
} picture_difference;
picture_difference picture_compare(const io_image *a, const io_image *b);

/* ---- the table ---- */

enum { TABLE_PATHS_MAX = 32, TABLE_NAME = 64 };

/* One way to render: whose rays, which normals. */
typedef struct table_path {
    char name[TABLE_NAME];       /* "packet8-phong", as --path takes it */
    char title[TABLE_NAME + 16]; /* "packet8, Phong", a column's head */
    bool embree;                 /* else: */
    const cw_kernel *kernel;     /* NULL: the one that the library chooses */
    scene_normals normals;
} table_path;

typedef struct table_options {
    run_options run;
    option_list scenes, paths;
    const char *out, *scene_folder;
    unsigned samples;
    double seconds, width;
    bool quick;
    int leaf; /* a cw_leaf */
} table_options;

/* ---- paths.c ---- */

/* Reads NAME or NAME-phong, -central or -bilinear, NAME being default, auto or a kernel's name. */
bool table_path_parse(const char *text, table_path *path, io_error *error);
/* The requested paths that can run here, in order; lines for those that cannot go to skipped (a JSON array). */
bool table_paths_choose(const table_options *options, table_path *paths, size_t *count, json_t *skipped,
                        io_error *error);

/* ---- render.c ---- */

/* Renders one scene by all paths. A JSON object of kind "scene"; NULL with the reason in error. */
json_t *table_scene_run(const char *name, const table_path *paths, size_t path_count, const table_options *options,
                        double seconds, io_error *error);

/* ---- text.c: from JSON lines to text, the same from the same ---- */

void table_write_markdown(FILE *to, const json_t *lines);
void table_write_csv(FILE *to, const json_t *lines);

#endif
