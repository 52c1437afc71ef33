/* SPDX-License-Identifier: Apache-2.0 */
/* Files beside a raster that programs read as part of it: statistics, smaller copies, masks, world files. Those of a file
 * that is replaced would be wrong for the new one, and are removed with it. */
#ifndef CELLWALK_IO_RASTER_SIDECARS_H
#define CELLWALK_IO_RASTER_SIDECARS_H

#include "io_error.h"

/* What programs read beside a format, up to a NULL: ".ovr" is added to the raster's name, "*.tfw" takes the place of its
 * ending. */
typedef const char *const *io_sidecar_list;

/* For an output that replaces no file: false if a file of the list is there, which would be read with the new raster but
 * may be wanted. For one that replaces a file: false if one of the list is an input. */
bool io_sidecars_check(io_sidecar_list list, const char *path, bool replaces, io_error *error);

/* Removes them; links, and not the files behind them. False, with a message, if one stays. */
bool io_sidecars_remove(io_sidecar_list list, const char *path, io_error *error);

#endif
