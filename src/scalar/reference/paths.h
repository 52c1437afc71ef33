/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_REFERENCE_PATHS_H
#define CELLWALK_REFERENCE_PATHS_H

#include "kernels.h"

extern const cw_kernel_code cw_brute, cw_grid3d;

/* Makes the grid a guest of the field. */
cw_status cw_grid3d_build(cw_field *field);

#endif
