/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/results.h"
#include "peers/embree.h"
#include "scenes/table.h"

#include <stdio.h>
#include <string.h>

/* The coursework's table, all with Phong normals to compare like with like, and the library's default. */
static const char *const default_paths[] = {"default-phong", "grid3d-phong",   "cell-phong", "packet4-phong",
                                            "packet8-phong", "packet16-phong", "auto-phong"};

/* Endings of names, and of titles. */
static const struct {
    const char *ending, *title;
    scene_normals normals;
} phong[] = {{"-phong", ", Phong", SCENE_NORMALS_AREA},
             {"-central", ", central", SCENE_NORMALS_CENTRAL},
             {"-bilinear", ", bilinear", SCENE_NORMALS_BILINEAR}};

bool table_path_parse(const char *text, table_path *path, io_error *error) {
    const char *const end = strrchr(text, '-');
    const char *title = "";
    size_t length = strlen(text);
    *path = (table_path){.normals = SCENE_NORMALS_FLAT};
    for (size_t k = 0; end != NULL && k < sizeof phong / sizeof phong[0]; k++) {
        if (strcmp(end, phong[k].ending) != 0) continue;
        path->normals = phong[k].normals;
        title = phong[k].title;
        length = (size_t)(end - text);
    }
    char name[TABLE_NAME];
    snprintf(path->name, sizeof path->name, "%s", text);
    snprintf(name, sizeof name, "%.*s", (int)length, text);
    path->embree = strcmp(name, "default") == 0;
    const bool automatic = strcmp(name, "auto") == 0;
    if (!path->embree && !automatic) path->kernel = cw_kernel_find(name);
    if (!path->embree && !automatic && !cw_kernel_exists(path->kernel))
        return io_fail(error,
                       "--path %s: a path is default, auto or a kernel (see cellwalk info), and -phong, -central or "
                       "-bilinear after it for Phong normals",
                       text);
    snprintf(path->title, sizeof path->title, "%s%s", path->embree ? "Default" : automatic ? "cellwalk" : name, title);
    return true;
}

/* Why a path cannot run here; empty if it can. */
static void obstacle(const table_path *path, char why[160]) {
    why[0] = '\0';
    if (path->embree && peer_embree_version() == NULL)
        snprintf(why, 160, "built without Embree (Debian: libembree-dev), so there is no Default to compare with");
    if (path->kernel && !cw_kernel_describe(path->kernel).available)
        snprintf(why, 160, "needs %s, and this CPU or the limit set has %s",
                 cw_isa_name(cw_kernel_describe(path->kernel).isa), cw_isa_name(cw_isa_best()));
}

bool table_paths_choose(const table_options *o, table_path *paths, size_t *count, json_t *skipped, io_error *error) {
    const bool standard = o->paths.count == 0;
    const char *const *texts = standard ? default_paths : o->paths.item;
    const size_t wanted = standard ? sizeof default_paths / sizeof default_paths[0] : o->paths.count;
    *count = 0;
    for (size_t k = 0; k < wanted; k++) {
        char why[160] = "this build has no such kernel"; /* without the SIMD kernels */
        if (*count == TABLE_PATHS_MAX) return io_fail(error, "--path: more than %d paths", TABLE_PATHS_MAX);
        const bool known = table_path_parse(texts[k], &paths[*count], error);
        if (!known && !standard) return false;
        if (known) obstacle(&paths[*count], why);
        *count += why[0] == '\0';
        if (why[0])
            results_append(skipped, json_pack("{s:s, s:s, s:s}", "kind", "skipped", "path", texts[k], "why", why));
    }
    return *count > 0 || io_fail(error, "none of the paths can run here");
}
