/* SPDX-License-Identifier: Apache-2.0 */
#include "sun_table.h"

#include "command.h"
#include "number.h"
#include "output.h"

#include <math.h>
#include <string.h>
#include <time.h>

enum { DAYS_MOST = 62 }; /* with a row each */

bool sun_table_check(sun_table *a, const char *name) {
    char *end;
    a->ground = a->tilt && strcmp(a->tilt, "ground") == 0;
    const double tilt = a->tilt && !a->ground ? number_read(a->tilt, &end) : 0;
    if (a->at == NULL)
        return (a->tilt == NULL && isnan(a->facing)) || command_refuse(name, "--tilt and --facing go with --at");
    if (a->tilt && !a->ground && (end == a->tilt || *end != '\0' || !(tilt >= 0 && tilt <= 180)))
        return command_refuse(name, "--tilt takes degrees from 0 to 180, or the word ground, not '%s'", a->tilt);
    if (!isnan(a->facing) && (a->tilt == NULL || a->ground))
        return command_refuse(name, "--facing goes with --tilt DEGREES");
    a->desc.tilt = tilt;
    a->desc.facing = isnan(a->facing) ? 180 : a->facing;
    return product_parse_place(name, a->at, 0, &a->place);
}

bool sun_table_place(const product *p, sun_table *a, const terrain *t, const double at[2], io_error *error) {
    const ground *g = &p->ground;
    sun_place found;
    const bool known = sun_place_of(t, &g->about.georef, at, g->path, "--lon-lat tells it", &found, error);
    if (known && a->placed)
        return io_fail(error, "%s: the file says where on earth it lies; --lon-lat is for files that do not", g->path);
    if (known) a->desc.place = found;
    return known || a->placed;
}

/* Days that share a row. */
typedef struct sum {
    sun_day all;
    double rises, sets; /* seconds after the days' midnights of UTC */
    size_t lit;
} sum;

static void add(sum *s, const sun_day *d, double midnight) {
    double *to[] = {&s->all.hours,       &s->all.free_hours, &s->all.direct,
                    &s->all.free_direct, &s->all.diffuse,    &s->all.free_diffuse};
    const double from[] = {d->hours, d->free_hours, d->direct, d->free_direct, d->diffuse, d->free_diffuse};
    for (int k = 0; k < 6; k++) *to[k] += from[k];
    if (isnan(d->rise)) return;
    s->rises += d->rise - midnight;
    s->sets += d->set - midnight;
    s->lit++;
}

static const char *as_text(double seconds, const char *format, char text[32]) {
    const time_t time = (time_t)nearbyint(seconds);
    text[0] = '\0';
    if (isfinite(seconds)) strftime(text, 32, format, gmtime(&time));
    return text;
}

static bool print_row(io_output *to, const sum *s, double midnight, bool month, io_error *error) {
    char name[32], rise[32], set[32];
    const double lit = s->lit > 0 ? (double)s->lit : NAN, from = month ? 0 : midnight;
    const char *clock = month ? "%H:%MZ" : "%Y-%m-%dT%H:%MZ";
    const sun_day *d = &s->all;
    return io_output_print(to, error, "%s,%s,%s,%.2f,%.2f,%.0f,%.0f,%.0f,%.0f\n",
                           as_text(midnight, month ? "%Y-%m" : "%Y-%m-%d", name),
                           as_text(from + s->rises / lit, clock, rise), as_text(from + s->sets / lit, clock, set),
                           d->hours, d->free_hours, d->direct, d->free_direct, d->diffuse, d->free_diffuse);
}

static bool begins_month(double midnight) {
    char text[32];
    return strcmp(as_text(midnight, "%d", text), "01") == 0;
}

static bool print_days(product *p, const sun_table *a, const sight *s, double share, io_output *to, sum *all,
                       io_error *error) {
    const bool months = a->days > DAYS_MOST;
    sum row = {0};
    if (!io_output_print(to, error, "%s,rise,set,hours,free_hours,direct,free_direct,diffuse,free_diffuse\n",
                         months ? "month" : "day"))
        return false;
    for (size_t k = 0; k < a->days; k++) {
        const double midnight = a->first + day * (double)k;
        const sun_day d = cw_sun_day(s, &a->desc, share, midnight, NULL, NULL, 0);
        add(&row, &d, midnight);
        add(all, &d, midnight);
        product_tell(p, (double)(k + 1) / (double)a->days);
        if (months && k + 1 < a->days && !begins_month(midnight + day)) continue;
        if (!print_row(to, &row, midnight, months, error)) return false;
        row = (sum){0};
    }
    return true;
}

static bool print_list(product *p, const sun_table *a, const sight *s, io_output *to, io_error *error) {
    sun_list list;
    bool good = sun_list_read(a->suns, &p->ground.watch, &list, error);
    if (good) {
        const sun_day d = cw_sun_day(s, &a->desc, NAN, 0, list.suns, list.weights, list.count);
        good = io_output_print(to, error, "suns,hours,free_hours,direct,free_direct\n%zu,%.6g,%.6g,%.6g,%.6g\n",
                               list.count, d.hours, d.free_hours, d.direct, d.free_direct);
    }
    sun_list_free(&list);
    return good;
}

bool sun_table_write(product *p, sun_table *a, io_error *error) {
    ground *g = &p->ground;
    const terrain *t = &g->terrain;
    sun_day_desc *d = &a->desc;
    double eye[3], xy[2];
    sight s;
    sight_bounds *bounds;
    io_output to = {0};
    if (!ground_read_around(g, a->place.x, a->place.y, d->max_distance, error) ||
        !ground_find_place(t, &a->place, eye, NULL, error))
        return false;
    terrain_to_map(t, eye[0], eye[1], xy);
    if (!a->suns && !sun_table_place(p, a, t, xy, error)) return false;
    if (a->ground) cw_sun_day_lean(t, eye, d);
    if (cw_sight_bounds_create(t, &bounds) != CW_OK) return io_fail(error, "out of memory");
    cw_sight_init(&s, t, bounds, eye, a->curvature);
    sum all = {0};
    const bool good =
        io_output_open(&to, p->output ? p->output : "-", error) &&
        (a->suns ? print_list(p, a, &s, &to, error) : print_days(p, a, &s, cw_sun_day_sky(&s, d), &to, &all, error)) &&
        io_output_commit(&to, error);
    io_output_discard(&to);
    progress_end();
    if (good && a->suns) command_wrote(p->name, p->quiet, p->output, p->start, "the suns of %s at a place", a->suns);
    if (good && !a->suns)
        command_wrote(p->name, p->quiet, p->output, p->start, "%zu day%s at a place, %.0f hours of sun, %.4g kWh/m2",
                      a->days, a->days == 1 ? "" : "s", all.all.hours, 1e-3 * (all.all.direct + all.all.diffuse));
    cw_sight_bounds_destroy(bounds);
    return good;
}
