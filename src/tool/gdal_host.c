/* SPDX-License-Identifier: Apache-2.0 */
/* Libraries behind GDAL (HDF5, libdap, netCDF and others) print what files contain, commands to the terminal included.
 * While GDAL runs, the standard streams therefore lead to /dev/null. GDAL still hands over the reason of a failure. */

#include "gdal_host.h"

#include "network.h"
#include "raster.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { FIRST = STDOUT_FILENO, STREAMS = 2 };
static int streams[STREAMS], nothing = -1; /* copies, and /dev/null */
static atomic_int messages = STDERR_FILENO;

int gdal_host_messages(void) { return atomic_load(&messages); }

/* What is in the buffer of standard output belongs to the place that it leads to so far. */
static void lead(const int to[STREAMS]) {
    fflush(stdout);
    for (int k = 0; k < STREAMS; k++)
        while (dup2(to[k], FIRST + k) < 0 && errno == EINTR) continue;
}

static void hide(void) { lead((const int[STREAMS]){nothing, nothing}); }
static void show(void) { lead(streams); }

static bool prepare(bool network, io_error *error) {
    if (nothing >= 0) return true;
    if (!network && !network_close(error)) return false;
    const int to = open("/dev/null", O_RDWR | O_CLOEXEC);
    for (int k = 0; k < STREAMS; k++) streams[k] = fcntl(FIRST + k, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (to < 0 || streams[0] < 0 || streams[1] < 0)
        return io_fail(error, "cannot load GDAL: /dev/null: %s", strerror(errno));
    nothing = to;
    atomic_store(&messages, streams[STREAMS - 1]);
    return true;
}

static io_gdal_host host = {.prepare = prepare, .hide_streams = hide, .show_streams = show};

void gdal_host_install(void) { io_raster_host(&host); }

void gdal_allow_network(void) { host.network = true; }
