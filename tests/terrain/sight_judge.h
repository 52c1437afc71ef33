/* SPDX-License-Identifier: Apache-2.0 */
/* Lines of sight in rational numbers, by a look at every edge on the way. */
#ifndef CELLWALK_TESTS_TERRAIN_SIGHT_JUDGE_H
#define CELLWALK_TESTS_TERRAIN_SIGHT_JUDGE_H

#include "sight.h"

/* Of all between the eye and a place at height z, and above over it, both ends left out, 1: something is above the line, 0: something
 * touches it, -1: neither. */
int judge_line(const sight *s, double i, double j, double z, double above);

#endif
