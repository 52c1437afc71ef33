/* SPDX-License-Identifier: Apache-2.0 */
/* Points, corners of lines and polygons from any file of features that GDAL reads. */

#include "parts.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_alg.h>
#include <math.h>
#include <ogr_api.h>
#include <string.h>
#include <strings.h>

typedef struct reader {
    const char *path;
    io_points *points;
    const io_mask *mask;                 /* or this, for polygons */
    OGRCoordinateTransformationH to_map; /* NULL: none */
    int height, weight, name;            /* numbers of the attributes, or -1 */
    bool has_z;                          /* a place's is not 0 */
    size_t parts, lines, singles;
    const io_points_options *options;
    bool is_kml;
    io_error *error;
} reader;

static OGRLayerH choose_layer(const reader *r, GDALDatasetH file) {
    const char *path = r->path, *name = r->options->layer;
    io_error *error = r->error;
    const int count = GDALDatasetGetLayerCount(file);
    OGRLayerH layer = name ? GDALDatasetGetLayerByName(file, name) : count == 1 ? GDALDatasetGetLayer(file, 0) : NULL;
    if (layer != NULL) return layer;
    char there[300] = "";
    for (int k = 0; k < count; k++) io_list(there, sizeof there, "%s", OGR_L_GetName(GDALDatasetGetLayer(file, k)));
    if (count == 0)
        io_fail(error, "%s: holds no layer of features", path);
    else if (name)
        io_fail(error, "%s: has no layer '%s'; there are %s", path, name, there);
    else
        io_fail(error, "%s: has several layers%s%s", path,
                r->mask ? ", and a file with one is needed: " : "; --layer names one of ", there);
    return NULL;
}

/* False only after an error: where either says no coordinate system, coordinates are the map's. */
static bool find_way(reader *r, OGRLayerH layer, const char *crs) {
    OGRSpatialReferenceH given = OGR_L_GetSpatialRef(layer), map = given && crs ? OSRNewSpatialReference(crs) : NULL;
    if (map == NULL) return true;
    OGRSpatialReferenceH from = OSRClone(given);
    OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
    OSRSetAxisMappingStrategy(map, OAMS_TRADITIONAL_GIS_ORDER);
    const bool same = OSRIsSame(from, map) != 0;
    CPLErrorReset();
    if (!same) r->to_map = OCTNewCoordinateTransformation(from, map);
    OSRDestroySpatialReference(from);
    OSRDestroySpatialReference(map);
    return same || r->to_map != NULL ||
           gdal_fail(r->error, r->path, "its coordinate system has no way to that of the terrain");
}

/* An attribute as a number; an unset one leaves *number as it is. */
static bool take_number(reader *r, OGRFeatureH f, int field, double *number) {
    if (field < 0 || !OGR_F_IsFieldSetAndNotNull(f, field)) return true;
    const char *text = OGR_F_GetFieldAsString(f, field);
    if (text[0] == '\0') return true;
    char *end = NULL;
    *number = CPLStrtod(text, &end);
    return (end != text && *end == '\0' && isfinite(*number)) ||
           io_fail(r->error, "%s: feature %lld: '%.40s' stands where a number should, in %s", r->path,
                   (long long)OGR_F_GetFID(f), text, OGR_Fld_GetNameRef(OGR_F_GetFieldDefnRef(f, field)));
}

static bool add_place(reader *r, OGRGeometryH g, int k, io_place *p) {
    p->x = OGR_G_GetX(g, k);
    p->y = OGR_G_GetY(g, k);
    r->has_z |= OGR_G_Is3D(g) && OGR_G_GetZ(g, k) != 0;
    CPLErrorReset();
    if (r->to_map != NULL && !(OCTTransform(r->to_map, 1, &p->x, &p->y, NULL) && isfinite(p->x) && isfinite(p->y)))
        return io_fail(r->error, "%s: feature %zu: %.10g, %.10g has no place on the terrain's map", r->path, p->number,
                       OGR_G_GetX(g, k), OGR_G_GetY(g, k));
    if (!(isfinite(p->x) && isfinite(p->y)))
        return io_fail(r->error, "%s: feature %zu: has a coordinate that is no number", r->path, p->number);
    return gdal_program()->add(r->points, p) || io_fail(r->error, "%s: out of memory", r->path);
}

static bool take_geometry(reader *r, OGRGeometryH g, io_place *p) {
    const OGRwkbGeometryType type = g ? OGR_GT_Flatten(OGR_G_GetGeometryType(g)) : wkbNone;
    bool good = true;
    if (g == NULL || OGR_G_IsEmpty(g)) return true;
    if (type == wkbPoint) {
        p->part = 0;
        r->singles++;
        return add_place(r, g, 0, p);
    }
    if (type == wkbLineString) {
        p->part = r->parts++;
        r->lines++;
        for (int k = 0; good && k < OGR_G_GetPointCount(g); k++) good = add_place(r, g, k, p);
        return good;
    }
    if (type != wkbMultiPoint && type != wkbMultiLineString && type != wkbGeometryCollection)
        return io_fail(r->error, "%s: feature %zu: is a %s, neither points nor a line", r->path, p->number,
                       OGR_G_GetGeometryName(g));
    for (int k = 0; good && k < OGR_G_GetGeometryCount(g); k++) good = take_geometry(r, OGR_G_GetGeometryRef(g, k), p);
    return good;
}

/* Attributes that have a value somewhere, and that nothing else reads. KML's own, such as tessellate, are no user's. */
enum { FIELDS_MOST = 200 };

static void note_others(const reader *r, OGRFeatureH f, bool others[FIELDS_MOST]) {
    static const char *const own[] = {"description", "timestamp",  "begin",     "end",  "altitudeMode", "tessellate",
                                      "extrude",     "visibility", "drawOrder", "icon", "snippet",      "id"};
    const int count = OGR_F_GetFieldCount(f) < FIELDS_MOST ? OGR_F_GetFieldCount(f) : FIELDS_MOST;
    for (int k = 0; k < count; k++) {
        bool known = k == r->height || k == r->weight || k == r->name;
        for (size_t n = 0; n < sizeof own / sizeof *own && r->is_kml; n++)
            known |= strcasecmp(OGR_Fld_GetNameRef(OGR_F_GetFieldDefnRef(f, k)), own[n]) == 0;
        others[k] |= !known && OGR_F_IsFieldSetAndNotNull(f, k) && OGR_F_GetFieldAsString(f, k)[0] != '\0';
    }
}

/* Else a height under another name would silently become the usual one. */
static void warn_of_others(const reader *r, OGRFeatureDefnH about, const bool others[FIELDS_MOST]) {
    char list[300] = "";
    for (int k = 0; k < FIELDS_MOST; k++)
        if (others[k]) io_list(list, sizeof list, "'%s'", OGR_Fld_GetNameRef(OGR_FD_GetFieldDefn(about, k)));
    if (r->has_z) io_list(list, sizeof list, "z of places");
    if (list[0] != '\0')
        gdal_warn(
            &r->options->warn,
            "%s: passed over: %s; attributes with a meaning are height (or OFFSETA, above ground), weight and name",
            r->path, list);
}

static bool take_features(reader *r, OGRLayerH layer) {
    bool others[FIELDS_MOST] = {false};
    OGRFeatureDefnH about = OGR_L_GetLayerDefn(layer);
    r->height = OGR_FD_GetFieldIndex(about, "height");
    if (r->height < 0) r->height = OGR_FD_GetFieldIndex(about, "OFFSETA");
    r->name = OGR_FD_GetFieldIndex(about, "name");
    r->weight = OGR_FD_GetFieldIndex(about, "weight");
    r->points->has_weight = r->weight >= 0;
    OGR_L_ResetReading(layer);
    CPLErrorReset();
    for (OGRFeatureH f; (f = OGR_L_GetNextFeature(layer)) != NULL;) {
        io_place p = {.z = r->options->height,
                      .weight = 1,
                      .along = NAN,
                      .from = IO_PLACE_FEATURE,
                      .text = r->path,
                      .number = (size_t)OGR_F_GetFID(f)};
        if (r->name >= 0 && OGR_F_IsFieldSetAndNotNull(f, r->name))
            snprintf(p.name, sizeof p.name, "%s", OGR_F_GetFieldAsString(f, r->name));
        note_others(r, f, others);
        const bool good = take_number(r, f, r->height, &p.z) && take_number(r, f, r->weight, &p.weight) &&
                          take_geometry(r, OGR_F_GetGeometryRef(f), &p);
        OGR_F_Destroy(f);
        if (!good) return false;
    }
    if (CPLGetLastErrorType() >= CE_Failure) return gdal_fail_read(r->error, r->path, "cannot read");
    warn_of_others(r, about, others);
    r->points->has_lines = r->lines > 0;
    return r->lines == 0 || r->singles == 0 || io_fail(r->error, "%s: has points and lines", r->path);
}

/* Opens the file and gives its layer to take. */
static bool read_layer(reader *r, bool (*take)(reader *r, OGRLayerH layer)) {
    const io_points_options *o = r->options;
    GDALDatasetH file = gdal_open_name(r->path, GDAL_OF_VECTOR, r->error);
    if (file == NULL) return false;
    r->is_kml = strstr(GDALGetDriverShortName(GDALGetDatasetDriver(file)), "KML") != NULL;
    OGRLayerH layer = choose_layer(r, file);
    const bool good =
        layer != NULL && gdal_note_files(file, r->path, r->error) && find_way(r, layer, o->crs) && take(r, layer);
    OCTDestroyCoordinateTransformation(r->to_map);
    GDALClose(file);
    return good;
}

bool gdal_points(const char *path, const io_points_options *o, io_points *points, io_error *error) {
    GDAL_CALL;
    reader r = {.path = path, .points = points, .options = o, .error = error};
    return read_layer(&r, take_features);
}

/* ---- polygons ---------------------------------------------------------------------------------------------------- */

/* GDAL counts pixels in int, and draws what lies farther away elsewhere. */
static bool is_in_reach(const io_mask *m, OGRGeometryH polygons) {
    const double(*a)[4] = m->map, far = 0x1p29 * fabs(a[0][0] * a[1][1] - a[0][1] * a[1][0]);
    OGREnvelope e;
    OGR_G_GetEnvelope(polygons, &e);
    const double x = fmax(fabs(e.MinX - a[0][3]), fabs(e.MaxX - a[0][3])),
                 y = fmax(fabs(e.MinY - a[1][3]), fabs(e.MaxY - a[1][3]));
    return fabs(a[1][1]) * x + fabs(a[0][1]) * y < far && fabs(a[1][0]) * x + fabs(a[0][0]) * y < far;
}

/* A copy of a feature's polygons on the terrain's map; NULL after an error. */
static OGRGeometryH take_polygons(reader *r, OGRFeatureH f) {
    const long long number = OGR_F_GetFID(f);
    OGRGeometryH given = OGR_F_GetGeometryRef(f);
    if (OGR_G_GetDimension(given) != 2) {
        io_fail(r->error, "%s: feature %lld: is a %s, no polygon", r->path, number, OGR_G_GetGeometryName(given));
        return NULL;
    }
    OGRGeometryH g = OGR_G_GetLinearGeometry(given, 0, NULL);
    const bool placed = g != NULL && (r->to_map == NULL || OGR_G_Transform(g, r->to_map) == OGRERR_NONE);
    if (placed && is_in_reach(r->mask, g)) return g;
    OGR_G_DestroyGeometry(g);
    io_fail(r->error, "%s: feature %lld: %s", r->path, number,
            placed ? "reaches too far away from the terrain" : "has no place on the terrain's map");
    return NULL;
}

/* Sets bytes in the memory of a raster that GDAL draws on. */
static bool draw(const io_mask *m, OGRGeometryH polygons) {
    const double(*a)[4] = m->map, one = 1;
    double corner[6]; /* of the first sample's pixel */
    for (int k = 0; k < 2; k++) {
        corner[3 * k] = a[k][3] - 0.5 * (a[k][0] + a[k][1]);
        corner[3 * k + 1] = a[k][0];
        corner[3 * k + 2] = a[k][1];
    }
    char bytes[64] = "DATAPOINTER=";
    bytes[12 + CPLPrintPointer(bytes + 12, m->inside, (int)sizeof bytes - 13)] = '\0';
    char *const options[] = {bytes, NULL};
    GDALDatasetH raster = GDALCreate(GDALGetDriverByName("MEM"), "", (int)m->nx, (int)m->ny, 0, GDT_Byte, NULL);
    if (raster == NULL) return false;
    const int band = 1;
    const bool good =
        GDALSetGeoTransform(raster, corner) == CE_None &&
        GDALAddBand(raster, GDT_Byte, (char **)(uintptr_t)options) == CE_None &&
        GDALRasterizeGeometries(raster, 1, &band, 1, &polygons, NULL, NULL, &one, NULL, NULL, NULL) == CE_None;
    GDALClose(raster);
    return good;
}

static bool take_areas(reader *r, OGRLayerH layer) {
    OGRGeometryH all = OGR_G_CreateGeometry(wkbGeometryCollection); /* whose parts are drawn one by one */
    bool good = true;
    OGR_L_ResetReading(layer);
    CPLErrorReset();
    for (OGRFeatureH f; good && (f = OGR_L_GetNextFeature(layer)) != NULL; OGR_F_Destroy(f)) {
        if (OGR_F_GetGeometryRef(f) == NULL || OGR_G_IsEmpty(OGR_F_GetGeometryRef(f))) continue;
        OGRGeometryH g = take_polygons(r, f);
        good = g != NULL;
        if (good) OGR_G_AddGeometryDirectly(all, g);
    }
    if (good && CPLGetLastErrorType() >= CE_Failure) good = gdal_fail_read(r->error, r->path, "cannot read");
    if (good && OGR_G_GetGeometryCount(all) == 0) good = io_fail(r->error, "%s: holds no polygons", r->path);
    if (good && !draw(r->mask, all)) good = gdal_fail(r->error, r->path, "cannot be drawn");
    OGR_G_DestroyGeometry(all);
    return good;
}

bool gdal_areas(const char *path, const io_points_options *o, const io_mask *mask, io_error *error) {
    GDAL_CALL;
    reader r = {.path = path, .mask = mask, .options = o, .error = error};
    return read_layer(&r, take_areas);
}
