/* SPDX-License-Identifier: Apache-2.0 */
#include "suns.h"

#include "gdal/module.h"
#include "inputs.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 180 / 3.141592653589793;

bool sun_place_of(const terrain *t, const io_georef *georef, const double at[2], const char *path, const char *instead,
                  sun_place *place, io_error *error) {
    const terrain *whole = terrain_whole(t);
    double xy[2];
    *place = (sun_place){0, 0, 0};
    if (at)
        memcpy(xy, at, sizeof xy);
    else
        terrain_to_map(whole, 0.5 * (double)(whole->nx - 1), 0.5 * (double)(whole->ny - 1), xy);
    if (t->geographic) {
        place->longitude = remainder(xy[0] * t->unit * degrees, 360); /* else it would begin the day before */
        place->latitude = xy[1] * t->unit * degrees;
        return true;
    }
    if (georef->crs == NULL)
        return io_fail(error, "%s: names no coordinate system, so the sun's place at a time is not known%s%s", path,
                       instead ? "; " : "", instead ? instead : "");
    const io_gdal *gdal = io_gdal_load(error);
    double x[2] = {xy[0]}, y[2] = {xy[1]};
    if (gdal == NULL || !gdal->lon_lat(georef->crs, false, 1, x, y, error)) return false;
    place->longitude = x[0];
    place->latitude = y[0];
    /* Two places, one 20 m north of the other. */
    x[1] = x[0];
    y[0] -= 1e-4;
    y[1] = y[0] + 2e-4;
    if (!gdal->lon_lat(georef->crs, true, 2, x, y, error)) return false;
    place->turned = atan2(x[1] - x[0], y[1] - y[0]) * degrees;
    return true;
}

enum { AZIMUTH, ALTITUDE, WEIGHT, NAMES };

static bool take_sun(const io_table *t, size_t row, const size_t columns[NAMES], sun_list *list, io_error *error) {
    sun_position *p = &list->suns[row];
    double *weight = &list->weights[row];
    *p = (sun_position){.distance = 1};
    *weight = 1;
    if (!io_table_number(t, row, columns[AZIMUTH], &p->azimuth, error) ||
        !io_table_number(t, row, columns[ALTITUDE], &p->altitude, error) ||
        (columns[WEIGHT] < t->columns && !io_table_number(t, row, columns[WEIGHT], weight, error)))
        return false;
    return fabs(p->altitude) <= 90 ||
           io_table_fail(t, row, columns[ALTITUDE], "an angle from -90 to 90 degrees", error);
}

bool sun_list_read(const char *path, const ground_watch *w, sun_list *list, io_error *error) {
    static const char *const names[NAMES] = {"azimuth", "altitude", "weight"};
    size_t columns[NAMES];
    io_table t;
    *list = (sun_list){0};
    if (!io_inputs_note_path(path)) return io_fail(error, "out of memory");
    if (!io_table_read(path, &t, error)) return false;
    bool good = io_table_columns(&t, names, NAMES, WEIGHT, columns, &w->warn, error);
    if (good && t.rows == 0) good = io_fail(error, "%s: holds no places of the sun", path);
    list->suns = calloc(t.rows + 1, sizeof *list->suns);
    list->weights = calloc(t.rows + 1, sizeof *list->weights);
    if (good && !(list->suns && list->weights)) good = io_fail(error, "out of memory");
    for (size_t row = 0; good && row < t.rows; row++) good = take_sun(&t, row, columns, list, error);
    list->count = t.rows;
    io_table_free(&t);
    return good;
}

void sun_list_free(sun_list *list) {
    free(list->suns);
    free(list->weights);
    *list = (sun_list){0};
}
