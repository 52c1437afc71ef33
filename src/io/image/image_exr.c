/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR through its C library, which goes back in the file to fill in its table of chunks: a pipe cannot be written to. */

#include "image.h"
#include "inputs.h"

#include <errno.h>
#include <openexr.h>
#include <string.h>
#include <unistd.h>

/* The library's first message about the picture that this thread is at, to follow the file's name in ours. The library tells errors while
 * it holds its own lock, on which asking it for the context's user data would wait for ever. */
static _Thread_local char first_message[200];

static void keep_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code;
    if (first_message[0] == '\0') snprintf(first_message, sizeof first_message, "%s", message);
}

static const char *reason(exr_result_t code) {
    return first_message[0] != '\0' ? first_message : exr_get_default_error_message(code);
}

/* Where a channel's values stand among R, G, B, A; -1 for other names. */
static int component(const char *name) {
    static const char order[] = "RGBA";
    const char *place = name[0] != '\0' && name[1] == '\0' ? strchr(order, name[0]) : NULL;
    return place ? (int)(place - order) : -1;
}

/* ---- writing ------------------------------------------------------------------------------------------------------ */

static int64_t write_bytes(exr_const_context_t context, void *user, const void *bytes, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail) {
    FILE *to = user;
    (void)fail; /* would take the library's lock */
    if (fseeko(to, (off_t)offset, SEEK_SET) == 0 && fwrite(bytes, 1, (size_t)size, to) == size) return (int64_t)size;
    keep_message(context, EXR_ERR_WRITE_IO, strerror(errno));
    return -1;
}

static const float opaque = 1;

static exr_result_t encode_chunks(exr_context_t context, const io_image *image) {
    const int height = (int)image->height;
    int32_t lines = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(context, 0, &lines);
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    for (int y = 0; result == EXR_ERR_SUCCESS && y < height; y += lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, 0, y, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = y == 0 ? exr_encoding_initialize(context, 0, &chunk, &encoder)
                        : exr_encoding_update(context, 0, &chunk, &encoder);
        if (result != EXR_ERR_SUCCESS) break;
        for (int c = 0; c < encoder.channel_count; c++) {
            exr_coding_channel_info_t *channel = &encoder.channels[c];
            const int place = component(channel->channel_name);
            const float *pixels = image->rgb + (size_t)y * image->width * 3 + place;
            channel->user_bytes_per_element = sizeof *pixels;
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_pixel_stride = place < 3 ? 3 * sizeof *pixels : 0;
            channel->user_line_stride = place < 3 ? (int32_t)(image->width * 3 * sizeof *pixels) : 0;
            channel->encode_from_ptr = (const uint8_t *)(place < 3 ? pixels : &opaque);
        }
        if (y == 0) result = exr_encoding_choose_default_routines(context, 0, &encoder);
        if (result == EXR_ERR_SUCCESS) result = exr_encoding_run(context, 0, &encoder);
    }
    exr_encoding_destroy(context, &encoder);
    return result;
}

/* Of zlib, whose default is 6: half of its time for files that are 4 % larger, measured on pictures of the six scenes. */
enum { ZIP_LEVEL = 4 };

static exr_result_t encode(FILE *to, const char *name, const io_image *image) {
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.user_data = to;
    setup.write_fn = write_bytes;
    setup.zip_level = ZIP_LEVEL;
    exr_context_t context = NULL;
    exr_result_t result = exr_start_write(&context, name, EXR_WRITE_FILE_DIRECTLY, &setup);
    if (result != EXR_ERR_SUCCESS) return result;

    const int width = (int)image->width, height = (int)image->height;
    int part = 0;
    result = exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (result == EXR_ERR_SUCCESS)
        result = exr_initialize_required_attr_simple(context, part, width, height, EXR_COMPRESSION_ZIP);
    static const char *const names[4] = {"A", "B", "G", "R"}; /* the file's order is the alphabet's */
    for (int c = 0; c < 4 && result == EXR_ERR_SUCCESS; c++)
        result = exr_add_channel(context, part, names[c], EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    if (result == EXR_ERR_SUCCESS) result = exr_write_header(context);
    if (result == EXR_ERR_SUCCESS) result = encode_chunks(context, image);
    const exr_result_t finished = exr_finish(&context);
    return result == EXR_ERR_SUCCESS ? finished : result;
}

bool io_exr_put(io_output *out, const io_image *image, io_error *error) {
    enum { SIDE_MAX = 1 << 24 }; /* keeps a row's bytes in the 31 bits that the library has for them */
    if (image->width > SIDE_MAX || image->height > SIDE_MAX)
        return io_fail(error, "%s: %zu x %zu pixels are too many for OpenEXR", out->name, image->width, image->height);
    if (out->direct) return io_fail(error, "%s: cannot write: OpenEXR needs a regular file", out->name);
    first_message[0] = '\0';
    const exr_result_t result = encode(out->file, out->name, image);
    return result == EXR_ERR_SUCCESS || io_fail(error, "%s: cannot write: %s", out->name, reason(result));
}

/* ---- reading ------------------------------------------------------------------------------------------------------ */

typedef struct reader {
    int fd;
    uint64_t file_size;
    exr_context_t context;
    exr_decode_pipeline_t decoder;
    bool started; /* the decoder */
    bool grey;    /* Y alone */
    io_image *image;
} reader;

static int64_t file_bytes(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const reader *)user)->file_size;
}

/* As many bytes as there are: the library takes fewer than it asked for as the file's end. */
static int64_t read_bytes(exr_const_context_t context, void *user, void *to, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t fail) {
    (void)context, (void)fail;
    const reader *r = user;
    const uint64_t left = offset < r->file_size ? r->file_size - offset : 0;
    const size_t count = (size_t)(size < left ? size : left);
    return io_file_read_at(r->fd, "", to, count, offset, NULL) ? (int64_t)count : -1;
}

/* Decodes one chunk whose first pixel is (x, y) of the picture. */
static exr_result_t decode_chunk(reader *r, const exr_chunk_info_t *chunk, size_t x, size_t y) {
    exr_result_t result = r->started ? exr_decoding_update(r->context, 0, chunk, &r->decoder)
                                     : exr_decoding_initialize(r->context, 0, chunk, &r->decoder);
    if (result != EXR_ERR_SUCCESS) return result;
    enum { PIXEL = 4 * sizeof(uint16_t) };
    const size_t row = (r->image->width + 2) * PIXEL;
    uint8_t *corner = (uint8_t *)r->image->halves + y * row + (x + 1) * PIXEL;
    for (int32_t k = 0; k < chunk->height; k++)
        memset(corner + (size_t)k * row, 0, (size_t)chunk->width * PIXEL); /* for channels that the file lacks */
    for (int c = 0; c < r->decoder.channel_count; c++) {
        exr_coding_channel_info_t *channel = &r->decoder.channels[c];
        const int place = !r->grey                                  ? component(channel->channel_name)
                          : strcmp(channel->channel_name, "Y") == 0 ? 0
                                                                    : -1;
        channel->decode_to_ptr = NULL;
        if (place < 0 || place > 2) continue;
        channel->user_bytes_per_element = sizeof(uint16_t);
        channel->user_data_type = EXR_PIXEL_HALF;
        channel->user_pixel_stride = PIXEL;
        channel->user_line_stride = (int32_t)row;
        channel->decode_to_ptr = corner + (size_t)place * sizeof(uint16_t);
    }
    if (!r->started) result = exr_decoding_choose_default_routines(r->context, 0, &r->decoder);
    r->started = true;
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(r->context, 0, &r->decoder) : result;
}

static exr_result_t decode_lines(reader *r, int32_t top) {
    int32_t lines = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(r->context, 0, &lines);
    for (size_t y = 0; result == EXR_ERR_SUCCESS && y < r->image->height; y += (size_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(r->context, 0, top + (int32_t)y, &chunk);
        if (result == EXR_ERR_SUCCESS) result = decode_chunk(r, &chunk, 0, y);
    }
    return result;
}

static exr_result_t decode_tiles(reader *r) {
    int32_t width = 1, height = 1;
    exr_result_t result = exr_get_tile_sizes(r->context, 0, 0, 0, &width, &height);
    for (size_t y = 0; y < r->image->height; y += (size_t)height)
        for (size_t x = 0; x < r->image->width && result == EXR_ERR_SUCCESS; x += (size_t)width) {
            exr_chunk_info_t chunk;
            result = exr_read_tile_chunk_info(r->context, 0, (int)(x / (size_t)width), (int)(y / (size_t)height), 0, 0,
                                              &chunk);
            if (result == EXR_ERR_SUCCESS) result = decode_chunk(r, &chunk, x, y);
        }
    return result;
}

/* Looks for R, G and B, or Y alone; none of them thinned out. */
static bool know_channels(exr_context_t context, bool *grey) {
    const exr_attr_chlist_t *list = NULL;
    if (exr_get_channels(context, 0, &list) != EXR_ERR_SUCCESS) return false;
    enum { Y = 1 << 4 };
    unsigned found = 0;
    for (int c = 0; c < list->num_channels; c++) {
        const exr_attr_chlist_entry_t *entry = &list->entries[c];
        const int place = component(entry->name.str);
        const unsigned bit = strcmp(entry->name.str, "Y") == 0 ? Y : place >= 0 ? 1u << place : 0;
        if (bit != 0 && (entry->x_sampling != 1 || entry->y_sampling != 1)) return false;
        found |= bit;
    }
    *grey = (found & 7) == 0;
    return *grey ? (found & Y) != 0 : (found & 7) == 7;
}

static bool read_started(reader *r, const char *path, io_error *error) {
    exr_storage_t storage;
    exr_attr_box2i_t window;
    exr_result_t result = exr_get_storage(r->context, 0, &storage);
    if (result == EXR_ERR_SUCCESS) result = exr_get_data_window(r->context, 0, &window);
    if (result != EXR_ERR_SUCCESS) return io_fail(error, "%s: cannot read: %s", path, reason(result));
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return io_fail(error, "%s: deep pictures are not supported", path);
    if (!know_channels(r->context, &r->grey))
        return io_fail(error, "%s: has neither the channels R, G and B nor Y at full resolution", path);

    const int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1) return io_fail(error, "%s: has no pixels", path);
    if ((uint64_t)width * (uint64_t)height / IO_EXR_PIXELS_PER_BYTE_MAX > r->file_size)
        return io_fail(error, "%s: %lld x %lld pixels are more than %llu bytes can hold", path, (long long)width,
                       (long long)height, (unsigned long long)r->file_size);
    if (!io_image_allocate(r->image, (size_t)width, (size_t)height, path, error)) return false;
    result = storage == EXR_STORAGE_TILED ? decode_tiles(r) : decode_lines(r, window.min.y);
    if (result != EXR_ERR_SUCCESS) {
        io_image_free(r->image);
        return io_fail(error, "%s: cannot read: %s", path, reason(result));
    }
    uint16_t *pixel = r->image->halves;
    for (size_t k = 0; r->grey && k < (r->image->width + 2) * r->image->height; k++, pixel += 4)
        pixel[1] = pixel[2] = pixel[0];
    return true;
}

bool io_exr_read(const char *path, io_image *image, io_error *error) {
    reader r = {.image = image, .decoder = EXR_DECODE_PIPELINE_INITIALIZER};
    r.fd = io_file_open(path, &r.file_size, error);
    if (r.fd < 0) return false;
    first_message[0] = '\0';
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.user_data = &r;
    setup.read_fn = read_bytes;
    setup.size_fn = file_bytes;
    setup.max_image_width = setup.max_image_height = 1 << 24;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t result = exr_start_read(&r.context, path, &setup);
    const bool good = result == EXR_ERR_SUCCESS
                          ? read_started(&r, path, error)
                          : io_fail(error, "%s: not a readable OpenEXR picture: %s", path, reason(result));
    if (r.started) exr_decoding_destroy(r.context, &r.decoder);
    exr_finish(&r.context);
    close(r.fd);
    return good;
}
