/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk info`: this machine's kernels, and the contents and cost of a field. */

#include "cellwalk_expert.h"
#include "clock.h"
#include "command.h"
#include "commands.h"
#include "cpus.h"
#include "field_file.h"
#include "info_place.h"
#include "json.h"
#include "parts.h"
#include "proc.h"
#include "query_options.h"
#include "raster_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct machine {
    char cpu[128];
    unsigned cpus; /* that this process may use */
} machine;

static machine look_at_machine(void) {
    machine m = {.cpus = cpus_usable()};
    proc_value("/proc/cpuinfo", "model name", m.cpu, sizeof m.cpu);
    return m;
}

static void print_kernels(const cw_kernel *chosen) {
    printf("\n    %-14s %5s  %-8s %-16s %s\n", "kernel", "width", "needs", "leaf test", "description");
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        const char *mark = cw_kernel_at(k) == chosen ? "*" : info.available ? " " : "-";
        printf("  %s %-14s %5u  %-8s %-16s %s\n", mark, info.name, info.width, cw_isa_name(info.isa),
               cw_leaf_name(info.default_leaf), info.what);
    }
    puts("  (* chosen, - not available here)");
}

static void print_kernels_json(const cw_kernel *chosen) {
    fputs("\"kernels\": [", stdout);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        fputs(k ? ", {\"name\": " : "{\"name\": ", stdout);
        json_string(stdout, info.name);
        printf(", \"width\": %u, \"isa\": \"%s\", \"leaf\": \"%s\", \"available\": %s, \"chosen\": %s, \"what\": ",
               info.width, cw_isa_name(info.isa), cw_leaf_name(info.default_leaf), info.available ? "true" : "false",
               cw_kernel_at(k) == chosen ? "true" : "false");
        json_string(stdout, info.what);
        fputs("}", stdout);
    }
    fputs("]", stdout);
}

/* One line with the parts found, one with those missing. */
static void print_parts(void) {
    for (int there = 1; there >= 0; there--) {
        const char *before = there ? "libraries       " : "not there       ";
        for (size_t k = 0; k < IO_PARTS; k++) {
            const io_part part = io_part_at(k);
            if (part.there != (there == 1)) continue;
            printf("%s%s (%s)", before, part.name, part.for_what);
            before = ", ";
        }
        if (before[0] == ',') putchar('\n');
    }
}

static void print_parts_json(void) {
    fputs("\"libraries\": {", stdout);
    for (size_t k = 0; k < IO_PARTS; k++) {
        const io_part part = io_part_at(k);
        printf("%s\"%s\": %s", k ? ", " : "", part.name, part.there ? "true" : "false");
    }
    fputs("}, ", stdout);
}

static void print_machine(const machine *m) {
    printf("cellwalk        %s\nCPU             ", CW_VERSION);
    print_text(stdout, m->cpu);
    printf(", %u to use\ninstruction set %s", m->cpus, cw_isa_name(cw_isa_best()));
    const char *limit = getenv("CELLWALK_ISA");
    if (limit) fputs(" (CELLWALK_ISA=", stdout);
    print_text(stdout, limit ? limit : "");
    puts(limit ? ")" : "");
}

static void print_machine_json(const machine *m) {
    printf("{\"version\": \"%s\", \"cpu\": ", CW_VERSION);
    json_string(stdout, m->cpu);
    printf(", \"cpus\": %u, \"isa\": \"%s\", ", m->cpus, cw_isa_name(cw_isa_best()));
}

typedef struct survey {
    field_file file;
    cw_field_info info;
    double read_seconds; /* from the file's name to the field, without building */
} survey;

static bool look_at_field(const char *path, const io_raster_options *options, const coarser_options *coarser,
                          const cw_run *query, survey *s, io_error *error) {
    const double start = clock_seconds();
    if (!field_file_open(&s->file, path, options, coarser, query, error)) return false;
    s->info = cw_field_describe(s->file.field);
    s->read_seconds = clock_seconds() - start - cw_field_build_seconds(s->file.field);
    return true;
}

static double sample_bytes(const cw_field_info *info) { return (double)info->nx * (double)info->ny * sizeof(float); }

/* Samples and structures built on them, whether the samples are copied or borrowed. */
static double bytes_per_cell(const cw_field_info *info) {
    return (sample_bytes(info) + (double)info->bytes_built) / ((double)(info->nx - 1) * (double)(info->ny - 1));
}

/* Facts on the terrain first, then the cost of the field. */
static void print_field(const char *path, const survey *s) {
    const cw_field_info *f = &s->info;
    const io_raster *r = &s->file.raster;
    char unit[40];
    print_text(stdout, path);
    putchar('\n');
    if (r->z) info_print_place(r);
    if (f->low <= f->high)
        printf("  heights       %.9g to %.9g%s\n", (double)f->low, (double)f->high, info_height_unit(r, unit));
    else
        puts("  heights       none");
    printf("  holes         %zu", f->holes);
    if (r->georef.has_nodata) printf(" (no data: %.9g)", r->georef.nodata);
    if (r->georef.scale != 0)
        printf("\n  stored        heights are %.9g + %.9g x the file's numbers", r->georef.offset, r->georef.scale);
    printf("\n  samples       %zu x %zu (%zu x %zu cells)\n", f->nx, f->ny, f->nx - 1, f->ny - 1);
    printf("  memory        %.0f bytes of samples, %zu bytes built: %.2f bytes a cell\n", sample_bytes(f),
           f->bytes_built, bytes_per_cell(f));
    printf("  read          %.6f s\n", s->read_seconds);
    printf("  built         %.6f s, for kernel %s\n", cw_field_build_seconds(s->file.field),
           cw_kernel_describe(s->file.kernel).name);
    puts("  user space    rows of the map from (x, y, z, 1):");
    for (int k = 0; k < 3; k++)
        printf("                %.17g %.17g %.17g %.17g\n", s->file.map[k][0], s->file.map[k][1], s->file.map[k][2],
               s->file.map[k][3]);
}

static void print_field_json(const char *path, const survey *s) {
    const cw_field_info *f = &s->info;
    const bool some = f->low <= f->high;
    fputs(", \"field\": {\"path\": ", stdout);
    json_string(stdout, path);
    printf(", \"nx\": %zu, \"ny\": %zu, \"low\": ", f->nx, f->ny);
    json_number(stdout, some ? (double)f->low : NAN);
    fputs(", \"high\": ", stdout);
    json_number(stdout, some ? (double)f->high : NAN);
    printf(", \"holes\": %zu, \"bytes_samples\": %.0f, \"bytes_built\": %zu, \"bytes_per_cell\": ", f->holes,
           sample_bytes(f), f->bytes_built);
    json_number(stdout, bytes_per_cell(f));
    fputs(", \"read_seconds\": ", stdout);
    json_number(stdout, s->read_seconds);
    fputs(", \"build_seconds\": ", stdout);
    json_number(stdout, cw_field_build_seconds(s->file.field));
    if (s->file.raster.z) info_print_place_json(&s->file.raster);
    const io_georef *g = &s->file.raster.georef;
    if (g->scale != 0) printf(", \"scale\": %.17g, \"offset\": %.17g", g->scale, g->offset);
    fputs(", \"map\": [", stdout);
    for (int k = 0; k < 3; k++)
        printf("%s[%.17g, %.17g, %.17g, %.17g]", k ? ", " : "", s->file.map[k][0], s->file.map[k][1], s->file.map[k][2],
               s->file.map[k][3]);
    fputs("]}", stdout);
}

static int show(const char *path, raster_options *raster, const cw_run *query, bool json) {
    survey s = {.read_seconds = 0};
    io_error error = {""};
    io_raster_options options;
    if (!raster_options_resolve(raster, "info", &options)) return EXIT_USAGE;
    const bool good = path == NULL || look_at_field(path, &options, &raster->coarser, query, &s, &error);
    progress_end(&raster->line);
    if (!good) return command_fail("info", "%s", error.text);
    const machine m = look_at_machine();
    const cw_kernel *chosen = path ? s.file.kernel : cw_run_kernel(NULL, query);
    if (json) {
        print_machine_json(&m);
        print_parts_json();
        print_kernels_json(chosen);
        if (path) print_field_json(path, &s);
        puts("}");
    } else {
        if (path) {
            print_field(path, &s);
        } else {
            print_machine(&m);
            print_parts();
            print_kernels(chosen);
        }
    }
    field_file_close(&s.file);
    return EXIT_SUCCESS;
}

static int run(int argc, char **argv) {
    query_options q = {0};
    bool json = false;
    raster_options raster;
    enum { OWN = 1, SHARED = OWN + QUERY_OPTION_COUNT, ALL = SHARED + RASTER_OPTION_COUNT };
    option_spec options[ALL] = {option_flag("json", &json, "print one JSON object")};
    query_options_rows(&q, options + OWN);
    raster_options_rows(&raster, options + SHARED);
    static const char *const operand_names[] = {"FIELD"};
    const options_usage usage = {
        .name = "info",
        .synopsis = "[FIELD] [OPTIONS]",
        .what = "Prints the contents and the cost of a height field, or without FIELD the kernels that this machine "
                "can run.\n\n"
                "With FIELD: its extent, cell size, coordinate system, heights and holes, then its size, its memory in "
                "bytes, and the seconds of reading it and of building the structure of the chosen kernel. Without "
                "FIELD: the CPU, its instruction set as far as the system supports it, the optional libraries found, "
                "and the kernels (ways to find hits) with the chosen one.\n\n" FIELD_FILE_HELP,
        .examples = "  cellwalk info\n"
                    "  cellwalk info dem.tif\n"
                    "  cellwalk info --isa sse4.2        # the kernel chosen without AVX2\n"
                    "  cellwalk info terrain.npy --kernel grid3d --json\n",
        .options = options,
        .option_count = ALL,
        .operands = operand_names,
        .operand_most = 1,
    };
    const char *path;
    const int status = options_parse(&usage, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    cw_run query;
    if (!query_options_resolve(&q, usage.name, &query)) return EXIT_USAGE;
    return show(path, &raster, &query, json);
}

const command command_info = {"info", "print a field's contents and cost, or this machine's kernels", run};
