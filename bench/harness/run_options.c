/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/run_options.h"

#include "command.h"

#include <limits.h>
#include <sched.h>

void run_options_rows(run_options *run, option_spec rows[RUN_OPTION_COUNT]) {
    *run = (run_options){.seed = 1, .isa = -1, .cpu = UINT_MAX};
    rows[0] = (option_spec){
        "isa",       "NAME",          "the highest instruction set to use, by Embree as well; by default the best here",
        OPTION_NAME, .to = &run->isa, .names = option_isa_names};
    rows[1] =
        (option_spec){"seed", "N", "seed of rays and order (1)", OPTION_COUNT, .to = &run->seed, .high = UINT_MAX};
    rows[2] = (option_spec){"cpu",
                            "N",
                            "stay on this CPU; by default on the one that the program starts on",
                            OPTION_COUNT,
                            .to = &run->cpu,
                            .high = 1023};
    rows[3] =
        (option_spec){"no-pin", NULL, "let the system move the program between CPUs", OPTION_FLAG, .to = &run->no_pin};
}

bool run_options_check(run_options *run, const char *name) {
    const cw_isa best = cw_isa_best();
    if (run->isa < 0) run->isa = (int)best;
    if (run->isa > (int)best) {
        command_fail(name, "--isa %s: this machine, or CELLWALK_ISA, allows no more than %s",
                     cw_isa_name((cw_isa)run->isa), cw_isa_name(best));
        return false;
    }
    cw_isa_limit((cw_isa)run->isa);
    return true;
}

bool run_options_pin(const run_options *run, int *cpu, io_error *error) {
    cpu_set_t set;
    *cpu = run->cpu == UINT_MAX ? sched_getcpu() : (int)run->cpu;
    CPU_ZERO(&set);
    if (*cpu >= 0 && *cpu < CPU_SETSIZE) CPU_SET((size_t)*cpu, &set);
    if (run->no_pin) *cpu = -1;
    return run->no_pin || sched_setaffinity(0, sizeof set, &set) == 0 ||
           io_fail(error, "--cpu %d: the system does not allow this process there", *cpu);
}
