/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_HARNESS_FOLDER_H
#define CELLWALK_BENCH_HARNESS_FOLDER_H

#include "error.h"

/* Makes a folder and those that it lies in; one that is there already is good as well. */
bool folder_make(const char *path, io_error *error);

#endif
