/* SPDX-License-Identifier: Apache-2.0 */
/* GDAL and the network. */
#ifndef CELLWALK_IO_GDAL_NETWORK_H
#define CELLWALK_IO_GDAL_NETWORK_H

#include <stdbool.h>

/* Once, before any file is opened: GDAL sends no request unless network; standard input and output it never takes. */
void gdal_network_close(bool network);
/* After drivers were registered: those that do not keep to local files go again. */
void gdal_network_drivers(void);

/* Whether the name is an address on the network that GDAL must not be given. */
bool gdal_network_is_url(const char *path);
/* Whether anything was refused since the last reset. */
void gdal_network_reset(void);
bool gdal_network_asked(void);
/* The name of the driver that gdal_network_drivers took away and that would read the file; NULL if there is none. kind: GDAL_OF_RASTER
 * or GDAL_OF_VECTOR. */
const char *gdal_network_driver_of(const char *path, unsigned kind);

#endif
