/* SPDX-License-Identifier: Apache-2.0 */
#include "peers/peer.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <vector>

namespace {
/* The nearest triangle so far; Bullet names its cell. */
struct nearest : btTriangleRaycastCallback {
    int i = -1, j = -1;
    nearest(const btVector3 &from, const btVector3 &to) : btTriangleRaycastCallback(from, to) {}
    btScalar reportHit(const btVector3 &, btScalar fraction, int x, int y) override {
        i = x;
        j = y;
        return fraction;
    }
};

struct bullet {
    size_t nx, ny;
    double low, high;
    std::vector<float> z;
    std::unique_ptr<btHeightfieldTerrainShape> shape;
};

void *create(const cw_field *field, cw_isa, unsigned, struct io_error *) try {
    const cw_field_info info = cw_field_describe(field);
    std::unique_ptr<bullet> p(new bullet{info.nx, info.ny, info.low, info.high, {}, nullptr});
    for (size_t j = 0; j < info.ny; j++)
        p->z.insert(p->z.end(), cw_field_row(field, j), cw_field_row(field, j) + info.nx);
    /* Flipped quads have the diagonal from sample (i, j) to (i + 1, j + 1). */
    p->shape.reset(new btHeightfieldTerrainShape(static_cast<int>(info.nx), static_cast<int>(info.ny), p->z.data(),
                                                 info.low, info.high, 2, true));
    return p.release();
} catch (const std::bad_alloc &) {
    return nullptr;
}

void destroy(void *peer) { delete static_cast<bullet *>(peer); }

size_t bytes_of(const void *peer, double *) {
    const bullet *p = static_cast<const bullet *>(peer);
    return p->nx * p->ny * sizeof(float);
}

/* Bullet takes segments, about the middle of the field's box. Cut to the box in double, they lose least by rounding. */
cw_hit trace(const bullet *p, const cw_ray &ray) {
    cw_hit hit = {};
    hit.t = std::numeric_limits<float>::infinity();
    hit.i = hit.j = -1;
    const double high[3] = {double(p->nx - 1), double(p->ny - 1), p->high}, low[3] = {0, 0, p->low};
    double begin = ray.tmin, end = ray.tmax;
    for (int c = 0; c < 3; c++) {
        const double a = (low[c] - ray.org[c]) / ray.dir[c], b = (high[c] - ray.org[c]) / ray.dir[c];
        if (ray.dir[c] == 0 && (ray.org[c] < low[c] || ray.org[c] > high[c])) return hit;
        if (ray.dir[c] == 0) continue;
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    if (!(begin <= end)) return hit;
    btVector3 from, to;
    for (int c = 0; c < 3; c++) {
        from[c] = btScalar(ray.org[c] + begin * ray.dir[c] - (low[c] + high[c]) / 2);
        to[c] = btScalar(ray.org[c] + end * ray.dir[c] - (low[c] + high[c]) / 2);
    }
    nearest best(from, to);
    p->shape->performRaycast(&best, from, to);
    if (best.i < 0) return hit;
    const double t = begin + best.m_hitFraction * (end - begin);
    const double x = ray.org[0] + t * ray.dir[0] - best.i, y = ray.org[1] + t * ray.dir[1] - best.j;
    const bool upper = y > x;
    hit.t = float(t);
    hit.i = best.i;
    hit.j = best.j;
    hit.triangle = upper ? CW_TRIANGLE_B : CW_TRIANGLE_A;
    hit.u = float(upper ? x : x - y);
    hit.v = float(upper ? y - x : y);
    return hit;
}

void closest(const contender *c, const cw_ray *rays, size_t n, cw_hit *hits) {
    for (size_t k = 0; k < n; k++) hits[k] = trace(static_cast<const bullet *>(c->peer), rays[k]);
}

void any(const contender *c, const cw_ray *rays, size_t n, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) occluded[k] = trace(static_cast<const bullet *>(c->peer), rays[k]).i >= 0;
}

void enter(contender *c, const void *peer, unsigned width, bool) {
    std::memset(c, 0, sizeof *c);
    std::strcpy(c->name, "w1");
    c->width = c->threads = width;
    c->closest = closest;
    c->any = any;
    c->peer = peer;
}
} // namespace

const peer_kind peer_bullet = {"bullet", "libbullet-dev", "present", 0, {1},  {16, 16},
                               create,          destroy,   bytes_of,         enter};
