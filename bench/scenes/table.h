/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench table: the six scenes, each rendered along every path, timed against Embree ("Default") in one process.
 * Everything that is printed or saved is made from the JSON lines, so that no two of them can disagree. */
#ifndef CELLWALK_BENCH_SCENES_TABLE_H
#define CELLWALK_BENCH_SCENES_TABLE_H

#include "cellwalk.h"
#include "harness/options.h"
#include "peers/embree.h"

#include <jansson.h>

enum { TABLE_PATHS_MAX = 32, TABLE_NAME = 64 };

/* One way to render: whose rays, which normals. */
typedef struct table_path {
    char name[TABLE_NAME];      /* "packet8-phong", as --path takes it */
    char title[TABLE_NAME + 8]; /* "packet8, Phong", a column's head */
    bool embree;                /* else: */
    const cw_kernel *kernel;    /* NULL: the one that the library chooses */
    cw_leaf leaf;
    bool phong;
} table_path;

typedef struct table_options {
    option_list scenes, paths;
    const char *out, *scene_folder, *leaf_name, *isa_name;
    uint64_t samples, seed, cpu;
    double seconds, width;
    bool quick, no_pin;
    cw_leaf leaf;
    cw_isa isa;
} table_options;

/* ---- table_paths.c ---- */

/* Reads NAME or NAME-phong, NAME being default, auto or a kernel's name. */
bool table_path_parse(const char *text, cw_leaf leaf, table_path *path, io_error *error);
/* The paths that are asked for and can run here, in order; lines for those that cannot go to skipped (a JSON array). */
bool table_paths_choose(const table_options *options, table_path *paths, size_t *count, json_t *skipped,
                        io_error *error);

/* ---- table_scene.c ---- */

/* Renders one scene along all paths. A JSON object of kind "scene"; NULL with the reason in error. */
json_t *table_scene_run(const char *name, const char *file, const table_path *paths, size_t path_count,
                        const table_options *options, double seconds, io_error *error);

/* ---- table_text.c: from JSON lines to text ---- */

/* The page, or its first two tables if brief. NULL if out of memory. The caller frees it. */
char *table_markdown(const json_t *lines, bool brief);
char *table_csv(const json_t *lines);

/* What the coursework that the scenes come from reports: pbrt-v2 on a 2.7 GHz Core i7, 8 threads, seconds. plain is its
 * triangle mesh; the other two have Phong normals. */
typedef struct table_coursework {
    const char *scene;
    double plain, grid, grid_phong, cell_phong;
} table_coursework;
/* NULL if it has no such scene. */
const table_coursework *table_coursework_of(const char *scene);

int table_main(char **arguments, int count);

#endif
