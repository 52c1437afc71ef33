/* SPDX-License-Identifier: Apache-2.0 */
/* The subcommands of cellwalk-bench, each in the room that it is named after. */
#ifndef CELLWALK_BENCH_COMMANDS_H
#define CELLWALK_BENCH_COMMANDS_H

#include "command.h"

extern const command command_accuracy, command_compare, command_micro, command_table, command_tradeoff;

#endif
