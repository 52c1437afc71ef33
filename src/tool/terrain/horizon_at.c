/* SPDX-License-Identifier: Apache-2.0 */
#include "horizon_at.h"

#include "../json.h"
#include "inputs.h"
#include "observers.h"
#include "output.h"
#include "place_horizon.h"
#include "sun_place.h"

#include <math.h>

bool horizon_at_check(horizon_at *h, const char *name) {
    for (size_t k = 0; k < h->at.count; k++)
        if (!product_parse_place(name, h->at.values[k], 0, &h->places[k])) return false;
    return true;
}

typedef struct job {
    product *product;
    const horizon_at *options;
    const cw_horizon *desc;
    sight_bounds *bounds;
    bool in_circles; /* the circle around each place is read, not all of the raster */
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

static void write_json(FILE *to, const finding *f, bool first) {
    json_print(to, first ? "\n" : ",\n");
    json_print(to, "  {'azimuth': %g, 'true_azimuth': %g, 'angle': %g, 'distance': %g, 'at': ", f->is.azimuth,
               f->true_azimuth, f->is.angle, f->is.distance);
    if (isnan(f->is.angle))
        fputs("null}", to);
    else
        fprintf(to, "[%.10g, %.10g]}", f->is.at[0], f->is.at[1]);
}

static bool read_around(job *j, const ground_place *p, double metres, io_error *error) {
    ground *g = &j->product->ground;
    sight_bounds_destroy(j->bounds);
    j->bounds = NULL;
    return ground_read_around(g, p->x, p->y, metres, error) &&
           (sight_bounds_create(&g->terrain, &j->bounds) == CW_OK || io_fail(error, "out of memory"));
}

static bool write_place(job *j, const ground_place *p, io_error *error) {
    const ground *g = &j->product->ground;
    const cw_horizon *d = j->desc;
    const terrain *t = &g->terrain;
    const bool json = j->options->json;
    double eye[3], level, xy[2];
    sight s;
    sun_place north;
    io_error unknown;
    j->number++;
    if (j->in_circles && !read_around(j, p, d->max_distance, error)) return false;
    if (!ground_find_place(t, p, eye, &level, error)) return false;
    if (isnan(level)) return io_fail(error, "%s: is not on the terrain, where the horizon is found", p->text);
    sight_init(&s, t, j->bounds, eye, d->curvature);
    terrain_to_map(t, eye[0], eye[1], xy);
    if (!sun_place_of(t, &g->about.georef, xy, g->path, NULL, &north, &unknown)) north.turned = NAN;
    if (json && !io_output_print(&j->to, error, "%s {\"place\": [%.10g, %.10g], \"horizon\": [",
                                 j->number > 1 ? ",\n" : "", xy[0], xy[1]))
        return false;
    for (size_t k = 0; k < d->count; k++) {
        finding f = {
            place_horizon_toward(&s, fmod(d->start + 360.0 * (double)k / (double)d->count, 360), d->max_distance), 0};
        f.true_azimuth = fmod(f.is.azimuth - north.turned + 360, 360);
        if (json)
            write_json(j->to.file, &f, k == 0);
        else if (!write_row(j, &f, error))
            return false;
    }
    return !json || io_output_print(&j->to, error, "]}");
}

static bool write_all(job *j, const observers *all, io_error *error) {
    const bool json = j->options->json;
    if (!io_output_print(&j->to, error, json ? "{\"places\": [\n" : "place,azimuth,true_azimuth,angle,distance,x,y\n"))
        return false;
    for (size_t k = 0; k < all->count; k++) {
        char text[OBSERVER_TEXT];
        const ground_place place = observers_place(all, k, text);
        if (!product_tell(j->product, (double)k / (double)all->count)) return io_fail(error, "interrupted");
        if (!write_place(j, &place, error)) return false;
    }
    return !json || io_output_print(&j->to, error, "\n]}\n");
}

bool horizon_at_write(product *p, const horizon_at *h, const cw_horizon *desc, io_error *error) {
    const observers_from from = {.places = h->places, .place_count = h->at.count, .file = h->file};
    job j = {.product = p, .options = h, .desc = desc};
    observers all;
    if (h->file && !io_inputs_note_path(h->file)) return io_fail(error, "out of memory");
    if (!observers_find(&all, &from, &p->ground, error)) return false;
    ground *g = &p->ground;
    j.in_circles = desc->max_distance > 0 && (all.count == 1 || !ground_is_small(g));
    bool good = j.in_circles || read_around(&j, &(ground_place){0}, 0, error);
    good = good && io_output_open(&j.to, p->output ? p->output : "-", error) && write_all(&j, &all, error) &&
           io_output_commit(&j.to, error);
    io_output_discard(&j.to);
    sight_bounds_destroy(j.bounds);
    observers_free(&all);
    return good;
}
