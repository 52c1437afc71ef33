/* SPDX-License-Identifier: Apache-2.0 */
/* Coordinate systems, by GDAL's OGR and PROJ. */

#include "parts.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <math.h>
#include <string.h>

/* NULL of a system that is damaged. */
static char *well_known_text(OGRSpatialReferenceH crs) {
    static const char *const options[] = {"FORMAT=WKT2_2019", "MULTILINE=NO", NULL};
    char *text = NULL;
    const bool good = OSRExportToWktEx(crs, &text, options) == OGRERR_NONE && text != NULL;
    char *copy = good ? strdup(text) : NULL; /* for the program to free */
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

/* By longitudes and latitudes of the ends of two lines, one along the map's x and one along its y, which are so far
 * from each other on the map. metres: on the ground in one of the map's; *cosine: of the angle between the lines. */
static bool take_scale(const globe *g, const double x[4], const double y[4], double far, double metres[2],
                       double *cosine) {
    double end[4][3], along[2][3], dot = 0;
    for (size_t e = 0; e < 4; e++) to_space(g, x[e], y[e], end[e]);
    for (int a = 0; a < 2; a++) {
        for (int c = 0; c < 3; c++) along[a][c] = (end[2 * a + 1][c] - end[2 * a][c]) / far;
        metres[a] = sqrt(along[a][0] * along[a][0] + along[a][1] * along[a][1] + along[a][2] * along[a][2]);
    }
    for (int c = 0; c < 3; c++) dot += along[0][c] * along[1][c];
    *cosine = dot / (metres[0] * metres[1]);
    return isfinite(metres[0]) && metres[0] > 0 && isfinite(metres[1]) && metres[1] > 0;
}

/* By the system's own longitudes and latitudes: without a change of datum, which may need grids. */
static bool find_scale(OGRSpatialReferenceH system, OGRSpatialReferenceH earth, double map[3][4], size_t nx, size_t ny,
                       map_scale *scale, double *sheared) {
    enum { NODES = MAP_SCALE_ROWS * MAP_SCALE_COLUMNS };
    OGRErr status[2] = {OGRERR_NONE, OGRERR_NONE};
    const double unit = OSRGetLinearUnits(system, NULL), semi_major = OSRGetSemiMajor(earth, &status[0]),
                 inverse = OSRGetInvFlattening(earth, &status[1]), flattening = inverse > 0 ? 1 / inverse : 0;
    const globe g = {semi_major, flattening * (2 - flattening), OSRGetAngularUnits(earth, NULL)};
    if (status[0] != OGRERR_NONE || status[1] != OGRERR_NONE || !(unit > 0) || !(semi_major > 0)) return false;
    const double away = step / unit;
    double x[4 * NODES], y[4 * NODES];
    for (int n = 0; n < NODES; n++) {
        const double i = (double)(n % MAP_SCALE_COLUMNS) / (MAP_SCALE_COLUMNS - 1) * (double)(nx - 1),
                     j = (double)(n / MAP_SCALE_COLUMNS) / (MAP_SCALE_ROWS - 1) * (double)(ny - 1),
                     at[2] = {map[0][0] * i + map[0][1] * j + map[0][3], map[1][0] * i + map[1][1] * j + map[1][3]};
        for (int e = 0; e < 4; e++) {
            x[4 * n + e] = at[0] + (e == 0 ? -away : e == 1 ? away : 0);
            y[4 * n + e] = at[1] + (e == 2 ? -away : e == 3 ? away : 0);
        }
    }
    bool good = bring(system, earth, 4 * NODES, x, y);
    *sheared = 0;
    for (int n = 0; n < NODES && good; n++) {
        double cosine;
        good = take_scale(&g, x + 4 * n, y + 4 * n, 2 * away,
                          scale->metres[n / MAP_SCALE_COLUMNS][n % MAP_SCALE_COLUMNS], &cosine);
        *sheared = fmax(*sheared, fabs(cosine));
    }
    return good;
}

bool gdal_scale(const char *crs, double map[3][4], size_t nx, size_t ny, map_scale *scale, double *sheared,
                io_error *error) {
    GDAL_CALL;
    CPLErrorReset();
    OGRSpatialReferenceH system = OSRNewSpatialReference(crs), earth = system ? OSRCloneGeogCS(system) : NULL;
    const bool good = earth != NULL && find_scale(system, earth, map, nx, ny, scale, sheared);
    OSRDestroySpatialReference(earth);
    OSRDestroySpatialReference(system);
    return good || fail_way(error);
}
