/* SPDX-License-Identifier: Apache-2.0 */
#include "cellwalk.h"

const char *cw_version(void) { return CW_VERSION; }

const char *cw_status_message(cw_status status) {
    switch (status) {
    case CW_OK:
        return "no error";
    case CW_ERROR_ARGUMENT:
        return "a required pointer is NULL";
    case CW_ERROR_SIZE:
        return "a field needs 2 to 8388608 samples a side and fewer than 2147483648 in all";
    case CW_ERROR_STRIDE:
        return "the row stride is shorter than a row, or rows that far apart exceed the address space";
    case CW_ERROR_MAP:
        return "the map to user space is not finite or cannot be inverted";
    case CW_ERROR_HEIGHT:
        return "a sample lies beyond plus or minus 2^100; mark holes by NaN";
    case CW_ERROR_HOLE:
        return "borrowed samples hold an infinity; mark holes by NaN or let the field copy them";
    case CW_ERROR_MEMORY:
        return "out of memory";
    case CW_ERROR_UNAVAILABLE:
        return "this CPU, or the limit on instruction sets, rules the kernel out";
    case CW_ERROR_UNSUPPORTED:
        return "the kernel does not offer this leaf test";
    case CW_ERROR_NOT_BUILT:
        return "the kernel needs a structure that has not been built for this field";
    case CW_ERROR_THREAD:
        return "a thread could not be started";
    case CW_ERROR_OPTION:
        return "an option has no such value, or a tolerance is negative or not finite";
    case CW_ERROR_KERNEL:
        return "there is no kernel of that name";
    case CW_ERROR_POOL_SIZE:
        return "a pool has at most 4096 threads";
    case CW_ERROR_SLANTED:
        return "the map to user space leans the heights, so that no single place is above (x, y)";
    case CW_ERROR_CANCELLED:
        return "cancelled";
    case CW_ERROR_BUSY:
        return "a field cannot be updated while queries or another update run on it";
    case CW_ERROR_DIRECTION:
        return "a heading's direction is not finite, or its longer component is not from 2^-40 to 2^40";
    case CW_ERROR_SLOPE:
        return "a slope is NaN, or the lowest slope lies above the highest";
    case CW_ERROR_RECTANGLE:
        return "the rectangle is no part of the field";
    }
    return "unknown status";
}
