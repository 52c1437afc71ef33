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

bool gdal_lon_lat(const char *crs, bool back, size_t n, double *x, double *y, io_error *error) {
    OGRSpatialReferenceH map = OSRNewSpatialReference(crs), earth = OSRNewSpatialReference(NULL);
    OGRCoordinateTransformationH transformation = NULL;
    bool good = false;
    CPLErrorReset();
    if (map != NULL && earth != NULL && OSRImportFromEPSG(earth, 4326) == OGRERR_NONE) {
        OSRSetAxisMappingStrategy(map, OAMS_TRADITIONAL_GIS_ORDER);
        OSRSetAxisMappingStrategy(earth, OAMS_TRADITIONAL_GIS_ORDER);
        transformation = OCTNewCoordinateTransformation(back ? earth : map, back ? map : earth);
        good = transformation != NULL && OCTTransform(transformation, (int)n, x, y, NULL) != 0;
        for (size_t k = 0; k < n; k++) good = good && isfinite(x[k]) && isfinite(y[k]);
    }
    if (!good) gdal_fail(error, "the coordinate system", "has no way to longitude and latitude");
    OCTDestroyCoordinateTransformation(transformation);
    if (map) OSRDestroySpatialReference(map);
    if (earth) OSRDestroySpatialReference(earth);
    return good;
}
