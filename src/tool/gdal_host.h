/* SPDX-License-Identifier: Apache-2.0 */
/* What the program does with GDAL: no network, and nothing printed by the libraries behind it. */
#ifndef CELLWALK_TOOL_GDAL_HOST_H
#define CELLWALK_TOOL_GDAL_HOST_H

/* Once, before anything is read. */
void gdal_host_install(void);

/* Before GDAL is loaded: leaves the network open. */
void gdal_allow_network(void);

/* The descriptor of standard error, also while GDAL runs. For signal handlers. */
int gdal_host_messages(void);

#endif
