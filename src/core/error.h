/* SPDX-License-Identifier: Apache-2.0 */
/* Messages for cw_last_error: each failure of a public function calls cw_fail once. */
#ifndef CELLWALK_CORE_ERROR_H
#define CELLWALK_CORE_ERROR_H

#include "cellwalk.h"

/* Keeps the sentence for this thread and returns status. */
__attribute__((format(printf, 2, 3))) cw_status cw_fail(cw_status status, const char *format, ...);

/* The same for failures that need no more words than the status has. */
cw_status cw_fail_plainly(cw_status status);

#endif
