/* SPDX-License-Identifier: Apache-2.0 */

/* Cellwalk: where does this ray hit this height field?
 *
 * Words. A *field* is nx × ny samples; sample (i, j) stands at field coordinates x = i, y = j and its value is z.
 * *Cell* (i, j), 0 <= i < nx - 1, 0 <= j < ny - 1, lies between samples (i, j) and (i + 1, j + 1). Each cell is two
 * *triangles*, split along the diagonal from (i, j) to (i + 1, j + 1):
 *
 *     CW_TRIANGLE_A = (i, j), (i + 1, j), (i + 1, j + 1)      below the diagonal (y - j <= x - i)
 *     CW_TRIANGLE_B = (i, j), (i + 1, j + 1), (i, j + 1)      above the diagonal
 *
 * *Field space* has unit cells and the samples' own heights; *user space* is whatever the caller models in, tied to
 * field space by an affine map that is kept in double.
 *
 * All functions are safe to call from several threads at once unless they say otherwise. None of the queries
 * allocates. None changes the floating-point environment: queries run in the IEEE default environment (round to
 * nearest, denormals kept) whatever the caller's is, and put the caller's back; what follows from a hit is computed in the
 * caller's. Functions that return no status take no NULL unless they say so. */

#ifndef CELLWALK_H
#define CELLWALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CW_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

#define CW_VERSION       "0.1.0"
#define CW_VERSION_MAJOR 0
#define CW_VERSION_MINOR 1
#define CW_VERSION_PATCH 0

/* The version of the library that runs, which may be another than that of the header that a program was compiled with. */
CW_API const char *cw_version(void);

/* Descriptions that a caller fills in, cw_field_desc, cw_update and cw_query, end in room for what later versions add. It
 * holds zeros, which always mean the default; a library that finds anything else is asked for something that it does not
 * know, and says CW_ERROR_OPTION. So start from the default, or from {0}. */

/* ---- status ----------------------------------------------------------------------------------------------------- */

typedef enum cw_status {
    CW_OK = 0,
    CW_ERROR_ARGUMENT, /* a required pointer is NULL, or an update has samples that a field which borrows has no use for */
    CW_ERROR_SIZE,     /* nx or ny below 2, above CW_SIDE_MAX, or too many samples for 31-bit sample numbers, in which
                           * borrowed samples count with the gaps between their rows */
    CW_ERROR_STRIDE,      /* a row stride shorter than a row, or so long that rows exceed the address space */
    CW_ERROR_MAP,         /* the affine map is not finite or cannot be inverted */
    CW_ERROR_HEIGHT,      /* a sample lies beyond plus or minus CW_HEIGHT_MAX */
    CW_ERROR_HOLE,        /* borrowed samples hold an infinity: mark holes by NaN, or let the field copy them */
    CW_ERROR_MEMORY,      /* out of memory */
    CW_ERROR_UNAVAILABLE, /* this machine, or the instruction-set limit, rules the kernel out */
    CW_ERROR_UNSUPPORTED, /* the kernel has no such leaf test */
    CW_ERROR_NOT_BUILT,   /* the kernel needs a structure that has not been built: see cw_field_build */
    CW_ERROR_THREAD,      /* a thread could not be started */
    CW_ERROR_OPTION,      /* an option has a value that it does not know, or a tolerance is negative or not finite */
    CW_ERROR_KERNEL,      /* there is no kernel of that name: see cw_kernel_find */
    CW_ERROR_POOL_SIZE,   /* more threads than CW_THREADS_MAX */
    CW_ERROR_SLANTED,     /* places above (x, y) of user space are asked for, whose map leans the heights */
    CW_ERROR_CANCELLED,   /* the watch said to stop */
    CW_ERROR_BUSY,      /* the field is to be updated while queries or another update run on it, or asked during that */
    CW_ERROR_DIRECTION, /* a heading's direction is not finite, or its longer component is not from 2^-40 to 2^40 */
    CW_ERROR_SLOPE,     /* a slope is NaN, or low lies above high */
    CW_ERROR_RECTANGLE  /* the rectangle of an update or of a heading's query is no part of the field */
} cw_status;

/* One English sentence without a full stop; never NULL, static storage. */
CW_API const char *cw_status_message(cw_status status);

/* ---- kernels ---------------------------------------------------------------------------------------------------- */

/* Instruction sets in the order in which they include each other. */
typedef enum cw_isa { CW_ISA_SCALAR = 0, CW_ISA_SSE42, CW_ISA_AVX2, CW_ISA_AVX512 } cw_isa;

/* "scalar", "sse4.2", "avx2", "avx512"; NULL for any other value. */
CW_API const char *cw_isa_name(cw_isa isa);

/* The widest instruction set in use, which is the least of three bounds:
 *  - what CPU and operating system both support (CPUID and XGETBV);
 *  - the environment variable CELLWALK_ISA, the user's upper bound for the whole process. It holds a name as above and is
 *    read once, at the first call that has to know. The library takes any other value for no bound at all, since it has
 *    nowhere to complain: a program should check the variable when it starts, as cellwalk and cellwalk-bench do;
 *  - the last cw_isa_limit, which is the program's own bound: it may be lowered and raised again, but lifts neither of the
 *    other two. CW_ISA_AVX512, or anything beyond, takes it away.
 * A query that has begun goes on as it began; the next one is told CW_ERROR_UNAVAILABLE if it names a kernel beyond the limit
 * that has come meanwhile. */
CW_API cw_isa cw_isa_best(void);
CW_API void cw_isa_limit(cw_isa highest);

/* A leaf test decides where a ray meets one cell's two triangles. */
typedef enum cw_leaf {
    CW_LEAF_DEFAULT = 0,     /* what the kernel does best: see cw_kernel_info */
    CW_LEAF_MOLLER_TRUMBORE, /* each triangle by itself (Möller and Trumbore 1997): a ray may slip between two */
    CW_LEAF_WATERTIGHT       /* the sign of ray height minus surface height at each crossing, which neighbours share */
} cw_leaf;
enum { CW_LEAF_COUNT = 3 };

/* "default", "moller-trumbore", "watertight"; NULL for any other value. */
CW_API const char *cw_leaf_name(cw_leaf leaf);

/* A kernel is one way to find hits. Kernels live as long as the program. cell, packet* and pyramid* answer strict queries with
 * the same bits for the same leaf test. brute and grid3d have rules of their own. */
typedef struct cw_kernel cw_kernel;

typedef struct cw_kernel_info {
    const char *name; /* "packet8" */
    const char *what; /* one line for a person */
    cw_isa isa;       /* needed */
    unsigned width;   /* rays that one instruction serves */
    bool needs_build; /* cw_field_build must be called for it first */
    bool available;   /* on this machine under the present limit */
    cw_leaf default_leaf;
} cw_kernel_info;

CW_API size_t cw_kernel_count(void);
/* number in [0, cw_kernel_count()), else NULL. */
CW_API const cw_kernel *cw_kernel_at(size_t number);
/* If no kernel has that name, a stand-in: cw_kernel_exists is false for it, it is not available, and a query that names it
 * fails with CW_ERROR_KERNEL. It is not NULL, which in a query means the best kernel: so a misspelt name runs nothing else. */
CW_API const cw_kernel *cw_kernel_find(const char *name);
CW_API bool cw_kernel_exists(const cw_kernel *kernel);
/* NULL is described like the stand-in of cw_kernel_find. */
CW_API cw_kernel_info cw_kernel_describe(const cw_kernel *kernel);

/* ---- threads ---------------------------------------------------------------------------------------------------- */

/* Threads that wait for work to share: array queries, fields to be made or updated. They serve one caller at a time: a query that
 * finds them at work, from a second thread of the caller's, runs on its own thread alone. Two queries that are both to be
 * shared take a pool each. */
typedef struct cw_pool cw_pool;

enum { CW_THREADS_MAX = 4096 };

/* threads >= 1 counts the calling thread; 0 stands for one per CPU this process may use. The caller owns the pool. On failure
 * *pool is NULL. */
CW_API cw_status cw_pool_create(unsigned threads, cw_pool **pool);
/* NULL is allowed. No query may be running on the pool. */
CW_API void cw_pool_destroy(cw_pool *pool);
/* Threads that the caller has already, as engines have them with their own tasks. */
typedef void cw_task_fn(void *argument, unsigned number);
typedef struct cw_tasks {
    unsigned threads; /* how many tasks to make of a query: from 1 to CW_THREADS_MAX */
    /* Calls task(argument, k) for each k in [0, count), on any threads and in any order, and returns when all have
     * returned. Called by whichever threads run queries on the pool, several at once if they do. */
    void (*run)(void *context, cw_task_fn *task, void *argument, unsigned count);
    void *context;
} cw_tasks;
/* A pool without threads of its own. tasks is copied; what its context points to stays until cw_pool_destroy. */
CW_API cw_status cw_pool_create_on(const cw_tasks *tasks, cw_pool **pool);
/* 1 for NULL, which is the calling thread alone. */
CW_API unsigned cw_pool_threads(const cw_pool *pool);

/* A piece of work: items [begin, end). */
typedef void cw_work_fn(void *context, size_t begin, size_t end);
/* Lends the pool's threads to work of the caller's own: runs it over [0, n) in pieces of grain items, on the calling thread
 * alone if pool is NULL, and returns when all is done. The pieces may come in any order; a thread alone gets all in one.
 * Grain 0 counts as 1. */
CW_API void cw_pool_run(cw_pool *pool, size_t n, size_t grain, cw_work_fn *work, void *context);

/* Called now and then during a query, or while a field is made, by one thread at a time, with the share that is done, in
 * (0, 1]. Returns false to stop, which then ends soon with CW_ERROR_CANCELLED; nothing says which answers of a query were
 * written. */
typedef bool cw_watch_fn(void *context, double done);

/* ---- field ------------------------------------------------------------------------------------------------------ */

/* Field coordinates must be exact in float: a side has at most 2^23 samples, and all samples are fewer than 2^31. */
enum { CW_SIDE_MAX = 1 << 23 };

/* Heights up to 2^100, about 1.27e30, leave room for sums and products that answers are made of. */
#define CW_HEIGHT_MAX 0x1p100f

typedef struct cw_field cw_field;

typedef enum cw_storage {
    CW_COPY = 0, /* the field keeps a copy; the caller's samples may go right after cw_field_create */
    CW_BORROW /* the field reads the caller's samples, which must stay until cw_field_destroy, and stay unchanged but for
                  * what cw_field_update is told of */
} cw_storage;

typedef struct cw_field_desc {
    const float *samples; /* sample (i, j) is samples[j * stride + i]; NaN and infinity mark holes */
    size_t nx, ny;        /* samples a row, rows; each >= 2 */
    size_t stride;        /* floats from one row to the next; 0 stands for nx */
    cw_storage storage;
    bool bare; /* build nothing yet: until cw_field_build only kernels without needs_build run */
    /* Field space to user space, three rows of four: user = map[.][0..2] · (x, y, z) + map[.][3]. All zero stands for the
     * identity. */
    double map[3][4];
    /* For as long as cw_field_create takes; the field keeps neither. */
    cw_pool *pool;      /* NULL: the calling thread alone */
    cw_watch_fn *watch; /* NULL: the field is made to its end */
    void *watch_context;
    uint64_t reserved[1]; /* 0 */
} cw_field_desc;

/* No samples, no size, CW_COPY, not bare, identity map: fill in the rest. */
CW_API cw_field_desc cw_field_desc_default(void);

/* Makes a field, which the caller owns, with what the default kernel walks on: the bounds pyramid, but nothing if it has at
 * most 32 cells a side, on which packets are faster without. On failure *field is NULL. A triangle with a hole at a vertex
 * does not exist: every ray passes through it. Borrowed samples mark holes by NaN alone (else CW_ERROR_HOLE). The field is the
 * same, to the last bit, for any pool. */
CW_API cw_status cw_field_create(const cw_field_desc *desc, cw_field **field);
/* NULL is allowed. No query may be running on the field. */
CW_API void cw_field_destroy(cw_field *field);

/* Builds what a kernel with needs_build walks on; a second call does nothing. Neither a query nor another call of this may be
 * running on the field. */
CW_API cw_status cw_field_build(cw_field *field, const cw_kernel *kernel);

/* Samples that change: waves, a crater, a tile that has arrived. */
typedef struct cw_update {
    size_t i, j;   /* the first sample of a rectangle */
    size_t nx, ny; /* samples in a row of it, rows; nothing is done where one is 0 */
    /* Of a field that has a copy: the new samples, (i + x, j + y) at samples[y * stride + x]. Of a field that borrows: NULL;
     * the caller has changed them already. */
    const float *samples;
    size_t stride;        /* floats from one row to the next; 0 stands for nx */
    cw_pool *pool;        /* NULL: the calling thread alone, which is best for small rectangles */
    uint64_t reserved[4]; /* 0 */
} cw_update;

/* After it the field has, to the last bit, what a field made of the new samples would have; but what grid3d walks on is
 * dropped, and cw_field_build makes it again. It takes time for the rectangle, not for the field: 64 × 64 samples 0.1 to
 * 0.3 ms, in any field. Headings stay valid. Nothing is allocated.
 *
 * Samples that cw_field_create would refuse are refused here, with its status, and the field keeps what it had. If it borrows,
 * the samples themselves have changed: put others there and call this again before the next query. CW_ERROR_RECTANGLE if
 * the rectangle is no part of the field; CW_ERROR_ARGUMENT if samples are given to a field that borrows, or none to one that does not.
 *
 * No query and no other update may be running on the field: whichever comes second, update or query, gets CW_ERROR_BUSY and
 * does nothing. That protects a field that has a copy, and the bounds of one that borrows, whose samples the caller must not
 * change meanwhile. Functions that return no status do not look. */
CW_API cw_status cw_field_update(cw_field *field, const cw_update *update);

typedef struct cw_field_info {
    size_t nx, ny;
    float low, high;      /* over the samples that are not holes; low > high when all are */
    size_t holes;         /* samples that are NaN or infinite */
    size_t bytes_samples; /* owned by the field: 0 if borrowed */
    size_t bytes_built;   /* all structures built so far */
    double build_seconds; /* wall time spent on them, and on a look at all samples where that was one with it */
} cw_field_info;

CW_API cw_field_info cw_field_describe(const cw_field *field);

/* Sample (i, j) in field space as the kernels see it: holes are NaN. NaN outside the field as well. */
CW_API float cw_field_sample(const cw_field *field, size_t i, size_t j);

/* ---- queries ---------------------------------------------------------------------------------------------------- */

/* Points org + t · dir for t in [tmin, tmax], both ends included, in field space. dir need not have unit length. tmin
 * and tmax may be infinite; both are clamped to half of the largest float. A direction component of at most 2^-128, whose
 * reciprocal is no float, counts as zero; one above 2^126, whose reciprocal is denormal, counts as infinite. A ray with a
 * NaN anywhere, an infinite origin or direction, a zero direction or tmin > tmax misses. A ray that touches the surface
 * hits it; but on the field's outer border and on the rim of a hole, where nothing lies behind, a touch may also be a miss.
 *
 * A ray may start anywhere. From more than half a side's length outside the field, or more than eight times its range of
 * heights above or below the middle of it, a ray is first moved to where it enters the field's box, in double: distance costs
 * neither speed nor precision. A ray that would enter it beyond half of the largest float misses. */
typedef struct cw_ray {
    float org[3];
    float tmin;
    float dir[3];
    float tmax;
} cw_ray;

typedef enum cw_triangle { CW_TRIANGLE_A = 0, CW_TRIANGLE_B = 1 } cw_triangle;

/* With p0, p1, p2 the triangle's vertices in the order given at the top, the hit is p0 + u (p1 - p0) + v (p2 - p0).
 * t counts from the ray's origin as given. With CW_LEAF_WATERTIGHT t is the exact one rounded to the nearest float, and u
 * and v are within 1.25 · 2^-24 of theirs, unless the ray passes within rounding of the triangle's edge or is all but
 * parallel to it; papers/numerics.md has the bounds. From afar a float t no longer tells neighbouring cells apart: i, j, u
 * and v do.
 * A miss has t = +infinity, i = j = -1, triangle, u and v 0. */
typedef struct cw_hit {
    float t;
    float u, v;
    int32_t i, j;
    uint32_t triangle; /* a cw_triangle */
} cw_hit;

/* What is known of rays that are neighbours in the array. It changes speed, never an answer of a strict query. */
typedef enum cw_coherence {
    CW_COHERENCE_AUTO = 0, /* nothing: the library looks for itself */
    CW_COHERENCE_LOW,      /* they have nothing in common: each goes its own way */
    CW_COHERENCE_HIGH      /* they run side by side: they share their way for as long as it pays, even if far apart */
} cw_coherence;

typedef struct cw_query {
    const cw_kernel *kernel; /* NULL: the best for this machine */
    cw_leaf leaf;
    cw_pool *pool; /* NULL: the calling thread alone, on which fewer than 1024 rays stay in any case */
    cw_coherence coherence;
    /* Tolerant queries may take the surface for as thick as tolerance + cone · t · |dir|, in the field's heights, with |dir|
     * as it is in field space and nothing for the cone where t < 0. org + t · dir then lies within that of the hit's
     * triangle, in height. Each ray that hits hits still; one that passes as near may hit as well, also right where it
     * starts. Which point within the tolerance is the hit depends on the walk, so tolerant hits may differ
     * between kernels and, unlike all others, with a ray's neighbours in the array. Meant for detail below a pixel at its distance:
     * cone is a pixel's width at distance 1. Both are finite and not negative; 0 stands for strict. Only the
     * pyramid kernels with CW_LEAF_WATERTIGHT make use of them; others answer as without. */
    float tolerance, cone;
    cw_watch_fn *watch; /* NULL: the query runs to its end */
    void *watch_context;
    uint64_t reserved[4]; /* 0 */
} cw_query;

/* All zero: the best kernel, its default leaf test, one thread, no hint, strict. A NULL query means the same. */
CW_API cw_query cw_query_default(void);

/* The kernel that a query runs on this field; field may be NULL, which stands for a field like most. */
CW_API const cw_kernel *cw_query_kernel(const cw_field *field, const cw_query *query);

/* cw_field_build for that kernel, on the query's pool and under its watch; cancelled, it leaves the field as it was. */
CW_API cw_status cw_field_build_for(cw_field *field, const cw_query *query);

/* Closest hit of each of n rays (n may be 0). rays and hits need no alignment beyond their types' and may not overlap.
 * Unless the query is tolerant, the answer for a ray does not depend on its neighbours, its place in the array or the
 * number of threads. On an error other than CW_ERROR_CANCELLED hits are untouched. */
CW_API cw_status cw_closest(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, cw_hit *hits);

/* occluded[k] = 1 if rays[k] hits anything, else 0; always what cw_closest would find. */
CW_API cw_status cw_any(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, uint8_t *occluded);

/* ---- rays of one heading, from the samples themselves -------------------------------------------------------------- */

/* Sunlight, or the view in one direction of the compass: rays that leave from many samples and go the same way. Each starts
 * on the surface, at its sample exactly, and what counts is what it meets after that; so nothing has to be lifted off or cut
 * away. They share so much that this is some ten times as fast as a query with a ray for each sample.
 *
 * A heading is a direction (dir[0], dir[1]) in field coordinates, made ready for one field: 48 bytes for each cell that the
 * longest way through the field leads over. Along it, from sample (i, j) with height z, the surface at
 * (i + t dir[0], j + t dir[1]) rises by (height - z) / t, t > 0. Only triangles' edges need be looked at, since a steepest
 * rise is at one. An edge between two samples that are no holes counts, even where both triangles beside it have a hole. */
typedef struct cw_heading cw_heading;

/* The longer of dir's components is from 2^-40 to 2^40, else CW_ERROR_DIRECTION. The caller owns the heading and destroys it
 * before the field. */
CW_API cw_status cw_heading_create(const cw_field *field, const double dir[2], cw_heading **heading);
/* NULL is allowed. */
CW_API void cw_heading_destroy(cw_heading *heading);

/* The steepest rise as seen from each sample of a rectangle: slope[y * nx + x] for sample (i + x, j + y), or NaN at a hole. It
 * is off by less than 2^-21 of the rise to the higher of the edge's two samples. Rises from low to high are told apart; what
 * is less comes out as low, also where the ray meets nothing before it leaves the field, and what is more as high. The
 * narrower this range, the faster; -infinity and infinity tell all rises apart. CW_ERROR_SLOPE unless low <= high,
 * CW_ERROR_RECTANGLE if the rectangle is no part of the field; it may be empty. Of the query only pool and kernel count, the
 * latter by its instruction set; the answers are the same for any. */
CW_API cw_status cw_heading_steepest(const cw_heading *heading, const cw_query *query, float low, float high, size_t i,
                                     size_t j, size_t nx, size_t ny, float *slope);

/* occluded[y * nx + x] = 1 if the steepest rise is at least slope, so that the ray that rises by slope meets the surface
 * again. Else 0, also at a hole or where nothing is met. slope may be infinite, but not NaN. */
CW_API cw_status cw_heading_any(const cw_heading *heading, const cw_query *query, float slope, size_t i, size_t j,
                                size_t nx, size_t ny, uint8_t *occluded);

/* ---- user space ------------------------------------------------------------------------------------------------- */

/* A ray in user space; as cw_ray otherwise. */
typedef struct cw_user_ray {
    double org[3];
    double tmin;
    double dir[3];
    double tmax;
} cw_user_ray;

/* Moves rays to field space in double and rounds last, so that a field far from the user's origin loses nothing: from 5 · 10^6 m
 * away, cells of 1 m get the same rays as at the origin. What is lost is one rounding to float: of an origin within a field of
 * 10 000 cells, as in UTM, up to 5 · 10^-4 cells; of one 10^5 cells away, a sensor 700 km above cells of 10 m in geocentric
 * coordinates, up to 4 · 10^-3; and 2^-24 of the direction's length. t is the same in both spaces. in and out may not overlap. */
CW_API void cw_rays_to_field(const cw_field *field, const cw_user_ray *in, size_t n, cw_ray *out);

/* cw_closest and cw_any of rays in user space, which are moved a few at a time: nothing is allocated, and the answers are
 * those of cw_rays_to_field and a query after it. If cw_isa_limit takes the query's kernel away meanwhile, the status says so
 * and which answers were written is not told. */
CW_API cw_status cw_closest_user(const cw_field *field, const cw_query *query, const cw_user_ray *rays, size_t n,
                                 cw_hit *hits);
CW_API cw_status cw_any_user(const cw_field *field, const cw_query *query, const cw_user_ray *rays, size_t n,
                             uint8_t *occluded);

/* The place on the surface at field coordinates (x, y), as a hit with t = 0, from which point, normals and texture coordinates
 * follow as below. A miss outside the field, in a triangle with a hole at a vertex, and for NaN. */
CW_API void cw_field_at(const cw_field *field, double x, double y, cw_hit *hit);
/* The same at (x, y) in user space. CW_ERROR_SLANTED, and a miss, unless heights change z alone there: map[0][2] and map[1][2]
 * are 0. */
CW_API cw_status cw_field_at_user(const cw_field *field, double x, double y, cw_hit *hit);

/* ---- what follows from a hit: computed on request, so that a query pays only for what its scene requires ---------- */

/* Each takes a hit on this field; the results are in user space. What follows from a miss, or from a cell that the field does not
 * have, is NaN. */

/* The point on the triangle, from (i, j, triangle, u, v): it lies on the surface to rounding, unlike org + t · dir. */
CW_API void cw_hit_point(const cw_field *field, const cw_hit *hit, double point[3]);

/* The points, normals and Phong normals of n hits, on the pool's threads; pool may be NULL. Each is what the function for one
 * hit gives. */
CW_API cw_status cw_hit_points(const cw_field *field, cw_pool *pool, const cw_hit *hits, size_t n, double (*points)[3]);
CW_API cw_status cw_hit_normals(const cw_field *field, cw_pool *pool, const cw_hit *hits, size_t n,
                                double (*normals)[3]);
CW_API cw_status cw_hit_phong_normals(const cw_field *field, cw_pool *pool, const cw_hit *hits, size_t n,
                                      double (*normals)[3]);

/* Unit normal of the triangle, on the side of growing z. */
CW_API void cw_hit_normal(const cw_field *field, const cw_hit *hit, double normal[3]);

/* Unit Phong normal (Phong 1975): each vertex takes the area-weighted sum of the normals of its up to six triangles, the
 * hit interpolates them by its barycentric coordinates. Triangles with holes count for nothing. */
CW_API void cw_hit_phong_normal(const cw_field *field, const cw_hit *hit, double normal[3]);

/* The same normal and how it turns over the triangle: its derivatives by field x (change[0]) and by field y (change[1]),
 * which say how far apart reflected neighbours go. */
CW_API void cw_hit_phong_change(const cw_field *field, const cw_hit *hit, double normal[3], double change[2][3]);

/* Texture coordinates (x / (nx - 1), y / (ny - 1)), each in [0, 1]. */
CW_API void cw_hit_uv(const cw_field *field, const cw_hit *hit, float uv[2]);

#ifdef __cplusplus
}
#endif

#endif
