/* SPDX-License-Identifier: Apache-2.0 */
#include "drape.h"

#include "../cancel.h"
#include "half.h"

#include <math.h>
#include <string.h>
#include <strings.h>

/* Texels a side at most: more than most pictures show of them. Heights change slowly enough for half as many. */
enum { SIDE_MOST = 4096 };

static bool begin(io_image *image, double width, double height, bool by_height, io_error *error) {
    const double most = by_height ? SIDE_MOST / 2 : SIDE_MOST;
    const size_t columns = (size_t)fmax(1, fmin(most, ceil(width))), rows = (size_t)fmax(1, fmin(most, ceil(height)));
    return io_image_allocate(image, columns, rows, by_height, "the field's colours", error);
}

/* The place in the field that a texel shows. */
static double place(size_t texel, size_t texels, size_t samples) {
    return ((double)texel + 0.5) / (double)texels * (double)(samples - 1);
}

/* ---- by height ---------------------------------------------------------------------------------------------------- */

/* Linear light at even steps of height. */
enum { STEPS = 4 };
static const float tints[STEPS + 1][3] = {
    {0.10f, 0.24f, 0.08f}, {0.34f, 0.40f, 0.14f}, {0.50f, 0.37f, 0.18f}, {0.38f, 0.30f, 0.25f}, {0.92f, 0.92f, 0.95f}};

static void tint(double height, double low, double high, uint16_t rgba[4]) {
    const double x = high > low && height > low ? fmin((height - low) / (high - low), 1) * STEPS : 0;
    const int step = x < STEPS ? (int)x : STEPS - 1;
    const float part = (float)(x - step);
    for (int c = 0; c < 3; c++)
        rgba[c] = half_from_float(tints[step][c] + part * (tints[step + 1][c] - tints[step][c]));
    rgba[3] = 0;
}

bool drape_heights(io_image *colours, const terrain *t, io_error *error) {
    const cw_field_info info = cw_field_describe(t->field);
    const double metres = terrain_metres_of_height(t), low = (double)info.low * metres,
                 high = (double)info.high * metres;
    if (!begin(colours, (double)(t->nx - 1), (double)(t->ny - 1), true, error)) return false;
    for (size_t y = 0; y < colours->height; y++)
        for (size_t x = 0; x < colours->width; x++)
            tint(terrain_height(t, place(x, colours->width, t->nx), place(y, colours->height, t->ny)), low, high,
                 colours->halves + ((colours->width + 2) * y + x + 1) * 4);
    return true;
}

/* ---- orthophotos -------------------------------------------------------------------------------------------------- */

/* The grey outside the orthophoto and at its holes. */
static const float bare = 0.4f;

typedef struct ortho {
    io_image *to;
    const terrain *terrain;
    bool several; /* bands */
} ortho;

static void note_bands(void *context, const char *text) {
    ortho *o = context;
    o->several |= strstr(text, "--band") != NULL; /* others are on heights */
}

static bool go_on(void *context, double share) {
    (void)context;
    (void)share;
    return !atomic_load(cancel_flag());
}

/* Field coordinates to columns and rows of the photo. */
static bool field_to_photo(const terrain *t, const io_raster *photo, double m[2][3]) {
    if (!photo->georef.placed) {
        /* Pixels are areas: the whole of them lies on the whole of the field. */
        const double n[2] = {(double)photo->nx / (double)(t->nx - 1), (double)photo->ny / (double)(t->ny - 1)};
        const double stretched[2][3] = {{n[0], 0, -0.5}, {0, n[1], -0.5}};
        memcpy(m, stretched, sizeof stretched);
        return true;
    }
    const double(*p)[4] = photo->map;
    const double a = p[0][0], b = p[0][1], c = p[1][0], d = p[1][1], determinant = a * d - b * c;
    const double back[2][2] = {{d / determinant, -b / determinant}, {-c / determinant, a / determinant}};
    if (!(isfinite(1 / determinant) && determinant != 0)) return false;
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 3; k++) {
            const int column = k < 2 ? k : 3;
            const double x = t->map[0][column] - (k == 2 ? p[0][3] : 0), y = t->map[1][column] - (k == 2 ? p[1][3] : 0);
            m[r][k] = back[r][0] * x + back[r][1] * y;
        }
    return true;
}

static void take_band(const ortho *o, const io_raster *photo, double m[2][3], int band, int bands) {
    const io_image *to = o->to;
    for (size_t y = 0; y < to->height; y++)
        for (size_t x = 0; x < to->width; x++) {
            const double i = place(x, to->width, o->terrain->nx), j = place(y, to->height, o->terrain->ny);
            const double column = nearbyint(m[0][0] * i + m[0][1] * j + m[0][2]);
            const double row = nearbyint(m[1][0] * i + m[1][1] * j + m[1][2]);
            const bool on = column >= 0 && row >= 0 && column < (double)photo->nx && row < (double)photo->ny;
            const float value = on ? photo->z[(size_t)row * photo->nx + (size_t)column] : NAN;
            for (int c = band; c < band + 3 / bands; c++) to->rgb[(y * to->width + x) * 3 + (size_t)c] = value;
        }
}

/* Values as screens show them (sRGB) to linear light. The largest tells whether they are shares, bytes or 16 bits. */
static void make_linear(io_image *image) {
    const size_t n = image->width * image->height * 3;
    float most = 0;
    for (size_t k = 0; k < n; k++) most = image->rgb[k] > most && !isinf(image->rgb[k]) ? image->rgb[k] : most;
    const double white = most <= 1 ? 1 : most <= 255 ? 255 : 65535;
    for (size_t k = 0; k < n; k++) {
        const double s = fmin(fmax((double)image->rgb[k] / white, 0), 1);
        const double linear = s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
        image->rgb[k] = isfinite(image->rgb[k]) ? (float)linear : bare;
    }
}

static bool same_crs(const char *path, const io_georef *photo, const io_georef *ground, io_error *error) {
    char of_photo[100], of_ground[100];
    io_georef_name(photo, of_photo, sizeof of_photo);
    io_georef_name(ground, of_ground, sizeof of_ground);
    if (!photo->placed || photo->crs == NULL || ground->crs == NULL || strcmp(of_photo, of_ground) == 0) return true;
    return io_fail(error, "%s: is on another map (%s) than the terrain (%s); gdalwarp -t_srs moves it", path, of_photo,
                   of_ground);
}

static bool read_band(ortho *o, const char *path, const io_georef *georef, int band, io_error *error) {
    const io_raster_options options = {
        .band = (unsigned)band, .warn = band ? NULL : note_bands, .progress = go_on, .context = o};
    io_raster photo;
    double m[2][3];
    if (!io_raster_read(path, &options, &photo, error)) return false;
    bool good = same_crs(path, &photo.georef, georef, error);
    if (good && !field_to_photo(o->terrain, &photo, m)) good = io_fail(error, "%s: its map cannot be inverted", path);
    if (good && band == 0) {
        const terrain *t = o->terrain;
        good = begin(o->to, hypot(m[0][0], m[1][0]) * (double)(t->nx - 1),
                     hypot(m[0][1], m[1][1]) * (double)(t->ny - 1), false, error);
    }
    if (good) take_band(o, &photo, m, band > 0 ? band - 1 : 0, o->several ? 3 : 1);
    io_raster_free(&photo);
    return good;
}

static bool is_picture(const char *path) {
    const char *ending = strrchr(path, '.');
    return ending && (strcasecmp(ending, ".exr") == 0 || strcasecmp(ending, ".pfm") == 0);
}

bool drape_image(io_image *colours, const char *path, const terrain *t, const io_georef *georef, io_error *error) {
    *colours = (io_image){0};
    if (is_picture(path)) return io_image_read(path, colours, error);
    ortho o = {.to = colours, .terrain = t};
    bool good = read_band(&o, path, georef, 0, error);
    for (int band = 2; good && o.several && band <= 3; band++) good = read_band(&o, path, georef, band, error);
    if (good)
        make_linear(colours);
    else
        io_image_free(colours);
    return good;
}
