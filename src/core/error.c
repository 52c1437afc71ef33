/* SPDX-License-Identifier: Apache-2.0 */
#include "error.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char text[256];

cw_status cw_fail(cw_status status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return status;
}

cw_status cw_fail_plainly(cw_status status) { return cw_fail(status, "%s", cw_status_message(status)); }

const char *cw_last_error(void) { return text; }

const char *cw_version(void) { return CW_VERSION; }
uint32_t cw_version_number(void) { return CW_VERSION_NUMBER; }

const char *cw_status_message(cw_status status) {
    static const char *const messages[] = {
        [CW_OK] = "no error",
        [CW_ERROR_ARGUMENT] = "an argument is missing, out of range or unknown to this version",
        [CW_ERROR_SAMPLE] =
            "a sample lies beyond plus or minus 2^100, or a borrowed one is infinite; mark holes by NaN",
        [CW_ERROR_KERNEL] = "there is no such kernel here, or it does not have this leaf test",
        [CW_ERROR_NOT_BUILT] = "the kernel needs a structure that has not been built for this field",
        [CW_ERROR_MEMORY] = "out of memory",
        [CW_ERROR_BUSY] = "a field cannot be updated while queries or another update run on it",
        [CW_ERROR_CANCELLED] = "cancelled",
    };
    return (uint32_t)status < sizeof messages / sizeof messages[0] ? messages[status] : "unknown status";
}
