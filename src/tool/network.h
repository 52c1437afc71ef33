/* SPDX-License-Identifier: Apache-2.0 */
/* The network, closed to the program. */
#ifndef CELLWALK_TOOL_NETWORK_H
#define CELLWALK_TOOL_NETWORK_H

#include "io_error.h"

/* From now on no thread of this process, and no process that it starts, gets a socket: socket() fails with EACCES. For
 * good. False where the system has no such filter. */
bool network_close(io_error *error);

#endif
