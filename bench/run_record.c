/* SPDX-License-Identifier: Apache-2.0 */
#include "run_record.h"

#include "build_info.h"
#include "cellwalk.h"
#include "commit.h"
#include "peer_embree.h"
#include "timing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The value of the first line of a /proc file that starts with key; "unknown" if there is none. */
static void proc_value(const char *path, const char *key, char *value, size_t size) {
    snprintf(value, size, "unknown");
    FILE *file = fopen(path, "r");
    if (file == NULL) return;
    char line[512];
    while (fgets(line, sizeof line, file)) {
        const char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || colon == NULL) continue;
        colon += 1 + strspn(colon + 1, " \t");
        snprintf(value, size, "%.*s", (int)strcspn(colon, "\n"), colon);
        break;
    }
    fclose(file);
}

json_t *run_record(const char *command, uint32_t seed, int cpu) {
    char model[256], cache[64], date[32];
    proc_value("/proc/cpuinfo", "model name", model, sizeof model);
    proc_value("/proc/cpuinfo", "cache size", cache, sizeof cache);
    double load = -1;
    if (getloadavg(&load, 1) != 1) load = -1;
    const time_t now = time(NULL);
    struct tm utc;
    strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
    const char *embree = peer_embree_version();
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:i, s:s, s:s, s:s, s:s, s:s, s:s?, s:I, s:i, s:f, s:f, s:s}", "kind",
                     "run", "command", command, "cellwalk", CW_VERSION, "cpu", model, "cache", cache, "cpus",
                     (int)sysconf(_SC_NPROCESSORS_ONLN), "isa", cw_isa_name(cw_isa_best()), "compiler",
                     BUILD_INFO_COMPILER, "build_type", BUILD_INFO_TYPE, "flags", BUILD_INFO_FLAGS, "commit",
                     BUILD_INFO_COMMIT, "embree", embree, "seed", (json_int_t)seed, "pinned_to_cpu", cpu, "load", load,
                     "tsc_hz", timing_tick_rate(), "date", date);
}

static const char *text_of(const json_t *record, const char *key) {
    const char *text = json_string_value(json_object_get(record, key));
    return text ? text : "none";
}

void run_record_text(const json_t *record, char *text, size_t size) {
    snprintf(text, size,
             "%s, %s, %s, %s, commit %s, Embree %s, one thread, seed %" JSON_INTEGER_FORMAT ", load %.2f, %s",
             text_of(record, "cpu"), text_of(record, "isa"), text_of(record, "compiler"), text_of(record, "build_type"),
             text_of(record, "commit"), text_of(record, "embree"), json_integer_value(json_object_get(record, "seed")),
             json_real_value(json_object_get(record, "load")), text_of(record, "date"));
}
