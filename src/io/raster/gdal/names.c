/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the file of a name. GDAL takes names that are no files', too: text of a dataset, addresses in memory, and
 * chains of such. A service may pass on the name of a stranger, so these are refused. */

#include "parts.h"

#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>

/* MEM reads the process's memory at any address. GDAL opens no name with it from version 3.10 on; before, a VRT can. A
 * driver that reads no rasters opens none, but still makes those that other drivers work with. */
void gdal_names_close_memory(void) {
    GDALDriverH memory = GDALGetDriverByName("MEM");
    if (memory != NULL) GDALSetMetadataItem(memory, GDAL_DCAP_RASTER, NULL, NULL);
}

static bool is_file(const char *path) {
    VSIStatBufL about;
    return VSIStatExL(path, &about, VSI_STAT_EXISTS_FLAG) == 0;
}

/* XML and JSON of VRT, MRF, map servers and others. */
static bool is_text(const char *path) {
    const char *start = path + strspn(path, " \t\r\n");
    return (start[0] == '{' || strchr(path, '<') != NULL) && !is_file(path);
}

/* Whether a path's file, or what stands in the place of one of its folders, is neither a regular file nor a folder. */
static bool is_special(char *path) {
    struct stat about;
    while (stat(path, &about) != 0) {
        char *slash = strrchr(path, '/');
        if (slash == NULL || slash == path) return false;
        *slash = '\0';
    }
    return !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode);
}

/* Whether a name is, or holds the name of, a device, or a pipe or standard stream whose writer GDAL would wait for. A
 * name may hold that of another file: /vsigzip/FILE, /vsisubfile/0_9,FILE, GTIFF_DIR:1:FILE, NETCDF:"FILE":z. Each of
 * its words is tried as a file, without the prefixes /vsi.../ before it. */
static bool gdal_waits(const char *name) {
    static const char marks[] = "\":,;=?&{}";
    char file[PATH_MAX];
    struct stat about;
    if (stat(name, &about) == 0) return !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode);
    for (const char *at = name + strspn(name, marks), *end; *at != '\0'; at = end + strspn(end, marks)) {
        end = at + strcspn(at, marks);
        while (at < end && strncmp(at, "/vsi", 4) == 0) {
            if (strncmp(at, "/vsistd", 7) == 0) return true;
            const char *slash = memchr(at + 1, '/', (size_t)(end - at - 1));
            at = slash != NULL ? slash + 1 : end;
        }
        if (snprintf(file, sizeof file, "%.*s", (int)(end - at), at) < PATH_MAX && is_special(file)) return true;
    }
    return false;
}

/* The names of drivers that may open path: all except MEM and the two that open the names within a name. */
static char **choose_drivers(const char *path) {
    static const char *const never = " MEM Memory DERIVED ", *const within = " VRT OGR_VRT ";
    const bool file = is_file(path);
    char **names = NULL;
    for (int k = 0; k < GDALGetDriverCount(); k++) {
        const char *name = GDALGetDriverShortName(GDALGetDriver(k));
        char word[80];
        snprintf(word, sizeof word, " %s ", name);
        if (strstr(never, word) == NULL && (file || strstr(within, word) == NULL)) names = CSLAddString(names, name);
    }
    return names;
}

GDALDatasetH gdal_open_name(const char *path, unsigned kind, io_error *error) {
    CPLErrorReset();
    if (gdal_waits(path) || is_text(path)) {
        io_fail(error, "%s: cannot read: not a regular file", path);
        return NULL;
    }
    char **drivers = choose_drivers(path);
    GDALDatasetH file =
        GDALOpenEx(path, kind | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, (const char *const *)drivers, NULL, NULL);
    CSLDestroy(drivers);
    if (file == NULL) gdal_fail_read(error, path, "cannot read");
    return file;
}

/* A VRT lists its sources, but not those of a VRT among them. More levels and more such files than these no honest
 * one has, and one that names itself has no end. */
enum { VRT_DEPTH_MAX = 8, VRT_FILES_MAX = 4096 };

typedef struct listing {
    const char *path;
    int left;
    io_error *error;
} listing;

static bool note_files(listing *l, GDALDatasetH file, int depth) {
    static const char *const vrt[] = {"VRT", NULL};
    char **files = GDALGetFileList(file);
    bool good = true;
    for (char **name = files; good && name != NULL && *name != NULL; name++) {
        good = !gdal_waits(*name) || io_fail(l->error, "%s: cannot read: %s is not a regular file", l->path, *name);
        good = good && (gdal_program()->note(*name) || io_fail(l->error, "%s: out of memory", l->path));
        /* The first one is the dataset itself. */
        if (!good || name == files || depth == VRT_DEPTH_MAX || l->left == 0) continue;
        if (GDALIdentifyDriverEx(*name, GDAL_OF_RASTER, vrt, NULL) == NULL) continue;
        GDALDatasetH inner = GDALOpenEx(*name, GDAL_OF_RASTER | GDAL_OF_READONLY, vrt, NULL, NULL);
        if (inner == NULL) continue; /* reading it will fail */
        l->left--;
        good = note_files(l, inner, depth + 1);
        GDALClose(inner);
    }
    CSLDestroy(files);
    return good;
}

bool gdal_note_files(GDALDatasetH file, const char *path, io_error *error) {
    listing l = {path, VRT_FILES_MAX, error};
    const bool good = note_files(&l, file, 0);
    CPLErrorReset();
    return good;
}

/* Words of names and messages when something on the network is wanted. */
static bool wants_network(const char *text) {
    static const char *const words[] = {"://",        "/vsicurl", "/vsis3",       "/vsigs",    "/vsiaz",
                                        "/vsiadls",   "/vsioss",  "/vsiswift",    "/vsihdfs",  "/vsiwebhdfs",
                                        "CURL error", "libcurl",  "resolve host", "connect to"};
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++)
        if (strstr(text, words[k]) != NULL) return true;
    return false;
}

bool gdal_fail_read(io_error *error, const char *path, const char *what) {
    if (gdal_host() == NULL || gdal_host()->network || (!wants_network(path) && !wants_network(CPLGetLastErrorMsg())))
        return gdal_fail(error, path, what);
    char reason[400];
    snprintf(reason, sizeof reason, "%s; GDAL is kept from the network unless you give --allow-network", what);
    return gdal_fail(error, path, reason);
}
