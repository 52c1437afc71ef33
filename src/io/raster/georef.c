/* SPDX-License-Identifier: Apache-2.0 */
#include "georef.h"

#include "gdal/module.h"
#include "number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void io_georef_free(io_georef *georef) {
    free(georef->crs);
    *georef = (io_georef){0};
}

void io_georef_name(const io_georef *georef, char *name, size_t size) {
    const char *quote = georef->crs ? strchr(georef->crs, '"') : NULL;
    const size_t length = quote ? strcspn(quote + 1, "\"") : 0;
    snprintf(name, size, "%.*s", (int)(length < 200 ? length : 200), quote ? quote + 1 : "");
}

void io_unit_name(double metres, char *text) {
    static const struct {
        double metres;
        const char *name;
    } units[] = {{1, "m"}, {0.3048, "ft"}, {1200.0 / 3937, "US survey ft"}, {1000, "km"}};
    text[0] = '\0';
    if (metres > 0) snprintf(text, IO_UNIT_NAME - 1, "x %.9g m", metres);
    for (size_t k = 0; k < sizeof units / sizeof units[0]; k++)
        if (fabs(metres / units[k].metres - 1) < 1e-8) snprintf(text, IO_UNIT_NAME - 1, "%s", units[k].name);
}

/* ---- well-known text --------------------------------------------------------------------------------------------- */

/* Well-known text (OGC 01-009, ISO 19162; ESRI's .prj files) is nested KEYWORD["name", …]. A terrain needs three
 * facts from it: whether the coordinates are angles, their unit, and the ellipsoid. */

/* The numbers behind a node's name. */
static bool numbers(const char *node, double *value, int count) {
    const char *at = strchr(node, '"');
    at = at ? strchr(at + 1, '"') : NULL;
    if (at == NULL) return false;
    for (at++; count > 0; count--) {
        at += strspn(at, " \t\r\n");
        if (*at != ',') return false;
        char *end;
        *value = number_read(at + 1, &end);
        if (end == at + 1 || !isfinite(*value)) return false;
        at = end;
        value++;
    }
    return true;
}

/* The first node of these names, which stand between bars, in the text of another: behind its bracket. depth: 1 for
 * that node's own, 0 for those in them, too. */
static const char *find(const char *text, const char *names, int depth) {
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_0123456789";
    char name[24]; /* no known one is cut */
    int here = 1;
    for (const char *c = text; *c != '\0' && here > 0; c++) {
        const size_t length = strspn(c, letters);
        const char *bracket = c + length + strspn(c + length, " \t\r\n");
        snprintf(name, sizeof name, "|%.*s|", (int)(length < sizeof name ? length : sizeof name), c);
        if (length > 0 && (*bracket == '[' || *bracket == '(') && (depth == 0 || here == depth) &&
            strcasestr(names, name))
            return bracket + 1;
        if (length > 0) c += length - 1;
        if (*c == '"' && (c = strchr(c + 1, '"')) == NULL) return NULL;
        here += (*c == '[' || *c == '(') - (*c == ']' || *c == ')');
    }
    return NULL;
}

static bool is_balanced(const char *wkt) {
    int depth = 0;
    for (const char *c = wkt; *c != '\0'; c++) {
        if (*c == '"' && (c = strchr(c + 1, '"')) == NULL) return false;
        depth += (*c == '[' || *c == '(') - (*c == ']' || *c == ')');
    }
    return depth == 0;
}

bool io_georef_from_wkt(io_georef *georef, const char *wkt) {
    static const char geographic[] = "|GEOGCS|GEOGCRS|GEOGRAPHICCRS|",
                      systems[] = "|PROJCS|PROJCRS|PROJECTEDCRS|LOCAL_CS|ENGCRS|GEOGCS|GEOGCRS|GEOGRAPHICCRS|",
                      units[] = "|UNIT|LENGTHUNIT|ANGLEUNIT|";
    double ellipsoid[2] = {0, 0}, value;
    const char *system = find(wkt, systems, 0); /* that of heights follows the horizontal one */
    if (system == NULL || !is_balanced(wkt) || (georef->crs = strdup(wkt)) == NULL) return false;
    const char *axis = find(system, "|AXIS|", 1), *unit = find(system, units, 1),
               *round = find(system, "|SPHEROID|ELLIPSOID|", 0);
    if (unit == NULL && axis != NULL) unit = find(axis, units, 1); /* where one unit of all axes is missing */
    if (round != NULL && !numbers(round, ellipsoid, 2)) ellipsoid[0] = ellipsoid[1] = 0;
    georef->geographic = find(wkt, geographic, 0) == system;
    georef->unit = unit != NULL && numbers(unit, &value, 1) && value > 0 ? value : 0;
    georef->semi_major = ellipsoid[0];
    georef->inverse_flattening = ellipsoid[1];
    return true;
}

/* ---- the scale of a projection ----------------------------------------------------------------------------------- */

/* What a map_scale leaves out may be this large: angles of the horizon are then off by up to 0.3 degrees. */
static const double most = 0.01;

/* What a user can do who has such a map around that place of it. */
static const char *cure(const char *crs, const double middle[2], char text[120]) {
    double longitude = middle[0], latitude = middle[1];
    const io_gdal *gdal = io_gdal_load(NULL);
    if (gdal && gdal->lon_lat(crs, false, 1, &longitude, &latitude, NULL) && fabs(longitude) < 180 &&
        fabs(latitude) < 84)
        snprintf(text, 120, "gdalwarp -t_srs EPSG:%d makes a map without that",
                 (latitude < 0 ? 32700 : 32600) + (int)floor((longitude + 180) / 6) + 1);
    else
        snprintf(text, 120, "gdalwarp -t_srs makes a map in another coordinate system, such as UTM");
    return text;
}

/* Local and engineering systems stand for no place on earth. */
static bool is_projected(const io_georef *g) {
    return g->placed && !g->geographic && g->crs != NULL && find(g->crs, "|LOCAL_CS|ENGCRS|ENGINEERINGCRS|", 0) == NULL;
}

/* How far the scale differs from that of the row's middle. */
static double along_rows(const map_scale *s) {
    double worst = 0;
    for (int v = 0; v < MAP_SCALE_ROWS; v++)
        for (int u = 0; u < MAP_SCALE_COLUMNS; u++)
            for (int k = 0; k < 2; k++)
                worst = fmax(worst, fabs(s->metres[v][u][k] / s->metres[v][MAP_SCALE_COLUMNS / 2][k] - 1));
    return worst;
}

bool io_scale_find(const io_georef *georef, double map[3][4], size_t nx, size_t ny, const char *name,
                   const io_warner *warn, map_scale *scale) {
    if (!is_projected(georef)) return false;
    const double i = 0.5 * (double)(nx - 1), j = 0.5 * (double)(ny - 1);
    const double middle[2] = {map[0][0] * i + map[0][1] * j + map[0][3], map[1][0] * i + map[1][1] * j + map[1][3]};
    char crs[200], text[120];
    io_error error;
    double sheared;
    io_georef_name(georef, crs, sizeof crs);
    const io_gdal *gdal = io_gdal_load(&error);
    if (gdal == NULL || !gdal->scale(georef->crs, map, nx, ny, scale, &sheared, &error)) {
        io_warn(warn,
                "%s: how long a metre of its map, %s, is on the ground is not known (%s), so distances and angles are "
                "the map's; %s",
                name, crs, error.text, cure(georef->crs, middle, text));
        return false;
    }
    /* A cosine c makes one diagonal of a square longer by about c / 2 of it and the other shorter by as much. */
    if (sheared > most)
        io_warn(warn, "%s: on its map, %s, distances differ by direction by up to %.2g %%, which is left out; %s", name,
                crs, 100 * sheared, cure(georef->crs, middle, text));
    const double uneven = along_rows(scale);
    if (uneven > most)
        io_warn(warn,
                "%s: on its map, %s, the scale differs by up to %.2g %% from that of the row's middle, which stands "
                "for the row; %s",
                name, crs, 100 * uneven, cure(georef->crs, middle, text));
    return true;
}
