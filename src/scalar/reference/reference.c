/* SPDX-License-Identifier: Apache-2.0 */
#include "reference.h"

#include "paths.h"

static const cw_kernel kernels[] = {
    {"brute", "every triangle: the ground truth for small fields", CW_ISA_SCALAR, 1, &cw_brute, cw_heading1,
     cw_to_field1, NULL},
    {"grid3d", "uniform 3D grid, 3D-DDA", CW_ISA_SCALAR, 1, &cw_grid3d, cw_heading1, cw_to_field1, cw_grid3d_build},
};

void cw_reference_add(void) { cw_kernels_add(kernels, sizeof kernels / sizeof kernels[0]); }
