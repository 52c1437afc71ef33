/* SPDX-License-Identifier: Apache-2.0 */
/* The large height fields make most of the text: a million numbers, which are read in one pass without copying, and the
 * usual kind of them without a token each. */

#include "pbrt_lex.h"

#include "inputs.h"
#include "number.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

bool pbrt_source_open(pbrt_source *s, const char *path, io_error *error) {
    *s = (pbrt_source){.path = strdup(path)};
    if (s->path == NULL) return io_fail(error, "%s: out of memory", path);
    s->text = io_file_read(path, &s->size, error);
    if (s->text != NULL) return true;
    pbrt_source_close(s);
    return false;
}

void pbrt_source_close(pbrt_source *s) {
    free(s->path);
    free(s->text);
    *s = (pbrt_source){0};
}

size_t pbrt_line(pbrt_source *s, size_t offset) {
    if (offset < s->counted) s->counted = s->line = 0;
    for (; s->counted < offset; s->counted++) s->line += s->text[s->counted] == '\n';
    return s->line + 1;
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }

static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/* Whole powers of ten that a double holds exactly. */
static const double power_of_ten[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                      1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
static const uint64_t exact_in_double = (uint64_t)1 << 53;

/* Whether a double that was rounded once may be rounded to float once more. It lies on the same side of the point
 * halfway between two floats as the number that it came from, unless it is that point itself; below the smallest
 * normal float these points lie elsewhere. */
static bool rounds_twice_alike(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return (bits & 0x1fffffff) != 0x10000000 && (number == 0 || fabs(number) >= 0x1p-126);
}

float pbrt_float(const pbrt_token *token) {
    if (rounds_twice_alike(token->number)) return (float)token->number;
    return number_read_float(token->start, NULL);
}

static const char *skip_digits(const char *p) {
    while (is_digit(*p)) p++;
    return p;
}

/* A decimal number without regard to the locale, correctly rounded: [+-] digits [. digits] [e [+-] digits]. text must
 * end in a NUL somewhere. Returns the end of the number, or NULL if there is none. */
static const char *pbrt_number(const char *text, double *number) {
    const char *start = text + (*text == '-' || *text == '+'), *point = skip_digits(start), *p = point;
    if (*p == '.') p = skip_digits(p + 1);
    if (p - start == (*point == '.')) return NULL; /* no digit */
    if (*p == 'e' || *p == 'E') {
        p += p[1] == '-' || p[1] == '+' ? 2 : 1;
        if (!is_digit(*p)) return NULL;
        p = skip_digits(p);
    }
    *number = number_read(text, NULL);
    return p;
}

/* A number of at most 18 digits without an exponent, before a blank, if quick arithmetic rounds it for certain. Returns
 * its end, or NULL for any other. */
static const char *plain_float(const char *p, float *value) {
    const bool negative = *p == '-';
    p += negative;
    uint64_t mantissa = 0;
    const char *first = p;
    for (; is_digit(*p); p++) mantissa = mantissa * 10 + (uint64_t)(*p - '0');
    ptrdiff_t digits = p - first, behind = 0;
    if (*p == '.') {
        first = ++p;
        for (; is_digit(*p); p++) mantissa = mantissa * 10 + (uint64_t)(*p - '0');
        behind = p - first;
        digits += behind;
    }
    /* With more digits the mantissa may have overflowed. */
    if (digits == 0 || digits > 18 || mantissa > exact_in_double || !is_blank(*p)) return NULL;
    const double size = (double)mantissa / power_of_ten[behind];
    if (!rounds_twice_alike(size)) return NULL;
    *value = (float)(negative ? -size : size);
    return p;
}

size_t pbrt_plain_floats(pbrt_source *s, float *values, size_t most) {
    const char *p = s->text + s->at;
    size_t count = 0;
    for (; count < most; count++) {
        while (is_blank(*p)) p++;
        const char *end = plain_float(p, &values[count]);
        if (end == NULL) break;
        p = end;
    }
    s->at = (size_t)(p - s->text);
    return count;
}

static void skip_blanks_and_comments(pbrt_source *s) {
    const char *p = s->text + s->at, *end = s->text + s->size;
    for (;; p++) {
        while (p < end && is_blank(*p)) p++;
        if (p == end || *p != '#') break;
        while (p < end && *p != '\n') p++;
        if (p == end) break;
    }
    s->at = (size_t)(p - s->text);
}

static pbrt_token bad(pbrt_token token, const char *problem) {
    token.kind = PBRT_BAD;
    token.problem = problem;
    return token;
}

/* The text's NUL does, too. */
static bool ends_token(char c) { return strchr(" \n\t\r[]\"#", c) != NULL; }

pbrt_token pbrt_next(pbrt_source *s) {
    skip_blanks_and_comments(s);
    const char *start = s->text + s->at, *end = s->text + s->size;
    pbrt_token token = {.kind = PBRT_END, .offset = s->at, .start = start};
    if (start == end) return token;
    const char *p = start + 1;
    if (*start == '[' || *start == ']') {
        token.kind = *start == '[' ? PBRT_OPEN : PBRT_CLOSE;
    } else if (*start == '"') {
        while (p < end && *p != '"' && *p != '\n') p++;
        if (p == end || *p == '\n') return bad(token, "unterminated string");
        token.kind = PBRT_STRING;
        token.start = start + 1;
        token.length = (size_t)(p - start) - 1;
        if (memchr(token.start, '\0', token.length) != NULL) return bad(token, "NUL byte in a string");
        s->at = (size_t)(p + 1 - s->text);
        return token;
    } else if (is_letter(*start)) {
        token.kind = PBRT_WORD;
        while (is_letter(*p) || is_digit(*p)) p++;
    } else if (is_digit(*start) || (*start != '\0' && strchr("+-.", *start) != NULL)) {
        token.kind = PBRT_NUMBER;
        p = pbrt_number(start, &token.number);
        if (p == NULL || !ends_token(*p)) return bad(token, "malformed number");
    } else {
        return bad(token, "unexpected character");
    }
    token.length = (size_t)(p - start);
    s->at = (size_t)(p - s->text);
    return token;
}
