/* SPDX-License-Identifier: Apache-2.0 */
#include "view.h"

#include "command.h"
#include "half.h"
#include "landscape.h"
#include "suns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char name[] = "render";

enum { WIDTH = 1200, HEIGHT = 800, SAMPLES = 4 };
static const double usual_fov = 40, usual_sun[2] = {315, 40}, usual_eye = 2, usual_pitch = 30;
static const double sun_light = 0.85, sky_light = 0.3;
static const float horizon[3] = {0.70f, 0.80f, 0.93f}, above[3] = {0.16f, 0.34f, 0.70f},
                   plain[3] = {0.20f, 0.27f, 0.16f};

/* ---- places ------------------------------------------------------------------------------------------------------ */

bool view_check(view *v) {
    memcpy(v->sun_at, usual_sun, sizeof usual_sun);
    if (v->fov == 0) v->fov = usual_fov;
    if (v->from && !product_parse_place(name, v->from, usual_eye, &v->eye)) return false;
    if (v->to && !product_parse_place(name, v->to, 0, &v->target)) return false;
    if ((v->sun || v->time) && !product_parse_sun(name, v->sun, v->time, v->sun_at, &v->seconds)) return false;
    if (v->curvature > 0 && v->from == NULL)
        return command_refuse(name, "--curvature lowers the terrain around the eye: give the eye's place by --from");
    if (v->curvature > 0 && !isnan(v->water))
        return command_refuse(name, "--water is level and does not go with --curvature");
    return true;
}

/* Field space to metres east, north and up of the middle of the map, on a plane that touches the earth there. */
static void to_metres(const terrain *t, double map[3][4]) {
    const double i = 0.5 * (double)(t->nx - 1), j = 0.5 * (double)(t->ny - 1);
    double metres[2];
    cw_terrain_metres(t, i, j, metres);
    for (int r = 0; r < 3; r++) {
        const double scale = r < 2 ? metres[r] : 1;
        for (int c = 0; c < 3; c++) map[r][c] = t->map[r][c] * scale;
        map[r][3] = r < 2 ? -(map[r][0] * i + map[r][1] * j) : 0;
    }
}

static void put(double map[3][4], double i, double j, double z, double out[3]) {
    for (int r = 0; r < 3; r++) out[r] = map[r][0] * i + map[r][1] * j + map[r][2] * z + map[r][3];
}

static bool put_place(const view *v, double map[3][4], const io_place *p, double out[3], io_error *error) {
    double at[3];
    if (!ground_find_place(&v->ground.terrain, p, at, NULL, error)) return false;
    put(map, at[0], at[1], at[2] - sight_fall(&v->earth, at[0], at[1]), out);
    return true;
}

/* What rays meet. */
static const raster_field *surface(const view *v) { return v->lowered.field ? &v->lowered : &v->ground.file; }

/* From the south, and nearly as near as shows all of the terrain's box with the target in the middle. */
static void stand_back(const view *v, double map[3][4], double aspect, const double target[3], double eye[3]) {
    const cw_field_info info = cw_field_describe(surface(v)->field);
    double sine, cosine, away = 0;
    cw_terrain_sine_cosine(usual_pitch, &sine, &cosine);
    const double half = tan(v->fov * (3.141592653589793 / 360));
    const double wide = aspect > 1 ? half * aspect : half, high = aspect > 1 ? half : half / aspect;
    for (int k = 0; k < 8; k++) {
        double p[3];
        put(map, k & 1 ? (double)(info.nx - 1) : 0, k & 2 ? (double)(info.ny - 1) : 0,
            (double)(k & 4 ? info.high : info.low), p);
        for (int c = 0; c < 3; c++) p[c] -= target[c];
        const double forward = cosine * p[1] - sine * p[2], up = sine * p[1] + cosine * p[2];
        away = fmax(away, 1.1 * (fmax(fabs(p[0]) / wide, fabs(up) / high) - forward));
    }
    const double from[3] = {0, -cosine * away, sine * away};
    for (int c = 0; c < 3; c++) eye[c] = target[c] + from[c];
}

static bool aim(const view *v, landscape_desc *d, io_error *error) {
    const cw_field_info info = cw_field_describe(v->ground.terrain.field);
    if (info.low > info.high) return io_fail(error, "%s: all samples are holes", v->ground.path);
    if (v->to) {
        if (!put_place(v, d->to_world, &v->target, d->target, error)) return false;
    } else {
        const double i = 0.5 * (double)(info.nx - 1), j = 0.5 * (double)(info.ny - 1);
        put(d->to_world, i, j, 0.5 * ((double)info.low + (double)info.high) - sight_fall(&v->earth, i, j), d->target);
    }
    if (v->from) {
        if (!put_place(v, d->to_world, &v->eye, d->eye, error)) return false;
    } else {
        stand_back(v, d->to_world, (double)d->width / (double)d->height, d->target, d->eye);
    }
    const double way = hypot(hypot(d->eye[0] - d->target[0], d->eye[1] - d->target[1]), d->eye[2] - d->target[2]);
    return way > 0 || io_fail(error, "--from and --to are the same place");
}

static void shine(const view *v, landscape_desc *d) {
    double s[2], c[2];
    for (int k = 0; k < 2; k++) cw_terrain_sine_cosine(v->sun_at[k], &s[k], &c[k]);
    const double sun[3] = {s[0] * c[1], c[0] * c[1], s[1]};
    memcpy(d->sun, sun, sizeof sun);
    d->sun_light = v->sun_at[1] > 0 ? sun_light : 0;
    d->sky_light = sky_light;
    if (v->sun_at[1] <= 0)
        io_warn(&v->ground.watch.warn, "the sun is at %g degrees, not above the horizon", v->sun_at[1]);
    memcpy(d->horizon, horizon, sizeof horizon);
    memcpy(d->above, above, sizeof above);
    memcpy(d->plain, plain, sizeof plain);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* Texels a side at most: heights change slowly enough for as many. */
enum { TEXELS_MOST = 2048 };

/* Linear light at even steps of height. */
enum { TINT_STEPS = 4 };
static const float tints[TINT_STEPS + 1][3] = {
    {0.10f, 0.24f, 0.08f}, {0.34f, 0.40f, 0.14f}, {0.50f, 0.37f, 0.18f}, {0.38f, 0.30f, 0.25f}, {0.92f, 0.92f, 0.95f}};

static void tint(double height, double low, double high, uint16_t rgba[4]) {
    const double x = high > low && height > low ? fmin((height - low) / (high - low), 1) * TINT_STEPS : 0;
    const int step = x < TINT_STEPS ? (int)x : TINT_STEPS - 1;
    const float part = (float)(x - step);
    for (int c = 0; c < 3; c++)
        rgba[c] = half_from_float(tints[step][c] + part * (tints[step + 1][c] - tints[step][c]));
    rgba[3] = 0;
}

/* The place in the field that a texel shows. */
static double texel_place(size_t texel, size_t texels, size_t samples) {
    return ((double)texel + 0.5) / (double)texels * (double)(samples - 1);
}

/* Green at the lowest height, brown, white at the highest. */
static bool tint_heights(io_image *colours, const terrain *t, io_error *error) {
    const cw_field_info info = cw_field_describe(t->field);
    const double metres = terrain_metres_of_height(t);
    const double low = (double)info.low * metres, high = (double)info.high * metres;
    const size_t columns = t->nx - 1 < TEXELS_MOST ? t->nx - 1 : TEXELS_MOST;
    const size_t rows = t->ny - 1 < TEXELS_MOST ? t->ny - 1 : TEXELS_MOST;
    if (!io_image_allocate(colours, columns, rows, IO_IMAGE_PIXELS_MAX, "the field's colours", error)) return false;
    for (size_t y = 0; y < rows; y++)
        for (size_t x = 0; x < columns; x++)
            tint(cw_terrain_height(t, texel_place(x, columns, t->nx), texel_place(y, rows, t->ny)), low, high,
                 colours->halves + ((columns + 2) * y + x + 1) * 4);
    return true;
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

/* Smooth normals are made of neighbours, and the renderer takes them all for ground: where one is a hole, the mean of
 * those around it that are not stands in. */
static float *fill_holes(const float *z, size_t nx, size_t ny, io_error *error) {
    float *filled = malloc(nx * ny * sizeof *filled);
    if (filled == NULL) {
        io_fail(error, "out of memory");
        return NULL;
    }
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) {
            double sum = 0, count = 0;
            filled[j * nx + i] = z[j * nx + i];
            if (isfinite(z[j * nx + i])) continue;
            for (size_t y = j > 0 ? j - 1 : 0; y <= j + 1 && y < ny; y++)
                for (size_t x = i > 0 ? i - 1 : 0; x <= i + 1 && x < nx; x++) {
                    if (!isfinite(z[y * nx + x])) continue;
                    sum += (double)z[y * nx + x];
                    count++;
                }
            filled[j * nx + i] = count > 0 ? (float)(sum / count) : 0;
        }
    return filled;
}

static bool find_sun(view *v, io_error *error) {
    const ground *g = &v->ground;
    sun_place place;
    if (v->time == NULL) return true;
    if (!sun_place_of(&g->terrain, &g->about.georef, NULL, g->path, "give --sun", &place, error)) return false;
    const sun_position p = cw_sun_at_place(v->seconds, &place);
    v->sun_at[0] = p.azimuth;
    v->sun_at[1] = p.altitude;
    return true;
}

static bool make_scene(view *v, io_error *error) {
    landscape_desc d = {.field = surface(v)->field,
                        .samples = surface(v)->raster.z,
                        .nx = v->ground.terrain.nx,
                        .ny = v->ground.terrain.ny,
                        .field_of_view = v->fov,
                        .width = v->width ? v->width : WIDTH,
                        .height = v->height ? v->height : HEIGHT,
                        .samples_a_pixel = SAMPLES};
    to_metres(&v->ground.terrain, d.to_world);
    if (!aim(v, &d, error) || !find_sun(v, error)) return false;
    shine(v, &d);
    d.vault = v->sky;
    if (v->haze > 0) d.visibility = v->haze;
    const double water = v->water / terrain_metres_of_height(&v->ground.terrain);
    if (!isnan(water)) d.water_level = &water;
    if (!isnan(water) && d.eye[2] <= v->water)
        io_warn(&v->ground.watch.warn, "--water %g: not drawn, as the eye is at %g m, not above it", v->water,
                d.eye[2]);
    if (v->smooth && cw_field_describe(d.field).holes > 0) {
        d.samples = v->filled = fill_holes(d.samples, d.nx, d.ny, error);
        if (v->filled == NULL) return false;
    }
    io_image colours;
    if (!tint_heights(&colours, &v->ground.terrain, error)) return false;
    d.colours = &colours;
    v->scene = landscape_create(&d, error);
    if (v->scene == NULL) io_image_free(&colours);
    return v->scene != NULL;
}

/* A copy of the raster whose samples are lowered by the sight's curvature. */
static bool lower(const io_raster *raster, const sight *s, const char *path, io_raster *lowered, io_error *error) {
    *lowered = (io_raster){.nx = raster->nx, .ny = raster->ny};
    if (!io_raster_allocate(path, lowered, error)) return false;
    float *z = lowered->memory;
    for (size_t j = 0; j < raster->ny; j++)
        for (size_t i = 0; i < raster->nx; i++)
            z[j * raster->nx + i] =
                (float)((double)raster->z[j * raster->nx + i] - sight_fall(s, (double)i, (double)j));
    memcpy(lowered->map, raster->map, sizeof lowered->map);
    return true;
}

/* The terrain as it is, and as the eye sees it: lowered by the earth's curvature. */
static bool read_terrain(view *v, io_error *error) {
    ground *g = &v->ground;
    const bool lowers = v->curvature > 0;
    const cw_run query = g->query;
    double eye[3];
    if (lowers) g->query.expert.kernel = cw_kernel_find("cell"); /* no ray meets the flat one */
    if (!ground_open(g, error) || !ground_read(g, ground_all(g), true, error)) return false;
    if (!lowers) return true;
    if (!ground_find_place(&g->terrain, &v->eye, eye, NULL, error)) return false;
    cw_sight_init(&v->earth, &g->terrain, NULL, eye, v->curvature);
    return lower(&g->file.raster, &v->earth, g->path, &v->lowered.raster, error) &&
           raster_field_build(&v->lowered, g->path, &query, &g->watch, error);
}

bool view_open(view *v, const field_options *fields, const char *path, io_error *error) {
    ground *g = &v->ground;
    *g = (ground){.path = path,
                  .reading = fields->reading,
                  .coarser = fields->coarser,
                  .watch = fields->watch,
                  .query = fields->query,
                  .bytes = INFINITY};
    g->reading.north_up = true;
    if (v->quiet) g->watch = (ground_watch){0};
    if (!read_terrain(v, error) || !make_scene(v, error)) return false;
    if (v->lowered.field) raster_field_close(&g->file);
    return true;
}

void view_close(view *v) {
    scene_free(v->scene);
    free(v->filled);
    raster_field_close(&v->lowered);
    ground_close(&v->ground);
}
