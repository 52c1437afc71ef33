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
    switch (status) {
    case CW_OK:
        return "no error";
    case CW_ERROR_ARGUMENT:
        return "an argument is missing, out of range or unknown to this version";
    case CW_ERROR_SAMPLE:
        return "a sample lies beyond plus or minus 2^100, or a borrowed one is infinite; mark holes by NaN";
    case CW_ERROR_KERNEL:
        return "there is no such kernel here, or it does not have this leaf test";
    case CW_ERROR_NOT_BUILT:
        return "the kernel needs a structure that has not been built for this field";
    case CW_ERROR_MEMORY:
        return "out of memory";
    case CW_ERROR_BUSY:
        return "a field cannot be updated while queries or another update run on it";
    case CW_ERROR_CANCELLED:
        return "cancelled";
    }
    return "unknown status";
}
