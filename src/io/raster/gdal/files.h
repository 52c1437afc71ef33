/* SPDX-License-Identifier: Apache-2.0 */
/* The files that GDAL may open. */
#ifndef CELLWALK_IO_GDAL_FILES_H
#define CELLWALK_IO_GDAL_FILES_H

#include <stdbool.h>

/* From now on GDAL opens files that are lent to it and, in a process of the program's own, of all others regular ones alone. */
void gdal_files_install(bool own_process);

/* The first name since the last reset that GDAL could not open because it is a pipe or a device; NULL if there is none. */
void gdal_files_reset(void);
const char *gdal_files_refused(void);

/* Lends GDAL a file that is open for reading and writing, under a name of GDAL's. Returns a number for the other two, or -1 if
 * too many are lent. By one thread at a time. The reason is the errno of the first write that failed, or 0. */
enum { GDAL_LENT_NAME = 40 };
int gdal_lend(int fd, char name[GDAL_LENT_NAME]);
/* From now on GDAL may make files whose names begin with that one's and a point. Their bytes go to files that scratch opens,
 * which stay its own. They are taken back with that one. */
void gdal_lend_scratch(int number, int (*scratch)(void *context), void *context);
int gdal_lent_reason(int number);
void gdal_take_back(int number);

#endif
