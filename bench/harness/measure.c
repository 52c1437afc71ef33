/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench measure: every measurement that the papers quote, one file of results each, in one go. */

#include "cellwalk.h"
#include "clock.h"
#include "commands.h"
#include "cpus.h"
#include "harness/child.h"
#include "harness/results.h"
#include "harness/run.h"
#include "peers/embree.h"

#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char what[] = "Makes every file of results that the papers quote, one after the other. A file that is "
                           "there already is kept, so a run that was broken off goes on where it was. For figures to "
                           "publish nothing else should run on the machine. Files:\n"
                           "  speed-ISA.json          each instruction set: all classes of rays on all fields, the "
                           "library's kernel and Embree\n"
                           "  peers.json              Embree's triangles and grids, normal and robust\n"
                           "  widths.json             every width of every walk\n"
                           "  threads.json            one thread, two, and one a CPU\n"
                           "  afar.json               rays that start up to a million field lengths away\n"
                           "  pages-*.json            large fields on huge and on ordinary pages\n"
                           "  building.json           memory and building time, Embree at its default quality\n"
                           "  counters.json           what the kernels do for a ray\n"
                           "  scenes/table.json       the six scenes\n"
                           "  tradeoff/tradeoff.json  speed against error\n"
                           "  precision/tradeoff.json errors of t, u, v and normals beside Embree's";

enum { WORDS_MAX = 32, STEPS_MAX = 16 };

/* One file. */
typedef struct step {
    char file[64], words[512]; /* of the command, without seconds, JSON file and seed; words have no spaces */
    double share;              /* of the time for all; 0 where no clock is looked at */
} step;

typedef struct campaign {
    step steps[STEPS_MAX];
    size_t count;
} campaign;

__attribute__((format(printf, 4, 5))) static void add(campaign *c, double share, const char *file, const char *format,
                                                      ...) {
    step *s = &c->steps[c->count++];
    va_list list;
    va_start(list, format);
    *s = (step){.share = share};
    snprintf(s->file, sizeof s->file, "%s", file);
    vsnprintf(s->words, sizeof s->words, format, list);
    va_end(list);
}

/* The widest kernel of the pyramid that an instruction set runs. */
static const char *kernel_of(cw_isa isa) {
    const char *best = "cell";
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (info.isa <= isa && strncmp(info.name, "pyramid", 7) == 0) best = info.name;
    }
    return best;
}

/* "cell,packet1,packet4": the kernels that can run here, but for brute force and, unless grids take part, the 3D grids. */
static const char *kernels(char text[256], bool grids) {
    size_t used = 0;
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        if (info.available && strcmp(info.name, "brute") != 0 && (grids || strncmp(info.name, "grid", 4) != 0) &&
            used < 256)
            used += (size_t)snprintf(text + used, 256 - used, "%s%s", used ? "," : "", info.name);
    }
    return text;
}

static void plan(campaign *c, bool quick) {
    const char *const rays = quick ? "--count 2048" : "--count 131072 --pass 5", *const some =
                                                                                     quick ? "65" : "257,1025";
    const bool embree = peer_embree_version() != NULL;
    const char *const triangles = embree ? "triangles" : "none", *const best = kernel_of(cw_isa_best());
    char names[256];
    for (int isa = (int)cw_isa_best(); isa >= CW_ISA_SSE42; isa--) {
        char file[64] = "speed-";
        for (const char *from = cw_isa_name((cw_isa)isa); *from; from++) /* without the dot of sse4.2 */
            if (*from != '.') strncat(file, from, 1);
        strcat(file, ".json");
        add(c, isa == (int)cw_isa_best() ? 8 : 5, file, "micro --isa %s --kernel %s --peer %s --field %s %s",
            cw_isa_name((cw_isa)isa), kernel_of((cw_isa)isa), triangles,
            quick ? "65,257" : "65,257,1025,4097,8193,sea-calm,sea-rough", rays);
    }
    add(c, 3, "peers.json", "micro --kernel %s --peer %s --field %s %s", best,
        embree ? "triangles,grid,triangles-robust,grid-robust" : "none", some, rays);
    add(c, 3, "widths.json", "micro --peer %s --field %s %s --kernel %s", triangles, some, rays, kernels(names, false));
    /* One CPU has nothing to be faster than, which is a result like another. */
    char threads[32] = "1";
    const unsigned cpus = cpus_usable();
    if (cpus > 1) snprintf(threads, sizeof threads, cpus > 2 ? "1,2,%u" : "1,2", cpus);
    add(c, 3, "threads.json", "micro --threads %s --kernel %s --peer none --field %s %s", threads, best, some,
        quick ? "--count 16384" : "--count 262144 --pass 5");
    add(c, 2, "afar.json", "micro --rays random --back 0,1,2,5,20,100,1e6 --kernel %s --peer none --field %s %s", best,
        quick ? "65" : "257,1025,4097,8193", rays);
    for (int huge = 1; huge >= 0; huge--)
        add(c, 1, huge ? "pages-huge.json" : "pages-small.json", "micro --kernel %s --peer none --field %s %s%s", best,
            quick ? "65" : "1025,4097,8193", rays, huge ? "" : " --small-pages");
    add(c, 0, "building.json", "micro --rays none --quality medium --kernel %s,grid3d --peer %s --field %s", best,
        embree ? "triangles,grid" : "none", quick ? "65,257" : "65,257,1025,4097,8193");
    /* Pass is long, so that who takes part does not depend on the machine's mood. */
    add(c, 0, "counters.json", "micro --counters --pass 60 --field %s --count %s --kernel %s",
        quick ? "65" : "65,257,1025,4097,sea-calm,sea-rough", quick ? "2048" : "8192", kernels(names, true));
    add(c, 2, "scenes/table.json", "table%s", quick ? " --quick --scene hftest" : "");
    add(c, 4, "tradeoff/tradeoff.json", "tradeoff %s",
        quick ? "--count 512 --field 65 --scene none" : "--field 257,1025 --count 131072 --pass 1");
    /* Pass is long, so that nobody gets fewer rays. */
    add(c, 0, "precision/tradeoff.json",
        "tradeoff --mode strict,embree,embree-robust --kernel %s --scene none --seconds 1 --pass 1000 %s", best,
        quick ? "--count 512 --field 65" : "--field 1025,8193x1025 --count 131072");
}

/* ---- running ---- */

typedef struct measure_options {
    const char *out;
    double seconds;
    unsigned seed;
    bool quick, again;
} measure_options;

/* The commit that a file's figures are of; they are not to be mixed with another's unnoticed. */
static void tell_kept(const char *path, size_t number, size_t count) {
    io_error error = {{0}};
    json_t *lines = results_read(path, &error), *now = run_record("measure", 0, -1);
    const json_t *run = json_array_get(lines, 0);
    const bool same = results_same(run, now, "commit");
    fprintf(stderr, "[%zu of %zu] %s is there already%s%s\n", number, count, path,
            lines == NULL ? ", but cannot be read: "
            : same        ? ""
                          : ", of another commit: ",
            lines == NULL ? error.text
            : same        ? ""
                          : results_text(run, "commit"));
    json_decref(now);
    json_decref(lines);
}

/* This program again, with the step's command. The status that it ends with. */
static int run_step(const step *s, const char *path, double seconds, unsigned seed) {
    char text[1024], place[1024];
    const char *words[WORDS_MAX + 1] = {"/proc/self/exe"};
    size_t count = 1;
    int used = snprintf(text, sizeof text, "%s --seed %u", s->words, seed);
    if (s->share > 0) snprintf(text + used, sizeof text - (size_t)used, " --seconds %.3g", seconds);
    for (char *word = strtok(text, " "); word && count + 3 < WORDS_MAX; word = strtok(NULL, " ")) words[count++] = word;
    snprintf(place, sizeof place, "%s", path);
    const bool folder = strncmp(s->words, "micro", 5) != 0; /* takes the file's folder instead of the file */
    if (folder) *strrchr(place, '/') = '\0';
    words[count++] = folder ? "--out" : "--json";
    words[count++] = place;
    return child_run(words, NULL, NULL);
}

static bool run(const campaign *c, const measure_options *o, io_error *error) {
    double shares = 0, load = 0;
    size_t failed = 0;
    for (size_t k = 0; k < c->count; k++) shares += c->steps[k].share;
    if (!io_folder_make(o->out, error)) return false;
    if (getloadavg(&load, 1) == 1 && load > 0.5)
        fprintf(stderr, "The load of this machine is %.1f: other programs disturb the measurement.\n", load);
    const double start = clock_seconds();
    for (size_t k = 0; k < c->count; k++) {
        const step *s = &c->steps[k];
        char path[900];
        if (snprintf(path, sizeof path, "%s/%s", o->out, s->file) >= (int)sizeof path)
            return io_fail(error, "--out %s: the name is too long", o->out);
        if (!o->again && access(path, F_OK) == 0) {
            tell_kept(path, k + 1, c->count);
            continue;
        }
        fprintf(stderr, "[%zu of %zu, %.0f s] %s: cellwalk-bench %s\n", k + 1, c->count, clock_seconds() - start, path,
                s->words);
        const int status = run_step(s, path, o->seconds * s->share / shares, o->seed);
        if (status < 0) return io_fail(error, "%s: the program does not start again: %s", s->file, strerror(errno));
        if (status > 128)
            return io_fail(error, "%s: stopped by signal %d; the same command goes on from here", s->file,
                           status - 128);
        if (status == 0 && access(path, F_OK) == 0) continue;
        command_fail("measure", "%s: ended with status %d", s->file, status);
        failed++;
    }
    fprintf(stderr, "%.0f s, %zu of %zu files are in %s\n", clock_seconds() - start, c->count - failed, c->count,
            o->out);
    return failed == 0 || io_fail(error, "%zu files could not be made", failed);
}

static int start(int argc, char **argv) {
    measure_options o = {.out = "out/measure", .seed = 1};
    const option_spec options[] = {
        {"out", "FOLDER", "where to put the files; made if need be (out/measure)", OPTION_TEXT, .to = &o.out},
        {"seconds", "S",
         "time for what is timed (1500; 10 with --quick); making fields and building Embree takes a quarter of an hour "
         "more",
         OPTION_REAL, .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"seed", "N", "seed of rays and order (1)", OPTION_COUNT, .to = &o.seed, .high = UINT_MAX},
        {"again", NULL, "make the files that are there, too", OPTION_FLAG, .to = &o.again},
        {"quick", NULL, "small fields and few rays: to see whether all runs", OPTION_FLAG, .to = &o.quick},
    };
    const options_usage usage = {"measure", "[OPTIONS]", what, NULL, options, sizeof options / sizeof *options,
                                 NULL,      0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    io_error error = {{0}};
    campaign c = {.count = 0};
    plan(&c, o.quick);
    if (o.seconds <= 0) o.seconds = o.quick ? 10 : 1500;
    return run(&c, &o, &error) ? EXIT_SUCCESS : command_fail("measure", "%s", error.text);
}

const command command_measure = {"measure", "make every file of results that the papers quote", start};
