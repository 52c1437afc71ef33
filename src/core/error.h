/* SPDX-License-Identifier: Apache-2.0 */
/* Messages for cw_last_error: each failure of a public function calls cw_fail once. CW_API: see sister.h. */
#ifndef CELLWALK_CORE_ERROR_H
#define CELLWALK_CORE_ERROR_H

#include "cellwalk.h"

/* mingw-w64 checks formats as Microsoft's library has them, though _GNU_SOURCE selects C's own. */
#ifdef __MINGW32__
#define CW_PRINTF gnu_printf
#else
#define CW_PRINTF printf
#endif

/* Keeps the sentence for this thread and returns status. */
CW_API __attribute__((format(CW_PRINTF, 2, 3))) cw_status cw_fail(cw_status status, const char *format, ...);

/* The same for failures that need no more words than the status has. */
CW_API cw_status cw_fail_plainly(cw_status status);

#endif
