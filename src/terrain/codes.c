/* SPDX-License-Identifier: Apache-2.0 */
#include "codes.h"

#include "sister.h"

static const terrain_code codes[] = {
#define CODE(SET, LANES) {CW_ISA_##SET, cw_heading##LANES, &cw_visible##LANES},
    CELLWALK_TERRAIN_CODES /* the widest first; the last is scalar */
};

cw_status cw_terrain_settle(cw_run *how, const terrain_code **code) {
    how->expert.leaf = CW_LEAF_DEFAULT;
    const cw_status status = cw_run_settle(how);
    if (status != CW_OK) return status;
    const cw_isa most = cw_kernel_describe(how->expert.kernel).isa;
    *code = codes;
    while ((*code)->isa != CW_ISA_SCALAR && !cw_isa_includes(most, (*code)->isa)) ++*code;
    return CW_OK;
}
