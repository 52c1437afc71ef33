/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of 8 bits a colour through libpng, row by row. */

#include "image.h"
#include "raster_sink.h"

#include <errno.h>
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

typedef struct png_state {
    png_structp png;
    png_infop info;
    char problem[200];
} png_state;

static void on_error(png_structp png, png_const_charp text) {
    png_state *s = png_get_error_ptr(png);
    /* Of a file libpng says only that it failed. Its text may lie on the stack that the jump leaves. */
    snprintf(s->problem, sizeof s->problem, "%s", errno != 0 ? strerror(errno) : text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) { (void)png, (void)text; }

static void free_state(io_raster_writer *w) {
    png_state *s = w->state;
    png_destroy_write_struct(&s->png, &s->info);
    free(s);
    w->state = NULL;
}

/* libpng leaves a step that fails by a jump to here. */
static bool take_step(io_raster_writer *w, void (*step)(io_raster_writer *w, const void *cells, size_t rows),
                      const void *cells, size_t rows, io_error *error) {
    png_state *s = w->state;
    errno = 0;
    if (setjmp(png_jmpbuf(s->png))) return io_fail(error, "%s: cannot write: %s", w->output.name, s->problem);
    step(w, cells, rows);
    return true;
}

static void begin(io_raster_writer *w, const void *cells, size_t rows) {
    const io_raster_product *p = &w->product;
    png_state *s = w->state;
    (void)cells, (void)rows;
    png_init_io(s->png, w->output.file);
    png_set_IHDR(s->png, s->info, (png_uint_32)p->nx, (png_uint_32)p->ny, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (p->georef == NULL) png_set_sRGB(s->png, s->info, PNG_sRGB_INTENT_PERCEPTUAL); /* light, and no map */
    png_write_info(s->png, s->info);
}

static bool png_create(io_raster_writer *w, io_error *error) {
    const io_raster_product *p = &w->product;
    if (p->nx > 1000000 || p->ny > 1000000)
        return io_fail(error, "%s: %zu x %zu pixels are too many for PNG", w->output.name, p->nx, p->ny);
    png_state *s = w->state = calloc(1, sizeof *s);
    if (s == NULL) return io_fail(error, "%s: out of memory", w->output.name);
    s->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, s, on_error, on_warning);
    s->info = s->png ? png_create_info_struct(s->png) : NULL;
    if (s->info == NULL)
        io_fail(error, "%s: out of memory", w->output.name);
    else if (take_step(w, begin, NULL, 0, error))
        return true;
    free_state(w);
    return false;
}

static void add_rows(io_raster_writer *w, const void *cells, size_t rows) {
    png_structp png = ((png_state *)w->state)->png;
    for (size_t j = 0; j < rows; j++) png_write_row(png, (const unsigned char *)cells + 3 * j * w->product.nx);
}

static bool png_write(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                      io_error *error) {
    (void)band;
    return take_step(w, add_rows, cells, window->ny, error);
}

static void end(io_raster_writer *w, const void *cells, size_t rows) {
    (void)cells, (void)rows;
    png_write_end(((png_state *)w->state)->png, NULL);
}

static bool png_finish(io_raster_writer *w, bool whole, io_error *error) {
    const bool good = whole && take_step(w, end, NULL, 0, error);
    free_state(w);
    return good;
}

/* The world file first: raster_out.c leaves it out if it writes one. */
static const char *const sidecars[] = {"*.pgw", "w", ".aux.xml", ".ovr", ".msk", NULL};
const io_raster_sink io_sink_png = {".png", "picture", 1, sidecars, png_create, png_write, png_finish};

/* ---- pictures of light ------------------------------------------------------------------------------------------------- */

/* IEC 61966-2-1. Light outside [0, 1] is cut off; NaN is black. */
static uint8_t srgb(float light) {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    const float code = light <= 0.0031308f ? 12.92f * light : 1.055f * powf(light, 1 / 2.4f) - 0.055f;
    return (uint8_t)(code * 255 + 0.5f);
}

bool io_png_put(io_output *out, const io_image *image, io_error *error) {
    io_raster_writer w = {.output = *out, .product = {.nx = image->width, .ny = image->height}};
    if (!png_create(&w, error)) return false;
    const size_t n = 3 * image->width;
    unsigned char *row = malloc(n);
    bool good = row != NULL || io_fail(error, "%s: out of memory", out->name);
    for (size_t y = 0; good && y < image->height; y++) {
        for (size_t k = 0; k < n; k++) row[k] = srgb(image->rgb[y * n + k]);
        good = take_step(&w, add_rows, row, 1, error);
    }
    free(row);
    return png_finish(&w, good, error);
}
