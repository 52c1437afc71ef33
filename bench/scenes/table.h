/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench table: the six scenes, each rendered along every path, timed against Embree ("Default") in one process.
 * Everything that is printed or saved is made from the JSON lines, so that no two of them can disagree. */
#ifndef CELLWALK_BENCH_SCENES_TABLE_H
#define CELLWALK_BENCH_SCENES_TABLE_H

#include "harness/run.h"

#include <jansson.h>

enum { TABLE_PATHS_MAX = 32, TABLE_NAME = 64 };

/* One way to render: whose rays, which normals. */
typedef struct table_path {
    char name[TABLE_NAME];      /* "packet8-phong", as --path takes it */
    char title[TABLE_NAME + 8]; /* "packet8, Phong", a column's head */
    bool embree;                /* else: */
    const cw_kernel *kernel;    /* NULL: the one that the library chooses */
    bool phong;
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

/* Reads NAME or NAME-phong, NAME being default, auto or a kernel's name. */
bool table_path_parse(const char *text, table_path *path, io_error *error);
/* The paths that are asked for and can run here, in order; lines for those that cannot go to skipped (a JSON array). */
bool table_paths_choose(const table_options *options, table_path *paths, size_t *count, json_t *skipped,
                        io_error *error);

/* ---- render.c ---- */

/* Renders one scene along all paths. A JSON object of kind "scene"; NULL with the reason in error. */
json_t *table_scene_run(const char *name, const table_path *paths, size_t path_count, const table_options *options,
                        double seconds, io_error *error);

/* ---- text.c: from JSON lines to text, the same from the same ---- */

void table_write_markdown(FILE *to, const json_t *lines);
void table_write_csv(FILE *to, const json_t *lines);

#endif
