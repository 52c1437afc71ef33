/* SPDX-License-Identifier: Apache-2.0 */
/* Writing .npy files. The size is known before the first element, so that a full disk is found out at the start; the
 * elements are written and not mapped, because a mapped page without room behind it kills the process. */

#include "npy.h"

#include <string.h>

enum { ALIGNMENT = 64 }; /* of the first element, as NumPy has it */

/* Version 1.0: magic, version, length of the rest as 16 bits, the dictionary, blanks up to the alignment, newline. */
bool io_npy_write_header(io_output *output, const char *type, size_t item, size_t rank, const uint64_t *shape,
                         io_error *error) {
    char header[1024] = "\x93NUMPY\x01", sides[24 * IO_NPY_RANK_MAX] = "";
    uint64_t bytes = item;
    size_t used = 0;
    for (size_t k = 0; k < rank; k++) {
        if (shape[k] > 0 && bytes > INT64_MAX / shape[k])
            return io_fail(error, "%s: too many elements for any file", output->name);
        bytes *= shape[k];
        used += (size_t)snprintf(sides + used, sizeof sides - used, "%s%llu%s", k > 0 ? " " : "",
                                 (unsigned long long)shape[k], k + 1 < rank || rank == 1 ? "," : "");
    }
    const size_t start = 10, room = sizeof header - ALIGNMENT - start;
    const int length =
        snprintf(header + start, room, "{'descr': %s, 'fortran_order': False, 'shape': (%s), }", type, sides);
    if (length < 0 || (size_t)length >= room) return io_fail(error, "%s: too many fields", output->name);
    size_t size = start + (size_t)length;
    while ((size + 1) % ALIGNMENT != 0) header[size++] = ' ';
    header[size++] = '\n';
    header[8] = (char)((size - start) & 0xff);
    header[9] = (char)((size - start) >> 8);
    return io_output_reserve(output, size + bytes, error) && io_output_write(output, header, size, error);
}

bool io_npy_create(io_npy_writer *writer, const char *path, const char *type, size_t item, uint64_t rows,
                   io_error *error) {
    *writer = (io_npy_writer){.left = rows * item};
    if (rows > INT64_MAX / item) return io_fail(error, "%s: too many elements for any file", path);
    if (!io_output_open(&writer->output, path, error)) return false;
    if (io_npy_write_header(&writer->output, type, item, 1, &rows, error)) return true;
    io_npy_discard(writer);
    return false;
}

bool io_npy_write(io_npy_writer *writer, const void *bytes, size_t size, io_error *error) {
    if (size > writer->left) return io_fail(error, "%s: more elements than announced", writer->output.name);
    writer->left -= size;
    return io_output_write(&writer->output, bytes, size, error);
}

bool io_npy_commit(io_npy_writer *writer, io_error *error) {
    if (writer->left == 0) return io_output_commit(&writer->output, error);
    io_fail(error, "%s: %llu bytes of elements are missing", writer->output.name, (unsigned long long)writer->left);
    io_npy_discard(writer);
    return false;
}

void io_npy_discard(io_npy_writer *writer) { io_output_discard(&writer->output); }
