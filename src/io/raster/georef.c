/* SPDX-License-Identifier: Apache-2.0 */
/* Well-known text (OGC 01-009, ISO 19162; ESRI's .prj files) is nested KEYWORD["name", …]. A terrain needs three
 * facts from it: whether the coordinates are angles, their unit, and the ellipsoid. */

#include "georef.h"

#include "number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

static bool is_word(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }

/* A word that opens a bracket; at is behind the bracket. Depths count from 1. */
typedef struct node {
    const char *word, *at;
    int length, depth;
} node;

/* The next node behind at, or false at the end. Text in quotes is passed over. */
static bool next_node(const char **at, int *depth, node *n) {
    const char *c = *at;
    while (*c != '\0') {
        if (*c == '"') {
            const char *end = strchr(c + 1, '"');
            if (end == NULL) return false;
            c = end + 1;
        } else if (*c == ']' || *c == ')') {
            --*depth;
            c++;
        } else if (is_word(*c)) {
            n->word = c;
            while (is_word(*c) || (*c >= '0' && *c <= '9')) c++;
            n->length = (int)(c - n->word);
            c += strspn(c, " \t\r\n");
            if (*c != '[' && *c != '(') continue;
            n->depth = ++*depth;
            n->at = *at = c + 1;
            return true;
        } else {
            c++;
        }
    }
    return false;
}

static bool is_one_of(const node *n, const char *const *words) {
    for (; *words; words++)
        if ((size_t)n->length == strlen(*words) && strncasecmp(n->word, *words, (size_t)n->length) == 0) return true;
    return false;
}

/* The numbers behind the node's name. */
static bool numbers(const node *n, double *value, int count) {
    const char *at = strchr(n->at, '"');
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

/* False where the text breaks off. */
static bool is_whole(const char *wkt) {
    int depth = 0;
    bool quoted = false;
    for (const char *c = wkt; *c != '\0'; c++) {
        quoted ^= *c == '"';
        if (!quoted) depth += (*c == '[' || *c == '(') - (*c == ']' || *c == ')');
    }
    return depth == 0 && !quoted;
}

bool io_georef_from_wkt(io_georef *georef, const char *wkt) {
    static const char *const projected[] = {"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", NULL};
    static const char *const geographic[] = {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", NULL};
    static const char *const ellipsoid[] = {"SPHEROID", "ELLIPSOID", NULL};
    static const char *const unit[] = {"UNIT", "LENGTHUNIT", "ANGLEUNIT", NULL};
    static const char *const axis[] = {"AXIS", NULL};
    int depth = 0, main_depth = 0, unit_depth = 0;
    node n;
    io_georef g = {0};
    for (const char *at = wkt; next_node(&at, &depth, &n);) {
        double value[2];
        if (main_depth == 0 && (is_one_of(&n, projected) || is_one_of(&n, geographic))) {
            g.geographic = is_one_of(&n, geographic);
            main_depth = n.depth;
        } else if (main_depth > 0 && n.depth <= main_depth) {
            break; /* the system of heights follows the horizontal one */
        } else if (is_one_of(&n, ellipsoid) && numbers(&n, value, 2) && g.semi_major == 0) {
            g.semi_major = value[0];
            g.inverse_flattening = value[1];
        } else if (main_depth > 0 && n.depth == main_depth + 1 && is_one_of(&n, axis)) {
            unit_depth = n.depth + 1; /* where one unit of all axes is missing */
        } else if (main_depth > 0 && (n.depth == main_depth + 1 || n.depth == unit_depth) && g.unit == 0 &&
                   is_one_of(&n, unit) && numbers(&n, value, 1)) {
            g.unit = value[0];
        }
    }
    if (main_depth == 0 || !is_whole(wkt)) return false;
    georef->crs = strdup(wkt);
    georef->geographic = g.geographic;
    georef->unit = g.unit > 0 ? g.unit : 0;
    georef->semi_major = g.semi_major;
    georef->inverse_flattening = g.inverse_flattening;
    return georef->crs != NULL;
}
