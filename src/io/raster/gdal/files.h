/* SPDX-License-Identifier: Apache-2.0 */
/* The files that GDAL may open. */
#ifndef CELLWALK_IO_GDAL_FILES_H
#define CELLWALK_IO_GDAL_FILES_H

#include <stdbool.h>

/* From now on GDAL opens outputs and, in a process of the program's own, of all other files regular ones alone. */
void gdal_files_install(bool own_process);

/* The first name since the last reset that GDAL could not open because it is a pipe or a device; NULL if there is none. */
void gdal_files_reset(void);
const char *gdal_files_refused(void);

/* A file to be written, which GDAL has another name for, and all whose names begin with its path. By one thread at a time. */
typedef struct gdal_output {
    const char *path;
    int reason; /* the errno of the first call that failed, or 0 */
    struct gdal_output *next;
} gdal_output;

void gdal_output_add(gdal_output *output);
void gdal_output_remove(gdal_output *output);

/* GDAL's name of a file, to be freed; NULL if memory is short. */
char *gdal_output_name(const char *path);

#endif
