/* SPDX-License-Identifier: Apache-2.0 */
/* Rows are read and not mapped: a mapping of a file that another process cuts ends this process. */

#include "npy.h"

#include "inputs.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "elements are used as they lie in the file");

/* The dictionary of an array of plain numbers has some 100 characters; versions 2 and 3 allow 4 GiB for records. */
enum { HEADER_MAX = 1 << 16 };

/* ---- the header -------------------------------------------------------------------------------------------------- */

/* The header is the text of a Python dictionary with exactly the keys descr, fortran_order and shape. It is read
 * strictly: text that NumPy does not write is an error that names the byte. */
typedef struct cursor {
    const char *text, *at; /* ends in a NUL byte */
    const char *path;
    uint64_t offset; /* of text in the file */
    io_error *error;
} cursor;

static bool fail(const cursor *c, const char *what) {
    const unsigned long long byte = c->offset + (uint64_t)(c->at - c->text);
    return io_fail(c->error, "%s: not a .npy header at byte %llu: %s", c->path, byte, what);
}

/* Passes over blanks and then, if it follows, over word. */
static bool take(cursor *c, const char *word) {
    c->at += strspn(c->at, " \n");
    if (strncmp(c->at, word, strlen(word)) != 0) return false;
    c->at += strlen(word);
    return true;
}

static bool take_string(cursor *c, char *to, size_t size) {
    const char quote = *c->at, *end = strchr("'\"", quote) && quote != '\0' ? strchr(c->at + 1, quote) : NULL;
    if (quote != '\'' && quote != '"') return fail(c, "a quoted word should stand here");
    if (end == NULL) return fail(c, "this quotation mark is not closed");
    if ((size_t)(end - c->at) > size) return fail(c, "this word has no meaning here");
    snprintf(to, size, "%.*s", (int)(end - c->at - 1), c->at + 1);
    c->at = end + 1;
    return true;
}

/* Byte order, kind, size. The kinds are numbers: float, integer, unsigned, complex, bool. */
static bool take_type(cursor *c, io_npy_header *header) {
    static const char *const sizes[] = {"1", "2", "4", "8", "16"};
    char type[64];
    if (*c->at == '[') return io_fail(c->error, "%s: holds records; only plain numbers can be read", c->path);
    if (!take_string(c, type, sizeof type)) return false;
    const bool number =
        strlen(type) >= 3 && strlen(type) < sizeof header->type && strchr("<>|", type[0]) && strchr("fiucb", type[1]);
    for (size_t k = 0; number && k < sizeof sizes / sizeof sizes[0]; k++)
        if (strcmp(type + 2, sizes[k]) == 0) header->item = (size_t)1 << k;
    if (header->item == 0)
        return io_fail(c->error, "%s: holds elements of type '%s'; only plain numbers can be read", c->path, type);
    strcpy(header->type, type);
    return true;
}

static bool take_shape(cursor *c, io_npy_header *header) {
    if (!take(c, "(")) return fail(c, "the shape should start with (");
    bool comma = true;
    while (!take(c, ")")) {
        char *end;
        if (!comma) return fail(c, "a comma or ) should stand here");
        if (header->rank == IO_NPY_RANK_MAX) return fail(c, "arrays of so many dimensions cannot be read");
        if (*c->at < '0' || *c->at > '9') return fail(c, "a size should stand here");
        errno = 0;
        header->shape[header->rank++] = strtoull(c->at, &end, 10);
        if (errno != 0) return fail(c, "this size is too large");
        c->at = end + (*end == 'L'); /* Python 2 wrote long integers so */
        comma = take(c, ",");
    }
    /* (5) is a number in Python, (5,) a shape. */
    return header->rank != 1 || comma || fail(c, "a shape of one dimension has a comma");
}

static bool take_entry(cursor *c, io_npy_header *header, bool seen[3]) {
    static const char *const keys[3] = {"descr", "fortran_order", "shape"};
    const cursor before = *c;
    char key[32];
    int which = 0;
    if (!take_string(c, key, sizeof key)) return false;
    while (which < 3 && strcmp(key, keys[which]) != 0) which++;
    if (which == 3) return fail(&before, "this key is unknown");
    if (seen[which]) return fail(&before, "this key is here for the second time");
    seen[which] = true;
    if (!take(c, ":")) return fail(c, "a colon should stand here");
    take(c, "");
    if (which == 1 && take(c, "True"))
        return io_fail(c->error, "%s: is in Fortran order; save numpy.ascontiguousarray(a) instead", c->path);
    if (which == 1) return take(c, "False") || fail(c, "fortran_order should be True or False");
    return which == 0 ? take_type(c, header) : take_shape(c, header);
}

static bool parse(cursor *c, size_t size, io_npy_header *header) {
    bool seen[3] = {false}, comma = true;
    if (!take(c, "{")) return fail(c, "the header should start with {");
    while (!take(c, "}")) {
        if (!comma) return fail(c, "a comma or } should stand here");
        if (!take_entry(c, header, seen)) return false;
        comma = take(c, ",");
    }
    if (!seen[0] || !seen[1] || !seen[2]) return fail(c, "descr, fortran_order or shape is missing");
    take(c, "");
    return c->at == c->text + size || fail(c, "only blanks may follow the dictionary");
}

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
    uint32_t length = 0;
    memcpy(&length, start + 8, before - 8);
    if (length > file_size - before)
        return io_fail(error, "%s: truncated: the header at byte %zu is said to be %llu bytes long, the file has %llu",
                       npy->path, before, (unsigned long long)length, (unsigned long long)file_size);
    if (length > HEADER_MAX)
        return io_fail(error, "%s: the header is %llu bytes long; no array of plain numbers needs more than %d",
                       npy->path, (unsigned long long)length, HEADER_MAX);
    char *text = calloc((size_t)length + 1, 1);
    if (text == NULL) return io_fail(error, "%s: out of memory", npy->path);
    cursor c = {.text = text, .at = text, .path = npy->path, .offset = before, .error = error};
    const bool good = io_file_read_at(npy->fd, npy->path, text, (size_t)length, before, error) &&
                      parse(&c, (size_t)length, &npy->header);
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
    io_npy_shape_text(h->rank, h->shape, shape, sizeof shape);
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

void io_npy_close(io_npy *npy) {
    free(npy->rows);
    if (npy->fd >= 0) close(npy->fd);
    free(npy->path);
    *npy = (io_npy){.fd = -1};
}

void io_npy_shape_text(size_t rank, const uint64_t *shape, char *text, size_t size) {
    size_t used = (size_t)snprintf(text, size, "(");
    for (size_t k = 0; k < rank && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s%llu", k ? ", " : "", (unsigned long long)shape[k]);
    if (used < size) snprintf(text + used, size - used, rank == 1 ? ",)" : ")");
}

bool io_npy_expect_type(const io_npy *npy, const char *const *types, size_t count, io_error *error) {
    char list[64] = "";
    for (size_t k = 0; k < count; k++) {
        if (strcmp(npy->header.type, types[k]) == 0) return true;
        io_list(list, sizeof list, "'%s'", types[k]);
    }
    return io_fail(error, "%s: holds elements of type '%s', not %s; in NumPy, a.astype('%s') converts", npy->path,
                   npy->header.type, list, types[0]);
}

const void *io_npy_rows(io_npy *npy, uint64_t first, uint64_t count, io_error *error) {
    const uint64_t bytes = count * npy->row_bytes;
    if (npy->rows == NULL || npy->room < bytes) {
        free(npy->rows);
        npy->rows = bytes < SIZE_MAX ? malloc(bytes > 0 ? (size_t)bytes : 1) : NULL;
        npy->room = bytes;
    }
    const bool good =
        (npy->rows != NULL ||
         io_fail(error, "%s: out of memory for %llu bytes", npy->path, (unsigned long long)bytes)) &&
        io_file_read_at(npy->fd, npy->path, npy->rows, (size_t)bytes, npy->offset + first * npy->row_bytes, error);
    return good ? npy->rows : NULL;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

enum { ALIGNMENT = 64 }; /* of the first element, as NumPy has it */

/* Version 1.0: magic, version, length of the rest as 16 bits, the dictionary, blanks up to the alignment, newline. */
bool io_npy_write_header(io_output *output, const char *type, size_t item, size_t rank, const uint64_t *shape,
                         io_error *error) {
    char header[1024] = "\x93NUMPY\x01", text[24 * IO_NPY_RANK_MAX];
    uint64_t bytes = item;
    for (size_t k = 0; k < rank; k++) {
        if (shape[k] > 0 && bytes > INT64_MAX / shape[k])
            return io_fail(error, "%s: too many elements for any file", output->name);
        bytes *= shape[k];
    }
    io_npy_shape_text(rank, shape, text, sizeof text);
    const size_t start = 10, room = sizeof header - ALIGNMENT - start;
    const int length =
        snprintf(header + start, room, "{'descr': %s, 'fortran_order': False, 'shape': %s, }", type, text);
    if (length < 0 || (size_t)length >= room) return io_fail(error, "%s: too many fields", output->name);
    size_t size = start + (size_t)length;
    while ((size + 1) % ALIGNMENT != 0) header[size++] = ' ';
    header[size++] = '\n';
    header[8] = (char)((size - start) & 0xff);
    header[9] = (char)((size - start) >> 8);
    return io_output_reserve(output, size + bytes, error) && io_output_write(output, header, size, error);
}
