/* SPDX-License-Identifier: Apache-2.0 */
#include "micro/micro.h"

#include "clock.h"
#include "commands.h"
#include "harness/memory.h"
#include "harness/results.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>

static const char what[] =
    "Times every kernel that this CPU can run, and Embree at its four packet widths, on the same rays, and prints a "
    "table for each field and class of rays; --json also writes the results to a file. All contenders are first "
    "compared with the plain cell walk, then timed in rounds, each round in another order, on one thread unless "
    "--threads says otherwise. Times are CPU time, which other programs on the machine disturb less. The columns:\n"
    "  Mrays/s  millions of rays a second, from the median time\n"
    "  CI +-%   half of the median's 97.5 % confidence interval; ! marks one that did not get narrow enough in time, ? "
    "one from fewer than 7 passes, which covers less than that\n"
    "  MAD %    median absolute deviation of the times\n"
    "  TSC/ray  ticks of the time stamp counter a ray: units of time, not cycles of the core\n"
    "  /Embree  speed over that of Embree's fastest width: above 1 is faster than Embree";

static const char examples[] = "  cellwalk-bench micro              # a first look, in a minute\n"
                               "  cellwalk-bench micro --kernel packet8 --rays shadow --field 1025 --isa avx2\n"
                               "  cellwalk-bench micro --field plane,grooves,comb --rays beside --call 1\n"
                               "  cellwalk-bench micro --json before.json\n"
                               "  cellwalk-bench micro --json after.json      # built with a change\n"
                               "  cellwalk-bench compare before.json after.json\n";

static const char *const peers[PEER_KINDS] = {"embree/triangles", "embree/grid", "embree/triangles-robust",
                                              "embree/grid-robust"};
static const char *peer_names(size_t number) {
    return number < PEER_KINDS ? peers[number] + strlen("embree/") : number == PEER_KINDS ? "none" : NULL;
}

static const char *quality_names(size_t number) { return number == 0 ? "high" : number == 1 ? "medium" : NULL; }

/* The classes that are timed, then the one that is so on request only, and none. */
enum { RAYS_BESIDE = WORKLOAD_CLASS_COUNT, RAYS_NONE };
static workload_class ray_class(size_t number) {
    return number == RAYS_BESIDE ? WORKLOAD_BESIDE : (workload_class)number;
}
static const char *ray_names(size_t number) {
    return number < RAYS_NONE ? workload_class_name(ray_class(number)) : number == RAYS_NONE ? "none" : NULL;
}

/* Those that a query may ask for, and all of them. */
static const char *leaf_names(size_t number) {
    return number + 1 < CW_LEAF_COUNT ? cw_leaf_name((cw_leaf)(number + 1))
                                      : (number + 1 == CW_LEAF_COUNT ? "all" : NULL);
}

static bool check_options(micro_options *o, io_error *error) {
    if (o->fields.count == 0)
        option_list_fill(&o->fields, workload_field_name, 0, o->longer ? WORKLOAD_FIELDS_TIMED : 3);
    if (o->rays.count == 0) option_list_fill(&o->rays, ray_names, 0, WORKLOAD_CLASS_COUNT);
    if (o->rays.count > 1 && option_wanted(&o->rays, RAYS_NONE))
        return io_fail(error, "--rays none: and no other class");
    if (o->rays.number[0] == RAYS_NONE) o->rays.count = 0;
    if (o->peers.count == 0) {
        const size_t none = PEER_KINDS, first = peer_embree_version() ? 0 : none;
        option_list_fill(&o->peers, peer_names, first, first + 1);
    }
    if (o->count == 0) o->count = o->longer ? 262144 : 32768;
    if (o->seconds <= 0) o->seconds = o->longer ? 900 : 40;
    if (o->pass <= 0) o->pass = o->longer ? 5 : 0.5;
    if (o->threads.count == 0) o->threads = (option_list){.item = {"1"}, .number = {1}, .count = 1};
    if (o->backs.count == 0) o->backs.count = 1; /* 0 */
    for (size_t t = 0; t < o->threads.count; t++)
        if (o->threads.number[t] > 1) o->by_clock = o->run.no_pin = true;
    if (o->threads.count > MICRO_THREADS_MAX)
        return io_fail(error, "--threads: more than %d numbers", MICRO_THREADS_MAX);
    return true;
}

static void close_field(micro_field *on) {
    for (size_t p = 0; p < on->peer_count; p++) peer_embree_destroy(on->peers[p].embree);
    cw_field_destroy(on->field);
    workload_field_free(&on->samples);
    *on = (micro_field){0};
}

static bool open_field(micro_field *on, const char *name, const micro_options *o, io_error *error) {
    *on = (micro_field){0};
    if (!workload_field_make(name, &on->samples)) return io_fail(error, "out of memory for field %s", name);
    const cw_status status = workload_field_open(&on->samples, CW_COPY, false, &on->field);
    if (status != CW_OK) return io_fail(error, "field %s: %s", name, cw_last_error());
    on->default_kernel = cw_kernel_describe(cw_run_kernel(on->field, NULL)).name;
    for (size_t p = 0; p < PEER_KINDS; p++) {
        const peer_geometry geometry = p % 2 ? PEER_GRID : PEER_TRIANGLES;
        if (!option_wanted(&o->peers, p) || !run_memory_has(peer_embree_needs(on->field, geometry), peers[p], name))
            continue;
        const peer_options options = {.isa = (cw_isa)o->run.isa,
                                      .geometry = geometry,
                                      .quality = o->quality == 0 ? PEER_HIGH : PEER_MEDIUM,
                                      .robust = p >= 2};
        micro_peer *peer = &on->peers[on->peer_count];
        *peer = (micro_peer){.build = {.name = peers[p]}};
        if (!micro_build_peer(peer, on->field, &options, error)) return false;
        on->peer_count++;
    }
    return micro_build_kernels(on, o, error);
}

static bool run_group(micro_field *on, workload_class c, double back, const micro_options *o, double seconds,
                      io_output *out, io_error *error) {
    micro_group *g = memory(1, sizeof *g);
    g->on = on;
    g->c = c;
    g->back = back;
    const int length = snprintf(g->name, sizeof g->name, "%s", workload_class_name(c));
    if (back > 0) snprintf(g->name + length, sizeof g->name - (size_t)length, "+%g", back);
    bool good = micro_group_run(g, o, seconds, error);
    if (good) micro_print_group(g);
    good = good && micro_write_group(out, g, error);
    free(g->rays);
    free(g);
    return good;
}

static bool run(const micro_options *o, io_output *out, io_error *error) {
    int cpu;
    if (!run_options_pin(&o->run, &cpu, error)) return false;
    json_t *record = run_record("micro", o->run.seed, cpu);
    char text[512] = "";
    for (size_t t = 0; t < o->threads.count; t++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s", t ? ", " : "", o->threads.item[t]);
    if (o->by_clock) results_set_text(record, "threads", text);
    run_record_text(record, text, sizeof text);
    printf("%s\n", text);
    if (!results_write(out, record, error)) return false;

    bool good = true;
    double end = clock_seconds() + o->seconds;
    const size_t sets = o->rays.count * o->backs.count;
    size_t groups = o->fields.count * sets;
    for (size_t f = 0; good && f < o->fields.count; f++) {
        fprintf(stderr, "field %s: making it and building Embree\n", o->fields.item[f]);
        micro_field on;
        const double start = clock_seconds();
        good = open_field(&on, o->fields.item[f], o, error);
        end += clock_seconds() - start;
        if (good) micro_print_field(&on);
        for (size_t s = 0; good && s < sets; s++, groups--) {
            const double left = end - clock_seconds();
            good = run_group(&on, ray_class(o->rays.number[s / o->backs.count]), o->backs.real[s % o->backs.count], o,
                             left > 0 ? left / (double)groups : 0, out, error);
        }
        if (good) good = micro_write_field(out, &on, error);
        close_field(&on);
    }
    return good;
}

/* The whole measurement, with a file if one is given. */
static bool run_into_file(micro_options *o, io_error *error) {
    io_output out = {0};
    if (o->small_pages && prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0) != 0)
        return io_fail(error, "--small-pages: the system does not allow it");
    bool good = o->json == NULL || io_output_open(&out, o->json, error);
    for (size_t t = 0; good && t < o->threads.count; t++) {
        const unsigned threads = (unsigned)o->threads.number[t];
        const cw_status status = threads > 1 ? cw_pool_create(threads, &o->pools[t]) : CW_OK;
        good = status == CW_OK || io_fail(error, "--threads %u: %s", threads, cw_last_error());
    }
    good = good && run(o, &out, error) && (o->json == NULL || io_output_commit(&out, error));
    for (size_t t = 0; t < o->threads.count; t++) cw_pool_destroy(o->pools[t]);
    io_output_discard(&out);
    return good;
}

static int start(int argc, char **argv) {
    micro_options o = {.run = RUN_DEFAULTS, .width = 0.02};
    const option_spec options[] = {
        {"kernel", "NAMES", "only these kernels; all by default", OPTION_LIST, .to = &o.kernels,
         .names = option_kernel_names},
        {"rays", "NAMES", "only these classes of rays; by default all but beside; none is for building alone",
         OPTION_LIST, .to = &o.rays, .names = ray_names},
        {"field", "NAMES", "these fields; by default the first three, with --long all", OPTION_LIST, .to = &o.fields,
         .names = workload_field_name},
        {"leaf", "NAMES", "these leaf tests; by default each kernel's own choice", OPTION_LIST, .to = &o.leaves,
         .names = leaf_names},
        {"peer", "NAMES", "these kinds of Embree geometry; triangles by default", OPTION_LIST, .to = &o.peers,
         .names = peer_names},
        {"threads", "NUMBERS",
         "threads that a query of a kernel uses (1); with more than one, times are wall-clock times", OPTION_COUNTS,
         .to = &o.threads, .low = 1, .high = 1024},
        {"back", "NUMBERS", "move the rays' origins back by so many times the field's longer side (0)", OPTION_REALS,
         .to = &o.backs, .high = 1e12},
        {"quality", "NAME", "Embree's build quality; high by default, medium is Embree's own default", OPTION_NAME,
         .to = &o.quality, .names = quality_names},
        {"count", "N", "rays in a class (32768; 262144 with --long)", OPTION_COUNT, .to = &o.count, .low = 16,
         .high = 1 << 24},
        {"call", "N", "rays in a call of a kernel; by default all at once", OPTION_COUNT, .to = &o.call, .low = 1,
         .high = 1 << 24},
        {"seconds", "S",
         "seconds for all but making and building the fields, kept as far as possible (40; 900 with --long)",
         OPTION_REAL, .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"width", "SHARE", "stop when the confidence interval is narrower than SHARE of the median (0.02)", OPTION_REAL,
         .to = &o.width, .low = 1e-6, .high = 10},
        {"pass", "S",
         "skip contenders that would take more than S seconds for one pass over the rays (0.5; 5 with --long)",
         OPTION_REAL, .to = &o.pass, .low = 1e-6, .high = 1e6},
        {"small-pages", NULL, "keep the system from backing large fields with huge pages", OPTION_FLAG,
         .to = &o.small_pages},
        {"long", NULL, "all fields, more rays, more time", OPTION_FLAG, .to = &o.longer},
        {"json", "FILE", "write the results to FILE as JSON lines", OPTION_TEXT, .to = &o.json},
        RUN_OPTIONS(o.run),
    };
    const options_usage usage = {"micro", "[OPTIONS]", what, examples, options, sizeof options / sizeof *options,
                                 NULL,    0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    io_error error = {{0}};
    if (!check_options(&o, &error)) return command_fail("micro", "%s", error.text), EXIT_USAGE;
    if (!run_options_check(&o.run, "micro")) return EXIT_USAGE;
    return run_into_file(&o, &error) ? EXIT_SUCCESS : command_fail("micro", "%s", error.text);
}

const command command_micro = {"micro", "time kernels and Embree on classes of rays and fields", start};
