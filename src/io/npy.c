/* SPDX-License-Identifier: Apache-2.0 */
/* Reading .npy files by windows: only the rows asked for are mapped, so that a file may be larger than memory and than
 * the address space that a process is granted. */

#include "npy.h"

#include "file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "elements are used as they lie in the file");

/* The dictionary of an array of plain numbers has some 100 characters; versions 2 and 3 allow 4 GiB for records. */
enum { HEADER_MAX = 1 << 16 };

/* Magic, version, length of the text: 10 bytes in version 1.0, 12 later. */
static bool read_header(io_npy *npy, uint64_t file_size, io_error *error) {
    unsigned char start[12];
    const size_t have = file_size < sizeof start ? (size_t)file_size : sizeof start;
    if (!io_file_read_at(npy->fd, npy->path, start, have, 0, error)) return false;
    static const char magic[] = "\x93NUMPY";
    const size_t magic_size = sizeof magic - 1;
    if (memcmp(start, magic, have < magic_size ? have : magic_size) != 0 || have == 0)
        return io_fail(error, "%s: not a .npy file (it does not start with \\x93NUMPY)", npy->path);
    if (have >= 8 && (start[6] < 1 || start[6] > 3 || start[7] != 0))
        return io_fail(error, "%s: .npy version %u.%u is unknown; 1.0, 2.0 and 3.0 can be read", npy->path, start[6],
                       start[7]);
    const size_t before = have >= 8 && start[6] == 1 ? 10 : 12;
    if (have < before)
        return io_fail(error, "%s: truncated: the file ends at byte %zu, within its header", npy->path, have);
    const uint64_t length =
        before == 10 ? (uint64_t)(start[8] | start[9] << 8)
                     : start[8] | (uint64_t)start[9] << 8 | (uint64_t)start[10] << 16 | (uint64_t)start[11] << 24;
    if (length > file_size - before)
        return io_fail(error, "%s: truncated: the header at byte %zu is said to be %llu bytes long, the file has %llu",
                       npy->path, before, (unsigned long long)length, (unsigned long long)file_size);
    if (length > HEADER_MAX)
        return io_fail(error, "%s: the header is %llu bytes long; no array of plain numbers needs more than %d",
                       npy->path, (unsigned long long)length, HEADER_MAX);
    char *text = malloc((size_t)length + 1);
    if (text == NULL) return io_fail(error, "%s: out of memory", npy->path);
    const bool good = io_file_read_at(npy->fd, npy->path, text, (size_t)length, before, error) &&
                      io_npy_parse(text, (size_t)length, npy->path, before, &npy->header, error);
    free(text);
    npy->offset = before + length;
    return good;
}

static bool multiply(uint64_t *product, uint64_t factor) {
    if (factor > 0 && *product > INT64_MAX / factor) return false;
    *product *= factor;
    return true;
}

/* The header's shape against the file's size. Keeps every later product within 63 bits. */
static bool check_size(io_npy *npy, uint64_t file_size, io_error *error) {
    const io_npy_header *h = &npy->header;
    bool fits = true;
    npy->row_bytes = h->item;
    for (size_t k = 1; k < h->rank; k++) fits = fits && multiply(&npy->row_bytes, h->shape[k]);
    uint64_t bytes = npy->row_bytes;
    fits = fits && multiply(&bytes, h->rank > 0 ? h->shape[0] : 1);
    char shape[128];
    io_npy_shape_text(npy, shape, sizeof shape);
    if (!fits) return io_fail(error, "%s: shape %s is too large for any file", npy->path, shape);
    const uint64_t data = file_size - npy->offset;
    if (data == bytes) return true;
    return io_fail(error, "%s: %s: shape %s of '%s' takes %llu bytes from byte %llu on, the file has %llu", npy->path,
                   data < bytes ? "truncated" : "too long", shape, h->type, (unsigned long long)bytes,
                   (unsigned long long)npy->offset, (unsigned long long)data);
}

bool io_npy_open(io_npy *npy, const char *path, io_error *error) {
    *npy = (io_npy){.fd = -1};
    uint64_t size = 0;
    npy->path = strdup(path);
    if (npy->path == NULL) return io_fail(error, "%s: out of memory", path);
    npy->fd = io_file_open(path, &size, error);
    if (npy->fd >= 0 && read_header(npy, size, error) && check_size(npy, size, error)) return true;
    io_npy_close(npy);
    return false;
}

static void unmap(io_npy *npy) {
    if (npy->window) munmap(npy->window, (size_t)(npy->window_end - npy->window_begin));
    free(npy->aligned);
    npy->window = npy->aligned = NULL;
}

void io_npy_close(io_npy *npy) {
    unmap(npy);
    if (npy->fd >= 0) close(npy->fd);
    free(npy->path);
    *npy = (io_npy){.fd = -1};
}

void io_npy_shape_text(const io_npy *npy, char *text, size_t size) {
    const io_npy_header *h = &npy->header;
    size_t used = (size_t)snprintf(text, size, "(");
    for (size_t k = 0; k < h->rank && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%llu", k ? ", " : "", (unsigned long long)h->shape[k]);
    if (used < size) snprintf(text + used, size - used, h->rank == 1 ? ",)" : ")");
}

bool io_npy_expect_type(const io_npy *npy, const char *const *types, size_t count, io_error *error) {
    char list[64] = "";
    size_t used = 0;
    for (size_t k = 0; k < count; k++) {
        if (strcmp(npy->header.type, types[k]) == 0) return true;
        if (used < sizeof list)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s'%s'", k ? ", " : "", types[k]);
    }
    return io_fail(error, "%s: holds elements of type '%s', not %s; in NumPy, a.astype('%s') converts", npy->path,
                   npy->header.type, list, types[0]);
}

const void *io_npy_rows(io_npy *npy, uint64_t first, uint64_t count, io_error *error) {
    static const max_align_t nothing;
    const uint64_t begin = npy->offset + first * npy->row_bytes, end = begin + count * npy->row_bytes;
    if (begin == end) return &nothing;
    const uint64_t page = (uint64_t)sysconf(_SC_PAGESIZE), mapped = begin / page * page;
    /* A pass that is repeated over one window keeps it. */
    const bool same = npy->window && npy->window_from == begin && npy->window_end == end;
    if (!same) {
        unmap(npy);
        void *window = MAP_FAILED;
        errno = ENOMEM;
        if (end - mapped <= SIZE_MAX)
            window = mmap(NULL, (size_t)(end - mapped), PROT_READ, MAP_PRIVATE, npy->fd, (off_t)mapped);
        if (window == MAP_FAILED) {
            io_fail(error, "%s: cannot map %llu bytes: %s", npy->path, (unsigned long long)(end - mapped),
                    strerror(errno));
            return NULL;
        }
        madvise(window, (size_t)(end - mapped), MADV_SEQUENTIAL);
        npy->window = window;
        npy->window_begin = mapped;
        npy->window_from = begin;
        npy->window_end = end;
    }
    const char *rows = (const char *)npy->window + (begin - mapped);
    if (begin % npy->header.item == 0) return rows;
    if (npy->aligned == NULL) {
        npy->aligned = malloc((size_t)(end - begin));
        if (npy->aligned == NULL) {
            io_fail(error, "%s: out of memory for %llu bytes", npy->path, (unsigned long long)(end - begin));
            return NULL;
        }
        memcpy(npy->aligned, rows, (size_t)(end - begin));
    }
    return npy->aligned;
}

void *io_npy_take_window(io_npy *npy, size_t *bytes) {
    if (npy->aligned || npy->window == NULL) return NULL;
    void *window = npy->window;
    *bytes = (size_t)(npy->window_end - npy->window_begin);
    npy->window = NULL;
    return window;
}
