/* SPDX-License-Identifier: Apache-2.0 */
/* NumPy's array files (.npy, versions 1.0 to 3.0): reading plain numbers in C order by rows, and writing from start to
 * end. Neither needs memory for the whole array. */
#ifndef CELLWALK_IO_NPY_H
#define CELLWALK_IO_NPY_H

#include "io_error.h"
#include "output.h"

#include <stddef.h>
#include <stdint.h>

enum { IO_NPY_RANK_MAX = 8, IO_NPY_TYPE_MAX = 8 };

/* The contents of a header. */
typedef struct io_npy_header {
    char type[IO_NPY_TYPE_MAX]; /* NumPy's name of the element type: "<f4", "|u1" */
    size_t item;                /* bytes an element */
    size_t rank;
    uint64_t shape[IO_NPY_RANK_MAX];
} io_npy_header;

typedef struct io_npy {
    io_npy_header header;
    char *path;
    uint64_t offset;    /* of the first element in the file */
    uint64_t row_bytes; /* of one step along the first axis */
    int fd;
    void *rows; /* that were read last, in room for so many bytes */
    uint64_t room;
} io_npy;

/* Opens a file whose size agrees with its header. On failure npy needs no closing. */
bool io_npy_open(io_npy *npy, const char *path, io_error *error);
void io_npy_close(io_npy *npy);

/* False, with the file's type and the wanted ones in error, unless the element type is one of count. */
bool io_npy_expect_type(const io_npy *npy, const char *const *types, size_t count, io_error *error);

/* "(1000, 8)" in text. */
void io_npy_shape_text(size_t rank, const uint64_t *shape, char *text, size_t size);

/* Rows [first, first + count), each row_bytes long, aligned for their type; valid until the next call on npy. NULL on
 * failure. */
const void *io_npy_rows(io_npy *npy, uint64_t first, uint64_t count, io_error *error);

/* Writes the header of an array of that shape at the start of an output and claims room for all of it, so that a full
 * disk is found before the work. type is a Python expression: "'<f4'" or a list of fields; item its size in bytes. */
bool io_npy_write_header(io_output *output, const char *type, size_t item, size_t rank, const uint64_t *shape,
                         io_error *error);

#endif
