/* SPDX-License-Identifier: Apache-2.0 */
/* The libraries that reading and writing may do without, and which of them this program has. */
#ifndef CELLWALK_IO_PARTS_H
#define CELLWALK_IO_PARTS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct io_part {
    const char *name; /* "OpenEXR" */
    const char *for_what;
    bool there; /* GDAL: its module is where it belongs; it is not loaded for that */
} io_part;

enum { IO_PARTS = 3 };
io_part io_part_at(size_t number);

#endif
