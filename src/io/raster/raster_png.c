/* SPDX-License-Identifier: Apache-2.0 */
/* Results as pictures of 8 bits a colour, grey or RGB, row by row: a product has more cells than a picture in memory would be good for.
 * Hence not libpng's simplified interface, which takes whole pictures, as src/io/image_png.c does. */

#include "raster_sink.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

typedef struct png_state {
    png_structp png;
    png_infop info;
    const char *name;
    char problem[200];
    unsigned char *grey;
} png_state;

static void on_error(png_structp png, png_const_charp text) {
    png_state *s = png_get_error_ptr(png);
    /* Of a file libpng says only that it failed. Its text may lie on the stack that the jump leaves. */
    snprintf(s->problem, sizeof s->problem, "%s", errno != 0 ? strerror(errno) : text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) {
    (void)png;
    (void)text;
}

static bool fail(const png_state *s, io_error *error) {
    return io_fail(error, "%s: cannot write: %s", s->name, s->problem);
}

static void free_state(io_raster_writer *w) {
    png_state *s = w->state;
    png_destroy_write_struct(&s->png, &s->info);
    free(s->grey);
    free(s);
    w->state = NULL;
}

static bool png_create(io_raster_writer *w, io_error *error) {
    const io_raster_product *p = &w->product;
    if (p->nx > 1000000 || p->ny > 1000000)
        return io_fail(error, "%s: %zu x %zu pixels are too many for PNG", w->output.name, p->nx, p->ny);
    png_state *s = calloc(1, sizeof *s);
    if (s == NULL || (s->grey = malloc(p->nx)) == NULL) {
        free(s);
        return io_fail(error, "%s: out of memory", w->output.name);
    }
    w->state = s;
    s->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, s, on_error, on_warning);
    s->info = s->png ? png_create_info_struct(s->png) : NULL;
    if (s->info == NULL) {
        free_state(w);
        return io_fail(error, "%s: out of memory", w->output.name);
    }
    png_init_io(s->png, w->output.file);
    s->name = w->output.name;
    errno = 0;
    if (setjmp(png_jmpbuf(s->png))) {
        fail(s, error);
        free_state(w);
        return false;
    }
    png_set_IHDR(s->png, s->info, (png_uint_32)p->nx, (png_uint_32)p->ny, 8,
                 p->rgb ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(s->png, s->info);
    return true;
}

/* NaN is black. */
static unsigned char grey(const io_raster_product *p, double value) {
    const double share = (value - p->black) / (p->white - p->black);
    return !(share > 0) ? 0 : share >= 1 ? 255 : (unsigned char)(share * 255 + 0.5);
}

static double cell_value(io_cell cell, const void *cells, size_t k) {
    if (cell == IO_CELL_UINT8) return ((const uint8_t *)cells)[k];
    if (cell == IO_CELL_UINT16) return ((const uint16_t *)cells)[k];
    return (double)((const float *)cells)[k];
}

static bool png_write(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                      io_error *error) {
    (void)band;
    const io_raster_product *p = &w->product;
    png_state *s = w->state;
    errno = 0;
    if (setjmp(png_jmpbuf(s->png))) return fail(s, error);
    for (size_t j = 0; j < window->ny; j++) {
        if (p->rgb) {
            png_write_row(s->png, (const unsigned char *)cells + 3 * j * p->nx);
            continue;
        }
        for (size_t i = 0; i < p->nx; i++) s->grey[i] = grey(p, cell_value(p->cell, cells, j * p->nx + i));
        png_write_row(s->png, s->grey);
    }
    return true;
}

static bool png_finish(io_raster_writer *w, bool whole, io_error *error) {
    png_state *s = w->state;
    volatile bool good = whole;
    errno = 0;
    if (setjmp(png_jmpbuf(s->png)))
        good = fail(s, error);
    else if (whole)
        png_write_end(s->png, NULL);
    free_state(w);
    return good;
}

/* The world file first: raster_out.c leaves it out if it writes one. */
static const char *const sidecars[] = {"*.pgw", "w", ".aux.xml", ".ovr", ".msk", NULL};
const io_raster_sink io_sink_png = {.ending = ".png",
                                    .what = "picture",
                                    .bands_most = 1,
                                    .sidecars = sidecars,
                                    .create = png_create,
                                    .write = png_write,
                                    .finish = png_finish};
