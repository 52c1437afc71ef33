/* SPDX-License-Identifier: Apache-2.0 */
#include "table.h"

#include <stdio.h>
#include <string.h>

/* The coursework's table, Embree with Phong normals to compare like with like, and what the library does by itself. */
static const char *const default_paths[] = {"default",       "default-phong",  "grid3d",
                                            "grid3d-phong",  "cell-phong",     "packet4-phong",
                                            "packet8-phong", "packet16-phong", "auto-phong"};

bool table_path_parse(const char *text, cw_leaf leaf, table_path *path, io_error *error) {
    static const char suffix[] = "-phong";
    const size_t length = strlen(text), cut = sizeof suffix - 1;
    *path = (table_path){.leaf = leaf, .phong = length > cut && strcmp(text + length - cut, suffix) == 0};
    char name[TABLE_NAME];
    if (length >= sizeof name) return io_fail(error, "--path %s: no such path", text);
    snprintf(name, sizeof name, "%.*s", (int)(path->phong ? length - cut : length), text);
    path->embree = strcmp(name, "default") == 0;
    const bool automatic = strcmp(name, "auto") == 0;
    if (!path->embree && !automatic) path->kernel = cw_kernel_find(name);
    if (!path->embree && !automatic && !cw_kernel_exists(path->kernel))
        return io_fail(error,
                       "--path %s: a path is default, auto or a kernel (see cellwalk info), and -phong after it for "
                       "Phong normals",
                       text);
    snprintf(path->name, sizeof path->name, "%s", text);
    snprintf(path->title, sizeof path->title, "%s%s",
             path->embree ? "Default"
             : automatic  ? "cellwalk"
                          : name,
             path->phong ? ", Phong" : "");
    return true;
}

static bool skip(json_t *skipped, const char *path, const char *why) {
    json_t *line = json_pack("{s:s, s:s, s:s}", "kind", "skipped", "path", path, "why", why);
    return line && json_array_append_new(skipped, line) == 0;
}

/* Why a path cannot run here; empty if it can. */
static void obstacle(const table_path *path, char *why, size_t size) {
    why[0] = '\0';
    if (path->embree && peer_embree_version() == NULL)
        snprintf(why, size, "built without Embree (Debian: libembree-dev), so there is no Default to compare with");
    if (path->kernel == NULL) return;
    const cw_kernel_info info = cw_kernel_describe(path->kernel);
    if (!info.available)
        snprintf(why, size, "needs %s, and this CPU or the limit set has %s", cw_isa_name(info.isa),
                 cw_isa_name(cw_isa_best()));
}

bool table_paths_choose(const table_options *o, table_path *paths, size_t *count, json_t *skipped, io_error *error) {
    const bool standard = o->paths.count == 0;
    const size_t wanted = standard ? sizeof default_paths / sizeof default_paths[0] : o->paths.count;
    *count = 0;
    for (size_t k = 0; k < wanted; k++) {
        const char *text = standard ? default_paths[k] : o->paths.items[k];
        if (*count == TABLE_PATHS_MAX) return io_fail(error, "--path: more than %d paths", TABLE_PATHS_MAX);
        table_path *path = &paths[*count];
        char why[160];
        if (!table_path_parse(text, o->leaf, path, error)) {
            /* A build without the SIMD kernels does not know them at all. */
            if (!standard) return false;
            snprintf(why, sizeof why, "this build has no such kernel");
        } else {
            obstacle(path, why, sizeof why);
        }
        if (why[0] == '\0')
            ++*count;
        else if (!skip(skipped, text, why))
            return io_fail(error, "out of memory");
    }
    return *count > 0 || io_fail(error, "none of the paths can run here");
}
