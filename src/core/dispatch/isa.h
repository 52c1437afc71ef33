/* SPDX-License-Identifier: Apache-2.0 */
/* What this machine can run. */
#ifndef CELLWALK_CORE_ISA_H
#define CELLWALK_CORE_ISA_H

#include "cellwalk.h"

/* The widest instruction set of the machine itself, whatever the limit. */
cw_isa cw_isa_machine(void);

#endif
