/* SPDX-License-Identifier: Apache-2.0 */
#include "scale.h"

#include "gdal/module.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { NODES = MAP_SCALE_ROWS * MAP_SCALE_COLUMNS, MIDDLE = MAP_SCALE_COLUMNS / 2 };

/* What a map_scale leaves out may be this large: angles of the horizon are then off by up to 0.3 degrees. */
static const double most = 0.01;

typedef struct finding {
    const io_georef *georef;
    const char *name;
    void (*warn)(void *context, const char *text);
    void *context;
    double longitude, latitude; /* of the middle, degrees; NaN: not known */
} finding;

__attribute__((format(printf, 2, 3))) static void tell(const finding *f, const char *format, ...) {
    char text[900], cure[120] = "gdalwarp -t_srs makes a map in another coordinate system, such as UTM";
    if (f->warn == NULL) return;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const int zone = (int)floor((f->longitude + 180) / 6) + 1;
    if (fabs(f->longitude) < 180 && fabs(f->latitude) < 84)
        snprintf(cure, sizeof cure, "gdalwarp -t_srs EPSG:%d makes a map without that",
                 (f->latitude < 0 ? 32700 : 32600) + zone);
    if (length > 0 && (size_t)length < sizeof text) snprintf(text + length, sizeof text - (size_t)length, "; %s", cure);
    f->warn(f->context, text);
}

/* Local and engineering systems stand for no place on earth. */
static bool is_projected(const io_georef *g) {
    static const char *const local[] = {"LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"};
    if (!g->placed || g->geographic || g->crs == NULL) return false;
    for (size_t k = 0; k < sizeof local / sizeof *local; k++)
        if (strncmp(g->crs, local[k], strlen(local[k])) == 0) return false;
    return true;
}

/* The map's scale at its nodes: metres of ground in x and in y, and the cosine between the two on the ground. */
static bool measure(finding *f, double map[3][4], size_t nx, size_t ny, double (*found)[3], io_error *error) {
    double *x = malloc(2 * NODES * sizeof *x), *y = x + NODES;
    if (x == NULL) return io_fail(error, "out of memory");
    for (int n = 0; n < NODES; n++) {
        const double i = (double)(n % MAP_SCALE_COLUMNS) / (MAP_SCALE_COLUMNS - 1) * (double)(nx - 1),
                     j = (double)(n / MAP_SCALE_COLUMNS) / (MAP_SCALE_ROWS - 1) * (double)(ny - 1);
        x[n] = map[0][0] * i + map[0][1] * j + map[0][3];
        y[n] = map[1][0] * i + map[1][1] * j + map[1][3];
    }
    f->longitude = x[NODES / 2];
    f->latitude = y[NODES / 2];
    const io_gdal *gdal = io_gdal_load(error);
    const bool good = gdal != NULL && gdal->scales(f->georef->crs, NODES, x, y, found, error);
    io_error unused;
    if (gdal == NULL || !gdal->lon_lat(f->georef->crs, false, 1, &f->longitude, &f->latitude, &unused))
        f->longitude = f->latitude = NAN;
    free(x);
    return good;
}

/* How far the scale differs from that of the row's middle. */
static double along_rows(const map_scale *s) {
    double worst = 0;
    for (int v = 0; v < MAP_SCALE_ROWS; v++)
        for (int u = 0; u < MAP_SCALE_COLUMNS; u++)
            for (int k = 0; k < 2; k++) worst = fmax(worst, fabs(s->metres[v][u][k] / s->metres[v][MIDDLE][k] - 1));
    return worst;
}

bool io_scale_find(const io_georef *georef, double map[3][4], size_t nx, size_t ny, const char *name,
                   void (*warn)(void *context, const char *text), void *context, map_scale *scale) {
    finding f = {georef, name, warn, context, NAN, NAN};
    double(*found)[3] = NULL, sheared = 0;
    io_error error = {"out of memory"};
    char crs[200];
    if (!is_projected(georef)) return false;
    io_georef_name(georef, crs, sizeof crs);
    found = malloc(NODES * sizeof *found);
    if (found == NULL || !measure(&f, map, nx, ny, found, &error)) {
        tell(&f,
             "%s: how long a metre of its map, %s, is on the ground is not known (%s), so distances and angles are the "
             "map's",
             name, crs, error.text);
        free(found);
        return false;
    }
    for (int n = 0; n < NODES; n++) {
        for (int k = 0; k < 2; k++) scale->metres[n / MAP_SCALE_COLUMNS][n % MAP_SCALE_COLUMNS][k] = found[n][k];
        sheared = fmax(sheared, fabs(found[n][2]));
    }
    free(found);
    /* A cosine c makes one diagonal of a square longer by about c / 2 of it and the other shorter by as much. */
    if (sheared > most)
        tell(&f, "%s: on its map, %s, distances differ by direction by up to %.2g %%, which is left out", name, crs,
             100 * sheared);
    const double uneven = along_rows(scale);
    if (uneven > most)
        tell(&f,
             "%s: on its map, %s, the scale differs by up to %.2g %% from that of the row's middle, which stands for "
             "the row",
             name, crs, 100 * uneven);
    return true;
}
