/* SPDX-License-Identifier: Apache-2.0 */
/* Portable float map: a text header ("PF" for colour or "Pf" for grey, width, height, a number whose sign says the byte
 * order), then rows of floats from the bottom up. The six scenes are made with .pfm images if OpenEXR is missing. */

#include "file.h"
#include "image_format.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static bool host_is_little_endian(void) {
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static void swap_bytes(float *values, size_t n) {
    for (size_t k = 0; k < n; k++) {
        uint32_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        bits = bits >> 24 | (bits >> 8 & 0xff00) | (bits << 8 & 0xff0000) | bits << 24;
        memcpy(&values[k], &bits, sizeof bits);
    }
}

/* Reads one blank-separated word and the single blank after it. */
static bool read_word(FILE *file, char word[32]) {
    int c, length = 0;
    while ((c = fgetc(file)) == ' ' || c == '\n' || c == '\t' || c == '\r') continue;
    for (; c != EOF && c != ' ' && c != '\n' && c != '\t' && c != '\r'; c = fgetc(file)) {
        if (length == 31) return false;
        word[length++] = (char)c;
    }
    word[length] = '\0';
    return length > 0;
}

static bool read_side(FILE *file, size_t *side) {
    char word[32];
    if (!read_word(file, word) || strspn(word, "0123456789") != strlen(word) || strlen(word) > 9) return false;
    *side = (size_t)strtoul(word, NULL, 10);
    return *side > 0;
}

/* Channels (3 or 1), size and byte order. */
static bool read_header(FILE *file, unsigned *channels, size_t *width, size_t *height, bool *little) {
    char word[32];
    if (!read_word(file, word)) return false;
    if (strcmp(word, "PF") != 0 && strcmp(word, "Pf") != 0) return false;
    *channels = word[1] == 'F' ? 3 : 1;
    if (!read_side(file, width) || !read_side(file, height) || !read_word(file, word)) return false;
    *little = word[0] == '-';
    return strspn(word, "+-.0123456789eE") == strlen(word);
}

static bool read_pixels(FILE *file, unsigned channels, bool little, const io_image *image) {
    const size_t row = image->width * channels;
    for (size_t y = image->height; y-- > 0;) {
        float *rgb = image->rgb + y * image->width * 3;
        if (fread(rgb, sizeof(float), row, file) != row) return false;
        if (little != host_is_little_endian()) swap_bytes(rgb, row);
        /* Grey spreads from the end, so that no value is overwritten before it is read. */
        for (size_t x = channels == 1 ? image->width : 0; x-- > 0;)
            rgb[x * 3] = rgb[x * 3 + 1] = rgb[x * 3 + 2] = rgb[x];
    }
    return true;
}

static bool read_open(FILE *file, const char *path, io_image *image, io_error *error) {
    unsigned channels;
    size_t width, height;
    bool little;
    if (!read_header(file, &channels, &width, &height, &little))
        return io_fail(error, "%s: not a portable float map (PF or Pf, width, height, byte order)", path);
    /* Before any memory is taken: a header of a few bytes can claim any size. */
    struct stat status;
    const long start = ftell(file);
    if (start < 0 || fstat(fileno(file), &status) != 0)
        return io_fail(error, "%s: cannot read: %s", path, strerror(errno));
    const uint64_t needed = (uint64_t)width * height * channels * sizeof(float);
    const uint64_t present =
        (uint64_t)status.st_size > (uint64_t)start ? (uint64_t)status.st_size - (uint64_t)start : 0;
    if (present < needed)
        return io_fail(error, "%s: %zu x %zu pixels need %llu bytes after the header at byte %ld, the file has %llu",
                       path, width, height, (unsigned long long)needed, start, (unsigned long long)present);
    if (!io_image_allocate(image, width, height, false, path, error)) return false;
    if (read_pixels(file, channels, little, image)) return true;
    io_image_free(image);
    return io_fail(error, "%s: cannot read: %s", path, strerror(errno));
}

static bool pfm_read(const char *path, bool halves, io_image *image, io_error *error) {
    (void)halves; /* the file has floats */
    FILE *file = io_file_stream(path, error);
    if (file == NULL) return false;
    const bool good = read_open(file, path, image, error);
    fclose(file);
    return good;
}

static bool pfm_write(io_output *out, const io_image *image, io_error *error) {
    char header[80];
    const int length = snprintf(header, sizeof header, "PF\n%zu %zu\n%s\n", image->width, image->height,
                                host_is_little_endian() ? "-1.0" : "1.0");
    if (!io_output_write(out, header, (size_t)length, error)) return false;
    for (size_t y = image->height; y-- > 0;) {
        const float *row = image->rgb + y * image->width * 3;
        if (!io_output_write(out, row, image->width * 3 * sizeof(float), error)) return false;
    }
    return true;
}

const image_format image_pfm = {".pfm", pfm_read, pfm_write};
