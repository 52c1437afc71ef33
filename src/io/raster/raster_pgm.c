/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from binary PGM images (Netpbm's P5), 8 bits where the largest value is below 256 and 16 bits, high byte
 * first, otherwise. A sample's height is its grey value. */

#include "file.h"
#include "raster.h"

#include <stdlib.h>
#include <unistd.h>

enum { HEADER_MAX = 4096, LARGEST = 65535 };

typedef struct header {
    size_t nx, ny, maxval;
    size_t offset; /* of the first sample */
} header;

/* The next number of the header; blanks and comments before it are passed over. */
static bool take_number(const char *text, size_t *at, size_t most, size_t *value) {
    size_t k = *at;
    while (text[k] == ' ' || (text[k] >= '\t' && text[k] <= '\r') || text[k] == '#') {
        if (text[k] == '#')
            while (text[k + 1] != '\n' && text[k + 1] != '\0') k++;
        k++;
    }
    *at = k;
    *value = 0;
    for (; text[k] >= '0' && text[k] <= '9'; k++) {
        *value = *value * 10 + (size_t)(text[k] - '0');
        if (*value > most) return false;
    }
    const bool some = k > *at;
    *at = k;
    return some;
}

/* text has the file's first bytes with a NUL behind them. */
static bool parse_header(const char *text, const char *path, header *h, io_error *error) {
    if (text[0] != 'P' || text[1] < '1' || text[1] > '7') return io_fail(error, "%s: not a PGM image", path);
    if (text[1] != '5') return io_fail(error, "%s: is a P%c image; only binary PGM (P5) can be read", path, text[1]);
    const size_t side_most = (size_t)1 << 31;
    size_t at = 2;
    if (!take_number(text, &at, side_most, &h->nx))
        return io_fail(error, "%s: the width should stand at byte %zu", path, at);
    if (!take_number(text, &at, side_most, &h->ny))
        return io_fail(error, "%s: the height should stand at byte %zu", path, at);
    if (!take_number(text, &at, LARGEST, &h->maxval) || h->maxval == 0)
        return io_fail(error, "%s: the largest value, 1 to %d, should stand before byte %zu", path, LARGEST, at);
    if (text[at] != ' ' && (text[at] < '\t' || text[at] > '\r'))
        return io_fail(error, "%s: a blank should stand at byte %zu", path, at);
    h->offset = at + 1;
    return true;
}

static bool read_samples(int fd, const char *path, const header *h, const io_raster_options *options, io_raster *raster,
                         io_error *error) {
    const size_t item = h->maxval < 256 ? 1 : 2;
    float *z = raster->memory;
    unsigned char *row = malloc(h->nx * item + 1);
    if (row == NULL) return io_fail(error, "%s: out of memory", path);
    bool good = true;
    for (size_t j = 0; j < h->ny && good; j++) {
        good = (j % 64 != 0 || io_raster_progress(options, path, (double)j / (double)h->ny, error)) &&
               io_file_read_at(fd, path, row, h->nx * item, h->offset + j * h->nx * item, error);
        for (size_t i = 0; i < h->nx && good; i++) {
            const unsigned value = item == 1 ? row[i] : (unsigned)(row[2 * i] << 8 | row[2 * i + 1]);
            z[j * h->nx + i] = (float)value;
            if (value > h->maxval)
                good = io_fail(error, "%s: row %zu, column %zu is %u, above the header's largest value %zu", path, j, i,
                               value, h->maxval);
        }
    }
    free(row);
    return good;
}

static bool read_open(int fd, uint64_t size, const char *path, const io_raster_options *options, io_raster *raster,
                      io_error *error) {
    char text[HEADER_MAX + 1];
    const size_t have = size < HEADER_MAX ? (size_t)size : HEADER_MAX;
    header h = {0};
    if (!io_file_read_at(fd, path, text, have, 0, error)) return false;
    text[have] = '\0';
    if (!parse_header(text, path, &h, error)) return false;
    /* No overflow: the factors have at most 31, 31 and 2 bits. */
    const uint64_t bytes = (uint64_t)h.nx * h.ny * (h.maxval < 256 ? 1 : 2), data = size - h.offset;
    if (data != bytes)
        return io_fail(error, "%s: %s: %zu x %zu samples take %llu bytes from byte %zu on, the file has %llu", path,
                       data < bytes ? "truncated" : "too long", h.nx, h.ny, (unsigned long long)bytes, h.offset,
                       (unsigned long long)data);
    /* An empty side lets the other one be of any length, whatever the file's size. */
    if (bytes == 0) return io_fail(error, "%s: %zu x %zu: holds no samples", path, h.nx, h.ny);
    return io_raster_allocate(path, h.nx, h.ny, raster, error) && read_samples(fd, path, &h, options, raster, error);
}

static bool read_pgm(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    uint64_t size = 0;
    const int fd = io_file_open(path, &size, error);
    if (fd < 0) return false;
    const bool good = read_open(fd, size, path, options, raster, error);
    close(fd);
    if (!good) io_raster_free(raster);
    return good;
}

const io_raster_format io_raster_pgm = {"binary PGM image", ".pgm", read_pgm};
