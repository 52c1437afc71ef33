/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of the ground for pictures, by height. */
#ifndef CELLWALK_GROUND_TINT_H
#define CELLWALK_GROUND_TINT_H

#include "image.h"
#include "terrain.h"

/* Green at the lowest height, brown, white at the highest. */
bool tint_heights(io_image *colours, const terrain *t, io_error *error);

#endif
