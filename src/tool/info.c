/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk info`: what this machine can do, and what a field costs on it. */

#include "cellwalk.h"
#include "command.h"
#include "json.h"
#include "query_options.h"

#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct machine {
    char cpu[128];
    int cpus; /* that this process may use */
} machine;

static machine look_at_machine(void) {
    machine m = {.cpu = "unknown"};
    FILE *file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file && fgets(line, sizeof line, file)) {
        const char *value = strstr(line, ": ");
        if (strncmp(line, "model name", 10) != 0 || value == NULL) continue;
        snprintf(m.cpu, sizeof m.cpu, "%.*s", (int)strcspn(value + 2, "\n"), value + 2);
        break;
    }
    if (file) fclose(file);
    cpu_set_t set;
    m.cpus = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return m;
}

static void print_kernels(const cw_kernel *chosen) {
    printf("\n    %-14s %5s  %-8s %-16s %s\n", "kernel", "width", "needs", "leaf test", "what it is");
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

static void print_machine(const machine *m) {
    printf("cellwalk        %s\nCPU             %s, %d to use\ninstruction set %s", CW_VERSION, m->cpu, m->cpus,
           cw_isa_name(cw_isa_best()));
    const char *limit = getenv("CELLWALK_ISA");
    if (limit) printf(" (CELLWALK_ISA=%s)", limit);
    putchar('\n');
}

static void print_machine_json(const machine *m) {
    printf("{\"version\": \"%s\", \"cpu\": ", CW_VERSION);
    json_string(stdout, m->cpu);
    printf(", \"cpus\": %d, \"isa\": \"%s\", ", m->cpus, cw_isa_name(cw_isa_best()));
}

static int run(int argc, char **argv) {
    query_options q = {0};
    bool json = false;
    option_spec options[QUERY_OPTION_COUNT + 1];
    query_options_rows(&q, options);
    options[QUERY_OPTION_COUNT] =
        (option_spec){.name = "json", .help = "print one JSON object", .kind = OPTION_FLAG, .to = &json};
    const options_usage usage = {
        .name = "info",
        .synopsis = "[OPTIONS]",
        .what = "Shows the CPU, its instruction set as far as the system supports it, and the\n"
                "kernels (ways to find hits) with the one that is chosen.\n",
        .examples = "  cellwalk info\n"
                    "  cellwalk info --isa avx2          what would be chosen without AVX-512\n",
        .options = options,
        .option_count = QUERY_OPTION_COUNT + 1,
    };
    const options_result result = options_parse(&usage, argc, argv, NULL);
    if (result != OPTIONS_GO) return result == OPTIONS_HELP ? EXIT_SUCCESS : EXIT_USAGE;
    cw_query query;
    if (!query_options_resolve(&q, usage.name, &query)) return EXIT_USAGE;
    const machine m = look_at_machine();
    const cw_kernel *chosen = cw_query_kernel(NULL, &query);
    if (json) {
        print_machine_json(&m);
        print_kernels_json(chosen);
        puts("}");
    } else {
        print_machine(&m);
        print_kernels(chosen);
    }
    return EXIT_SUCCESS;
}

const command command_info = {"info", "this machine's kernels, and what a field costs", run};
