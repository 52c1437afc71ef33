/* SPDX-License-Identifier: Apache-2.0 */
/* The instruction sets that this machine can run. */
#ifndef CELLWALK_CORE_ISA_H
#define CELLWALK_CORE_ISA_H

#include "cellwalk_expert.h"

/* The widest instruction set of the machine itself, without any limit. */
cw_isa cw_isa_machine(void);

/* The widest set that both include; b may be CW_ISA_ANY. */
cw_isa cw_isa_common(cw_isa a, cw_isa b);

/* True if kernels for isa may run: it is included in cw_isa_best(). */
bool cw_isa_allows(cw_isa isa);

#endif
