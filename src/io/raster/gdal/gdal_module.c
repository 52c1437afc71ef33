/* SPDX-License-Identifier: Apache-2.0 */
/* The module's table, and GDAL made ready: for good in the program's own process, else for the time of each call. */

#include "parts.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <stdatomic.h>
#include <string.h>

static char of_thread[300]; /* the first error of one of GDAL's own threads */

bool gdal_fail(io_error *error, const char *name, const char *what) {
    const char *words = CPLGetLastErrorMsg();
    if (words[0] == '\0' && gdal_thread_failed()) words = of_thread;
    const size_t length = strlen(name);
    /* GDAL mostly begins with the file itself. */
    if (strncmp(words, name, length) == 0 && words[length] == ':')
        words += length + 1 + strspn(words + length + 1, " ");
    if (words[0] == '\0')
        io_fail(error, "%s: %s", name, what);
    else
        io_fail(error, "%s: %s (GDAL: %s)", name, what, words);
    CPLErrorReset();
    return false;
}

void gdal_warn(const io_warner *to, const char *format, ...) {
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    gdal_streams(true);
    io_warn(to, "%s", text);
    gdal_streams(false);
}

/* ---- settings ---------------------------------------------------------------------------------------------------- */

static const struct {
    const char *key, *value;
} settings[] = {
    {"GDAL_PAM_ENABLED", "NO"},       /* no .aux.xml beside files read and written */
    {"GDAL_VRT_ENABLE_PYTHON", "NO"}, /* a VRT may hold code */
    {"AAIGRID_DATATYPE", "Float64"},  /* else GDAL guesses from the first 100 kB, and cuts fractions that come later */
};
enum { SETTINGS = sizeof settings / sizeof settings[0] };

static const io_gdal_program *program;
static _Thread_local bool set_here[SETTINGS];

const io_gdal_program *gdal_program(void) { return program; }
const io_gdal_host *gdal_host(void) { return program->host; }

void gdal_streams(bool shown) {
    if (gdal_host() != NULL) (shown ? gdal_host()->show_streams : gdal_host()->hide_streams)();
}

bool gdal_enter(void) {
    CPLPushErrorHandler(CPLQuietErrorHandler); /* its text goes into the messages of this module */
    for (size_t k = 0; k < SETTINGS; k++) {
        set_here[k] = CPLGetConfigOption(settings[k].key, NULL) == NULL;
        if (set_here[k]) CPLSetThreadLocalConfigOption(settings[k].key, settings[k].value);
    }
    gdal_streams(false);
    return true;
}

void gdal_leave(const bool *entered) {
    (void)entered;
    gdal_streams(true);
    for (size_t k = 0; k < SETTINGS; k++)
        if (set_here[k]) CPLSetThreadLocalConfigOption(settings[k].key, NULL);
    CPLPopErrorHandler();
}

/* GDAL loses errors of its worker threads: if one has no memory to compress a tile, the file lacks that tile. Errors of
 * the calling thread do not come here. */
static atomic_bool thread_fails, thread_failed;

static void CPL_STDCALL note_error(CPLErr class, CPLErrorNum number, const char *text) {
    (void)number;
    /* GDAL 3.6 complains about the file in memory that a thread decompresses with, but then does so; the caller's
     * thread gets to know failures there. */
    const bool of_reading = strstr(text, "/vsimem/decompress_") != NULL;
    if (class < CE_Failure || of_reading || atomic_exchange(&thread_fails, true)) return;
    snprintf(of_thread, sizeof of_thread, "%s", text);
    atomic_store(&thread_failed, true);
}

bool gdal_thread_failed(void) { return atomic_load(&thread_failed); }

/* GDAL's own threads have no settings but these. */
static void own_process(void) {
    CPLSetErrorHandler(note_error);
    gdal_names_close_memory();
    if (!gdal_host()->network) OSRSetPROJEnableNetwork(0);
    for (size_t k = 0; k < SETTINGS; k++)
        if (CPLGetConfigOption(settings[k].key, NULL) == NULL) CPLSetConfigOption(settings[k].key, settings[k].value);
    if (CPLGetConfigOption("GDAL_NUM_THREADS", NULL) == NULL) CPLSetConfigOption("GDAL_NUM_THREADS", "1");
}

void gdal_start(const io_gdal_program *of) {
    program = of;
    GDALAllRegister();
    if (gdal_host() != NULL) own_process();
}

#define ENTRY(name) .name = gdal_##name,
__attribute__((visibility("default"))) const io_gdal cellwalk_gdal_17 = {IO_GDAL_FUNCTIONS(ENTRY)};
