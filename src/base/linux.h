/* SPDX-License-Identifier: Apache-2.0 */
/* CELLWALK_LINUX is 1 where calls may be used that Linux alone has. Each has another way beside it; CELLWALK_PORTABLE
 * turns all of these on, so that they are compiled and tested on Linux. */
#ifndef CELLWALK_BASE_LINUX_H
#define CELLWALK_BASE_LINUX_H

#if defined(__linux__) && !defined(CELLWALK_PORTABLE)
#define CELLWALK_LINUX 1
#else
#define CELLWALK_LINUX 0
#endif

#endif
