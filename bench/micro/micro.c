/* SPDX-License-Identifier: Apache-2.0 */
#include "micro/micro.h"

#include "clock.h"
#include "harness/choices.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "harness/timing.h"
#include "micro/compare.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>

static const char *const usage =
    "Usage: cellwalk-bench micro [OPTIONS]\n"
    "       cellwalk-bench micro --compare A.json B.json\n"
    "\n"
    "Times every kernel that this CPU can run, and Embree at its four widths, on the same rays: for each field and "
    "class\n"
    "of rays all contenders are verified against the plain cell walk, then timed in rounds, each round in another "
    "order,\n"
    "on one thread unless --threads says more. Times are CPU time, so that other programs on the machine disturb "
    "less.\n"
    "The numbers:\n"
    "  Mrays/s    millions of rays a second, from the median time\n"
    "  CI +-%     half of the median's 97.5 % confidence interval; ! marks one that did not get narrow enough in time, "
    "?\n"
    "             one from fewer than 7 passes, which covers less than that\n"
    "  MAD %      median absolute deviation of the times\n"
    "  TSC/ray    ticks of the time stamp counter a ray: units of time, not cycles of the core\n"
    "  /Embree    speed over that of Embree's fastest width: above 1 is faster than Embree\n"
    "\n"
    "Options (lists are NAME,NAME or the option again):\n";

static const char *const examples =
    "\n"
    "Examples:\n"
    "  cellwalk-bench micro\n"
    "      A first look at fields of 65, 257 and 1025 samples a side, in a minute.\n"
    "  cellwalk-bench micro --kernel packet8 --rays shadow --field 1025 --leaf watertight --isa avx2\n"
    "      One kernel on one class of rays, against Embree held to the same instruction set.\n"
    "  cellwalk-bench micro --json before.json;  cellwalk-bench compare before.json after.json\n"
    "      Did a change make anything faster?\n";

static bool check_threads(micro_options *o, io_error *error) {
    if (o->threads.count == 0) o->threads.items[o->threads.count++] = "1";
    if (o->threads.count > MICRO_THREADS_MAX)
        return io_fail(error, "--threads: more than %d numbers", MICRO_THREADS_MAX);
    for (size_t t = 0; t < o->threads.count; t++) {
        char *end;
        const long value = strtol(o->threads.items[t], &end, 10);
        if (*end != '\0' || value < 1 || value > 1024)
            return io_fail(error, "--threads %s: must be a whole number from 1 to 1024", o->threads.items[t]);
        o->thread_counts[t] = (unsigned)value;
        if (value > 1) o->by_clock = o->no_pin = true;
    }
    if (o->by_clock && o->counters) return io_fail(error, "--counters: counts are those of one thread");
    return true;
}

static bool open_pools(micro_options *o, io_error *error) {
    for (size_t t = 0; t < o->threads.count; t++) {
        if (o->thread_counts[t] == 1) continue;
        const cw_status status = cw_pool_create(o->thread_counts[t], &o->pools[t]);
        if (status != CW_OK) return io_fail(error, "--threads %u: %s", o->thread_counts[t], cw_status_message(status));
    }
    return true;
}

static void close_pools(micro_options *o) {
    for (size_t t = 0; t < o->threads.count; t++) cw_pool_destroy(o->pools[t]);
}

static const char *const peer_names[] = {"triangles", "grid", "triangles-robust", "grid-robust", "none"};
enum { PEER_NAMES = sizeof peer_names / sizeof peer_names[0] };

static bool check_options(micro_options *o, cw_isa *isa, io_error *error) {
    const char *names[OPTION_LIST_MAX];
    size_t count = 0;
    if (!choices_kernels(&o->kernels, error) || !choices_fields(&o->fields, o->longer ? OPTION_LIST_MAX : 3, error))
        return false;
    for (count = 0; count < WORKLOAD_CLASS_COUNT; count++) names[count] = workload_class_name((workload_class)count);
    names[count] = "none";
    if (!options_check_names(&o->rays, "--rays", names, count + 1, count, error)) return false;
    for (size_t k = 0; k < o->rays.count; k++) {
        if (strcmp(o->rays.items[k], "none") != 0) continue;
        if (o->rays.count > 1) return io_fail(error, "--rays none: and no other class");
        o->rays.count = 0;
    }

    count = 0;
    for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++) names[count++] = cw_leaf_name((cw_leaf)leaf);
    names[count++] = "all";
    if (!options_check_names(&o->leaves, "--leaf", names, count, 0, error)) return false;

    if (!options_check_names(&o->peers, "--peer", peer_names, PEER_NAMES, peer_embree_version() && !o->counters ? 1 : 0,
                             error))
        return false;

    if (!check_threads(o, error)) return false;
    if (strcmp(o->quality, "high") != 0 && strcmp(o->quality, "medium") != 0)
        return io_fail(error, "--quality %s: must be high or medium", o->quality);
    return choices_isa(o->isa, isa, error);
}

static void close_field(micro_field *on) {
    for (size_t p = 0; p < on->peer_count; p++) peer_embree_destroy(on->peers[p].embree);
    cw_field_destroy(on->field);
    workload_field_free(&on->samples);
    *on = (micro_field){0};
}

/* Embree's peak while building, over what it holds in the end: measured at 1025 and 4097 samples a side, 245 bytes a cell
 * for triangles at high quality, 38 for a grid. An 8193 field would take 17 GB, and a system that runs out of memory kills
 * somebody. */
static bool embree_fits(const cw_field_info *info, bool grid, const char *label) {
    const double needed = (double)(info->nx - 1) * (double)(info->ny - 1) * (grid ? 50 : 260);
    const double available = run_memory_available();
    if (available <= 0 || needed < available) return true;
    printf("%s is left out: it would take about %.1f GB, and %.1f GB are available\n", label, needed * 1e-9,
           available * 1e-9);
    return false;
}

static bool open_field(micro_field *on, const char *name, const micro_options *o, cw_isa isa, io_error *error) {
    static const char *const labels[] = {"embree/triangles", "embree/grid", "embree/triangles-robust",
                                         "embree/grid-robust"};
    *on = (micro_field){0};
    if (!workload_field_make(name, &on->samples)) return io_fail(error, "out of memory for field %s", name);
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = on->samples.z;
    desc.nx = on->samples.nx;
    desc.ny = on->samples.ny;
    const cw_status status = cw_field_create(&desc, &on->field);
    if (status != CW_OK) return io_fail(error, "field %s: %s", name, cw_status_message(status));
    on->default_kernel = cw_kernel_describe(cw_query_kernel(on->field, NULL)).name;
    for (size_t p = 0; p + 1 < PEER_NAMES; p++) {
        bool wanted = false;
        for (size_t k = 0; k < o->peers.count; k++) wanted = wanted || strcmp(o->peers.items[k], peer_names[p]) == 0;
        const cw_field_info info = cw_field_describe(on->field);
        if (!wanted || !embree_fits(&info, p % 2 != 0, labels[p])) continue;
        const peer_options options = {.isa = isa,
                                      .geometry = p % 2 ? PEER_GRID : PEER_TRIANGLES,
                                      .quality = strcmp(o->quality, "high") == 0 ? PEER_HIGH : PEER_MEDIUM,
                                      .robust = p >= 2};
        micro_peer *peer = &on->peers[on->peer_count];
        *peer = (micro_peer){.build = {.name = labels[p]}};
        if (!micro_build_peer(peer, on->field, &options, error)) return false;
        on->peer_count++;
    }
    return micro_build_kernels(on, o, error);
}

/* ---- summary: the geometric mean over classes, one line a contender, one column a field ---- */

typedef struct summary {
    char names[MICRO_CONTENDERS_MAX][CONTENDER_NAME];
    double ratios[MICRO_CONTENDERS_MAX][16][WORKLOAD_CLASS_COUNT];
    size_t counts[MICRO_CONTENDERS_MAX][16];
    size_t count;
} summary;

static void summary_add(summary *s, size_t field, const micro_group *g) {
    for (size_t r = 0; r < g->row_count; r++) {
        const micro_row *row = &g->rows[r];
        if (!(row->to_embree > 0) || field >= 16) continue;
        size_t k = 0;
        while (k < s->count && strcmp(s->names[k], row->contender.name) != 0) k++;
        if (k == MICRO_CONTENDERS_MAX) return;
        if (k == s->count) {
            memcpy(s->names[k], row->contender.name, sizeof s->names[k]);
            s->count++;
        }
        s->ratios[k][field][s->counts[k][field]++] = row->to_embree;
    }
}

static void summary_print(const summary *s, const micro_options *o) {
    if (s->count == 0) return;
    bool partial = false;
    printf("\nSpeed over Embree's best width, geometric mean over the classes of rays:\n");
    printf("  %-30s", "contender");
    for (size_t f = 0; f < o->fields.count && f < 16; f++) printf(" %9s", o->fields.items[f]);
    printf("\n");
    for (size_t k = 0; k < s->count; k++) {
        printf("  %-30s", s->names[k]);
        for (size_t f = 0; f < o->fields.count && f < 16; f++) {
            const size_t n = s->counts[k][f];
            if (n == 0)
                printf(" %9s", "-");
            else
                printf(" %7.2f%s", statistics_geometric_mean(s->ratios[k][f], n), n == o->rays.count ? "  " : " *");
            partial = partial || (n > 0 && n < o->rays.count);
        }
        printf("\n");
    }
    if (partial) printf("  * not all classes: the others would have taken too long\n");
}

/* "1, 2" in the record of a run. */
static void set_threads(json_t *record, const micro_options *o) {
    char text[128] = "";
    for (size_t t = 0; t < o->threads.count; t++) {
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%u", t ? ", " : "", o->thread_counts[t]);
    }
    results_set_text(record, "threads", text);
}

static workload_class class_of(const char *name) {
    int c = 0;
    while (strcmp(workload_class_name((workload_class)c), name) != 0) c++;
    return (workload_class)c;
}

static bool run(const micro_options *o, cw_isa isa, io_output *out, io_error *error) {
    const int cpu = o->no_pin ? -1 : timing_pin(o->cpu == UINT64_MAX ? -1 : (int)o->cpu);
    if (!o->no_pin && cpu < 0)
        return io_fail(error, "--cpu %d: the system does not allow this process there", (int)o->cpu);
    json_t *record = run_record("micro", (uint32_t)o->seed, cpu);
    char text[512];
    if (o->by_clock) set_threads(record, o);
    run_record_text(record, text, sizeof text);
    printf("%s\n", text);
    if (!results_write(out, record, error)) return false;

    summary *s = calloc(1, sizeof *s);
    micro_group *g = calloc(1, sizeof *g);
    bool good = (s && g) || io_fail(error, "out of memory");
    double end = clock_seconds() + o->seconds;
    size_t groups = o->fields.count * o->rays.count;
    for (size_t f = 0; good && f < o->fields.count; f++) {
        fprintf(stderr, "field %s: making it and building Embree\n", o->fields.items[f]);
        micro_field on;
        const double start = clock_seconds();
        good = open_field(&on, o->fields.items[f], o, isa, error);
        end += clock_seconds() - start;
        if (good) micro_print_field(&on);
        for (size_t c = 0; good && c < o->rays.count; c++) {
            *g = (micro_group){.on = &on, .c = class_of(o->rays.items[c])};
            const double left = end - clock_seconds();
            good = micro_group_run(g, o, left > 0 ? left / (double)groups : 0, error);
            groups--;
            if (good) {
                if (o->counters) {
                    micro_print_counts(g);
                    good = micro_write_counts(out, g, error);
                } else {
                    micro_print_group(g);
                    summary_add(s, f, g);
                    good = micro_write_group(out, g, error);
                }
            }
            micro_group_free(g);
        }
        if (good) good = micro_write_field(out, &on, error);
        close_field(&on);
    }
    if (good) summary_print(s, o);
    free(g);
    free(s);
    return good;
}

int micro_main(char **arguments, int count) {
    if (count > 0 && strcmp(arguments[0], "--compare") == 0) return compare_main(arguments + 1, count - 1);
    for (int k = 0; k < count; k++)
        if (strcmp(arguments[k], "--counters") == 0 && !counters_here()) return micro_run_counting(arguments, count);
    micro_options o = {.quality = "high", .seed = 1, .cpu = UINT64_MAX, .width = 0.02};
    const option options[] = {
        {"--kernel", "NAMES", "only these kernels (cellwalk info lists them); all by default", OPTION_LIST, &o.kernels,
         0, 0},
        {"--rays", "NAMES",
         "only these classes: primary, shadow, ao, bounce, random, grazing; or none, to "
         "build alone",
         OPTION_LIST, &o.rays, 0, 0},
        {"--field", "NAMES",
         "65, 257, 1025 (these by default), 4097, 8193, sea-calm, sea-rough (these too with --long)", OPTION_LIST,
         &o.fields, 0, 0},
        {"--leaf", "NAMES", "moller-trumbore, watertight or all; by default each kernel's own choice", OPTION_LIST,
         &o.leaves, 0, 0},
        {"--peer", "NAMES", "Embree as triangles (default), grid, triangles-robust, grid-robust; or none", OPTION_LIST,
         &o.peers, 0, 0},
        {"--threads", "NUMBERS",
         "how many threads a query of a kernel has (1); with more than one all is timed by the clock", OPTION_LIST,
         &o.threads, 0, 0},
        {"--quality", "HIGH", "Embree's build quality: high (default) or medium, which is its own default", OPTION_TEXT,
         &o.quality, 0, 0},
        {"--isa", "NAME", "instruction set for all, Embree as well: scalar, sse4.2, avx2 or avx512", OPTION_TEXT,
         &o.isa, 0, 0},
        {"--count", "N", "rays in a class (32768; 262144 with --long)", OPTION_COUNT, &o.count, 16, 1 << 24},
        {"--seconds", "S",
         "time for all but making and building the fields, as far as it can be kept (40; 900 with --long)", OPTION_REAL,
         &o.seconds, 0.01, 1e6},
        {"--width", "SHARE", "narrow enough: width of the confidence interval over the median (0.02)", OPTION_REAL,
         &o.width, 1e-6, 10},
        {"--pass", "S", "leave out who would take longer for one pass over the rays (0.5; 5 with --long)", OPTION_REAL,
         &o.pass, 1e-6, 1e6},
        {"--seed", "N", "of rays and order (1)", OPTION_COUNT, &o.seed, 0, UINT32_MAX},
        {"--cpu", "N", "stay on this CPU; by default on the one that the program starts on", OPTION_COUNT, &o.cpu, 0,
         1023},
        {"--no-pin", NULL, "let the system move the program between CPUs", OPTION_FLAG, &o.no_pin, 0, 0},
        {"--small-pages", NULL, "keep the system from backing large fields with huge pages", OPTION_FLAG,
         &o.small_pages, 0, 0},
        {"--counters", NULL, "count steps, leaf tests, busy lanes and refills of the kernels instead of timing",
         OPTION_FLAG, &o.counters, 0, 0},
        {"--long", NULL, "all fields, more rays, more time", OPTION_FLAG, &o.longer, 0, 0},
        {"--json", "FILE", "write JSON lines there", OPTION_TEXT, &o.json, 0, 0},
    };
    const option_frame frame = {.command = "micro",
                                .usage = usage,
                                .examples = examples,
                                .options = options,
                                .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    cw_isa isa = CW_ISA_SCALAR;
    if (o.count == 0) o.count = o.longer ? 262144 : 32768;
    if (o.seconds <= 0) o.seconds = o.longer ? 900 : 40;
    if (o.pass <= 0) o.pass = o.longer || o.counters ? 5 : 0.5;
    if (!check_options(&o, &isa, &error)) return options_misused("micro", &error);
    cw_isa_limit(isa);

    io_output out = {0};
    if (o.small_pages && prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0) != 0) {
        io_fail(&error, "--small-pages: the system does not allow it");
        goto failure;
    }
    if (o.json && !io_output_open(&out, o.json, &error)) goto failure;
    const bool good = open_pools(&o, &error) && run(&o, isa, &out, &error);
    close_pools(&o);
    if (!good) goto failure;
    if (o.json && !io_output_commit(&out, &error)) goto failure;
    return EXIT_SUCCESS;
failure:
    io_output_discard(&out);
    return options_failed("micro", &error);
}
