/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the system lets this process start threads. */
#ifndef CELLWALK_IO_GDAL_THREADS_H
#define CELLWALK_IO_GDAL_THREADS_H

#include <stdbool.h>

/* True if so many threads, and some more, can run beside those that there are. Those tried have ended by the return. */
bool threads_can_start(unsigned wanted);

#endif
