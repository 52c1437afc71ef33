/* SPDX-License-Identifier: Apache-2.0 */
#include "horizon_at.h"

#include "../cancel.h"
#include "../json.h"
#include "inputs.h"
#include "output.h"
#include "place_horizon.h"
#include "points.h"
#include "sun_place.h"

#include <math.h>

bool horizon_at_check(horizon_at *h, const char *name) {
    for (size_t k = 0; k < h->at.count; k++)
        if (!ground_read_place(name, h->at.values[k], 0, &h->places[k])) return false;
    return true;
}

typedef struct job {
    ground *ground;
    const horizon_at *options;
    sight_bounds *bounds;
    io_output to;
    size_t number; /* of the place, from 1 on */
} job;

typedef struct finding {
    place_horizon is;
    double true_azimuth;
} finding;

static bool write_row(job *j, const finding *f, io_error *error) {
    char true_azimuth[40] = "";
    if (isfinite(f->true_azimuth)) snprintf(true_azimuth, sizeof true_azimuth, "%.6g", f->true_azimuth);
    if (!io_output_print(&j->to, error, "%zu,%.6g,%s,", j->number, f->is.azimuth, true_azimuth)) return false;
    if (isnan(f->is.angle)) return io_output_print(&j->to, error, ",,,\n");
    return io_output_print(&j->to, error, "%.6f,%.3f,%.10g,%.10g\n", f->is.angle, f->is.distance, f->is.at[0],
                           f->is.at[1]);
}

static bool write_json(job *j, const finding *f, bool first, io_error *error) {
    FILE *to = j->to.file;
    if (!io_output_print(&j->to, error, "%s\n  {\"azimuth\": ", first ? "" : ",")) return false;
    json_number(to, f->is.azimuth);
    fputs(", \"true_azimuth\": ", to);
    json_number(to, f->true_azimuth);
    fputs(", \"angle\": ", to);
    json_number(to, f->is.angle);
    fputs(", \"distance\": ", to);
    json_number(to, f->is.distance);
    return isnan(f->is.angle) ? io_output_print(&j->to, error, ", \"at\": null}")
                              : io_output_print(&j->to, error, ", \"at\": [%.10g, %.10g]}", f->is.at[0], f->is.at[1]);
}

static bool write_place(job *j, const ground_place *p, io_error *error) {
    const horizon_at *o = j->options;
    const terrain *t = &j->ground->terrain;
    double eye[3], level, xy[2];
    sight s;
    sun_place north;
    io_error unknown;
    j->number++;
    if (atomic_load(cancel_flag())) return io_fail(error, "interrupted");
    if (!ground_find_place(t, p, eye, &level, error)) return false;
    if (isnan(level)) return io_fail(error, "%s: is not on the terrain, where the horizon is found", p->text);
    sight_init(&s, t, j->bounds, eye, o->curvature);
    terrain_to_map(t, eye[0], eye[1], xy);
    if (!sun_place_of(t, ground_georef(j->ground), xy, j->ground->path, NULL, &north, &unknown)) north.turned = NAN;
    if (o->json && !io_output_print(&j->to, error, "%s {\"place\": [%.10g, %.10g], \"horizon\": [",
                                    j->number > 1 ? ",\n" : "", xy[0], xy[1]))
        return false;
    for (unsigned k = 0; k < o->directions; k++) {
        finding f = {place_horizon_toward(&s, fmod(o->start + 360.0 * k / o->directions, 360), o->max_distance), 0};
        f.true_azimuth = fmod(f.is.azimuth - north.turned + 360, 360);
        if (!(o->json ? write_json(j, &f, k == 0, error) : write_row(j, &f, error))) return false;
    }
    return !o->json || io_output_print(&j->to, error, "]}");
}

static bool write_file(job *j, io_error *error) {
    ground *g = j->ground;
    const io_points_options reading = {
        .crs = ground_georef(g)->crs, .warn = g->reading.warn, .context = g->reading.context};
    io_points points;
    if (!io_points_read(j->options->file, &reading, &points, error)) return false;
    bool good = true;
    for (size_t k = 0; k < points.count && good; k++) {
        const io_point *p = &points.points[k];
        const double height = isnan(p->height) ? 0 : p->height;
        char name[150], text[300];
        io_points_name(&points, k, name, sizeof name);
        snprintf(text, sizeof text, "%s: %.10g,%.10g,%s%.10g", name, p->x, p->y, p->absolute ? "=" : "", height);
        good = write_place(j, &(ground_place){text, p->x, p->y, height, p->absolute}, error);
    }
    io_points_free(&points);
    return good;
}

static bool write_all(job *j, io_error *error) {
    const horizon_at *o = j->options;
    if (!io_output_print(&j->to, error,
                         o->json ? "{\"places\": [\n" : "place,azimuth,true_azimuth,angle,distance,x,y\n"))
        return false;
    for (size_t k = 0; k < o->at.count; k++)
        if (!write_place(j, &o->places[k], error)) return false;
    if (o->file && !write_file(j, error)) return false;
    return !o->json || io_output_print(&j->to, error, "\n]}\n");
}

bool horizon_at_write(ground *g, const horizon_at *h, io_error *error) {
    job j = {.ground = g, .options = h};
    if (h->file && !io_inputs_note_path(h->file)) return io_fail(error, "out of memory");
    if (sight_bounds_create(&g->terrain, &j.bounds) != CW_OK) return io_fail(error, "out of memory");
    const bool good = io_output_open(&j.to, h->output ? h->output : "-", error) && write_all(&j, error) &&
                      io_output_commit(&j.to, error);
    io_output_discard(&j.to);
    sight_bounds_destroy(j.bounds);
    return good;
}
