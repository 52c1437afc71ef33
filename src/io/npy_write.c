/* SPDX-License-Identifier: Apache-2.0 */
/* Writing .npy files. The size is known before the first element, so that a full disk is found out at the start; the
 * elements are written and not mapped, because a mapped page without room behind it kills the process. */

#include "npy.h"

#include <string.h>

enum { ALIGNMENT = 64 }; /* of the first element, as NumPy has it */

/* Version 1.0: magic, version, length of the rest as 16 bits, the dictionary, blanks up to the alignment, newline. */
static bool write_header(io_npy_writer *writer, const char *type, uint64_t rows, io_error *error) {
    char header[1024] = "\x93NUMPY\x01";
    const size_t start = 10, room = sizeof header - ALIGNMENT - start;
    const int length = snprintf(header + start, room, "{'descr': %s, 'fortran_order': False, 'shape': (%llu,), }", type,
                                (unsigned long long)rows);
    if (length < 0 || (size_t)length >= room) return io_fail(error, "%s: too many fields", writer->output.name);
    size_t size = start + (size_t)length;
    while ((size + 1) % ALIGNMENT != 0) header[size++] = ' ';
    header[size++] = '\n';
    header[8] = (char)((size - start) & 0xff);
    header[9] = (char)((size - start) >> 8);
    return io_output_reserve(&writer->output, size + writer->left, error) &&
           io_output_write(&writer->output, header, size, error);
}

bool io_npy_create(io_npy_writer *writer, const char *path, const char *type, size_t item, uint64_t rows,
                   io_error *error) {
    *writer = (io_npy_writer){0};
    if (rows > INT64_MAX / item) return io_fail(error, "%s: too many elements for any file", path);
    writer->left = rows * item;
    if (!io_output_open(&writer->output, path, error)) return false;
    if (write_header(writer, type, rows, error)) return true;
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
