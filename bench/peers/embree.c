/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"
#include "io_error.h"
#include "peers/peer.h"

#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- Embree 3 and 4: names, order of arguments, and how a query is told the kind of its rays ---- */

#if CELLWALK_EMBREE == 4
#include <embree4/rtcore.h>

typedef struct embree_query {
    struct RTCIntersectArguments closest;
    struct RTCOccludedArguments any;
} embree_query;

/* The last arguments of rtcIntersect and rtcOccluded, in their order. */
#define EMBREE_CLOSEST(query, rays) (rays), &(query)->closest
#define EMBREE_ANY(query, rays)     (rays), &(query)->any

static inline embree_query embree_query_of(bool coherent) {
    embree_query query;
    rtcInitIntersectArguments(&query.closest);
    rtcInitOccludedArguments(&query.any);
    query.closest.flags = query.any.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    return query;
}
#else
#include <embree3/rtcore.h>

typedef struct RTCIntersectContext embree_query;

#define EMBREE_CLOSEST(query, rays) (query), (rays)
#define EMBREE_ANY(query, rays)     (query), (rays)

static inline embree_query embree_query_of(bool coherent) {
    embree_query query;
    rtcInitIntersectContext(&query);
    query.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return query;
}
#endif

typedef struct embree {
    RTCDevice device;
    RTCScene scene;
    size_t nx, ny;
    bool grid;
    double cells_inverse; /* one over the cells of a row */
    double build_seconds;
    _Atomic int64_t bytes;
} embree;

/* ---- building ---- */

static bool count_memory(void *peer, ssize_t bytes, bool after) {
    (void)after;
    atomic_fetch_add(&((embree *)peer)->bytes, (int64_t)bytes);
    return true;
}

/* Vertices (i, j, height). Embree's grids split a quad along the diagonal that starts at its second corner, so for them
 * rows run backwards in i, which turns it into the diagonal of a cell. */
static bool add_vertices(RTCGeometry geometry, const cw_field *field, size_t nx, size_t ny, bool backwards) {
    float *v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof *v, nx * ny);
    if (v == NULL) return false;
    for (size_t j = 0; j < ny; j++)
        for (size_t k = 0; k < nx; k++, v += 3) {
            const size_t i = backwards ? nx - 1 - k : k;
            v[0] = (float)i;
            v[1] = (float)j;
            v[2] = cw_field_row(field, j)[i];
        }
    return true;
}

/* Triangle 2 · cell is A, 2 · cell + 1 is B, vertices in the order of cellwalk.h, so that u and v mean the same. */
static bool add_triangles(RTCGeometry geometry, size_t nx, size_t ny) {
    const size_t count = 2 * (nx - 1) * (ny - 1);
    unsigned *t = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof *t, count);
    if (t == NULL) return false;
    for (size_t j = 0; j + 1 < ny; j++)
        for (size_t i = 0; i + 1 < nx; i++, t += 6) {
            const unsigned p00 = (unsigned)(j * nx + i), p01 = p00 + (unsigned)nx;
            t[0] = p00, t[1] = p00 + 1, t[2] = p01 + 1;
            t[3] = p00, t[4] = p01 + 1, t[5] = p01;
        }
    return true;
}

static bool add_grid(RTCGeometry geometry, size_t nx, size_t ny) {
    struct RTCGrid *g = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof *g, 1);
    if (g == NULL) return false;
    *g = (struct RTCGrid){.startVertexID = 0, .stride = (unsigned)nx, .width = (uint16_t)nx, .height = (uint16_t)ny};
    return true;
}

static bool build(embree *p, const cw_field *field, unsigned options) {
    const RTCGeometry geometry =
        rtcNewGeometry(p->device, p->grid ? RTC_GEOMETRY_TYPE_GRID : RTC_GEOMETRY_TYPE_TRIANGLE);
    p->scene = rtcNewScene(p->device);
    if (geometry == NULL || p->scene == NULL) return false;
    rtcSetSceneBuildQuality(p->scene, options & PEER_MEDIUM ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(p->scene, options & PEER_ROBUST ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    const bool filled = add_vertices(geometry, field, p->nx, p->ny, p->grid) &&
                        (p->grid ? add_grid(geometry, p->nx, p->ny) : add_triangles(geometry, p->nx, p->ny));
    if (filled) {
        const double start = clock_cpu_seconds();
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(p->scene, geometry);
        rtcCommitScene(p->scene);
        p->build_seconds = clock_cpu_seconds() - start;
    }
    rtcReleaseGeometry(geometry);
    return filled && rtcGetDeviceError(p->device) == RTC_ERROR_NONE;
}

static void destroy(void *peer) {
    embree *p = peer;
    if (p == NULL) return;
    if (p->scene) rtcReleaseScene(p->scene);
    if (p->device) rtcReleaseDevice(p->device);
    free(p);
}

static void *create(const cw_field *field, cw_isa isa, unsigned options, io_error *error) {
    static const char *const configs[CW_ISA_COUNT] = {
        "threads=1",
        [CW_ISA_SCALAR] = "threads=1,isa=sse2",
        [CW_ISA_SSE42] = "threads=1,isa=sse4.2",
        [CW_ISA_AVX2] = "threads=1,isa=avx2",
        [CW_ISA_AVX512] = "threads=1,isa=avx512",
        [CW_ISA_NEON] = "threads=1",
    };
    const cw_field_info info = cw_field_describe(field);
    if ((options & PEER_GRID) && (info.nx > INT16_MAX || info.ny > INT16_MAX)) {
        io_fail(error, "Embree's grids have at most %d samples a side, the field has %zu x %zu", INT16_MAX, info.nx,
                info.ny);
        return NULL;
    }
    embree *p = calloc(1, sizeof *p);
    if (p) {
        p->nx = info.nx;
        p->ny = info.ny;
        p->grid = options & PEER_GRID;
        p->cells_inverse = 1 / (double)(info.nx - 1);
        p->device = rtcNewDevice(configs[isa]);
        if (p->device) rtcSetDeviceMemoryMonitorFunction(p->device, count_memory, p);
        if (p->device && build(p, field, options)) return p;
    }
    io_fail(error, "Embree (%s) could not build a field of %zu x %zu samples", configs[isa], info.nx, info.ny);
    destroy(p);
    return NULL;
}

static size_t bytes_of(const void *peer, double *seconds) {
    const embree *p = peer;
    const int64_t bytes = atomic_load(&p->bytes);
    *seconds = p->build_seconds;
    return bytes > 0 ? (size_t)bytes : 0;
}

static bool is_native(const embree *p, unsigned width) {
    const enum RTCDeviceProperty property = width == 4   ? RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED
                                            : width == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                         : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED;
    return width == 1 || rtcGetDeviceProperty(p->device, property) != 0;
}

/* ---- rays and hits ---- */

/* Flush to zero and denormals are zero, for as long as Embree runs. */
#if defined(__SSE__)
static unsigned flush_denormals(void) {
    enum { MXCSR_FTZ = 0x8000, MXCSR_DAZ = 0x40 };
    const unsigned caller = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(caller | MXCSR_FTZ | MXCSR_DAZ);
    return caller;
}
static void restore_denormals(unsigned caller) { __builtin_ia32_ldmxcsr(caller); }
#else
static unsigned flush_denormals(void) { return 0; }
static void restore_denormals(unsigned caller) { (void)caller; }
#endif

/* RTCRayHit, RTCRayHit4, 8 and 16 as rows of 1, 4, 8 or 16 numbers. */
enum { ORG_X, ORG_Y, ORG_Z, TNEAR, DIR_X, DIR_Y, DIR_Z, TIME, TFAR, MASK, ID, FLAGS };
enum { NG_X = FLAGS + 1, NG_Y, NG_Z, HIT_U, HIT_V, PRIM_ID, GEOM_ID, INST_ID };
#ifdef RTC_GEOMETRY_INSTANCE_ARRAY
enum { ROWS = INST_ID + 2 };
#else
enum { ROWS = INST_ID + 1 };
#endif
typedef union packet {
    struct RTCRayHit16 whole;
    float f[ROWS * 16];
    unsigned u[ROWS * 16];
} packet;
_Static_assert(sizeof(packet) == sizeof(float[ROWS * 16]), "rows that this file does not know");

static inline void packet_clear(packet *p, unsigned n) {
    for (unsigned k = 0; k < n; k++) {
        p->f[TIME * n + k] = 0;
        p->u[MASK * n + k] = UINT32_MAX;
        p->u[ID * n + k] = 0;
        p->u[FLAGS * n + k] = 0;
        p->u[INST_ID * n + k] = RTC_INVALID_GEOMETRY_ID;
    }
}

/* Lanes that are not used repeat the last ray: Embree looks at them although they are not valid. */
static inline void packet_fill(packet *p, unsigned n, const cw_ray *rays, unsigned used) {
    for (unsigned k = 0; k < n; k++) {
        const cw_ray *ray = &rays[k < used ? k : used - 1];
        for (unsigned a = 0; a < 3; a++) p->f[(ORG_X + a) * n + k] = ray->org[a];
        p->f[TNEAR * n + k] = ray->tmin;
        for (unsigned a = 0; a < 3; a++) p->f[(DIR_X + a) * n + k] = ray->dir[a];
        p->f[TFAR * n + k] = ray->tmax;
    }
}

static inline cw_hit triangle_hit(const embree *p, unsigned prim, float t, float u, float v) {
    const unsigned cell = prim / 2, cells = (unsigned)p->nx - 1;
    /* The half keeps the product clear of whole numbers, so that cutting it off is dividing. */
    const unsigned j = (unsigned)(int)((cell + 0.5) * p->cells_inverse);
    return (cw_hit){.t = t, .u = u, .v = v, .i = (int32_t)(cell - j * cells), .j = (int32_t)j, .triangle = prim % 2};
}

/* A grid tells the place on the whole grid in [0, 1] × [0, 1], along its rows and across. */
static inline cw_hit grid_hit(const embree *p, float t, float u, float v) {
    const float last_i = (float)(p->nx - 1), last_j = (float)(p->ny - 1);
    const float x = last_i - u * last_i, y = v * last_j;
    const float i = fmaxf(0, fminf(floorf(x), last_i - 1)), j = fmaxf(0, fminf(floorf(y), last_j - 1));
    const float a = x - i, b = y - j;
    const bool upper = b > a;
    return (cw_hit){.t = t,
                    .u = upper ? a : a - b,
                    .v = upper ? b - a : b,
                    .i = (int32_t)i,
                    .j = (int32_t)j,
                    .triangle = upper ? CW_TRIANGLE_B : CW_TRIANGLE_A};
}

static inline cw_hit make_hit(const embree *p, unsigned geometry, unsigned prim, float t, float u, float v) {
    if (geometry == RTC_INVALID_GEOMETRY_ID) return (cw_hit){.t = INFINITY, .i = -1, .j = -1};
    return p->grid ? grid_hit(p, t, u, v) : triangle_hit(p, prim, t, u, v);
}

/* ---- tracing ---- */

/* One of rtcIntersect4 and its kin. */
#define TRACE(width)                                                                                                   \
    (any ? rtcOccluded##width(valid, in, EMBREE_ANY(query, (struct RTCRay##width *)p))                                 \
         : rtcIntersect##width(valid, in, EMBREE_CLOSEST(query, (struct RTCRayHit##width *)p)))

static inline void trace_packet(const contender *c, unsigned width, bool any, const int *valid, embree_query *query,
                                packet *p) {
    RTCScene in = ((const embree *)c->peer)->scene;
    if (width == 1 && any)
        rtcOccluded1(in, EMBREE_ANY(query, (struct RTCRay *)p));
    else if (width == 1)
        rtcIntersect1(in, EMBREE_CLOSEST(query, (struct RTCRayHit *)p));
    else if (width == 4)
        TRACE(4);
    else if (width == 8)
        TRACE(8);
    else
        TRACE(16);
}

/* A body for any width and both queries, compiled once for each because the callers give them as constants. */
static inline __attribute__((always_inline)) void trace_packets(const contender *c, unsigned width, bool any,
                                                                embree_query *query, const cw_ray *rays, size_t n,
                                                                contender_answers out) {
    _Alignas(64) int valid[16];
    packet p;
    packet_clear(&p, width);
    for (unsigned k = 0; k < width; k++) valid[k] = -1;
    for (size_t begin = 0; begin < n; begin += width) {
        const unsigned used = n - begin < width ? (unsigned)(n - begin) : width;
        if (used == width)
            packet_fill(&p, width, rays + begin, width);
        else
            packet_fill(&p, width, rays + begin, used);
        for (unsigned k = used; k < width; k++) valid[k] = 0;
        for (unsigned k = 0; !any && k < width; k++) p.u[GEOM_ID * width + k] = RTC_INVALID_GEOMETRY_ID;
        trace_packet(c, width, any, valid, query, &p);
        for (unsigned k = 0; k < used; k++) {
            const float t = p.f[TFAR * width + k];
            if (any)
                out.occluded[begin + k] = t < 0;
            else
                out.hits[begin + k] = make_hit(c->peer, p.u[GEOM_ID * width + k], p.u[PRIM_ID * width + k], t,
                                               p.f[HIT_U * width + k], p.f[HIT_V * width + k]);
        }
    }
}

static inline __attribute__((always_inline)) void trace(const contender *c, bool any, const cw_ray *rays, size_t n,
                                                        contender_answers out) {
    const unsigned caller = flush_denormals();
    embree_query query = embree_query_of(c->coherent);
    if (c->width == 4)
        trace_packets(c, 4, any, &query, rays, n, out);
    else if (c->width == 8)
        trace_packets(c, 8, any, &query, rays, n, out);
    else if (c->width == 16)
        trace_packets(c, 16, any, &query, rays, n, out);
    else
        trace_packets(c, 1, any, &query, rays, n, out);
    restore_denormals(caller);
}

static void closest(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits) {
    trace(self, false, rays, n, (contender_answers){.hits = hits});
}

static void any(const contender *self, const cw_ray *rays, size_t n, uint8_t *occluded) {
    trace(self, true, rays, n, (contender_answers){.occluded = occluded});
}

static void enter(contender *c, const void *peer, unsigned width, bool coherent) {
    *c = (contender){.width = width, .threads = 1, .closest = closest, .any = any, .peer = peer, .coherent = coherent};
    snprintf(c->name, sizeof c->name, "w%u%s", width, is_native(peer, width) ? "" : "-split");
}

/* needs: measured at 1025 and 4097 samples a side, 245 bytes a cell for triangles at high quality, 38 for a grid. A
 * field of 8193 would take 17 GB, and a system that runs out of memory kills somebody. */
const peer_kind peer_embree = {.name = "embree",
                               .package = "libembree-dev",
                               .version = RTC_VERSION_STRING,
                               .options = EMBREE_OPTIONS,
                               .widths = {1, 4, 8, 16},
                               .needs = {260, 50},
                               .create = create,
                               .destroy = destroy,
                               .bytes = bytes_of,
                               .enter = enter};
