/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/agree.h"

#include <math.h>
#include <string.h>

static const char *const reason_names[AGREE_REASON_COUNT] = {"end", "edge", "grazing", "unjudged", "other"};

const char *agree_reason_name(agree_reason reason) { return reason_names[reason]; }

/* How uncertain rounding makes a ray's hits on a field. */
typedef struct slack {
    double unit;   /* one rounding of the largest coordinate */
    double length; /* of dir: t times this is a distance */
} slack;

static slack slack_of(const cw_field_info *info, const cw_ray *ray) {
    double scale = (double)(info->nx > info->ny ? info->nx : info->ny) - 1;
    scale = fmax(scale, fmax(fabs((double)info->low), fabs((double)info->high)));
    double squares = 0;
    for (int k = 0; k < 3; k++) {
        scale = fmax(scale, fabs((double)ray->org[k]));
        squares += (double)ray->dir[k] * (double)ray->dir[k];
    }
    return (slack){.unit = scale * 0x1p-24, .length = sqrt(squares)};
}

/* Cosine between the ray and the normal of the triangle hit, in field space. */
static double cosine(const cw_field *field, const cw_ray *ray, const cw_hit *hit, double length) {
    const size_t i = (size_t)hit->i, j = (size_t)hit->j;
    const double h00 = (double)cw_field_row(field, j)[i], h11 = (double)cw_field_row(field, j + 1)[i + 1];
    const bool a = hit->triangle == CW_TRIANGLE_A;
    const double other = (double)(a ? cw_field_row(field, j)[i + 1] : cw_field_row(field, j + 1)[i]);
    const double sx = a ? other - h00 : h11 - other, sy = a ? h11 - other : other - h00;
    const double dot = (double)ray->dir[2] - sx * (double)ray->dir[0] - sy * (double)ray->dir[1];
    return fabs(dot) / (length * sqrt(1 + sx * sx + sy * sy));
}

/* Why this hit might be missed. */
static agree_reason reason_of(const cw_field *field, const cw_ray *ray, const cw_hit *hit, slack s) {
    const double bound = AGREE_ROUNDINGS * s.unit, c = cosine(field, ray, hit, s.length);
    if (!(c * fabs((double)hit->t) >= 0)) return AGREE_OTHER; /* NaN */
    if (AGREE_PLACE <= bound) return AGREE_UNJUDGED;
    const double from_start = fabs((double)hit->t - (double)ray->tmin),
                 to_end = fabs((double)ray->tmax - (double)hit->t);
    if (fmin(from_start, to_end) * s.length * c <= bound) return AGREE_END;
    if (!(c * AGREE_PLACE > bound)) return AGREE_GRAZING;
    const double edge = fmin(fmin((double)hit->u, (double)hit->v), 1 - (double)hit->u - (double)hit->v);
    return edge <= bound / c ? AGREE_EDGE : AGREE_OTHER;
}

void agree_closest(agreement *sum, const cw_field *field, const cw_ray *rays, size_t n, const cw_hit *a,
                   const cw_hit *b) {
    const cw_field_info info = cw_field_describe(field);
    sum->rays += n;
    for (size_t k = 0; k < n; k++) {
        const bool hit_a = a[k].i >= 0, hit_b = b[k].i >= 0;
        sum->hits_a += hit_a;
        sum->hits_b += hit_b;
        if (memcmp(&a[k], &b[k], sizeof *a) == 0) {
            sum->same_bits++;
            continue;
        }
        if (!hit_a && !hit_b) continue;
        const slack s = slack_of(&info, &rays[k]);
        if (hit_a != hit_b) {
            *(hit_a ? &sum->only_a : &sum->only_b) += 1;
            sum->why[reason_of(field, &rays[k], hit_a ? &a[k] : &b[k], s)]++;
            continue;
        }
        const double flatter = fmin(cosine(field, &rays[k], &a[k], s.length), cosine(field, &rays[k], &b[k], s.length));
        const double apart = fabs((double)a[k].t - (double)b[k].t) * s.length * flatter / s.unit;
        const bool other = a[k].i != b[k].i || a[k].j != b[k].j || a[k].triangle != b[k].triangle;
        if (!(apart <= AGREE_ROUNDINGS) || (other && AGREE_PLACE <= AGREE_ROUNDINGS * s.unit)) {
            const cw_hit *nearer = a[k].t < b[k].t ? &a[k] : &b[k];
            sum->far++;
            sum->why[isnan(apart) ? AGREE_OTHER : reason_of(field, &rays[k], nearer, s)]++;
        } else
            sum->other_triangle += other;
    }
}

void agree_any(agreement *sum, const cw_field *field, const cw_ray *rays, size_t n, const uint8_t *a, const uint8_t *b,
               const contender *of_a, const contender *of_b) {
    const cw_field_info info = cw_field_describe(field);
    sum->rays += n;
    for (size_t k = 0; k < n; k++) {
        sum->hits_a += a[k];
        sum->hits_b += b[k];
        if (a[k] == b[k]) {
            sum->same_bits++;
            continue;
        }
        *(a[k] ? &sum->only_a : &sum->only_b) += 1;
        cw_hit hit;
        const contender *of = a[k] ? of_a : of_b;
        of->closest(of, &rays[k], 1, &hit);
        /* A contender that answers "any" against its own closest hit is wrong without any comparison. */
        sum->why[hit.i < 0 ? AGREE_OTHER : reason_of(field, &rays[k], &hit, slack_of(&info, &rays[k]))]++;
    }
}
