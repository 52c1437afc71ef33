/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk render`: a picture of a scene. */

#include "cancel.h"
#include "command.h"
#include "commands.h"
#include "image.h"
#include "json.h"
#include "options.h"
#include "progress.h"
#include "query_options.h"
#include "scene.h"

#include <stdlib.h>

static const char name[] = "render";

typedef struct render_command {
    query_options query;
    const char *output;
    unsigned samples;
    bool phong, stats, json;
} render_command;

static void warn(void *context, const char *message) {
    (void)context;
    fprintf(stderr, "cellwalk render: warning: %s\n", message);
}

/* Rays per second of the whole rendering, in millions. */
static double mrays(const scene_render_stats *s) {
    return (double)(s->camera_rays + s->shadow_rays + s->mirror_rays) / s->seconds * 1e-6;
}

static const char *kernel_name(scene *s, const cw_query *query) {
    const cw_field *field = scene_field_count(s) > 0 ? scene_field(s, 0) : NULL;
    return cw_kernel_describe(cw_query_kernel(field, query)).name;
}

static void print_stats(const scene_render_stats *s, const char *kernel) {
    printf("kernel        %s\n"
           "camera rays   %llu\nshadow rays   %llu\nmirror rays   %llu\nfield queries %llu\n"
           "build         %.3f s\nrender        %.3f s, %.1f Mrays/s\ntracing       %.3f s, added up over threads\n",
           kernel, (unsigned long long)s->camera_rays, (unsigned long long)s->shadow_rays,
           (unsigned long long)s->mirror_rays, (unsigned long long)s->field_queries, s->build_seconds, s->seconds,
           mrays(s), s->trace_seconds);
}

static void print_json(const scene_render_stats *s, const char *kernel, const char *path, const io_image *image) {
    fputs("{\"scene\": ", stdout);
    json_string(stdout, path);
    printf(", \"width\": %zu, \"height\": %zu, \"kernel\": \"%s\", \"camera_rays\": %llu, \"shadow_rays\": %llu, "
           "\"mirror_rays\": %llu, \"field_queries\": %llu",
           image->width, image->height, kernel, (unsigned long long)s->camera_rays, (unsigned long long)s->shadow_rays,
           (unsigned long long)s->mirror_rays, (unsigned long long)s->field_queries);
    const struct {
        const char *key;
        double value;
    } rest[] = {{"build_seconds", s->build_seconds},
                {"seconds", s->seconds},
                {"trace_seconds", s->trace_seconds},
                {"mrays_per_s", mrays(s)}};
    for (size_t k = 0; k < sizeof rest / sizeof rest[0]; k++) {
        printf(", \"%s\": ", rest[k].key);
        json_number(stdout, rest[k].value);
    }
    puts("}");
}

/* Renders and writes; the output file was opened before, so that no work is done in vain. */
static int render(const render_command *c, const char *path, scene *s, const cw_query *query, io_output *out) {
    progress p = progress_start("rendering");
    const scene_render_options options = {.query = *query,
                                          .threads = c->query.threads,
                                          .samples = c->samples,
                                          .phong = c->phong,
                                          .cancel = cancel_flag(),
                                          .progress = progress_update,
                                          .progress_context = &p};
    io_image image;
    io_error error;
    scene_render_stats stats;
    const bool rendered = scene_render(s, &options, &image, &stats, &error);
    progress_end(&p);
    if (!rendered) {
        io_output_discard(out);
        return command_fail(name, "%s", error.text);
    }
    bool good = io_image_put(out, &image, &error);
    if (good)
        good = io_output_commit(out, &error);
    else
        io_output_discard(out);
    if (good && c->stats) print_stats(&stats, kernel_name(s, query));
    if (good && c->json) print_json(&stats, kernel_name(s, query), path, &image);
    io_image_free(&image);
    return good ? EXIT_SUCCESS : command_fail(name, "%s", error.text);
}

static int load_and_render(const render_command *c, const char *path, const cw_query *query) {
    io_error error;
    scene *s = scene_load(path, warn, NULL, &error);
    if (s == NULL) return command_fail(name, "%s", error.text);
    io_output out;
    const int status = io_output_open(&out, c->output, &error) ? render(c, path, s, query, &out)
                                                               : command_fail(name, "%s", error.text);
    scene_free(s);
    return status;
}

static int run(int argc, char **argv) {
    render_command c = {.output = NULL};
    option_spec options[QUERY_OPTION_COUNT + 5];
    const option_spec own[] = {
        {.name = "output",
         .letter = 'o',
         .value = "IMAGE",
         .help = "the picture: .exr (half RGBA, linear), .png (8 bit, sRGB)\n"
                 "or .pfm (float, linear)",
         .kind = OPTION_TEXT,
         .to = &c.output},
        {.name = "samples",
         .value = "N",
         .help = "samples a pixel (default: what the scene says)",
         .kind = OPTION_COUNT,
         .to = &c.samples,
         .low = 1,
         .high = 65536},
        {.name = "phong", .help = "smooth height fields by Phong normals", .kind = OPTION_FLAG, .to = &c.phong},
        {.name = "stats", .help = "print numbers of rays and times", .kind = OPTION_FLAG, .to = &c.stats},
        {.name = "json", .help = "print the same as one JSON object", .kind = OPTION_FLAG, .to = &c.json}};
    for (size_t k = 0; k < 5; k++) options[k] = own[k];
    query_options_rows(&c.query, options + 5);
    static const char *const operands[] = {"SCENE.pbrt"};
    const options_usage usage = {
        .name = name,
        .synopsis = "SCENE.pbrt -o IMAGE [OPTIONS]",
        .what = "Renders a scene in the part of pbrt's scene language that height-field scenes\n"
                "need: shapes heightfield and cylinder, materials matte and mirror, image\n"
                "textures, point lights, a perspective camera. Anything else in the file is an\n"
                "error with its line, or a warning where it changes neither geometry nor light.\n",
        .examples = "  cellwalk render landsea-0.pbrt -o landsea-0.png\n"
                    "  cellwalk render landsea-0.pbrt -o smooth.exr --phong --samples 64 --stats\n",
        .options = options,
        .option_count = QUERY_OPTION_COUNT + 5,
        .operands = operands,
        .operand_least = 1,
        .operand_most = 1,
    };
    const char *path = NULL;
    const int status = options_parse(&usage, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    cw_query query;
    if (!query_options_resolve(&c.query, name, &query)) return EXIT_USAGE;
    io_error error;
    if (c.output == NULL || !io_image_can_write(c.output, &error)) {
        command_fail(name, "%s", c.output ? error.text : "no picture to write to: -o IMAGE is missing");
        return EXIT_USAGE;
    }
    return load_and_render(&c, path, &query);
}

const command command_render = {name, "a picture of a scene", run};
