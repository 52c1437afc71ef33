/* SPDX-License-Identifier: Apache-2.0 */
/* What libcellwalk_terrain needs of libcellwalk and no header for users has. The shared library exports it for its
 * sister of the same version alone. */
#ifndef CELLWALK_CORE_SISTER_H
#define CELLWALK_CORE_SISTER_H

#include "door.h"
#include "error.h"
#include "memory.h"
#include "run.h"

/* False while an update runs on the field. Otherwise updates fail with CW_ERROR_BUSY until cw_field_leave. */
CW_API bool cw_field_enter(const cw_field *field, door_pass *pass);
CW_API void cw_field_leave(door_pass pass);

#endif
