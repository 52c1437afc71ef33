/* SPDX-License-Identifier: Apache-2.0 */
#include "surface.h"

#include "float3.h"

#include <string.h>

/* ---- cylinders ---------------------------------------------------------------------------------------------------- */

/* |o + t d|² - 1 in the cylinder's x and y is a t² + 2 half t + c. */
typedef struct quadratic {
    double a, half, c;
} quadratic;

static quadratic cylinder_quadratic(const cylinder *shape, const cw_user_ray *ray) {
    const double(*m)[4] = shape->to_object.m;
    const double ox = dot(m[0], ray->org) + m[0][3], oy = dot(m[1], ray->org) + m[1][3];
    const double dx = dot(m[0], ray->dir), dy = dot(m[1], ray->dir);
    return (quadratic){dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy - 1};
}

static bool cylinder_holds(const cylinder *shape, const cw_user_ray *ray, double t) {
    const double *row = shape->to_object.m[2];
    return t >= ray->tmin && t <= ray->tmax && fabs(dot(row, ray->org) + row[3] + t * dot(row, ray->dir)) <= 1;
}

double cylinder_hit(const cylinder *shape, const cw_user_ray *ray) {
    const quadratic f = cylinder_quadratic(shape, ray);
    const double square = f.half * f.half - f.a * f.c;
    if (!(f.a > 0) || !(square >= 0)) return INFINITY;
    /* The sum that does not cancel; one root is q / a, the other c / q. */
    const double q = f.half < 0 ? sqrt(square) - f.half : -sqrt(square) - f.half;
    /* From inside, the nearer root lies behind. */
    if (!(f.c < 0 && ray->tmin >= 0)) {
        const double near = f.half < 0 ? f.c / q : q / f.a;
        if (cylinder_holds(shape, ray, near)) return near;
    }
    const double far = f.half < 0 ? q / f.a : f.c / q;
    return cylinder_holds(shape, ray, far) ? far : INFINITY;
}

bool cylinder_blocks(const cylinder *shape, const cw_user_ray *ray) {
    /* The inside is convex: a segment with both ends inside stays there. */
    const quadratic f = cylinder_quadratic(shape, ray);
    const double t0 = ray->tmin, t1 = ray->tmax;
    if ((f.a * t0 + 2 * f.half) * t0 + f.c < 0 && (f.a * t1 + 2 * f.half) * t1 + f.c < 0) return false;
    return cylinder_hit(shape, ray) < INFINITY;
}

void surface_of_cylinder(const cylinder *c, const cw_user_ray *ray, double t, surface *s) {
    const double(*m)[4] = c->to_object.m;
    for (int k = 0; k < 3; k++) s->point[k] = ray->org[k] + t * ray->dir[k];
    for (int r = 0; r < 3; r++) s->object[r] = (float)(dot(m[r], s->point) + m[r][3]);
    /* (x, y, 0) by the transposed inverse. */
    for (int k = 0; k < 3; k++) s->normal[k] = s->object[0] * c->linear[0][k] + s->object[1] * c->linear[1][k];
    float3_normalise(s->normal);
    memcpy(s->shading, s->normal, sizeof s->shading);
    s->offset = surface_offset_cylinder * t;
}

static const float by_whole_turn = 0.159154943f;

/* The angle of (x, y) as a share of the whole turn, in [-1/2, 1/2], to 2^-22: a tenth of a texel where an image is 400000
 * texels wide. x and y are on the unit circle, so that no size needs care; the polynomial is within 4·10^-8 of
 * atan(x) / 2 pi on [0, 1], with the least error that its degree allows. */
static float turn_of(float x, float y) {
    static const float coefficient[7] = {0.159154326f,  -0.0530262291f,  0.0315250382f, -0.0210612342f,
                                         0.0126720183f, -0.00534788379f, 0.00108400721f};
    const float ax = fabsf(x), ay = fabsf(y);
    const float tangent = ax > ay ? ay / ax : ax / ay, square = tangent * tangent;
    float sum = 0;
    for (int k = 6; k >= 0; k--) sum = sum * square + coefficient[k];
    float turn = tangent * sum;
    if (ay >= ax) turn = 0.25f - turn;
    if (x < 0) turn = 0.5f - turn;
    return y < 0 ? -turn : turn;
}

void surface_uv_of_cylinder(const surface *s, float uv[2]) {
    uv[0] = turn_of(s->object[0], s->object[1]); /* images repeat: [-1/2, 0) is as good as [1/2, 1) */
    uv[1] = (s->object[2] + 1) / 2;
}

void surface_uv_change_on_cylinder(const cylinder *c, const surface *s, float change[2][3], float uv_change[2][2]) {
    for (int k = 0; k < 2; k++) {
        float d[3];
        for (int r = 0; r < 3; r++) d[r] = float3_dot(c->linear[r], change[k]);
        uv_change[k][0] = (s->object[0] * d[1] - s->object[1] * d[0]) * by_whole_turn;
        uv_change[k][1] = d[2] / 2;
    }
}

/* ---- height fields ------------------------------------------------------------------------------------------------ */

void surface_of_field(const heightfield *h, const cw_hit *hit, bool phong, surface *s, float turn[2][3]) {
    double normal[3];
    cw_hit_point(h->field, hit, s->point);
    cw_hit_normal(h->field, hit, normal);
    float3_from(normal, s->normal);
    s->offset = surface_offset_field * (double)hit->t;
    if (!phong) {
        memcpy(s->shading, s->normal, sizeof s->shading);
        if (turn != NULL) memset(turn, 0, 2 * sizeof *turn);
        return;
    }
    if (turn == NULL) {
        cw_hit_phong_normal(h->field, hit, normal);
    } else {
        double change[2][3];
        cw_hit_phong_change(h->field, hit, normal, change);
        for (int c = 0; c < 3; c++) {
            turn[0][c] = (float)change[0][c] * (float)(h->nx - 1);
            turn[1][c] = (float)change[1][c] * (float)(h->ny - 1);
        }
    }
    float3_from(normal, s->shading);
}

void surface_uv_of_field(const heightfield *h, const cw_hit *hit, float uv[2]) { cw_hit_uv(h->field, hit, uv); }

void surface_uv_change_on_field(const heightfield *h, float change[2][3], float uv_change[2][2]) {
    for (int k = 0; k < 2; k++)
        for (int r = 0; r < 2; r++) uv_change[k][r] = float3_dot(h->to_uv[r], change[k]);
}
