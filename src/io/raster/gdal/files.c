/* SPDX-License-Identifier: Apache-2.0 */
/* The files that GDAL opens, through callbacks of this module in place of GDAL's own:
 *  - A name of the file system is opened only if it is a regular file. GDAL itself waits for ever for the writer of a pipe,
 *    which may stand behind a link, beside the file (.aux.xml) or in a VRT.
 *  - A file to be written is lent by its descriptor, so that it needs no name before it is whole, and the system's reason is
 *    known when it cannot be written. So are the files that GDAL makes beside it on its way. */

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

/* ---- names of the file system ------------------------------------------------------------------------------------ */

typedef struct input {
    FILE *file;
    vsi_l_offset at, wanted; /* the stream's position, and the reader's: a seek that reads nothing costs nothing */
    bool at_end;
} input;

static char refused[512]; /* the first name since gdal_files_reset of something other than a regular file */

void gdal_files_reset(void) { refused[0] = '\0'; }
const char *gdal_files_refused(void) { return refused[0] != '\0' ? refused : NULL; }

static void *open_input(void *context, const char *name, const char *access) {
    (void)context;
    /* Without O_NONBLOCK opening a pipe would wait for its other end. */
    const bool updates = strchr(access, '+') != NULL;
    const int way =
        access[0] == 'r' ? (updates ? O_RDWR : O_RDONLY) : O_RDWR | O_CREAT | (access[0] == 'w' ? O_TRUNC : 0);
    const int fd = open(name, way | O_CLOEXEC | O_NONBLOCK, 0666);
    struct stat about;
    if (fd < 0) return NULL;
    const bool regular = fstat(fd, &about) == 0 && S_ISREG(about.st_mode);
    input *f = regular ? calloc(1, sizeof *f) : NULL;
    if (f != NULL && (f->file = fdopen(fd, way == O_RDONLY ? "rb" : "r+b")) != NULL) return f;
    if (!regular && !S_ISDIR(about.st_mode) && refused[0] == '\0') snprintf(refused, sizeof refused, "%s", name);
    errno = regular ? ENOMEM : S_ISDIR(about.st_mode) ? EISDIR : EINVAL;
    free(f);
    close(fd);
    return NULL;
}

static vsi_l_offset tell_input(void *file) { return ((input *)file)->wanted; }

static int seek_input(void *file, vsi_l_offset offset, int whence) {
    input *f = file;
    struct stat about;
    if (whence == SEEK_CUR) offset += f->wanted;
    if (whence == SEEK_END) {
        if (fflush(f->file) != 0 || fstat(fileno(f->file), &about) != 0) return -1;
        offset += (vsi_l_offset)about.st_size;
    }
    if (offset > INT64_MAX) return -1;
    f->wanted = offset;
    f->at_end = false;
    return 0;
}

static size_t read_input(void *file, void *to, size_t size, size_t count) {
    input *f = file;
    if (size == 0 || count == 0) return 0;
    if (f->at != f->wanted && fseeko(f->file, (off_t)f->wanted, SEEK_SET) != 0) return 0;
    const size_t bytes = fread(to, 1, size * count, f->file);
    f->at = f->wanted += bytes;
    f->at_end = bytes < size * count;
    return bytes / size;
}

/* GDAL writes no file of the program's in this way; other code of the process may. */
static size_t write_input(void *file, const void *from, size_t size, size_t count) {
    input *f = file;
    if (size == 0 || fseeko(f->file, (off_t)f->wanted, SEEK_SET) != 0) return 0;
    const size_t done = fwrite(from, size, count, f->file);
    f->wanted += size * done;
    f->at = UINT64_MAX; /* a stream has to be placed between writing and reading */
    return done;
}

static int truncate_input(void *file, vsi_l_offset size) {
    input *f = file;
    return fflush(f->file) == 0 ? ftruncate(fileno(f->file), (off_t)size) : -1;
}

static int flush_input(void *file) { return fflush(((input *)file)->file); }

static int remove_name(void *context, const char *name) {
    (void)context;
    return unlink(name);
}

static int at_end_of_input(void *file) { return ((input *)file)->at_end; }

static int close_input(void *file) {
    input *f = file;
    const int status = fclose(f->file);
    free(f);
    return status;
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

/* ---- files that are lent ----------------------------------------------------------------------------------------- */

enum { LENT_MAX = 16 };
static const char lent_prefix[] = "/vsicellwalk/";
enum { SUFFIX_MAX = 40 };
static struct lent {
    bool used;
    int fd, reason;
    int beside;              /* the file that it was made beside, or -1 */
    char suffix[SUFFIX_MAX]; /* the text behind the other file's name in that of a file beside it: ".ovr.tmp" */
    int (*scratch)(void *context);
    void *context;
} lent[LENT_MAX];

typedef struct output {
    struct lent *file;
    vsi_l_offset at;
    bool at_end;
} output;

int gdal_lend(int fd, char name[GDAL_LENT_NAME]) {
    for (int k = 0; k < LENT_MAX; k++) {
        if (lent[k].used) continue;
        lent[k] = (struct lent){.used = true, .fd = fd, .beside = -1};
        snprintf(name, GDAL_LENT_NAME, "%s%d.tif", lent_prefix, k);
        return k;
    }
    return -1;
}

void gdal_lend_scratch(int number, int (*scratch)(void *context), void *context) {
    lent[number].scratch = scratch;
    lent[number].context = context;
}

/* Of the file, or of one beside it. */
int gdal_lent_reason(int number) {
    for (int k = 0; k < LENT_MAX; k++)
        if (lent[k].used && lent[k].beside == number && lent[k].reason != 0) return lent[k].reason;
    return lent[number].reason;
}

void gdal_take_back(int number) {
    for (int k = 0; k < LENT_MAX; k++)
        if (lent[k].beside == number) lent[k].used = false;
    lent[number].used = false;
}

/* The number at the beginning of a name, and the suffix; -1 if that file is not lent. */
static int number_of(const char *name, const char **suffix) {
    char *end;
    const long k = strtol(name, &end, 10);
    if (end == name || strncmp(end, ".tif", 4) != 0 || k < 0 || k >= LENT_MAX) return -1;
    *suffix = end + 4;
    return lent[k].used && lent[k].beside < 0 ? (int)k : -1;
}

static struct lent *find_lent(const char *name) {
    const char *suffix;
    const int number = number_of(name, &suffix);
    if (number < 0) return NULL;
    if (suffix[0] == '\0') return &lent[number];
    for (int k = 0; k < LENT_MAX; k++)
        if (lent[k].used && lent[k].beside == number && strcmp(lent[k].suffix, suffix) == 0) return &lent[k];
    return NULL;
}

/* A new file beside one that is lent; NULL, with errno, if there can be none. */
static struct lent *make_beside(const char *name) {
    const char *suffix;
    char unused[GDAL_LENT_NAME];
    const int number = number_of(name, &suffix);
    errno = ENOENT;
    if (number < 0 || lent[number].scratch == NULL || suffix[0] != '.' || strlen(suffix) >= SUFFIX_MAX) return NULL;
    const int fd = lent[number].scratch(lent[number].context), k = fd >= 0 ? gdal_lend(fd, unused) : -1;
    if (k < 0) {
        if (fd >= 0) errno = EMFILE;
        lent[number].reason = errno;
        return NULL;
    }
    lent[k].beside = number;
    snprintf(lent[k].suffix, SUFFIX_MAX, "%s", suffix);
    return &lent[k];
}

static void *open_output(void *context, const char *name, const char *access) {
    (void)context;
    struct lent *file = find_lent(name);
    if (file == NULL && access[0] == 'w')
        file = make_beside(name);
    else if (file == NULL)
        errno = ENOENT;
    output *f = file ? calloc(1, sizeof *f) : NULL;
    if (f == NULL) {
        if (file) errno = ENOMEM;
        return NULL;
    }
    f->file = file;
    if (access[0] == 'w' && ftruncate(file->fd, 0) != 0) {
        file->reason = errno;
        free(f);
        return NULL;
    }
    return f;
}

static vsi_l_offset tell_output(void *file) { return ((output *)file)->at; }

static int seek_output(void *file, vsi_l_offset offset, int whence) {
    output *f = file;
    struct stat about;
    if (whence == SEEK_CUR) offset += f->at;
    if (whence == SEEK_END) {
        if (fstat(f->file->fd, &about) != 0) return -1;
        offset += (vsi_l_offset)about.st_size;
    }
    if (offset > INT64_MAX) return -1;
    f->at = offset;
    f->at_end = false;
    return 0;
}

static size_t read_output(void *file, void *to, size_t size, size_t count) {
    output *f = file;
    size_t done = 0;
    const size_t bytes = size * count;
    while (done < bytes) {
        const ssize_t got = pread(f->file->fd, (char *)to + done, bytes - done, (off_t)f->at);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        done += (size_t)got;
        f->at += (vsi_l_offset)got;
    }
    f->at_end = done < bytes;
    return size > 0 ? done / size : 0;
}

static size_t write_output(void *file, const void *from, size_t size, size_t count) {
    output *f = file;
    size_t done = 0;
    const size_t bytes = size * count;
    while (done < bytes) {
        const ssize_t put = pwrite(f->file->fd, (const char *)from + done, bytes - done, (off_t)f->at);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) {
            if (f->file->reason == 0) f->file->reason = put < 0 ? errno : ENOSPC;
            break;
        }
        done += (size_t)put;
        f->at += (vsi_l_offset)put;
    }
    return size > 0 ? done / size : 0;
}

static int at_end_of_output(void *file) { return ((output *)file)->at_end; }

static int truncate_output(void *file, vsi_l_offset size) {
    output *f = file;
    const int status = ftruncate(f->file->fd, (off_t)size);
    if (status != 0 && f->file->reason == 0) f->file->reason = errno;
    return status;
}

static int flush_output(void *file) {
    (void)file;
    return 0;
}

static int close_output(void *file) {
    free(file);
    return 0;
}

static int stat_output(void *context, const char *name, VSIStatBufL *about, int flags) {
    (void)context, (void)flags;
    memset(about, 0, sizeof *about);
    const struct lent *file = find_lent(name);
    struct stat now;
    if (file == NULL || fstat(file->fd, &now) != 0) return -1;
    about->st_mode = S_IFREG | 0666;
    about->st_size = now.st_size;
    return 0;
}

/* A file beside another is scratch: its bytes go; scratch's owner closes it. */
static int remove_output(void *context, const char *name) {
    (void)context;
    struct lent *file = find_lent(name);
    if (file == NULL || file->beside < 0) {
        errno = ENOENT;
        return -1;
    }
    file->used = false;
    return ftruncate(file->fd, 0);
}

void gdal_files_install(void) {
    VSIFilesystemPluginCallbacksStruct *c = VSIAllocFilesystemPluginCallbacksStruct();
    c->stat = stat_name;
    c->read_dir = read_folder;
    c->open = open_input;
    c->tell = tell_input;
    c->seek = seek_input;
    c->read = read_input;
    c->eof = at_end_of_input;
    c->write = write_input;
    c->flush = flush_input;
    c->truncate = truncate_input;
    c->unlink = remove_name;
    c->close = close_input;
    VSIInstallPluginHandler("", c);
    VSIFreeFilesystemPluginCallbacksStruct(c);

    c = VSIAllocFilesystemPluginCallbacksStruct();
    c->stat = stat_output;
    c->open = open_output;
    c->tell = tell_output;
    c->seek = seek_output;
    c->read = read_output;
    c->eof = at_end_of_output;
    c->write = write_output;
    c->flush = flush_output;
    c->truncate = truncate_output;
    c->unlink = remove_output;
    c->close = close_output;
    VSIInstallPluginHandler(lent_prefix, c);
    VSIFreeFilesystemPluginCallbacksStruct(c);
}
