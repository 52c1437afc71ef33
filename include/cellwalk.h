/* SPDX-License-Identifier: Apache-2.0 */

/* Cellwalk finds where rays hit a height field.
 *
 * Words. A *field* is nx × ny samples. Sample (i, j) is at field coordinates x = i, y = j; its value is the height z.
 * *Cell* (i, j), 0 <= i < nx - 1, 0 <= j < ny - 1, lies between samples (i, j) and (i + 1, j + 1). Each cell is two
 * *triangles*, split along the diagonal from (i, j) to (i + 1, j + 1):
 *
 *     CW_TRIANGLE_A = (i, j), (i + 1, j), (i + 1, j + 1)      below the diagonal (y - j <= x - i)
 *     CW_TRIANGLE_B = (i, j), (i + 1, j + 1), (i, j + 1)      above the diagonal
 *
 * A *hole* is a sample without a height (NaN); triangles with a hole at a vertex do not exist. *Field space* has unit cells
 * and the samples' heights. *User space* is the caller's; an affine map in double ties it to field space.
 *
 * Threads. Every function may be called from several threads at once unless it says otherwise. Queries do not allocate. A call
 * needs at most 128 KiB of stack. No function is a cancellation point, and callbacks run with cancellation disabled; asynchronous
 * cancellation is undefined. A callback must return: it must not jump out, throw or end its thread. In a child made by fork,
 * queries of the parent's other threads do not keep a field busy; an update does, so destroy a field that was being updated.
 *
 * Errors. Functions that can fail return a cw_status and leave a sentence with the argument, its value and the limit for
 * cw_last_error. Unless a function says otherwise, its outputs are untouched on an error. Functions without a status are not
 * checked: no argument may be NULL. Arrays may be NULL if nothing is in them: for n = 0 and for an empty rectangle.
 *
 * Floating point. Queries run in the IEEE default environment (round to nearest, denormals kept) and restore the caller's.
 *
 * Growing. Structs that the caller fills end in reserved members, which must be zero: later versions give them a meaning, and
 * anything but zero fails with CW_ERROR_ARGUMENT. Zero is always the default, so start from {0}. Structs that the library
 * fills take their size, so that a program compiled with an older header gets the members of that header. cw_ray,
 * cw_user_ray and cw_hit are records in arrays and never change.
 *
 * Stability. Everything is stable within a major version, except headings, which are experimental.
 *
 * Not offered: instances, rays with a stride, walks in double precision, queries on a field that another thread destroys. */

#ifndef CELLWALK_H
#define CELLWALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A program that compiles the library into itself may define CW_API as it likes. */
#ifndef CW_API
#define CW_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define CW_VERSION       "0.2.0"
#define CW_VERSION_MAJOR 0
#define CW_VERSION_MINOR 2
#define CW_VERSION_PATCH 0
/* For #if: 10000 · major + 100 · minor + patch. */
#define CW_VERSION_NUMBER (10000 * CW_VERSION_MAJOR + 100 * CW_VERSION_MINOR + CW_VERSION_PATCH)

/* The version of the library that runs, which may differ from that of the header. */
CW_API const char *cw_version(void);

/* ---- status ----------------------------------------------------------------------------------------------------- */

typedef enum cw_status {
    CW_OK = 0,
    CW_ERROR_ARGUMENT,  /* an argument or a member is NULL, out of range or of a value unknown to this version */
    CW_ERROR_SAMPLE,    /* a sample lies beyond CW_HEIGHT_MAX, or a borrowed one is infinite */
    CW_ERROR_KERNEL,    /* no kernel of that name, not on this CPU or under this limit, or not with this leaf test */
    CW_ERROR_NOT_BUILT, /* a reference kernel needs cw_field_build first */
    CW_ERROR_MEMORY,    /* out of memory, or of threads */
    CW_ERROR_BUSY,      /* an update and something else would run on one field at the same time */
    CW_ERROR_CANCELLED  /* the watch returned false */
} cw_status;

/* The general meaning of the status: one English sentence without a full stop, in static storage, never NULL. */
CW_API const char *cw_status_message(cw_status status);

/* The error of the last call that failed on this thread, with names, values and limits: "nx: 1 samples; a field has
 * 2 to 8388608 a side". Empty if none has failed. Valid until the next failure on this thread; successful calls keep
 * it. */
CW_API const char *cw_last_error(void);

/* ---- kernels ---------------------------------------------------------------------------------------------------- */

typedef enum cw_isa {
    CW_ISA_SCALAR = 0,
    CW_ISA_SSE42,
    CW_ISA_AVX2,
    CW_ISA_AVX512,
    CW_ISA_NEON,
    CW_ISA_ANY = 255 /* as a limit: none */
} cw_isa;
enum { CW_ISA_COUNT = 5 };

/* "scalar", "sse4.2", "avx2", "avx512", "neon"; NULL for any other value. */
CW_API const char *cw_isa_name(cw_isa isa);

/* True if code for part runs wherever code for whole does: avx512 includes avx2 includes sse4.2, each includes
 * scalar and itself, neon includes scalar. */
CW_API bool cw_isa_includes(cw_isa whole, cw_isa part);

/* The instruction set in use, which is the widest that is included in all of these:
 *  - the CPU's and the operating system's (CPUID and XGETBV);
 *  - the environment variable CELLWALK_ISA, one of the names above, read once. Another value limits nothing, so a program
 *    should check the variable at its start;
 *  - the last cw_isa_limit. */
CW_API cw_isa cw_isa_best(void);
/* Limits the process to an instruction set and those that it includes. CW_ISA_ANY lifts the limit. Queries that have
 * begun are not affected. */
CW_API void cw_isa_limit(cw_isa most);

/* A leaf test decides where a ray meets one cell's two triangles. */
typedef enum cw_leaf {
    CW_LEAF_DEFAULT = 0,     /* the kernel's default_leaf */
    CW_LEAF_MOLLER_TRUMBORE, /* each triangle separately (Möller and Trumbore 1997): a ray may slip between two */
    CW_LEAF_WATERTIGHT       /* the sign of ray height minus surface height at each crossing, which neighbours share */
} cw_leaf;
enum { CW_LEAF_COUNT = 3 };

/* "default", "moller-trumbore", "watertight"; NULL for any other value. */
CW_API const char *cw_leaf_name(cw_leaf leaf);

/* A kernel is one way to find hits. Kernels live as long as the program. cell, packet* and pyramid* return the same
 * bits for the same leaf test. A program may add reference kernels, which are in no library: brute and grid3d use other operations
 * and may differ in last bits and near edges. */
typedef struct cw_kernel cw_kernel;

typedef struct cw_kernel_info {
    const char *name; /* "packet8" */
    const char *what; /* a description in one line */
    cw_isa isa;       /* the instruction set it needs */
    unsigned width;   /* lanes of the vectors that it walks with */
    bool needs_build; /* it needs another structure than a field's bounds: only reference kernels do */
    bool available;   /* on this machine under the present limit */
    cw_leaf default_leaf;
} cw_kernel_info;

CW_API size_t cw_kernel_count(void);
/* NULL from cw_kernel_count() on. */
CW_API const cw_kernel *cw_kernel_at(size_t number);
/* For a name that no kernel has: a stand-in, with which a query fails with CW_ERROR_KERNEL, so that a typo never
 * selects the default kernel. */
CW_API const cw_kernel *cw_kernel_find(const char *name);
/* False for the stand-in of cw_kernel_find and for NULL. */
CW_API bool cw_kernel_exists(const cw_kernel *kernel);
/* Fills in the first size bytes of a cw_kernel_info. NULL is described like the stand-in. */
CW_API void cw_kernel_describe_into(const cw_kernel *kernel, cw_kernel_info *info, size_t size);
static inline cw_kernel_info cw_kernel_describe(const cw_kernel *kernel) {
    cw_kernel_info info;
    cw_kernel_describe_into(kernel, &info, sizeof info);
    return info;
}

/* ---- threads and runs ------------------------------------------------------------------------------------------- */

/* Threads that wait for work. A pool serves one caller at a time: if it is busy, the work runs on the calling
 * thread. */
typedef struct cw_pool cw_pool;

enum { CW_THREADS_MAX = 4096 };

/* threads, at most CW_THREADS_MAX, counts the calling thread; 0 is one for each CPU that this process may use. The
 * caller owns the pool, whose threads have at least 1 MiB of stack. On failure *pool is NULL: CW_ERROR_ARGUMENT,
 * _MEMORY. In a child made by fork the pool is the calling thread alone, and the child may destroy it. */
CW_API cw_status cw_pool_create(unsigned threads, cw_pool **pool);
/* NULL is allowed. Nothing may be running on the pool. */
CW_API void cw_pool_destroy(cw_pool *pool);
/* A task that the library hands to the caller's threads. */
typedef void cw_task_fn(void *argument, unsigned number);
/* Threads that the caller has already. */
typedef struct cw_tasks {
    unsigned threads; /* tasks to make of a piece of work: from 1 to CW_THREADS_MAX */
    /* Calls task(argument, k) for each k in [0, count) on any threads in any order, and returns when all have
     * returned. Several threads may call it at once. */
    void (*run)(void *context, cw_task_fn *task, void *argument, unsigned count);
    void *context; /* must live until cw_pool_destroy */
} cw_tasks;
/* A pool that uses the caller's threads. tasks is copied. The caller owns the pool. On failure *pool is NULL:
 * CW_ERROR_ARGUMENT, _MEMORY. */
CW_API cw_status cw_pool_create_on(const cw_tasks *tasks, cw_pool **pool);
/* 1 for NULL. */
CW_API unsigned cw_pool_threads(const cw_pool *pool);

/* Items [begin, end) of a piece of work. */
typedef void cw_work_fn(void *context, size_t begin, size_t end);
/* Runs the caller's work over [0, n) on the pool's threads, in pieces of grain items (0 counts as 1) and in any
 * order; on one thread in one piece. Returns when all is done. */
CW_API void cw_pool_run(cw_pool *pool, size_t n, size_t grain, cw_work_fn *work, void *context);

/* Called during long work by one thread at a time with the share that is done, in (0, 1]. Returning false ends the
 * work soon with CW_ERROR_CANCELLED; its output is then unspecified. */
typedef bool cw_watch_fn(void *context, double done);

/* How something runs. All zero, and a NULL cw_run, mean: the best kernel, its default leaf test, the calling thread,
 * no watch. */
typedef struct cw_run {
    const cw_kernel *kernel; /* NULL: the best for this machine and field */
    cw_leaf leaf;            /* of queries; else ignored */
    cw_pool *pool;           /* NULL: the calling thread. Queries of fewer than 1024 rays stay on it in any case */
    cw_watch_fn *watch;      /* NULL: none */
    void *watch_context;
    uint64_t reserved[4]; /* 0 */
} cw_run;

/* ---- memory ----------------------------------------------------------------------------------------------------- */

/* Memory for fields, structures and headings, such as memory backed by files. allocate returns bytes bytes aligned
 * to alignment, a power of two up to 2^21, or NULL. release takes a pointer that allocate returned, never NULL. Both
 * are called by several threads at once. */
typedef struct cw_allocator {
    void *(*allocate)(void *context, size_t bytes, size_t alignment);
    void (*release)(void *context, void *memory);
    void *context;
} cw_allocator;

/* Sets the allocator of the whole process; NULL: the library's own. Must be called before the first object is made
 * or after all have been destroyed. That is not checked: memory of objects that live on goes to the new release. Pools and threads use the C library. Fails with CW_ERROR_ARGUMENT if a function
 * is missing. */
CW_API cw_status cw_allocator_set(const cw_allocator *allocator);

/* ---- field ------------------------------------------------------------------------------------------------------ */

/* Field coordinates are exact in float: a side has 2 to 2^23 samples, and all samples are fewer than 2^31. */
enum { CW_SIDE_MAX = 1 << 23 };

/* Heights lie within plus or minus 2^100, so that sums and products of them do not overflow. */
#define CW_HEIGHT_MAX 1267650600228229401496703205376.0f

typedef struct cw_field cw_field;

typedef enum cw_storage {
    CW_COPY = 0, /* the field copies the samples, which may be freed after cw_field_create */
    /* The field reads the caller's samples. They must stay until cw_field_destroy, and may change only together with
     * cw_field_update. */
    CW_BORROW
} cw_storage;

typedef struct cw_field_desc {
    /* Sample (i, j) is samples[j * stride + i]. Holes are NaN; infinite samples are also holes if they are copied. */
    const float *samples;
    size_t nx, ny; /* samples in a row; rows. Each from 2 to CW_SIDE_MAX */
    size_t stride; /* floats from one row to the next; 0: nx */
    cw_storage storage;
    /* Field space to user space, three rows of four: user = map[.][0..2] · (x, y, z) + map[.][3]. All zero: the
     * identity. */
    double map[3][4];
    uint64_t reserved[4]; /* 0 */
} cw_field_desc;

/* The identity map and nothing else. */
CW_API cw_field_desc cw_field_desc_default(void);

/* Makes a field, which the caller owns, with the bounds that kernels walk on: less than 2 bytes a cell, but for small fields, and
 * 2 KiB. Of run, pool and watch are used; a reference kernel gets its structure, too. The field has the same bits for any pool. On failure *field is NULL: CW_ERROR_ARGUMENT, _SAMPLE, _KERNEL, _MEMORY, _CANCELLED. */
CW_API cw_status cw_field_create(const cw_field_desc *desc, const cw_run *run, cw_field **field);
/* NULL is allowed. Nothing may be running on the field. */
CW_API void cw_field_destroy(cw_field *field);

/* Makes the structure that run's kernel needs beside the bounds, if it does, unless the field has it. Nothing else may be running
 * on the field. On failure the field does not change: CW_ERROR_ARGUMENT, _KERNEL, _MEMORY. */
CW_API cw_status cw_field_build(cw_field *field, const cw_run *run);

/* Samples (i, j) to (i + nx - 1, j + ny - 1). */
typedef struct cw_rectangle {
    size_t i, j;
    size_t nx, ny;
} cw_rectangle;

typedef struct cw_update {
    cw_rectangle at; /* may be empty */
    /* The new samples, (at.i + x, at.j + y) at samples[y * stride + x]. NULL for a field that borrows: its caller
     * has changed them already. */
    const float *samples;
    size_t stride;        /* floats from one row to the next; 0: at.nx */
    uint64_t reserved[4]; /* 0 */
} cw_update;

/* Changes samples. Afterwards the field has the same bits as one made of the new samples, except that a reference
 * kernel's structure is dropped until cw_field_build. The time grows with the rectangle, not with the field. Does not
 * allocate. Headings stay valid. Only run's pool is used: an update is not cancelled.
 * CW_ERROR_SAMPLE: a sample is refused, and the field does not change; if it borrows, put other samples there and
 * call this again before the next query. CW_ERROR_BUSY: a query or another update is running on the field. Functions
 * without a status are not checked for that. */
CW_API cw_status cw_field_update(cw_field *field, const cw_update *update, const cw_run *run);

typedef struct cw_field_info {
    size_t nx, ny;
    float low, high;      /* lowest and highest sample; low > high if all are holes */
    size_t holes;         /* samples that are holes */
    size_t bytes_samples; /* owned by the field: 0 if borrowed */
    size_t bytes_built;   /* of all structures */
    double build_seconds; /* elapsed time spent on them, including the sample scan if it was done in the same pass */
    double map[3][4];     /* field space to user space */
} cw_field_info;

/* Fills in the first size bytes of a cw_field_info. */
CW_API void cw_field_describe_into(const cw_field *field, cw_field_info *info, size_t size);
static inline cw_field_info cw_field_describe(const cw_field *field) {
    cw_field_info info;
    cw_field_describe_into(field, &info, sizeof info);
    return info;
}

/* The nx samples of row j as kernels see them, with holes as NaN: valid until the field is destroyed. NULL from ny
 * on. */
CW_API const float *cw_field_row(const cw_field *field, size_t j);

/* ---- queries ---------------------------------------------------------------------------------------------------- */

/* Points org + t · dir for t in [tmin, tmax], both ends included, in field space. dir need not have unit length.
 * tmin and tmax may be infinite; both are clamped to half of the largest float. A direction component of at most
 * 2^-128, whose reciprocal overflows, counts as zero; one above 2^126, whose reciprocal is denormal, counts as
 * infinite. A ray with a NaN anywhere, an infinite origin or direction, a zero direction or tmin > tmax misses. A
 * ray that goes through the surface hits it, on edges too. One that touches it from one side hits as far as floats
 * can tell: within rounding (papers/numerics.md) it may miss, and so may one that meets the field's outer border or
 * the rim of a hole.
 *
 * A ray may start anywhere. One that starts more than half a side outside the field, or more than eight times its
 * range of heights above or below its middle, is first moved to where it enters the field's box: distance costs
 * neither speed nor precision. */
typedef struct cw_ray {
    float org[3];
    float tmin;
    float dir[3];
    float
        tmax; /* infinite: the ray has no end. 0, as {0} leaves it: the ray is its origin alone, and all but always misses */
} cw_ray;

typedef enum cw_triangle { CW_TRIANGLE_A = 0, CW_TRIANGLE_B = 1 } cw_triangle;

/* With p0, p1, p2 the triangle's vertices in the order given at the top, the hit is p0 + u (p1 - p0) + v (p2 - p0).
 * t counts from the ray's origin as given, and lies in [tmin, tmax]. With CW_LEAF_WATERTIGHT t is the exact one
 * rounded to the nearest float, or to the next one if it is within 2^-50 of it of the middle of the two, and u and v
 * are within 1.25 · 2^-24 of theirs, with four exceptions: the ray passes within rounding of the triangle's edge; it is
 * all but parallel to the triangle; its range begins or ends within rounding of the surface, where t may be that end;
 * or t is so small, as below 1e-10 in a field of unit heights, that the rounding of the heights in double counts.
 * papers/numerics.md has the bounds of all. From afar a float t does not distinguish neighbouring cells: i, j, u and
 * v do. A miss has t = +infinity, i = j = -1, and 0 elsewhere.
 * The 24 bytes are also the record of the tool's hits.npy. */
typedef struct cw_hit {
    float t;
    int32_t i, j;
    uint32_t triangle; /* a cw_triangle */
    float u, v;
} cw_hit;

/* CW_OK if a query with this run on this field would start; field NULL stands for one that has every structure. */
CW_API cw_status cw_run_check(const cw_field *field, const cw_run *run);

/* The kernel that a query with this run uses, on any field. */
CW_API const cw_kernel *cw_run_kernel(const cw_field *field, const cw_run *run);

/* The closest hit of each of n rays (n may be 0). rays and hits must not overlap. The answer for a ray does not
 * depend on the others, its place in the array or the number of threads. Fails with CW_ERROR_ARGUMENT, _KERNEL,
 * _NOT_BUILT, _BUSY during an update, or _CANCELLED; with a watch also _MEMORY. */
CW_API cw_status cw_closest(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, cw_hit *hits);

/* occluded[k] = 1 if rays[k] hits anything, else 0: always 1 if cw_closest has a hit, else 0. Fails like cw_closest. */
CW_API cw_status cw_occluded(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, uint8_t *occluded);

/* ---- user space ------------------------------------------------------------------------------------------------- */

/* A ray in user space; otherwise like cw_ray. */
typedef struct cw_user_ray {
    double org[3];
    double tmin;
    double dir[3];
    double tmax;
} cw_user_ray;

/* Moves rays to field space in double and rounds last, so that a field far from the user's origin loses nothing:
 * from 5 · 10^6 m away, cells of 1 m get the same rays as at the origin. One rounding to float is lost: of an origin
 * within a field of 10 000 cells, as in UTM, up to 5 · 10^-4 cells; of one 10^5 cells away, a sensor 700 km above
 * cells of 10 m in geocentric coordinates, up to 4 · 10^-3; and 2^-24 of the direction's length. A map that skews by
 * a factor s loses up to s times as much. t is the same in both spaces. in and out must not overlap. */
CW_API void cw_rays_to_field(const cw_field *field, const cw_user_ray *in, size_t n, cw_ray *out);

/* cw_closest and cw_occluded of rays in user space: the answers are those of cw_rays_to_field and a query after it. If
 * cw_isa_limit rules the kernel out meanwhile, the status says so and the output is unspecified. */
CW_API cw_status cw_closest_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                                 cw_hit *hits);
CW_API cw_status cw_occluded_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                                  uint8_t *occluded);

/* The place on the surface at field coordinates (x, y), as a hit with t = 0. A miss outside the field, in a triangle
 * with a hole at a vertex, and for NaN. */
CW_API void cw_field_at(const cw_field *field, double x, double y, cw_hit *hit);
/* The place on the surface above or below a point in user space, along the field's own up, which is the map's third
 * column: (x, y, anything) where that is (0, 0, 1), (x, anything, z) in a world whose y is up. A miss as for
 * cw_field_at. */
CW_API cw_status cw_field_at_user(const cw_field *field, const double point[3], cw_hit *hit);

/* ---- points and normals of hits ---------------------------------------------------------------------------------- */

/* Computed on request, so that a query pays only for hits. hits are n hits on this field; three doubles for each go
 * to the output, in user space: NaN for a miss and for a cell that the field does not have. Of run, kernel and leaf
 * are ignored. */

/* The point on the triangle, from i, j, triangle, u and v. It lies on the surface to rounding, unlike org + t · dir. */
CW_API cw_status cw_hit_points(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n, double *points);

/* The triangle's unit normal, on the side of growing z. */
CW_API cw_status cw_hit_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                                double *normals);

/* Unit Phong normals (Phong 1975): each vertex takes the area-weighted sum of the normals of its up to six
 * triangles, and the hit interpolates them by its barycentric coordinates. Triangles with holes are left out. */
CW_API cw_status cw_hit_phong_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                                      double *normals);

/* ---- headings (experimental) ------------------------------------------------------------------------------------- */

/* Sunlight, or the view in one compass direction: rays that leave from many samples in the same direction. Each
 * starts exactly on the surface at its sample and meets everything beyond it, so no ray has to be lifted off the
 * ground. This is faster than a query with one ray for each sample.
 *
 * A heading is a direction (dir[0], dir[1]) in field coordinates, prepared for one field: 48 bytes per cell along
 * the longest ray. From sample (i, j) with height z, the surface at (i + t dir[0], j + t dir[1]) rises by (height -
 * z) / t, t > 0. The steepest rise is at a triangle's edge, so only edges are examined. An edge counts if neither of
 * its samples is a hole, even if both triangles beside it have a hole. */
typedef struct cw_heading cw_heading;

/* The longer of dir's components is from 2^-40 to 2^40. The caller owns the heading and destroys it before the
 * field. On failure *heading is NULL: CW_ERROR_ARGUMENT, _MEMORY. */
CW_API cw_status cw_heading_create(const cw_field *field, const double dir[2], cw_heading **heading);
/* A heading of limited length, or on a curved earth. */
typedef struct cw_heading_desc {
    double dir[2];
    /* Only edges crossed at t <= reach count, up to rounding in the last bits; finite; 0: all. */
    double reach;
    /* The surface at t counts as lower by drop t²: at (i + t dir[0], j + t dir[1]) it rises by (height - drop t² -
     * z) / t, and is straight between the lowered edges. The error of a rise grows by up to 2^-23 drop t. 0: the
     * earth is flat. At most 2^77 times dir's longer component. */
    double drop;
    uint64_t reserved[4]; /* 0 */
} cw_heading_desc;

/* Like cw_heading_create, which is the same with the direction alone. */
CW_API cw_status cw_heading_create_with(const cw_field *field, const cw_heading_desc *desc, cw_heading **heading);
/* NULL is allowed. */
CW_API void cw_heading_destroy(cw_heading *heading);

/* The steepest rise seen from each sample of a rectangle: slope[y * at.nx + x] for sample (at.i + x, at.j + y), NaN
 * at a hole. Its error is less than 2^-21 of the steeper of the rises to the edge's two samples, by their sizes. A rise
 * beyond the largest float is infinite. Rises are clamped to [low, high]; if the ray meets nothing, the rise is low. So
 * -infinity may be either, unless low is finite. A narrow range is fast; -infinity and infinity clamp
 * nothing. Of run's kernel only the instruction set is used; the answers are the same for any. */
CW_API cw_status cw_heading_steepest(const cw_heading *heading, const cw_run *run, float low, float high,
                                     cw_rectangle at, float *slope);

/* occluded[y * at.nx + x] = 1 if the steepest rise is at least slope; else 0, also at a hole or where the ray meets
 * nothing. slope may be infinite. */
CW_API cw_status cw_heading_occluded(const cw_heading *heading, const cw_run *run, float slope, cw_rectangle at,
                                     uint8_t *occluded);

#ifdef __cplusplus
}
#endif

#endif
