/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_COMMANDS_H
#define CELLWALK_BENCH_COMMANDS_H

#include "command.h"

extern const command command_table, command_measure;

#endif
