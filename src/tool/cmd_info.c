/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk info`: this machine's kernels, and the contents and cost of a field. */

#include "cellwalk_expert.h"
#include "command.h"
#include "cpus.h"
#include "field_options.h"
#include "json.h"
#include "proc.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void print_kernels(const cw_kernel *chosen, bool json) {
    if (json)
        json_print(stdout, "'kernels': [");
    else
        printf("\n    %-14s %5s  %-8s %-16s %s\n", "kernel", "width", "needs", "leaf test", "description");
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        const bool is_chosen = cw_kernel_at(k) == chosen;
        const char *isa = cw_isa_name(info.isa), *leaf = cw_leaf_name(info.default_leaf);
        if (json && k) fputs(", ", stdout);
        if (json)
            json_print(stdout,
                       "{'name': %s, 'width': %u, 'isa': %s, 'leaf': %s, 'available': %b, 'chosen': %b, 'what': %s}",
                       info.name, (size_t)info.width, isa, leaf, info.available, is_chosen, info.what);
        else
            printf("  %s %-14s %5u  %-8s %-16s %s\n",
                   is_chosen        ? "*"
                   : info.available ? " "
                                    : "-",
                   info.name, info.width, isa, leaf, info.what);
    }
    fputs(json ? "]" : "  (* chosen, - not available here)\n", stdout);
}

static void print_machine(bool json) {
    char cpu[128] = "";
    const char *isa = cw_isa_name(cw_isa_best()), *limit = getenv("CELLWALK_ISA");
    proc_cpu(cpu, sizeof cpu);
    if (json) {
        json_print(stdout, "{'version': %s, 'cpu': %s, 'cpus': %u, 'isa': %s, ", CW_VERSION, cpu, (size_t)cpus_usable(),
                   isa);
        return;
    }
    printf("cellwalk        %s\nCPU             ", CW_VERSION);
    print_text(stdout, cpu);
    printf(", %u to use\ninstruction set %s%s", cpus_usable(), isa, limit ? " (CELLWALK_ISA=" : "");
    print_text(stdout, limit ? limit : "");
    puts(limit ? ")" : "");
}

typedef struct survey {
    raster_field file;
    cw_field_info info;
    const cw_kernel *kernel; /* NULL: only the header was read, so no structures are built */
    bool header;             /* samples are not read: there are many, and nobody asked for them */
} survey;

/* Size, map and place alone of a raster of many samples. */
static bool look_at_header(const char *path, const io_raster_options *options, survey *s, io_error *error) {
    const size_t many = (size_t)1 << 26;
    io_raster_options o = *options;
    io_raster *r = &s->file.raster;
    o.no_samples = true;
    o.progress = NULL;
    o.warn.call = NULL; /* until it is known that samples are not read, whose reading warns of the header too */
    if (!io_raster_read(path, &o, r, error)) return false;
    s->header = r->nx > many / r->ny;
    s->info = (cw_field_info){.nx = r->nx, .ny = r->ny};
    if (s->header) o.warn = options->warn;
    io_raster_free(r);
    return !s->header || io_raster_read(path, &o, r, error);
}

static double sample_bytes(const cw_field_info *info) { return (double)info->nx * (double)info->ny * sizeof(float); }

/* Samples and structures built on them, whether the samples are copied or borrowed. */
static double bytes_per_cell(const cw_field_info *info) {
    return (sample_bytes(info) + (double)info->bytes_built) / ((double)(info->nx - 1) * (double)(info->ny - 1));
}

/* The unit's name with a blank before it. */
static const char *unit_name(double metres, char text[IO_UNIT_NAME]) {
    text[0] = ' ';
    io_unit_name(metres, text + 1);
    return text[1] == '\0' ? text + 1 : text;
}

static const char *height_unit(const io_raster *r, char *text) {
    const io_georef *g = &r->georef;
    const bool metres = g->geographic || (g->unit == 0 && g->height_unit > 0); /* the map's heights */
    const double map = metres ? 1 : g->unit;
    return unit_name(g->placed ? r->map[2][2] * map : 0, text);
}

typedef struct place {
    double low[2], high[2], cell[2]; /* the least and the greatest X and Y of samples; how far apart they are */
    char crs[128];
} place;

static place find_place(const io_raster *r) {
    place p;
    for (int c = 0; c < 2; c++) {
        const double across = r->map[c][0] * ((double)r->nx - 1), down = r->map[c][1] * ((double)r->ny - 1);
        p.low[c] = fmin(across, 0) + fmin(down, 0) + r->map[c][3];
        p.high[c] = fmax(across, 0) + fmax(down, 0) + r->map[c][3];
        p.cell[c] = hypot(r->map[0][c], r->map[1][c]);
    }
    io_georef_name(&r->georef, p.crs, sizeof p.crs);
    return p;
}

static void print_place(const io_raster *r) {
    const io_georef *g = &r->georef;
    const place p = find_place(r);
    char unit[IO_UNIT_NAME];
    if (!g->placed) {
        puts("  extent        no map: terrain commands take cells for 1 wide and row 0 for the\n"
             "                northernmost");
        return;
    }
    printf("  extent        X %.10g to %.10g, Y %.10g to %.10g (pixels' centres)\n", p.low[0], p.high[0], p.low[1],
           p.high[1]);
    printf("  cell size     %.9g x %.9g%s\n", p.cell[0], p.cell[1],
           g->geographic ? " degrees" : unit_name(g->unit, unit));
    fputs("  coordinates   ", stdout);
    print_text(stdout, p.crs[0] != '\0' ? p.crs : "no coordinate system");
    putchar('\n');
}

/* Facts on the terrain first, then the cost of the field. */
static void print_field(const char *path, const survey *s) {
    const cw_field_info *f = &s->info;
    const io_raster *r = &s->file.raster;
    char unit[40];
    print_text(stdout, path);
    putchar('\n');
    print_place(r);
    if (s->header)
        puts("  heights       not read, as there are many: --samples reads them");
    else if (f->low <= f->high)
        printf("  heights       %.9g to %.9g%s\n", (double)f->low, (double)f->high, height_unit(r, unit));
    else
        puts("  heights       none");
    if (!s->header) printf("  holes         %zu", f->holes);
    if (!s->header && r->georef.has_nodata) printf(" (no data: %.9g)", r->georef.nodata);
    if (!s->header) putchar('\n');
    if (r->georef.scale != 0)
        printf("  stored        heights are %.9g + %.9g x the file's numbers\n", r->georef.offset, r->georef.scale);
    printf("  samples       %zu x %zu (%zu x %zu cells)\n", f->nx, f->ny, f->nx - 1, f->ny - 1);
    if (!s->header)
        printf("  memory        %.0f bytes of samples, %zu bytes built for kernel %s: %.2f bytes a cell\n",
               sample_bytes(f), f->bytes_built, cw_kernel_describe(s->kernel).name, bytes_per_cell(f));
    puts("  user space    rows of the map from (x, y, z, 1):");
    for (int k = 0; k < 3; k++)
        printf("                %.17g %.17g %.17g %.17g\n", s->file.raster.map[k][0], s->file.raster.map[k][1],
               s->file.raster.map[k][2], s->file.raster.map[k][3]);
}

static void print_field_json(const char *path, const survey *s) {
    const cw_field_info *f = &s->info;
    const io_raster *r = &s->file.raster;
    const io_georef *g = &r->georef;
    const bool some = !s->header && f->low <= f->high;
    json_print(stdout, ", 'field': {'path': %s, 'nx': %u, 'ny': %u, 'low': %g, 'high': %g, 'holes': %u, ", path, f->nx,
               f->ny, some ? (double)f->low : NAN, some ? (double)f->high : NAN, f->holes);
    json_print(stdout, "'bytes_samples': %u, 'bytes_built': %u, 'bytes_per_cell': %g", (size_t)sample_bytes(f),
               f->bytes_built, bytes_per_cell(f));
    if (g->placed) {
        const place p = find_place(r);
        json_print(stdout, ", 'extent': [%G, %G, %G, %G], 'cell_size': [%G, %G], 'degrees': %b", p.low[0], p.low[1],
                   p.high[0], p.high[1], p.cell[0], p.cell[1], g->geographic);
        if (p.crs[0] != '\0') json_print(stdout, ", 'coordinates': %s", p.crs);
    }
    if (g->scale != 0) json_print(stdout, ", 'scale': %G, 'offset': %G", g->scale, g->offset);
    for (int k = 0; k < 3; k++) {
        const double *m = s->file.raster.map[k];
        json_print(stdout, k ? ", [%G, %G, %G, %G]" : ", 'map': [[%G, %G, %G, %G]", m[0], m[1], m[2], m[3]);
    }
    json_print(stdout, "]}");
}

static int show(const char *path, const field_options *options, bool json, bool samples) {
    survey s = {0};
    io_error error = {""};
    bool good =
        path == NULL || samples || options->coarser.factor > 0 || look_at_header(path, &options->reading, &s, &error);
    if (good && path != NULL && !s.header &&
        (good = raster_field_open(&s.file, path, &options->reading, &options->coarser, &options->query, &options->watch,
                                  &error)))
        s.info = cw_field_describe(s.file.field);
    progress_end();
    if (!good) return command_fail("info", "%s", error.text);
    if (!s.header) s.kernel = cw_run_kernel(s.file.field, &options->query);
    if (json || !path) {
        print_machine(json);
        print_kernels(s.kernel, json);
    }
    if (path) json ? print_field_json(path, &s) : print_field(path, &s);
    if (json) puts("}");
    raster_field_close(&s.file);
    return EXIT_SUCCESS;
}

static int run(int argc, char **argv) {
    static field_options shared; /* large */
    static const char *const of_field[] = {"band",    "nodata", "zscale",  "cellsize",
                                           "coarser", "filter", "samples", NULL};
    bool json = false, samples = false;
    const option_spec options[] = {
        option_flag("json", &json, "print one JSON object"),
        option_flag("samples", &samples, "read the samples of rasters with more than 67 million of them too"),
    };
    static const char *const operand_names[] = {"FIELD"};
    const options_usage usage = {
        .name = "info",
        .synopsis = "[FIELD] [OPTIONS]",
        .what =
            "Prints the contents and the cost of a height field, or without FIELD the kernels that this machine "
            "can run.\n\n"
            "With FIELD: its extent, cell size, coordinate system, heights and holes, then its size and its memory in "
            "bytes, with the structures of the chosen kernel. Without FIELD: the CPU, its instruction set as far as "
            "the system supports it, and the kernels (ways to find "
            "hits) with the chosen one.\n\n" FIELD_FILE_HELP,
        .examples = "  cellwalk info\n"
                    "  cellwalk info dem.tif\n"
                    "  cellwalk info --isa sse4.2        # the kernel chosen without AVX2\n"
                    "  cellwalk info terrain.npy --kernel grid3d --json\n",
        OPTIONS_OF(options),
        .operands = operand_names,
        .operand_most = 1,
    };
    const char *path;
    const int status = field_options_parse(&shared, &usage, FIELD_KERNELS, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    if (path == NULL && !options_lack("info", of_field, "goes with a FIELD, which is missing")) return EXIT_USAGE;
    return show(path, &shared, json, samples);
}

const command command_info = {"info", "print a field's contents and cost, or this machine's kernels", run};
