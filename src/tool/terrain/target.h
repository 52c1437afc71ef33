/* SPDX-License-Identifier: Apache-2.0 */
/* The options of a viewshed that say which targets count. */
#ifndef CELLWALK_TOOL_TERRAIN_TARGET_H
#define CELLWALK_TOOL_TERRAIN_TARGET_H

#include "ground.h"
#include "view_limits.h"

typedef struct target_options {
    double height; /* metres above ground */
    sight_limits limits;
    const char *azimuth, *vertical; /* the texts */
} target_options;

enum { TARGET_OPTION_COUNT = 5 };
void target_rows(target_options *t, option_spec rows[TARGET_OPTION_COUNT]);

/* Reads the options' values; false after a message. */
bool target_options_read(target_options *t, const char *name);

/* Notes those that were given. */
void target_note(const target_options *t, ground_notes *notes);

#endif
