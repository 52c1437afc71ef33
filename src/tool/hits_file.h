/* SPDX-License-Identifier: Apache-2.0 */
/* Hits as a structured NumPy array: packed records of 21 bytes. */
#ifndef CELLWALK_TOOL_HITS_FILE_H
#define CELLWALK_TOOL_HITS_FILE_H

#include "cellwalk.h"
#include "npy.h"

/* The array as NumPy sees it has the fields t (float32), i, j (int32), triangle (uint8), u, v (float32). */
bool hits_file_create(io_npy_writer *writer, const char *path, uint64_t rays, io_error *error);

bool hits_file_write(io_npy_writer *writer, const cw_hit *hits, size_t n, io_error *error);

#endif
