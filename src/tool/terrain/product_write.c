/* SPDX-License-Identifier: Apache-2.0 */
/* Products of a part of a raster, and of rasters that memory does not hold: bands of rows, each from a piece of the
 * raster that has all that matters to it. */
#include "command.h"
#include "product.h"

#include <stdlib.h>
#include <string.h>

/* As many rows as a GeoTIFF's tiles have, fewer where that would hold up progress, or memory is short. */
static size_t block_rows(const io_raster_product *p, double passes, bool few) {
    enum { LEAST = 32 };
    const size_t tile = io_raster_tile_side(p->ny);
    size_t rows = tile;
    if (few) return tile < LEAST ? tile : LEAST;
    while (rows > LEAST && rows % 2 == 0 && passes * (double)rows * (double)p->nx > 1e7) rows /= 2;
    while (passes * (double)rows * (double)p->nx < 1e6 && rows < p->ny) rows += tile;
    return rows;
}

typedef struct writing {
    product *product;
    ground_plan plan;
    bool surveyed;      /* the plan's blocks have been taken */
    size_t rows, step;  /* rows of a block; rows of the window for each */
    size_t from, until; /* rows of the window that the piece is good for */
    void *cells;        /* a block */
    outcome outcome;
    picture *picture; /* NULL: rows are written as they come */
} writing;

static bool fits(const writing *w, cw_rectangle piece) {
    return ground_fits(&w->product->ground, piece, w->product->more);
}

/* The piece for the next so many blocks from row on. */
static bool piece_for(writing *w, size_t row, size_t blocks, cw_rectangle *part, cw_rectangle *piece, io_error *error) {
    ground *g = &w->product->ground;
    const cw_rectangle window = g->window;
    const size_t left = window.ny - row, block = w->rows * w->step,
                 rows = blocks < left / block + 1 ? blocks * block : left;
    if (!w->surveyed && !(w->surveyed = ground_plan_survey(&w->plan, g, error))) return false;
    *part = (cw_rectangle){window.i, window.j + row, window.nx, rows < left ? rows : left};
    return product_good(ground_plan_around(&w->plan, *part, piece), error);
}

/* Reads the piece for as many rows as there is memory for. */
static bool next_piece(writing *w, size_t row, io_error *error) {
    product *p = w->product;
    ground *g = &p->ground;
    cw_rectangle part = g->window, piece = ground_all(g);
    if (part.nx < piece.nx || part.ny < piece.ny || !fits(w, piece)) {
        size_t least = 1, most = (g->window.ny - row + w->rows * w->step - 1) / (w->rows * w->step);
        while (least < most) {
            const size_t blocks = most - (most - least) / 2;
            if (!piece_for(w, row, blocks, &part, &piece, error)) return false;
            if (fits(w, piece))
                least = blocks;
            else
                most = blocks - 1;
        }
        if (!piece_for(w, row, least, &part, &piece, error)) return false;
    }
    if (w->until == 0 || memcmp(&piece, &g->piece, sizeof piece) != 0) {
        if (p->leave) p->leave(p->context);
        if (!ground_read(g, piece, true, error) || (p->enter && !p->enter(p, error))) return false;
    }
    w->from = part.j - g->window.j;
    w->until = p->until = w->from + part.ny;
    return true;
}

/* That all pieces fit is known before the work begins. */
static bool check_pieces(writing *w, io_error *error) {
    const product *p = w->product;
    cw_rectangle part, piece;
    if (p->in_memory || fits(w, ground_all(&p->ground))) return true;
    for (size_t row = 0; row < p->ground.window.ny; row += w->rows * w->step)
        if (!piece_for(w, row, 1, &part, &piece, error) || !ground_check(&p->ground, piece, p->more, error))
            return false;
    return true;
}

static bool tell(void *context, double share) {
    const product *p = context;
    product_tell(p, p->done + share * p->part);
    return true;
}

static bool fill_block(writing *w, size_t band, size_t row, size_t rows, io_error *error) {
    product *p = w->product;
    const ground *g = &p->ground;
    product_block block = {.band = band, .row = row, .rows = rows, .run = g->query};
    block.area.at = (cw_rectangle){g->window.i - g->terrain.column, row * w->step + g->window.j - g->terrain.row,
                                   g->window.nx, rows};
    block.run.watch = tell;
    block.run.watch_context = p;
    p->done = ((double)band + (double)row / (double)p->raster.ny) / (double)p->raster.bands;
    p->part = (double)rows / (double)p->raster.ny / (double)p->raster.bands;
    tell(p, 0);
    return p->fill(p, &block, w->cells, error);
}

/* The block as the line at the end counts it and a picture shows it. */
static bool take_block(writing *w, size_t row, size_t rows, io_error *error) {
    const io_raster_product *p = &w->product->raster;
    const ground *g = &w->product->ground;
    const size_t first = g->window.i - g->terrain.column, local = row * w->step + g->window.j - g->terrain.row;
    outcome_take(&w->outcome, p, w->cells, rows * p->nx);
    return w->picture == NULL ||
           picture_take(w->picture, p, row, rows, w->cells, &g->terrain, first, local, w->step, error);
}

static bool write_blocks(writing *w, io_raster_writer *to, io_error *error) {
    product *made = w->product;
    const io_raster_product *p = &made->raster;
    for (size_t band = 0; band < p->bands; band++)
        for (size_t row = 0; row < p->ny; row += w->rows) {
            const size_t count = p->ny - row < w->rows ? p->ny - row : w->rows;
            const size_t at = row * w->step;
            if (!made->in_memory && (at < w->from || at >= w->until) && !next_piece(w, at, error)) return false;
            if (!fill_block(w, band, row, count, error) || (band == 0 && !take_block(w, row, count, error)))
                return false;
            if (to != NULL && !io_raster_write(to, w->cells, count, error)) return false;
        }
    return true;
}

static bool write_rows(writing *w, io_error *error) {
    io_raster_writer to;
    if (!io_raster_create(&to, w->product->output, &w->product->raster, error)) return false;
    const bool good = write_blocks(w, &to, error) && io_raster_commit(&to, error);
    io_raster_discard(&to);
    return good;
}

static bool write_picture(writing *w, io_error *error) {
    const product *p = w->product;
    picture drawn;
    for (size_t k = 0; k < 2 * p->mark_count; k++)
        p->marks[k] -= (double)(k % 2 ? p->ground.window.j : p->ground.window.i);
    w->picture = &drawn;
    const bool good = picture_begin(&drawn, p->output, p->raster.nx, p->raster.ny, error) &&
                      write_blocks(w, NULL, error) &&
                      picture_write(&drawn, p->output, &p->raster, &w->outcome, p->marks, p->mark_count, error);
    picture_end(&drawn);
    return good;
}

/* "cellwalk shadow: shadow.tif: 24.1 % of 138632 samples in the sun, 0.31 s" */
static void tell_outcome(const product *p, const outcome *o) {
    char text[200];
    outcome_text(o, &p->raster, p->counted ? p->counted : "above 0", text, sizeof text);
    command_wrote(p->name, p->quiet, p->output, p->start, "%s%s", p->raster.bands > 1 ? "in the first band " : "",
                  text);
}

bool product_write(product *p, io_error *error) {
    const io_raster_product *r = &p->raster;
    writing w = {.product = p, .step = p->every > 0 ? p->every : 1};
    w.rows = block_rows(r, p->passes, !p->in_memory && !fits(&w, ground_all(&p->ground)));
    w.cells = malloc(w.rows * r->nx * io_cell_bytes(r->cell));
    bool good = w.cells || io_fail(error, "out of memory");
    good = good && outcome_begin(&w.outcome, r->nx * r->ny, error);
    good = good && product_good(ground_plan_create(&w.plan, &p->matters, &p->ground.whole, p->ground.window), error);
    good = good && check_pieces(&w, error);
    if (good) good = io_raster_is_png(p->output) ? write_picture(&w, error) : write_rows(&w, error);
    if (good) tell_outcome(p, &w.outcome);
    ground_plan_destroy(&w.plan);
    outcome_end(&w.outcome);
    free(w.cells);
    return good;
}
