/* SPDX-License-Identifier: Apache-2.0 */
/* The header of a .npy file is the text of a Python dictionary with exactly the keys descr, fortran_order and shape. It
 * is read strictly: any text that NumPy does not write is an error that names the byte. */

#include "npy.h"

#include <string.h>

typedef struct cursor {
    const char *text;
    size_t size, place;
    const char *path;
    uint64_t at; /* of text in the file */
    io_error *error;
} cursor;

static bool fail(const cursor *c, const char *what) {
    const unsigned long long byte = c->at + c->place;
    return io_fail(c->error, "%s: not a .npy header at byte %llu: %s", c->path, byte, what);
}

static void skip_blanks(cursor *c) {
    while (c->place < c->size && (c->text[c->place] == ' ' || c->text[c->place] == '\n')) c->place++;
}

/* The next character other than a blank, or 0 at the end. It is not consumed. */
static char peek(cursor *c) {
    skip_blanks(c);
    return c->place < c->size ? c->text[c->place] : '\0';
}

static bool take(cursor *c, char wanted) {
    if (peek(c) != wanted || wanted == '\0') return false;
    c->place++;
    return true;
}

static bool take_word(cursor *c, const char *word) {
    const size_t length = strlen(word);
    skip_blanks(c);
    if (c->size - c->place < length || memcmp(c->text + c->place, word, length) != 0) return false;
    c->place += length;
    return true;
}

static bool take_string(cursor *c, char *to, size_t size) {
    const char quote = peek(c);
    if (quote != '\'' && quote != '"') return fail(c, "a quoted word should stand here");
    const char *begin = c->text + c->place + 1;
    const char *end = memchr(begin, quote, c->size - c->place - 1);
    if (end == NULL) return fail(c, "this quotation mark is not closed");
    const size_t length = (size_t)(end - begin);
    if (length >= size || memchr(begin, '\0', length)) return fail(c, "this word has no meaning here");
    memcpy(to, begin, length);
    to[length] = '\0';
    c->place += length + 2;
    return true;
}

/* Byte order, kind, size. The kinds are numbers: float, integer, unsigned, complex, bool. */
static bool plain_type(const char *type, size_t *item) {
    const bool known = strlen(type) >= 3 && strchr("<>|", type[0]) && strchr("fiucb", type[1]);
    if (!known) return false;
    static const struct {
        const char *digits;
        size_t item;
    } sizes[] = {{"1", 1}, {"2", 2}, {"4", 4}, {"8", 8}, {"16", 16}};
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        if (strcmp(type + 2, sizes[k].digits) == 0) {
            *item = sizes[k].item;
            return true;
        }
    return false;
}

static bool take_type(cursor *c, io_npy_header *header) {
    if (peek(c) == '[') return io_fail(c->error, "%s: holds records; only plain numbers can be read", c->path);
    char type[64];
    if (!take_string(c, type, sizeof type)) return false;
    if (strlen(type) >= sizeof header->type || !plain_type(type, &header->item))
        return io_fail(c->error, "%s: holds elements of type '%s'; only plain numbers can be read", c->path, type);
    strcpy(header->type, type);
    return true;
}

static bool take_order(cursor *c) {
    if (take_word(c, "False")) return true;
    if (take_word(c, "True"))
        return io_fail(c->error, "%s: is in Fortran order; save numpy.ascontiguousarray(a) instead", c->path);
    return fail(c, "fortran_order should be True or False");
}

static bool take_size(cursor *c, uint64_t *value) {
    char digit = peek(c);
    if (digit < '0' || digit > '9') return fail(c, "a size should stand here");
    uint64_t size = 0;
    for (; digit >= '0' && digit <= '9'; digit = c->place < c->size ? c->text[c->place] : '\0') {
        const uint64_t next = (uint64_t)(digit - '0');
        if (size > (UINT64_MAX - next) / 10) return fail(c, "this size is too large");
        size = size * 10 + next;
        c->place++;
    }
    if (digit == 'L') c->place++; /* Python 2 wrote long integers so */
    *value = size;
    return true;
}

static bool take_shape(cursor *c, io_npy_header *header) {
    if (!take(c, '(')) return fail(c, "the shape should start with (");
    header->rank = 0;
    bool comma = true;
    while (!take(c, ')')) {
        if (!comma) return fail(c, "a comma or ) should stand here");
        if (header->rank == IO_NPY_RANK_MAX) return fail(c, "arrays of so many dimensions cannot be read");
        if (!take_size(c, &header->shape[header->rank++])) return false;
        comma = take(c, ',');
    }
    /* (5) is a number in Python, (5,) a shape. */
    return header->rank != 1 || comma || fail(c, "a shape of one dimension has a comma");
}

enum { DESCR = 1, ORDER = 2, SHAPE = 4, ALL = 7 };

static bool take_entry(cursor *c, io_npy_header *header, unsigned *seen) {
    const cursor before = *c;
    char key[32];
    if (!take_string(c, key, sizeof key)) return false;
    const unsigned which = strcmp(key, "descr") == 0           ? DESCR
                           : strcmp(key, "fortran_order") == 0 ? ORDER
                           : strcmp(key, "shape") == 0         ? SHAPE
                                                               : 0;
    if (which == 0) return fail(&before, "this key is unknown");
    if (*seen & which) return fail(&before, "this key is here for the second time");
    *seen |= which;
    if (!take(c, ':')) return fail(c, "a colon should stand here");
    if (which == DESCR) return take_type(c, header);
    return which == ORDER ? take_order(c) : take_shape(c, header);
}

bool io_npy_parse(const char *text, size_t size, const char *path, uint64_t at, io_npy_header *header,
                  io_error *error) {
    cursor c = {.text = text, .size = size, .path = path, .at = at, .error = error};
    unsigned seen = 0;
    *header = (io_npy_header){0};
    if (!take(&c, '{')) return fail(&c, "the header should start with {");
    bool comma = true;
    while (!take(&c, '}')) {
        if (!comma) return fail(&c, "a comma or } should stand here");
        if (!take_entry(&c, header, &seen)) return false;
        comma = take(&c, ',');
    }
    if (seen != ALL) return fail(&c, "descr, fortran_order or shape is missing");
    skip_blanks(&c);
    return c.place == c.size || fail(&c, "only blanks may follow the dictionary");
}
