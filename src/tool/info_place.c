/* SPDX-License-Identifier: Apache-2.0 */
#include "info_place.h"

#include "json.h"

#include <math.h>

/* The unit's name with a blank before it. */
static const char *unit_name(double metres, char text[IO_UNIT_NAME]) {
    text[0] = ' ';
    io_unit_name(metres, text + 1);
    return text[1] == '\0' ? text + 1 : text;
}

const char *info_height_unit(const io_raster *r, char *text) {
    const io_georef *g = &r->georef;
    const double map = g->geographic ? 1 : g->unit; /* metres in a height on the map */
    return unit_name(g->placed ? r->map[2][2] * map : 0, text);
}

/* The least and the greatest X and Y of samples. */
static void find_extent(const io_raster *r, double low[2], double high[2]) {
    for (int c = 0; c < 2; c++)
        for (int k = 0; k < 4; k++) {
            const double x = r->map[c][0] * (k & 1 ? (double)r->nx - 1 : 0) +
                             r->map[c][1] * (k & 2 ? (double)r->ny - 1 : 0) + r->map[c][3];
            low[c] = k == 0 ? x : fmin(low[c], x);
            high[c] = k == 0 ? x : fmax(high[c], x);
        }
}

static void find_cell(const io_raster *r, double size[2]) {
    for (int c = 0; c < 2; c++) size[c] = hypot(r->map[0][c], r->map[1][c]);
}

void info_print_place(const io_raster *r) {
    const io_georef *g = &r->georef;
    double low[2], high[2], cell[2];
    char crs[128], unit[IO_UNIT_NAME];
    if (!g->placed) {
        puts("  extent        no map: terrain commands take cells for 1 wide and row 0 for the\n"
             "                northernmost");
        return;
    }
    find_extent(r, low, high);
    find_cell(r, cell);
    io_georef_name(g, crs, sizeof crs);
    printf("  extent        X %.10g to %.10g, Y %.10g to %.10g (pixels' centres)\n", low[0], high[0], low[1], high[1]);
    printf("  cell size     %.9g x %.9g%s\n", cell[0], cell[1], g->geographic ? " degrees" : unit_name(g->unit, unit));
    fputs("  coordinates   ", stdout);
    print_text(stdout, crs[0] != '\0' ? crs : "no coordinate system");
    putchar('\n');
}

void info_print_place_json(const io_raster *r) {
    const io_georef *g = &r->georef;
    double low[2], high[2], cell[2];
    char crs[128];
    if (!g->placed) return;
    find_extent(r, low, high);
    find_cell(r, cell);
    io_georef_name(g, crs, sizeof crs);
    printf(", \"extent\": [%.17g, %.17g, %.17g, %.17g], \"cell_size\": [%.17g, %.17g], \"degrees\": %s", low[0], low[1],
           high[0], high[1], cell[0], cell[1], g->geographic ? "true" : "false");
    if (crs[0] == '\0') return;
    fputs(", \"coordinates\": ", stdout);
    json_string(stdout, crs);
}
