/* SPDX-License-Identifier: Apache-2.0 */
/* Well-known text (OGC 01-009, ISO 19162; ESRI's .prj files) is nested KEYWORD["name", …]. A terrain needs three
 * facts from it: whether the coordinates are angles, their unit, and the ellipsoid. */

#include "georef.h"

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

typedef struct reading {
    io_georef found;
    int main, unit; /* depths of the system's own node, and of units in its axes; 0: not met */
    bool over;
} reading;

/* A node at a depth, from 1 on; at: behind its bracket. */
static void take_node(reading *r, const char *word, size_t length, int depth, const char *at) {
    static const char projected[] = "|PROJCS|PROJCRS|PROJECTEDCRS|LOCAL_CS|ENGCRS|",
                      geographic[] = "|GEOGCS|GEOGCRS|GEOGRAPHICCRS|";
    char name[24]; /* no known one is cut */
    double value[2];
    if (r->over) return;
    snprintf(name, sizeof name, "|%.*s|", (int)(length < sizeof name ? length : sizeof name), word);
    const bool own = r->main > 0 && depth == r->main + 1;
    if (r->main == 0 && (strcasestr(projected, name) || strcasestr(geographic, name))) {
        r->found.geographic = strcasestr(geographic, name) != NULL;
        r->main = depth;
    } else if (r->main > 0 && depth <= r->main) {
        r->over = true; /* the system of heights follows the horizontal one */
    } else if (strcasestr("|SPHEROID|ELLIPSOID|", name) && r->found.semi_major == 0 && numbers(at, value, 2)) {
        r->found.semi_major = value[0];
        r->found.inverse_flattening = value[1];
    } else if (own && strcasecmp(name, "|AXIS|") == 0) {
        r->unit = depth + 1; /* where one unit of all axes is missing */
    } else if ((own || (r->unit > 0 && depth == r->unit)) && r->found.unit == 0 &&
               strcasestr("|UNIT|LENGTHUNIT|ANGLEUNIT|", name) && numbers(at, value, 1)) {
        r->found.unit = value[0];
    }
}

bool io_georef_from_wkt(io_georef *georef, const char *wkt) {
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_0123456789";
    reading r = {.main = 0};
    int depth = 0;
    size_t length = 0; /* of the word that a bracket may follow */
    const char *word = wkt;
    for (const char *c = wkt; *c != '\0'; c++) {
        if (*c == '[' || *c == '(') take_node(&r, word, length, ++depth, c + 1);
        if (*c == ']' || *c == ')') depth--;
        if (*c == '"' && (c = strchr(c + 1, '"')) == NULL) return false;
        if (strchr(" \t\r\n", *c) != NULL) continue;
        word = c;
        length = strspn(c, letters);
        if (length > 0) c += length - 1;
    }
    if (r.main == 0 || depth != 0) return false;
    georef->crs = strdup(wkt);
    georef->geographic = r.found.geographic;
    georef->unit = r.found.unit > 0 ? r.found.unit : 0;
    georef->semi_major = r.found.semi_major;
    georef->inverse_flattening = r.found.inverse_flattening;
    return georef->crs != NULL;
}
