/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_HARNESS_FOLDER_H
#define CELLWALK_BENCH_HARNESS_FOLDER_H

#include "output.h"

/* Makes a folder and those that it lies in; one that is there already is good as well. */
bool folder_make(const char *path, io_error *error);

/* Opens the file in the folder, which is made if need be. */
bool folder_open(io_output *out, const char *folder, const char *name, io_error *error);

#endif
