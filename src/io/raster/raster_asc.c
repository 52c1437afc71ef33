/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from ESRI ASCII grids: lines "ncols 4", "nrows 3", "xllcorner 100" or "xllcenter 105", the same for y,
 * "cellsize 10" (or "dx 10", "dy 20"), optionally "nodata_value -9999", then the numbers by rows from the north. Row 0
 * is the northernmost, so y falls as j grows. A file of the same name that ends in .prj says the coordinate system. */

#include "file.h"
#include "number.h"
#include "raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

typedef struct scanner {
    const char *at; /* ends in a NUL byte */
    size_t line;
    const char *path;
    io_error *error;
} scanner;

/* The word at the scanner's place for messages, cut short. */
static bool fail(const scanner *s, const char *wanted) {
    int length = (int)strcspn(s->at, " \t\r\n");
    if (length > 40) length = 40;
    if (length == 0)
        return io_fail(s->error, "%s:%zu: truncated: the file ends where %s should stand", s->path, s->line, wanted);
    return io_fail(s->error, "%s:%zu: '%.*s' stands where %s should", s->path, s->line, length, s->at, wanted);
}

static void skip_blanks(scanner *s) {
    for (; *s->at == ' ' || *s->at == '\t' || *s->at == '\r' || *s->at == '\n'; s->at++)
        if (*s->at == '\n') s->line++;
}

static bool at_word_end(const char *at) { return *at == '\0' || strchr(" \t\r\n", *at) != NULL; }

/* Only characters of decimal numbers: number_read would also accept hexadecimal numbers and words. */
static bool decimal(const char *at) { return *at != '\0' && strspn(at, "+-.0123456789eE") == strcspn(at, " \t\r\n"); }

static bool take_double(scanner *s, double *value) {
    char *end = NULL;
    skip_blanks(s);
    if (decimal(s->at)) *value = number_read(s->at, &end);
    if (end == NULL || !at_word_end(end) || !isfinite(*value)) return fail(s, "a number");
    s->at = end;
    return true;
}

static bool take_size(scanner *s, size_t *value) {
    double number = 0;
    const scanner before = *s;
    if (!take_double(s, &number)) return false;
    if (number >= 1 && number <= 0x1p31 && number == floor(number)) {
        *value = (size_t)number;
        return true;
    }
    *s = before;
    skip_blanks(s);
    return fail(s, "a number of samples");
}

typedef enum key { NCOLS, NROWS, XCORNER, XCENTER, YCORNER, YCENTER, CELLSIZE, DX, DY, NODATA, KEY_COUNT } key;
static const char *const key_names[KEY_COUNT] = {"ncols",     "nrows",    "xllcorner", "xllcenter", "yllcorner",
                                                 "yllcenter", "cellsize", "dx",        "dy",        "nodata_value"};

typedef struct header {
    bool seen[KEY_COUNT];
    size_t nx, ny;
    double value[KEY_COUNT];
    float nodata; /* as the samples are rounded; infinite if it is beyond the range of float */
} header;

static bool take_key(scanner *s, header *h) {
    size_t k = 0;
    const size_t length = strcspn(s->at, " \t\r\n");
    while (k < KEY_COUNT && !(strlen(key_names[k]) == length && strncasecmp(key_names[k], s->at, length) == 0)) k++;
    if (k == KEY_COUNT)
        return fail(s, "a key of the header (ncols, nrows, xllcorner, yllcorner, cellsize, nodata_value)");
    if (h->seen[k]) return fail(s, "a key that has not been given before");
    h->seen[k] = true;
    s->at += length;
    if (k == NCOLS) return take_size(s, &h->nx);
    if (k == NROWS) return take_size(s, &h->ny);
    if (k != NODATA) return take_double(s, &h->value[k]);
    skip_blanks(s);
    h->nodata = NAN;
    if (strncasecmp(s->at, "nan", 3) == 0 && at_word_end(s->at + 3)) {
        s->at += 3; /* missing samples may also be written as nan */
        return true;
    }
    h->nodata = number_read_float(s->at, NULL);
    return take_double(s, &h->value[k]);
}

/* One coordinate: where the lowest row or column stands. */
static double first_centre(const header *h, key corner, key centre, double step) {
    if (h->seen[centre]) return h->value[centre];
    return (h->seen[corner] ? h->value[corner] : 0) + 0.5 * step;
}

static bool take_header(scanner *s, header *h) {
    for (;;) {
        skip_blanks(s);
        if (!((*s->at >= 'a' && *s->at <= 'z') || (*s->at >= 'A' && *s->at <= 'Z'))) break;
        if (h->seen[NCOLS] && h->seen[NROWS] && strncasecmp(s->at, "nan", 3) == 0) break; /* the first sample */
        if (!take_key(s, h)) return false;
    }
    if (!h->seen[NCOLS] || !h->seen[NROWS]) return fail(s, h->seen[NCOLS] ? "nrows" : "ncols");
    if (h->seen[CELLSIZE]) {
        if (h->seen[DX] || h->seen[DY]) return io_fail(s->error, "%s: the header gives cellsize and dx or dy", s->path);
        h->value[DX] = h->value[DY] = h->value[CELLSIZE];
    } else if (!h->seen[DX] || !h->seen[DY]) {
        return fail(s, "cellsize");
    }
    if (!(h->value[DX] > 0 && h->value[DY] > 0)) return io_fail(s->error, "%s: cellsize is not positive", s->path);
    if ((h->seen[XCORNER] && h->seen[XCENTER]) || (h->seen[YCORNER] && h->seen[YCENTER]))
        return io_fail(s->error, "%s: the header gives corner and centre of the lower left pixel", s->path);
    return true;
}

static bool take_sample(scanner *s, const header *h, float *z) {
    char *end = NULL;
    skip_blanks(s);
    if (decimal(s->at)) {
        *z = number_read_float(s->at, &end);
    } else if (strncasecmp(s->at, "nan", 3) == 0) {
        *z = NAN;
        end = (char *)s->at + 3;
    }
    if (end == NULL || !at_word_end(end)) return fail(s, "a number");
    if (h->seen[NODATA] && *z == h->nodata)
        *z = NAN;
    else if (isinf(*z))
        return fail(s, "a number in the range of float");
    s->at = end;
    return true;
}

static bool read_text(const char *path, const char *text, size_t size, const io_raster_options *options,
                      io_raster *raster, io_error *error) {
    scanner s = {.at = text, .line = 1, .path = path, .error = error};
    header h = {0};
    if (!take_header(&s, &h)) return false;
    /* A number and a blank take two bytes: checked before memory is allocated. No overflow: sides are at most 2^31. */
    const size_t left = size - (size_t)(s.at - text);
    if (h.nx * h.ny > left / 2 + 1)
        return io_fail(error, "%s: truncated: %zu x %zu samples do not fit into the %zu bytes from line %zu on", path,
                       h.nx, h.ny, left, s.line);
    if (!io_raster_allocate(path, h.nx, h.ny, raster, error)) return false;
    float *z = raster->memory;
    for (size_t j = 0; j < h.ny; j++) {
        if (j % 64 == 0 && !io_raster_progress(options, path, (double)j / (double)h.ny, error)) return false;
        for (size_t i = 0; i < h.nx; i++)
            if (!take_sample(&s, &h, z++)) return false;
    }
    skip_blanks(&s);
    if (s.at != text + size) return fail(&s, "the end of the file");
    const double dx = h.value[DX], dy = h.value[DY];
    const double west = first_centre(&h, XCORNER, XCENTER, dx), south = first_centre(&h, YCORNER, YCENTER, dy);
    raster->map[0][0] = dx;
    raster->map[0][3] = west;
    raster->map[1][1] = -dy;
    raster->map[1][3] = south + (double)(h.ny - 1) * dy;
    raster->georef.placed = true;
    raster->georef.has_nodata = h.seen[NODATA] && !isnan(h.nodata);
    raster->georef.nodata = h.value[NODATA];
    return true;
}

/* dem.prj beside dem.asc: the coordinate system. A file that is not there or says something else changes nothing. */
static void read_prj(const char *path, io_georef *georef) {
    const size_t stem = strlen(path) - strlen(".asc");
    char *name = malloc(stem + sizeof ".prj");
    if (name == NULL) return;
    memcpy(name, path, stem);
    strcpy(name + stem, ".prj");
    size_t size = 0;
    char *wkt = access(name, R_OK) == 0 ? io_file_read(name, &size, NULL) : NULL;
    if (wkt != NULL) io_georef_from_wkt(georef, wkt);
    free(wkt);
    free(name);
}

static bool read_asc(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    size_t size = 0;
    char *text = io_file_read(path, &size, error);
    if (text == NULL) return false;
    const bool good = read_text(path, text, size, options, raster, error);
    free(text);
    if (good)
        read_prj(path, &raster->georef);
    else
        io_raster_free(raster);
    return good;
}

const io_raster_format io_raster_asc = {"ESRI ASCII grid", ".asc", read_asc};
