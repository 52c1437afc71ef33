/* SPDX-License-Identifier: Apache-2.0 */
/* The program's subcommands. */
#ifndef CELLWALK_TOOL_COMMANDS_H
#define CELLWALK_TOOL_COMMANDS_H

#include "command.h"

extern const command command_info;

extern const command command_render;
extern const command command_trace;
/* terrain/ */
extern const command command_horizon;
extern const command command_los;
extern const command command_shadow;
extern const command command_sun;
extern const command command_viewshed;
extern const command command_visibility;

#endif
