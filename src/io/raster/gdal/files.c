/* SPDX-License-Identifier: Apache-2.0 */
/* The files that GDAL opens, through callbacks of this module:
 *  - A name of the file system is opened only if it is a regular file, and only for reading. GDAL itself waits for ever for the
 *    writer of a pipe, which may stand behind a link, beside the file (.aux.xml) or in a VRT.
 *  - The standard streams, which GDAL has names for, are not opened.
 *  - Files to be written have names of GDAL's, so that the system's reason is known when one cannot be. */

#include "files.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- an open file ------------------------------------------------------------------------------------------------ */

typedef struct handle {
    int fd, *reason; /* reason: of an output, where its first failure is noted; else NULL */
    vsi_l_offset at;
    bool at_end;
} handle;

static handle *make_handle(int fd, int *reason) {
    handle *h = malloc(sizeof *h);
    if (h != NULL) *h = (handle){.fd = fd, .reason = reason};
    errno = ENOMEM;
    return h;
}

static void note_reason(handle *h, int reason) {
    if (h->reason != NULL && *h->reason == 0) *h->reason = reason;
}

static vsi_l_offset tell(void *file) { return ((handle *)file)->at; }

static int seek(void *file, vsi_l_offset offset, int whence) {
    handle *h = file;
    struct stat about;
    if (whence == SEEK_CUR) offset += h->at;
    if (whence == SEEK_END) {
        if (fstat(h->fd, &about) != 0) return -1;
        offset += (vsi_l_offset)about.st_size;
    }
    if (offset > INT64_MAX) return -1;
    h->at = offset;
    h->at_end = false;
    return 0;
}

static size_t read_some(void *file, void *to, size_t size, size_t count) {
    handle *h = file;
    size_t done = 0;
    const size_t bytes = size * count;
    while (done < bytes) {
        const ssize_t got = pread(h->fd, (char *)to + done, bytes - done, (off_t)h->at);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        done += (size_t)got;
        h->at += (vsi_l_offset)got;
    }
    h->at_end = done < bytes;
    return size > 0 ? done / size : 0;
}

static size_t write_some(void *file, const void *from, size_t size, size_t count) {
    handle *h = file;
    size_t done = 0;
    const size_t bytes = size * count;
    while (done < bytes) {
        const ssize_t put = pwrite(h->fd, (const char *)from + done, bytes - done, (off_t)h->at);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) {
            note_reason(h, put < 0 ? errno : ENOSPC);
            break;
        }
        done += (size_t)put;
        h->at += (vsi_l_offset)put;
    }
    return size > 0 ? done / size : 0;
}

static int truncate_to(void *file, vsi_l_offset size) {
    handle *h = file;
    const int status = ftruncate(h->fd, (off_t)size);
    if (status != 0) note_reason(h, errno);
    return status;
}

static int is_at_end(void *file) { return ((handle *)file)->at_end; }

static int flush(void *file) {
    (void)file;
    return 0;
}

static int close_handle(void *file) {
    handle *h = file;
    const int status = close(h->fd);
    free(h);
    return status;
}

/* ---- names of the file system ------------------------------------------------------------------------------------ */

static char refused[512]; /* the first name since gdal_files_reset of something other than a regular file */

void gdal_files_reset(void) { refused[0] = '\0'; }
const char *gdal_files_refused(void) { return refused[0] != '\0' ? refused : NULL; }

static void *open_input(void *context, const char *name, const char *access) {
    (void)context;
    errno = EROFS;
    if (access[0] != 'r' || strchr(access, '+') != NULL) return NULL;
    /* Without O_NONBLOCK opening a pipe would wait for its other end. */
    const int fd = open(name, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat about;
    if (fd < 0) return NULL;
    const bool regular = fstat(fd, &about) == 0 && S_ISREG(about.st_mode);
    handle *h = regular ? make_handle(fd, NULL) : NULL;
    if (h != NULL) return h;
    if (!regular && !S_ISDIR(about.st_mode) && refused[0] == '\0') snprintf(refused, sizeof refused, "%s", name);
    if (!regular) errno = S_ISDIR(about.st_mode) ? EISDIR : EINVAL;
    close(fd);
    return NULL;
}

static int stat_name(void *context, const char *name, VSIStatBufL *about, int flags) {
    (void)context, (void)flags;
    struct stat now;
    memset(about, 0, sizeof *about);
    if (stat(name, &now) != 0) return -1;
    about->st_mode = now.st_mode;
    about->st_size = now.st_size;
    about->st_mtime = now.st_mtime;
    return 0;
}

static char **read_folder(void *context, const char *name, int most) {
    (void)context;
    DIR *folder = opendir(name[0] != '\0' ? name : ".");
    if (folder == NULL) return NULL;
    char **names = NULL;
    size_t count = 0, room = 0;
    for (const struct dirent *entry; (most <= 0 || count <= (size_t)most) && (entry = readdir(folder)) != NULL;) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) continue;
        if (count + 2 > room) { /* CSLAddString counts the list anew for each */
            room = room > 0 ? 2 * room : 64;
            names = CPLRealloc(names, room * sizeof *names);
        }
        names[count++] = CPLStrdup(entry->d_name);
        names[count] = NULL;
    }
    closedir(folder);
    return names;
}

/* ---- files to be written ----------------------------------------------------------------------------------------- */

static const char output_prefix[] = "/vsicellwalk/";
static gdal_output *outputs;

void gdal_output_add(gdal_output *o) {
    o->next = outputs;
    outputs = o;
}

void gdal_output_remove(gdal_output *o) {
    for (gdal_output **at = &outputs; *at != NULL; at = &(*at)->next)
        if (*at == o) {
            *at = o->next;
            return;
        }
}

char *gdal_output_name(const char *path) {
    char *name = malloc(sizeof output_prefix + strlen(path));
    if (name != NULL) sprintf(name, "%s%s", output_prefix, path);
    return name;
}

/* The output that a name belongs to; NULL, with errno, if it is none's. */
static gdal_output *find_output(const char *name) {
    errno = ENOENT;
    for (gdal_output *o = outputs; o != NULL; o = o->next)
        if (strncmp(name, o->path, strlen(o->path)) == 0) return o;
    return NULL;
}

static void *open_output(void *context, const char *name, const char *access) {
    (void)context;
    gdal_output *o = find_output(name);
    if (o == NULL) return NULL;
    const int fd = open(name, O_RDWR | O_CLOEXEC | (access[0] == 'w' ? O_CREAT | O_TRUNC : 0), 0600);
    handle *h = fd >= 0 ? make_handle(fd, &o->reason) : NULL;
    if (h == NULL && access[0] == 'w' && o->reason == 0) o->reason = errno;
    if (h == NULL && fd >= 0) close(fd);
    return h;
}

static int stat_output(void *context, const char *name, VSIStatBufL *about, int flags) {
    memset(about, 0, sizeof *about);
    return find_output(name) != NULL ? stat_name(context, name, about, flags) : -1;
}

/* All but the output itself. */
static int remove_output(void *context, const char *name) {
    (void)context;
    const gdal_output *o = find_output(name);
    return o != NULL && strcmp(name, o->path) != 0 ? unlink(name) : -1;
}

/* ---- standard streams -------------------------------------------------------------------------------------------- */

static void *refuse_open(void *context, const char *name, const char *access) {
    (void)context, (void)name, (void)access;
    errno = EACCES;
    return NULL;
}

static int refuse_stat(void *context, const char *name, VSIStatBufL *about, int flags) {
    (void)context, (void)name, (void)flags;
    memset(about, 0, sizeof *about);
    errno = EACCES;
    return -1;
}

static void install(const char *prefix, VSIFilesystemPluginOpenCallback open_file,
                    VSIFilesystemPluginStatCallback stat_file, VSIFilesystemPluginUnlinkCallback remove_file) {
    VSIFilesystemPluginCallbacksStruct *c = VSIAllocFilesystemPluginCallbacksStruct();
    c->open = open_file;
    c->stat = stat_file;
    c->read_dir = prefix[0] == '\0' ? read_folder : NULL;
    c->tell = tell;
    c->seek = seek;
    c->read = read_some;
    c->eof = is_at_end;
    c->write = write_some;
    c->flush = flush;
    c->truncate = truncate_to;
    c->unlink = remove_file;
    c->close = close_handle;
    VSIInstallPluginHandler(prefix, c); /* which keeps the pointer to the prefix */
    VSIFreeFilesystemPluginCallbacksStruct(c);
}

void gdal_files_install(bool own_process) {
    static const char *const streams[] = {"/vsistdin/", "/vsistdin?", "/vsistdout/", "/vsistdout_redirect/"};
    install(output_prefix, open_output, stat_output, remove_output);
    if (!own_process) return;
    install("", open_input, stat_name, NULL);
    for (size_t k = 0; k < sizeof streams / sizeof streams[0]; k++) install(streams[k], refuse_open, refuse_stat, NULL);
}
