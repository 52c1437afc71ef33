/* SPDX-License-Identifier: Apache-2.0 */
/* Lines of sight between pairs of places from a table, written as a table. */
#ifndef CELLWALK_TOOL_TERRAIN_LOS_PAIRS_H
#define CELLWALK_TOOL_TERRAIN_LOS_PAIRS_H

#include "output.h"
#include "product.h"

/* path: a table with the columns x1, y1, x2, y2 and, if there, height1 and height2. megahertz: 0, or that of radio links, whose
 * clearance is written too. profiles may be NULL. */
bool los_pairs(product *p, const char *path, double curvature, double megahertz, io_output *results,
               io_output *profiles, io_error *error);

#endif
