/* SPDX-License-Identifier: Apache-2.0 */
#include "workload/ray_classes.h"
#include "cellwalk_expert.h"

#include "stability/aimed.h"
#include "workload/fractal_terrain.h"

#include <math.h>
#include <stdlib.h>

static const struct {
    const char *name;
    bool any, coherent;
} classes[WORKLOAD_NAMES] = {
    [WORKLOAD_PRIMARY] = {"primary", false, true}, [WORKLOAD_SHADOW] = {"shadow", true, true},
    [WORKLOAD_AO] = {"ao", true, false},           [WORKLOAD_BOUNCE] = {"bounce", false, false},
    [WORKLOAD_RANDOM] = {"random", false, false},  [WORKLOAD_GRAZING] = {"grazing", false, false},
    [WORKLOAD_AFAR] = {"afar", false, true},       [WORKLOAD_VERTICES] = {"vertices", false, false},
    [WORKLOAD_EDGES] = {"edges", false, false},    [WORKLOAD_WITHIN_TWO] = {"within-2", false, false},
    [WORKLOAD_BESIDE] = {"beside", false, false},
};

const char *workload_class_name(workload_class c) { return (unsigned)c < WORKLOAD_NAMES ? classes[c].name : NULL; }
bool workload_class_is_any(workload_class c) { return classes[c].any; }
bool workload_class_is_coherent(workload_class c) { return classes[c].coherent; }

/* Number stream of a class: the second input of the hash, beside the ray's number. */
enum { STREAM_AO = 100, STREAM_BOUNCE = 200, STREAM_RANDOM = 300 };
enum { STREAM_GRAZING = 400, STREAM_SHORT = 500, STREAM_BESIDE = 600 };

/* Uniform in (0, 1), never an end. */
static double uniform(uint32_t seed, size_t ray, uint32_t stream) {
    return ((double)terrain_hash(seed, (uint32_t)ray, stream) + 0.5) * 0x1p-32;
}

static cw_ray make_ray(const double org[3], const double dir[3]) {
    const double length = sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
    cw_ray ray = {.tmin = 0, .tmax = INFINITY};
    for (int k = 0; k < 3; k++) {
        ray.org[k] = (float)org[k];
        ray.dir[k] = (float)(dir[k] / length);
    }
    return ray;
}

/* ---- primary ---- */

enum { VIEW = 1024, VIEW_TILES = VIEW / 4, TILE_RUN = 32 };

/* Stands over the middle of the field's near side and looks along +y. The look is tilted by shearing the view down, not
 * by turning it, so that no angle is needed. */
typedef struct camera {
    double eye[3];
    double down;
} camera;

static cw_ray camera_ray(const camera *c, double px, double py) {
    const double tan_half = 0.57735; /* 60 degrees from side to side */
    const double dir[3] = {(px / VIEW * 2 - 1) * tan_half, 1, (1 - py / VIEW * 2) * tan_half - c->down};
    return make_ray(c->eye, dir);
}

/* Tilts the view until half of a coarse raster of its pixels are sky. */
static camera camera_place(const cw_field *field, const cw_run *query) {
    enum { COARSE = 32 };
    const cw_field_info info = cw_field_describe(field);
    const double side = (double)((info.nx > info.ny ? info.nx : info.ny) - 1);
    camera c = {.eye = {NAN}};
    double least = INFINITY; /* from there: the nearest sample that is no hole */
    for (size_t j = 0; j < info.ny; j++)
        for (size_t i = 0; i < info.nx; i++) {
            const double x = (double)i - (double)((info.nx - 1) / 2), y = (double)j - (double)((info.ny - 1) / 50);
            const double z = (double)cw_field_row(field, j)[i];
            if (!(x * x + y * y < least && isfinite(z))) continue;
            least = x * x + y * y;
            c = (camera){.eye = {(double)i, (double)j, z + 0.04 * side}};
        }

    double low = -1, high = 1; /* the whole field lies below the view's axis at -1, above it at 1 */
    for (int step = 0; step < 12; step++) {
        c.down = (low + high) / 2;
        cw_ray rays[COARSE];
        cw_hit hits[COARSE];
        size_t sky = 0;
        for (int y = 0; y < COARSE; y++) {
            for (int x = 0; x < COARSE; x++)
                rays[x] = camera_ray(&c, (x + 0.5) * VIEW / COARSE, (y + 0.5) * VIEW / COARSE);
            if (cw_closest(field, query, rays, COARSE, hits) != CW_OK) return c;
            for (int x = 0; x < COARSE; x++) sky += hits[x].i < 0;
        }
        if (sky * 2 > (size_t)COARSE * COARSE)
            low = c.down;
        else
            high = c.down;
    }
    return c;
}

/* The ray through the place (x, y) of a view, in pixels; tile: number of its tile among those made. */
typedef cw_ray view_ray(const void *view, size_t tile, double x, double y);

/* Whole tiles of a view, at most n rays of them: runs of neighbouring tiles at equal distances, counted along the rows
 * of tiles; each row is turned round by another amount, or equal distances would pick the same columns each time. */
static size_t view_rays(const void *view, view_ray *ray, size_t n, cw_ray *rays) {
    enum { ROW_RUNS = VIEW_TILES / TILE_RUN };
    const size_t all = (size_t)VIEW_TILES * VIEW_TILES, tiles = n / WORKLOAD_TILE < all ? n / WORKLOAD_TILE : all;
    const size_t runs = (tiles + TILE_RUN - 1) / TILE_RUN;
    for (size_t k = 0; k < tiles; k++) {
        const size_t slot = (2 * (k / TILE_RUN) + 1) * (all / TILE_RUN) / (2 * runs), row = slot / ROW_RUNS;
        const size_t column = (slot + terrain_hash(0, (uint32_t)row, 0)) % ROW_RUNS;
        const size_t x0 = (column * TILE_RUN + k % TILE_RUN) * 4, y0 = row * 4;
        for (size_t p = 0; p < WORKLOAD_TILE; p++)
            rays[k * WORKLOAD_TILE + p] = ray(view, k, (double)(x0 + p % 4) + 0.5, (double)(y0 + p / 4) + 0.5);
    }
    return tiles * WORKLOAD_TILE;
}

static cw_ray primary_ray(const void *view, size_t tile, double x, double y) {
    (void)tile;
    return camera_ray(view, x, y);
}

static size_t primary(const cw_field *field, const cw_run *query, size_t n, cw_ray *rays) {
    const camera c = camera_place(field, query);
    return view_rays(&c, primary_ray, n, rays);
}

/* ---- afar ---- */

/* The whole field. Odd runs of tiles look in parallel, the others from one place. */
static cw_ray afar_ray(const void *view, size_t tile, double x, double y) {
    const cw_field_info *info = view;
    const double width = (double)(info->nx - 1), depth = (double)(info->ny - 1);
    const double away = 1000 * fmax(width, depth) * 0.70710678118654757,
                 z = ((double)info->low + (double)info->high) / 2;
    const double to[3] = {x / VIEW * width, y / VIEW * depth, z};
    const bool parallel = tile / TILE_RUN % 2;
    const double org[3] = {parallel ? to[0] : width / 2, (parallel ? to[1] : depth / 2) - away, z + away};
    double dir[3];
    for (int k = 0; k < 3; k++) dir[k] = to[k] - (parallel ? org[k] : (double)(float)org[k]);
    return make_ray(org, dir);
}

/* ---- secondary ---- */

/* Where the ray meets the plane of the triangle hit, and the triangle's normal, in double from ray and samples: of the
 * hit only the triangle counts, so that the rays outlive changes in the last bits of t, u and v. */
static void meet(const cw_field *field, const cw_ray *ray, const cw_hit *hit, double point[3], double normal[3]) {
    const size_t i = (size_t)hit->i, j = (size_t)hit->j;
    const double h00 = (double)cw_field_row(field, j)[i], h11 = (double)cw_field_row(field, j + 1)[i + 1];
    const bool a = hit->triangle == CW_TRIANGLE_A;
    const double h = (double)(a ? cw_field_row(field, j)[i + 1] : cw_field_row(field, j + 1)[i]);
    const double sx = a ? h - h00 : h11 - h, sy = a ? h11 - h : h - h00, length = sqrt(1 + sx * sx + sy * sy);
    const double above =
        (double)ray->org[2] - h00 - sx * ((double)ray->org[0] - (double)i) - sy * ((double)ray->org[1] - (double)j);
    const double falling = sx * (double)ray->dir[0] + sy * (double)ray->dir[1] - (double)ray->dir[2];
    for (int k = 0; k < 3; k++) point[k] = (double)ray->org[k] + above / falling * (double)ray->dir[k];
    normal[0] = -sx / length;
    normal[1] = -sy / length;
    normal[2] = 1 / length;
}

/* A direction about the unit normal, with probability in proportion to the cosine (Malley: a uniform point of the unit
 * disc, lifted to the half sphere). The frame is that of Duff et al. 2017, which needs no angle either. */
static void cosine_direction(const double n[3], uint32_t seed, size_t ray, uint32_t stream, double dir[3]) {
    double a = 0, b = 0, r2 = 0;
    for (uint32_t attempt = 0; attempt < 32; attempt++) { /* all fail once in 10^21 rays: then the normal itself */
        a = uniform(seed, ray, stream + 2 * attempt) * 2 - 1;
        b = uniform(seed, ray, stream + 2 * attempt + 1) * 2 - 1;
        r2 = a * a + b * b;
        if (r2 < 1) break;
        a = b = r2 = 0;
    }
    const double up = sqrt(1 - r2), sign = n[2] < 0 ? -1 : 1;
    const double p = -1 / (sign + n[2]), q = n[0] * n[1] * p;
    const double s[3] = {1 + sign * n[0] * n[0] * p, sign * q, -sign * n[0]};
    const double t[3] = {q, sign + n[1] * n[1] * p, -n[1]};
    for (int k = 0; k < 3; k++) dir[k] = a * s[k] + b * t[k] + up * n[k];
}

static size_t secondary(const cw_field *field, const cw_run *query, workload_class c, uint32_t seed, size_t n,
                        cw_ray *rays) {
    static const double sun[3] = {0.8, 0.6, 0.22};
    const cw_field_info info = cw_field_describe(field);
    /* Origins leave the surface by 16 times the rounding of the largest coordinate, so that a ray hits its own cell
     * only where the surface stands in its way. */
    const double offset = (double)(info.nx > info.ny ? info.nx : info.ny) * 0x1p-21;
    /* Half of the view is sky up to the coarseness of the camera's search; the surplus makes up for that. */
    size_t views = (n + n / 16) * 2 + WORKLOAD_TILE * TILE_RUN;
    if (views > WORKLOAD_PRIMARY_MAX) views = WORKLOAD_PRIMARY_MAX;
    cw_ray *view = malloc(views * sizeof *view);
    cw_hit *hits = malloc(views * sizeof *hits);
    size_t made = 0;
    if (view && hits) {
        views = primary(field, query, views, view);
        if (cw_closest(field, query, view, views, hits) != CW_OK) views = 0;
        for (size_t k = 0; k < views && made < n; k++) {
            if (hits[k].i < 0) continue;
            double point[3], normal[3], dir[3];
            meet(field, &view[k], &hits[k], point, normal);
            if (c == WORKLOAD_SHADOW)
                for (int a = 0; a < 3; a++) dir[a] = sun[a];
            else
                cosine_direction(normal, seed, made, c == WORKLOAD_AO ? STREAM_AO : STREAM_BOUNCE, dir);
            for (int a = 0; a < 3; a++) point[a] += offset * normal[a];
            rays[made++] = make_ray(point, dir);
        }
    }
    free(view);
    free(hits);
    return made;
}

/* To a place on the surface, from half to two cells before it, about the normal as ambient occlusion goes. */
static cw_ray short_ray(const cw_field *field, const cw_field_info *info, uint32_t seed, size_t k) {
    const cw_ray up = {.org = {(float)(uniform(seed, k, STREAM_SHORT) * (double)(info->nx - 1)),
                               (float)(uniform(seed, k, STREAM_SHORT + 1) * (double)(info->ny - 1))},
                       .dir = {0, 0, 1}};
    const double away = 0.5 + uniform(seed, k, STREAM_SHORT + 2) * 1.5;
    double org[3], normal[3], dir[3];
    cw_hit hit = {.i = -1};
    cw_surface_at(field, NULL, (double[2]){(double)up.org[0], (double)up.org[1]}, 1, &hit);
    if (hit.i < 0) return (cw_ray){.org = {NAN}}; /* a hole */
    meet(field, &up, &hit, org, normal);
    cosine_direction(normal, seed, k, STREAM_SHORT + 3, dir);
    for (int c = 0; c < 3; c++) {
        org[c] += away * dir[c];
        dir[c] = -dir[c];
    }
    return make_ray(org, dir);
}

/* ---- from outside ---- */

static cw_ray random_ray(const cw_field_info *info, uint32_t seed, size_t k) {
    const double low[3] = {0, 0, (double)info->low};
    const double high[3] = {(double)(info->nx - 1), (double)(info->ny - 1), (double)info->high};
    double org[3], dir[3], back = INFINITY;
    for (uint32_t a = 0; a < 3; a++) {
        org[a] = low[a] + uniform(seed, k, STREAM_RANDOM + a) * (high[a] - low[a]);
        dir[a] = low[a] + uniform(seed, k, STREAM_RANDOM + 3 + a) * (high[a] - low[a]) - org[a];
        /* How far back along the line the box begins. */
        if (dir[a] != 0) back = fmin(back, (dir[a] > 0 ? org[a] - low[a] : org[a] - high[a]) / dir[a]);
    }
    if (back < INFINITY)
        for (int a = 0; a < 3; a++) org[a] -= back * dir[a];
    return make_ray(org, dir);
}

static cw_ray grazing_ray(const cw_field_info *info, uint32_t seed, size_t k) {
    const double tan_1_degree = 0.017455;
    const double width = (double)(info->nx - 1), depth = (double)(info->ny - 1);
    const uint32_t side = terrain_hash(seed, (uint32_t)k, STREAM_GRAZING) & 3;
    const double a = uniform(seed, k, STREAM_GRAZING + 1), b = uniform(seed, k, STREAM_GRAZING + 2);
    const bool along_y = side & 1, backward = side & 2;
    const double near_end = backward ? 1 : 0, far_end = 1 - near_end;
    double org[3] = {width * (along_y ? a : near_end), depth * (along_y ? near_end : a), 0};
    double dir[3] = {width * (along_y ? b : far_end) - org[0], depth * (along_y ? far_end : b) - org[1], 0};
    dir[2] = (uniform(seed, k, STREAM_GRAZING + 3) * 2 - 1) * tan_1_degree * sqrt(dir[0] * dir[0] + dir[1] * dir[1]);
    /* Half way across the ray is at a height that the field has. */
    const double height = uniform(seed, k, STREAM_GRAZING + 4);
    org[2] = (double)info->low + height * ((double)info->high - (double)info->low) - dir[2] / 2;
    return make_ray(org, dir);
}

/* The plane through three corners of the field, at z + slope[0] x + slope[1] y, and the heights of samples over it. */
typedef struct corner_plane {
    double z, slope[2], low, high;
} corner_plane;

static corner_plane plane_of(const cw_field *field, const cw_field_info *info) {
    const size_t right = info->nx - 1, top = info->ny - 1;
    const double z = (double)cw_field_row(field, 0)[0];
    corner_plane p = {.z = z, .low = INFINITY, .high = -INFINITY};
    p.slope[0] = ((double)cw_field_row(field, 0)[right] - z) / (double)right;
    p.slope[1] = ((double)cw_field_row(field, top)[0] - z) / (double)top;
    for (size_t j = 0; j < info->ny; j++)
        for (size_t i = 0; i < info->nx; i++) {
            const double over =
                (double)cw_field_row(field, j)[i] - (z + p.slope[0] * (double)i + p.slope[1] * (double)j);
            p.low = fmin(p.low, over);
            p.high = fmax(p.high, over);
        }
    return p;
}

static cw_ray beside_ray(const corner_plane *p, const cw_field_info *info, uint32_t seed, size_t k) {
    static const double distance[4] = {1e-2, 1e-3, 1e-4, 1e-5};
    const double side[2] = {(double)(info->nx - 1), (double)(info->ny - 1)};
    const bool along = k % 4 == 3;
    double org[3] = {0, 0, p->z}, dir[3] = {1, 0, 0};
    for (uint32_t a = 0; a < 2; a++) {
        org[a] = uniform(seed, k, STREAM_BESIDE + a) * side[a];
        if (!along) dir[a] = uniform(seed, k, STREAM_BESIDE + 2 + a) * side[a] - org[a];
    }
    if (along) org[0] = 0;
    const double away = distance[k / 4 % 4], share = uniform(seed, k, STREAM_BESIDE + 4);
    org[2] += along ? p->low + share * (p->high - p->low) : p->high + (k / 16 % 2 ? -away : away);
    for (int a = 0; a < 2; a++) {
        org[2] += p->slope[a] * org[a];
        dir[2] += p->slope[a] * dir[a];
    }
    return make_ray(org, dir);
}

static size_t aimed(const cw_field *field, workload_class c, uint32_t seed, size_t n, cw_ray *rays) {
    aimed_field f = aimed_field_of(field);
    f.bounded = true; /* or errors would tell how far rays come from, not how they meet the surface */
    random_state r = {(uint64_t)seed << 8 | (unsigned)c};
    for (size_t k = 0; k < n; k++) {
        const aim edge = k % 3 ? AIM_EDGE : AIM_DIAGONAL;
        rays[k] = aimed_ray_make(c == WORKLOAD_EDGES ? edge : AIM_VERTEX, START_OVER, &f, &r).ray;
    }
    return n;
}

static size_t make(const cw_field *field, workload_class c, uint32_t seed, size_t n, cw_ray *rays) {
    /* One fixed kernel and leaf test, so that the rays do not change when a better kernel becomes the default. */
    const cw_run query = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = CW_LEAF_WATERTIGHT};
    const cw_field_info info = cw_field_describe(field);
    if (c == WORKLOAD_PRIMARY) return primary(field, &query, n, rays);
    if (c == WORKLOAD_AFAR) return view_rays(&info, afar_ray, n, rays);
    if (c < WORKLOAD_RANDOM) return secondary(field, &query, c, seed, n, rays);
    if (c == WORKLOAD_VERTICES || c == WORKLOAD_EDGES)
        return info.nx >= 4 && info.ny >= 4 ? aimed(field, c, seed, n, rays) : 0;
    if (c == WORKLOAD_BESIDE) {
        const corner_plane p = plane_of(field, &info);
        for (size_t k = 0; k < n; k++) rays[k] = beside_ray(&p, &info, seed, k);
        return n;
    }
    for (size_t k = 0; k < n; k++)
        rays[k] = c == WORKLOAD_WITHIN_TWO ? short_ray(field, &info, seed, k)
                  : c == WORKLOAD_RANDOM   ? random_ray(&info, seed, k)
                                           : grazing_ray(&info, seed, k);
    return n;
}

size_t workload_rays_make(const cw_field *field, workload_class c, uint32_t seed, size_t n, cw_ray *rays) {
    const size_t made = make(field, c, seed, n, rays);
    size_t kept = 0;
    for (size_t k = 0; k < made; k++) {
        double zero = 0;
        for (int a = 0; a < 3; a++) zero += 0 * ((double)rays[k].org[a] + (double)rays[k].dir[a]);
        if (zero == 0) rays[kept++] = rays[k];
    }
    return kept;
}
