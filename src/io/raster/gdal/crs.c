/* SPDX-License-Identifier: Apache-2.0 */
/* Coordinate systems, by GDAL's OGR and PROJ. */

#include "parts.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static char *well_known_text(OGRSpatialReferenceH crs) {
    static const char *const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", NULL};
    char *text = NULL;
    if (OSRExportToWktEx(crs, &text, options) != OGRERR_NONE || text == NULL) {
        CPLFree(text);
        text = NULL;
        if (OSRExportToWkt(crs, &text) != OGRERR_NONE || text == NULL) {
            CPLFree(text); /* of one that is damaged it is empty, not NULL */
            return NULL;
        }
    }
    char *copy = strdup(text); /* for the program to free */
    CPLFree(text);
    return copy;
}

void gdal_describe_crs(OGRSpatialReferenceH crs, io_georef *georef) {
    if (crs == NULL) return;
    georef->crs = well_known_text(crs);
    georef->geographic = OSRIsGeographic(crs) != 0 && OSRIsProjected(crs) == 0;
    georef->unit = georef->geographic ? OSRGetAngularUnits(crs, NULL) : OSRGetLinearUnits(crs, NULL);
    if (!(georef->unit > 0)) georef->unit = 0;
    OGRErr status = OGRERR_NONE;
    const double semi_major = OSRGetSemiMajor(crs, &status);
    if (status == OGRERR_NONE) georef->semi_major = semi_major;
    const double inverse_flattening = OSRGetInvFlattening(crs, &status);
    if (status == OGRERR_NONE) georef->inverse_flattening = inverse_flattening;
    if (OSRIsCompound(crs)) {
        const double unit = OSRGetTargetLinearUnits(crs, "VERT_CS", NULL);
        if (unit > 0) georef->height_unit = unit;
    }
}

/* Brings n places from one system to another, in place. */
static bool bring(OGRSpatialReferenceH from, OGRSpatialReferenceH to, size_t n, double *x, double *y) {
    OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
    OGRCoordinateTransformationH way = OCTNewCoordinateTransformation(from, to);
    const bool good = way != NULL && OCTTransform(way, (int)n, x, y, NULL) != 0;
    OCTDestroyCoordinateTransformation(way);
    return good;
}

static bool fail_way(io_error *error) {
    return gdal_fail(error, "the coordinate system", "has no way to longitude and latitude");
}

bool gdal_lon_lat(const char *crs, bool back, size_t n, double *x, double *y, io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    OGRSpatialReferenceH map = OSRNewSpatialReference(crs), earth = OSRNewSpatialReference(NULL);
    bool good = map != NULL && earth != NULL && OSRImportFromEPSG(earth, 4326) == OGRERR_NONE &&
                bring(back ? earth : map, back ? map : earth, n, x, y);
    for (size_t k = 0; k < n; k++) good = good && isfinite(x[k]) && isfinite(y[k]);
    OSRDestroySpatialReference(map);
    OSRDestroySpatialReference(earth);
    return good || fail_way(error);
}

/* ---- the scale of a projection ----------------------------------------------------------------------------------- */

/* Steps to either side of a place, in metres of the map. On the ground they are chords: of 2 km of a sphere one is
 * shorter than the arc by 4e-9 of it, and the difference of two ends leaves out 4e-9 of the scale for Mercator. The
 * coordinates' rounding, 1e-9 m, is 1e-12 of them. */
static const double step = 1000;

typedef struct globe {
    double semi_major, eccentricity2, unit; /* radians in one of its coordinates */
} globe;

/* A place of the ellipsoid, in metres from its centre. */
static void to_space(const globe *g, double longitude, double latitude, double out[3]) {
    const double lambda = longitude * g->unit, phi = latitude * g->unit, sine = sin(phi),
                 across = g->semi_major / sqrt(1 - g->eccentricity2 * sine * sine);
    out[0] = across * cos(phi) * cos(lambda);
    out[1] = across * cos(phi) * sin(lambda);
    out[2] = across * (1 - g->eccentricity2) * sine;
}

/* x and y hold 4 ends a place, as longitudes and latitudes; far: the distance of two ends on the map. */
static bool take_scales(const globe *g, size_t n, const double *x, const double *y, double far, double (*metres)[3]) {
    bool good = true;
    for (size_t k = 0; k < n; k++) {
        double end[4][3], along[2][3], dot = 0;
        for (size_t e = 0; e < 4; e++) to_space(g, x[4 * k + e], y[4 * k + e], end[e]);
        for (int a = 0; a < 2; a++) {
            for (int c = 0; c < 3; c++) along[a][c] = (end[2 * a + 1][c] - end[2 * a][c]) / far;
            metres[k][a] = sqrt(along[a][0] * along[a][0] + along[a][1] * along[a][1] + along[a][2] * along[a][2]);
        }
        for (int c = 0; c < 3; c++) dot += along[0][c] * along[1][c];
        metres[k][2] = dot / (metres[k][0] * metres[k][1]);
        for (int a = 0; a < 2; a++) good = good && isfinite(metres[k][a]) && metres[k][a] > 0;
    }
    return good;
}

/* The system's own longitudes and latitudes: without a change of datum, which may need grids. */
static bool find_scales(OGRSpatialReferenceH map, size_t n, const double *at_x, const double *at_y, double *x,
                        double *y, double (*metres)[3]) {
    OGRSpatialReferenceH earth = OSRCloneGeogCS(map);
    if (earth == NULL) return false;
    OGRErr status[2] = {OGRERR_NONE, OGRERR_NONE};
    const double unit = OSRGetLinearUnits(map, NULL), semi_major = OSRGetSemiMajor(earth, &status[0]),
                 inverse = OSRGetInvFlattening(earth, &status[1]), flattening = inverse > 0 ? 1 / inverse : 0;
    const globe g = {semi_major, flattening * (2 - flattening), OSRGetAngularUnits(earth, NULL)};
    bool good = status[0] == OGRERR_NONE && status[1] == OGRERR_NONE && unit > 0 && semi_major > 0;
    const double away = good ? step / unit : 0;
    for (size_t k = 0; k < 4 * n; k++) {
        x[k] = at_x[k / 4] + (k % 4 == 0 ? -away : k % 4 == 1 ? away : 0);
        y[k] = at_y[k / 4] + (k % 4 == 2 ? -away : k % 4 == 3 ? away : 0);
    }
    good = good && bring(map, earth, 4 * n, x, y) && take_scales(&g, n, x, y, 2 * away, metres);
    OSRDestroySpatialReference(earth);
    return good;
}

bool gdal_scales(const char *crs, size_t n, const double *at_x, const double *at_y, double (*metres)[3],
                 io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    OGRSpatialReferenceH map = OSRNewSpatialReference(crs);
    double *x = malloc(4 * n * sizeof *x), *y = malloc(4 * n * sizeof *y);
    const bool good = map != NULL && x != NULL && y != NULL && find_scales(map, n, at_x, at_y, x, y, metres);
    free(x);
    free(y);
    OSRDestroySpatialReference(map);
    return good || fail_way(error);
}
