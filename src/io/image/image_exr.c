/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR through its C library, which opens files by their names, and goes back in one that it writes to fill in the
 * table of chunks: a pipe cannot be written to. */

#include "image.h"
#include "inputs.h"

#include <openexr.h>
#include <string.h>
#include <unistd.h>

/* The first message about the picture that this thread is at, to follow the file's name in ours. The library reports
 * errors while it holds its lock, on which asking it for the context's user data would wait for ever. */
static _Thread_local char first_message[200];

static void keep_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code;
    if (first_message[0] == '\0') snprintf(first_message, sizeof first_message, "%s", message);
}

/* Whether a call of the library did its work. Some failures come without a message. */
static bool good(exr_result_t code) {
    if (code != EXR_ERR_SUCCESS) keep_message(NULL, code, exr_get_default_error_message(code));
    return code == EXR_ERR_SUCCESS;
}

/* Where a channel's values stand among R, G, B, A; -1 for other names. */
static int component(const char *name) {
    static const char order[] = "RGBA";
    const char *place = name[0] != '\0' && name[1] == '\0' ? strchr(order, name[0]) : NULL;
    return place ? (int)(place - order) : -1;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* The chunk of lines that begins with line y. */
static bool encode_chunk(exr_context_t context, exr_encode_pipeline_t *encoder, const io_image *image, int y) {
    static const float opaque = 1;
    exr_chunk_info_t chunk;
    if (!good(exr_write_scanline_chunk_info(context, 0, y, &chunk)) ||
        !good(y == 0 ? exr_encoding_initialize(context, 0, &chunk, encoder)
                     : exr_encoding_update(context, 0, &chunk, encoder)))
        return false;
    for (int c = 0; c < encoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &encoder->channels[c];
        const int place = component(channel->channel_name);
        const float *pixels = image->rgb + (size_t)y * image->width * 3 + place;
        channel->user_bytes_per_element = sizeof *pixels;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = place < 3 ? 3 * sizeof *pixels : 0;
        channel->user_line_stride = place < 3 ? (int32_t)(image->width * 3 * sizeof *pixels) : 0;
        channel->encode_from_ptr = (const uint8_t *)(place < 3 ? pixels : &opaque);
    }
    return (y > 0 || good(exr_encoding_choose_default_routines(context, 0, encoder))) &&
           good(exr_encoding_run(context, 0, encoder));
}

/* Of zlib, whose default is 6: half of its time for files 4 % larger, measured on pictures of the six scenes. */
enum { ZIP_LEVEL = 4 };

static bool encode(const char *path, const io_image *image) {
    static const char *const names[4] = {"A", "B", "G", "R"}; /* the file's order is the alphabet's */
    const int width = (int)image->width, height = (int)image->height;
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.zip_level = ZIP_LEVEL;
    exr_context_t context = NULL;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t part, lines = 1;
    bool whole = good(exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &setup)) &&
                 good(exr_add_part(context, NULL, EXR_STORAGE_SCANLINE, &part)) &&
                 good(exr_initialize_required_attr_simple(context, 0, width, height, EXR_COMPRESSION_ZIP));
    for (int c = 0; c < 4 && whole; c++)
        whole = good(exr_add_channel(context, 0, names[c], EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    whole = whole && good(exr_write_header(context)) && good(exr_get_scanlines_per_chunk(context, 0, &lines));
    for (int y = 0; y < height && whole; y += lines) whole = encode_chunk(context, &encoder, image, y);
    exr_encoding_destroy(context, &encoder);
    return good(exr_finish(&context)) && whole;
}

bool io_exr_put(io_output *out, const io_image *image, io_error *error) {
    enum { SIDE_MAX = 1 << 24 }; /* keeps a row's bytes in the 31 bits that the library has for them */
    if (image->width > SIDE_MAX || image->height > SIDE_MAX)
        return io_fail(error, "%s: %zu x %zu pixels are too many for OpenEXR", out->name, image->width, image->height);
    if (out->direct) return io_fail(error, "%s: cannot write: OpenEXR needs a regular file", out->name);
    first_message[0] = '\0';
    /* Said by the system's reason if it was the system that failed. */
    return encode(io_output_temporary(out), image) ||
           (io_output_has_room(out, error) && io_fail(error, "%s: cannot write: %s", out->name, first_message));
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

typedef struct reader {
    exr_context_t context;
    exr_decode_pipeline_t decoder;
    bool grey; /* Y alone */
    size_t most;
    io_image *image;
} reader;

/* Decodes a chunk, lines or a tile, whose first pixel is (x, y) of the picture. */
static bool decode_chunk(reader *r, const exr_chunk_info_t *chunk, size_t x, size_t y) {
    enum { PIXEL = 4 * sizeof(uint16_t) };
    const size_t row = (r->image->width + 2) * PIXEL;
    uint8_t *corner = (uint8_t *)r->image->halves + y * row + (x + 1) * PIXEL;
    const bool first = r->decoder.context == NULL;
    /* The library would show what its memory held before. */
    if (chunk->compression == EXR_COMPRESSION_NONE && chunk->packed_size != chunk->unpacked_size)
        return good(EXR_ERR_BAD_CHUNK_LEADER);
    if (!good(first ? exr_decoding_initialize(r->context, 0, chunk, &r->decoder)
                    : exr_decoding_update(r->context, 0, chunk, &r->decoder)))
        return false;
    for (int32_t k = 0; k < chunk->height; k++)
        memset(corner + (size_t)k * row, 0, (size_t)chunk->width * PIXEL); /* for channels that the file lacks */
    for (int c = 0; c < r->decoder.channel_count; c++) {
        exr_coding_channel_info_t *channel = &r->decoder.channels[c];
        const int place = r->grey && strcmp(channel->channel_name, "Y") == 0 ? 0 : component(channel->channel_name);
        channel->decode_to_ptr = NULL;
        if (place < 0 || place > 2) continue;
        channel->user_bytes_per_element = sizeof(uint16_t);
        channel->user_data_type = EXR_PIXEL_HALF;
        channel->user_pixel_stride = PIXEL;
        channel->user_line_stride = (int32_t)row;
        channel->decode_to_ptr = corner + (size_t)place * sizeof(uint16_t);
    }
    return (!first || good(exr_decoding_choose_default_routines(r->context, 0, &r->decoder))) &&
           good(exr_decoding_run(r->context, 0, &r->decoder));
}

/* Lines come in chunks as wide as the picture; top is the first one's number. */
static bool decode(reader *r, bool tiled, int32_t top) {
    const int32_t width = (int32_t)r->image->width, height = (int32_t)r->image->height;
    exr_chunk_info_t chunk;
    for (int32_t y = 0, row = 0; y < height; y += chunk.height, row++)
        for (int32_t x = 0, column = 0; x < width; x += chunk.width, column++)
            if (!good(tiled ? exr_read_tile_chunk_info(r->context, 0, column, row, 0, 0, &chunk)
                            : exr_read_scanline_chunk_info(r->context, 0, top + y, &chunk)) ||
                !decode_chunk(r, &chunk, (size_t)x, (size_t)y))
                return false;
    return true;
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

static bool read_started(reader *r, uint64_t file_size, const char *path, io_error *error) {
    exr_storage_t storage;
    exr_attr_box2i_t window;
    if (!good(exr_get_storage(r->context, 0, &storage)) || !good(exr_get_data_window(r->context, 0, &window)))
        return io_fail(error, "%s: cannot read: %s", path, first_message);
    if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
        return io_fail(error, "%s: deep pictures are not supported", path);
    if (!know_channels(r->context, &r->grey))
        return io_fail(error, "%s: has neither the channels R, G and B nor Y at full resolution", path);

    const int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    if (width < 1 || height < 1) return io_fail(error, "%s: has no pixels", path);
    if ((uint64_t)width * (uint64_t)height / IO_EXR_PIXELS_PER_BYTE_MAX > file_size)
        return io_fail(error, "%s: %lld x %lld pixels are more than %llu bytes can hold", path, (long long)width,
                       (long long)height, (unsigned long long)file_size);
    if (!io_image_allocate(r->image, (size_t)width, (size_t)height, r->most, path, error)) return false;
    if (!decode(r, storage == EXR_STORAGE_TILED, window.min.y)) {
        io_image_free(r->image);
        return io_fail(error, "%s: cannot read: %s", path, first_message);
    }
    uint16_t *pixel = r->image->halves;
    for (size_t k = 0; r->grey && k < (r->image->width + 2) * r->image->height; k++, pixel += 4)
        pixel[1] = pixel[2] = pixel[0];
    return true;
}

bool io_exr_read(const char *path, size_t most, io_image *image, io_error *error) {
    reader r = {.most = most, .image = image, .decoder = EXR_DECODE_PIPELINE_INITIALIZER};
    uint64_t size;
    const int file = io_file_open(path, &size, error);
    if (file < 0) return false;
    first_message[0] = '\0';
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.max_image_width = setup.max_image_height = 1 << 24;
    setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const bool whole = good(exr_start_read(&r.context, path, &setup))
                           ? read_started(&r, size, path, error)
                           : io_fail(error, "%s: not a readable OpenEXR picture: %s", path, first_message);
    exr_decoding_destroy(r.context, &r.decoder);
    exr_finish(&r.context);
    close(file);
    return whole;
}
