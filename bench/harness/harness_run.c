/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/harness_run.h"

#include "build_info.h"
#include "command.h"
#include "commit.h"
#include "cpus.h"
#include "harness/results.h"
#include "number.h"
#include "peers/peer.h"
#include "proc.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* ---- options ---- */

bool run_options_check(run_options *run, const char *name) {
    run->isa = run->isa < 0 ? (int)cw_isa_best() : CW_ISA_SCALAR + run->isa; /* the option counts names */
    return option_isa_environment(name) && option_isa_limit(name, (cw_isa)run->isa);
}

bool run_options_pin(const run_options *run, int *cpu, io_error *error) {
    cpu_set_t set;
    *cpu = run->no_pin ? -1 : sched_getcpu();
    if (*cpu < 0) return true;
    CPU_ZERO(&set);
    CPU_SET((size_t)*cpu, &set);
    return sched_setaffinity(0, sizeof set, &set) == 0 ||
           io_fail(error, "CPU %d: the system does not keep this process there", *cpu);
}

/* ---- record ---- */

bool run_memory_has(double bytes, char why[192]) {
    char kibibytes[64];
    proc_value("/proc/meminfo", "MemAvailable", kibibytes, sizeof kibibytes);
    const double available = number_read(kibibytes, NULL) * 1024;
    if (available <= 0 || bytes < available) return true;
    snprintf(why, 192, "it would take about %.1f GB, and %.1f GB are available", bytes * 1e-9, available * 1e-9);
    return false;
}

static char arguments_text[4096];
static unsigned cpus; /* before a measurement stays on one of them */

void run_record_begin(char **arguments, int count) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=+,./:@%";
    size_t used = 0;
    cpus = cpus_usable();
    arguments_text[0] = '\0';
    /* Words that a shell would take apart are quoted. */
    for (int k = 0; k < count && used < sizeof arguments_text; k++) {
        const char *quote = *arguments[k] && arguments[k][strspn(arguments[k], plain)] == '\0' ? "" : "'";
        used += (size_t)snprintf(arguments_text + used, sizeof arguments_text - used, "%s%s%s%s", k ? " " : "", quote,
                                 arguments[k], quote);
    }
}

json_t *run_record(const char *name, uint32_t seed, int cpu) {
    char model[256], cache[64], date[32];
    if (cpus == 0) cpus = cpus_usable();
    proc_cpu(model, sizeof model);
    proc_value("/proc/cpuinfo", "cache size", cache, sizeof cache);
    double load = -1;
    if (getloadavg(&load, 1) != 1) load = -1;
    const time_t now = time(NULL);
    struct tm utc;
    strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
    json_t *record = json_object();
    results_set_texts(record, "kind command arguments cellwalk cpu cache",
                      (const char *[]){"run", name, arguments_text, CW_VERSION, model, cache});
    results_set_counts(record, "cpus", &(size_t){cpus});
    results_set_texts(record, "isa compiler build_type flags commit embree",
                      (const char *[]){cw_isa_name(cw_isa_best()), BUILD_INFO_COMPILER, BUILD_INFO_TYPE,
                                       BUILD_INFO_FLAGS, BUILD_INFO_COMMIT, peer_embree.version});
    results_set_counts(record, "seed", &(size_t){seed});
    json_object_set_new(record, "pinned_to_cpu", json_integer(cpu));
    results_set_numbers(record, "load", &load);
    json_object_set_new(record, "date", json_string(date));
    return record;
}

void run_record_text(const json_t *record, char *text, size_t size) {
    const char *embree = results_text(record, "embree");
    snprintf(text, size, "%s, %s, %s, %s, commit %s, Embree %s, one thread, seed %.0f, load %.2f, %s",
             results_text(record, "cpu"), results_text(record, "isa"), results_text(record, "compiler"),
             results_text(record, "build_type"), results_text(record, "commit"), *embree ? embree : "none",
             results_number(record, "seed"), results_number(record, "load"), results_text(record, "date"));
}
