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
 * A *hole* is a sample without a height (NaN); triangles with a hole at a vertex do not exist. *Field space* has unit
 * cells and the samples' heights. *User space* is the caller's; an affine map in double ties it to field space.
 *
 * Threads. Every function may be called from several threads at once unless it says otherwise. Queries do not allocate.
 * A query of at most 8 rays, places or hits takes at most 16 KiB of stack if no kernel is forced, and any other call
 * 128 KiB. No function is a cancellation point, and callbacks run with cancellation disabled; asynchronous cancellation
 * is undefined. A callback must return: it must not jump out, throw or end its thread. In a child made by fork, queries
 * of the parent do not keep a field busy; an update does, so destroy a field that was being updated. A child that a
 * callback has forked must neither return from it nor update the field.
 *
 * Errors. Functions that can fail return a cw_status and leave a sentence with the argument, its value and the limit
 * for cw_last_error. Unless a function says otherwise, its outputs are untouched on an error. Functions without a
 * status are not checked: no argument may be NULL. Empty arrays may be NULL: for n = 0 and for an empty rectangle.
 *
 * Floating point. Calls compute in the IEEE default environment (round to nearest, denormals kept) and restore the
 * caller's rounding, treatment of denormals and masks. Exception flags that they raise stay raised. Callbacks run in
 * either environment.
 *
 * Growing. This header and the library keep source and binary compatibility within a major version. Enumerations are
 * int32_t, and their numbers are never used again. Structs that the caller fills end in reserved members, which must be
 * zero: later versions give them a meaning, and anything but zero fails with CW_ERROR_ARGUMENT. Zero is always the
 * default, so start from {0}. Structs that the library fills take their size, so a program compiled with an older
 * header gets the members of that header. The records cw_ray, cw_user_ray, cw_hit and cw_rectangle never change.
 * Kernels and instruction sets are chosen by cellwalk_expert.h, which may change in any version. Room is reserved in
 * cw_field_desc and cw_update for holes per cell, samples of 16 bits and the other diagonal.
 *
 * Not offered: instances, strided rays, walks in double precision, queries on a field that another thread destroys. */

#ifndef CELLWALK_H
#define CELLWALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How functions are declared. CW_SHARED: the program links the library as a DLL. CW_BUILD is for the library's own
 * build. A program that compiles the library into itself may define CW_API as it likes. */
#ifndef CW_API
#if defined(_WIN32) && defined(CW_BUILD)
#define CW_API __declspec(dllexport)
#elif defined(_WIN32) && defined(CW_SHARED)
#define CW_API __declspec(dllimport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define CW_API __attribute__((visibility("default")))
#else
#define CW_API
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define CW_VERSION       "1.0.0"
#define CW_VERSION_MAJOR 1
#define CW_VERSION_MINOR 0
#define CW_VERSION_PATCH 0
/* For #if: 10000 · major + 100 · minor + patch. */
#define CW_VERSION_NUMBER (10000 * CW_VERSION_MAJOR + 100 * CW_VERSION_MINOR + CW_VERSION_PATCH)

/* The version of the library that runs, which may differ from that of the header. */
CW_API const char *cw_version(void);
CW_API uint32_t cw_version_number(void);

/* ---- status ----------------------------------------------------------------------------------------------------- */

/* Any value but CW_OK is a failure, also one that only a later version knows. */
typedef int32_t cw_status;
enum {
    CW_OK = 0,
    CW_ERROR_ARGUMENT = 1, /* an argument or a member is NULL, out of range or of a value unknown to this version */
    CW_ERROR_SAMPLE = 2,   /* a sample lies beyond CW_HEIGHT_MAX, or a borrowed one is infinite */
    CW_ERROR_KERNEL = 3,   /* no kernel of that name, not on this CPU or under this limit, or not with this leaf test */
    CW_ERROR_NOT_BUILT = 4, /* a reference kernel needs cw_field_build first */
    CW_ERROR_MEMORY = 5,    /* out of memory, or of threads */
    CW_ERROR_BUSY = 6,      /* an update and something else would run on one field at the same time */
    CW_ERROR_CANCELLED = 7  /* the watch returned false */
};

/* The general meaning of the status: one English sentence without a full stop, in static storage, never NULL. */
CW_API const char *cw_status_message(cw_status status);

/* The error of the last call that failed on this thread, with names, values and limits: "nx: 1 samples; a field has
 * 2 to 8388608 a side". Empty if none has failed. Valid until the next failure on this thread; successful calls keep
 * it. */
CW_API const char *cw_last_error(void);

/* ---- threads and runs ------------------------------------------------------------------------------------------- */

/* Threads that wait for work. A pool serves one caller at a time: if it is busy, the work runs on the calling
 * thread. */
typedef struct cw_pool cw_pool;

enum { CW_THREADS_MAX = 4096 };

/* threads, at most CW_THREADS_MAX, counts the calling thread; 0 is one for each CPU that this process may use. The
 * caller owns the pool, whose threads have at least 1 MiB of stack. On failure *pool is NULL: CW_ERROR_ARGUMENT,
 * _MEMORY. In a child made by fork the pool is the calling thread alone, and the child may destroy it. */
CW_API cw_status cw_pool_create(uint32_t threads, cw_pool **pool);
/* NULL is allowed. Nothing may be running on the pool. */
CW_API void cw_pool_destroy(cw_pool *pool);

/* A task that the library hands to the caller's threads. */
typedef void cw_task_fn(void *argument, uint32_t number);
/* Threads that the caller has already. */
typedef struct cw_tasks {
    /* Calls task(argument, k) for each k in [0, count) on any threads in any order, and returns when all have
     * returned. Several threads may call it at once. */
    void (*run)(void *context, cw_task_fn *task, void *argument, uint32_t count);
    void *context;        /* passed to run; must live until cw_pool_destroy */
    uint32_t threads;     /* tasks to make of a piece of work: from 1 to CW_THREADS_MAX */
    uint32_t zero;        /* 0 */
    uint64_t reserved[4]; /* 0 */
} cw_tasks;
/* A pool that uses the caller's threads. tasks is copied. The caller owns the pool. On failure *pool is NULL:
 * CW_ERROR_ARGUMENT, _MEMORY. */
CW_API cw_status cw_pool_create_on(const cw_tasks *tasks, cw_pool **pool);

/* Called during long work by one thread at a time with the share that is done, in (0, 1]. Returning false ends the
 * work soon with CW_ERROR_CANCELLED; its output is then unspecified. */
typedef bool cw_watch_fn(void *context, double done);

/* A choice of kernel by cellwalk_expert.h. All zero: the library chooses. */
typedef struct cw_expert {
    const struct cw_kernel *kernel;
    int32_t leaf;
    int32_t isa;
} cw_expert;

/* How something runs. All zero, and a NULL cw_run, mean: the calling thread, no watch, the best kernel for this machine
 * and this number of rays. */
typedef struct cw_run {
    cw_pool *pool;        /* NULL: the calling thread. Queries of fewer than 1024 rays stay on it in any case */
    cw_watch_fn *watch;   /* NULL: none */
    void *watch_context;  /* passed to watch */
    cw_expert expert;     /* 0 */
    uint64_t reserved[6]; /* 0 */
} cw_run;

/* ---- field ------------------------------------------------------------------------------------------------------ */

/* Field coordinates are exact in float: a side has 2 to 2^23 samples, and all samples are fewer than 2^31. */
enum { CW_SIDE_MAX = 1 << 23 };

/* Heights lie within plus or minus 2^100, so that sums and products of them do not overflow. */
#define CW_HEIGHT_MAX 1267650600228229401496703205376.0f

typedef struct cw_field cw_field;

/* Memory for a field and for what is made from it, such as memory backed by files. Both functions are called by several
 * threads at once. */
typedef struct cw_allocator {
    /* Returns bytes bytes, at least 1, aligned to alignment, a power of two up to 2^21; or NULL. */
    void *(*allocate)(void *context, size_t bytes, size_t alignment);
    void (*release)(void *context, void *memory); /* takes a pointer that allocate returned, never NULL */
    void *context;                                /* passed to both; must live as long as the field */
    uint64_t reserved[4];                         /* 0 */
} cw_allocator;

typedef int32_t cw_storage;
enum {
    CW_COPY = 0, /* the field copies the samples, which may be freed after cw_field_create */
    /* The field reads the caller's samples. They must stay until cw_field_destroy, and may change only together with
     * cw_field_update. */
    CW_BORROW = 1
};

typedef struct cw_field_desc {
    /* Sample (i, j) is samples[j * stride + i]. Holes are NaN; infinite samples are also holes if they are copied. */
    const float *samples;
    size_t nx, ny; /* samples in a row; rows. Each from 2 to CW_SIDE_MAX */
    size_t stride; /* floats from one row to the next; 0: nx */
    /* Field space to user space, three rows of four: user = map[.][0..2] · (x, y, z) + map[.][3]. All zero: the
     * identity. */
    double map[3][4];
    const cw_allocator *allocator; /* copied, and kept for the field's life; NULL: the library's own */
    cw_storage storage;            /* CW_COPY or CW_BORROW */
    uint32_t zero;                 /* 0 */
    uint64_t reserved[8];          /* 0 */
} cw_field_desc;

/* Makes a field, which the caller owns, with the bounds that kernels walk on: less than 2 bytes a cell, but for small
 * or narrow fields, and 2 KiB. It has the same bits for any pool. On failure *field is NULL: CW_ERROR_ARGUMENT,
 * _SAMPLE, _MEMORY, _CANCELLED, or _KERNEL if run->expert names a kernel that does not exist. */
CW_API cw_status cw_field_create(const cw_field_desc *desc, const cw_run *run, cw_field **field);
/* NULL is allowed. Nothing may be running on the field. */
CW_API void cw_field_destroy(cw_field *field);

/* Samples (i, j) to (i + nx - 1, j + ny - 1). */
typedef struct cw_rectangle {
    size_t i, j;
    size_t nx, ny;
} cw_rectangle;

typedef struct cw_update {
    cw_rectangle at; /* may be empty */
    /* The new samples, (at.i + x, at.j + y) at samples[y * stride + x]; not in the field's own memory. NULL for a field
     * that borrows: its caller has changed them already. */
    const float *samples;
    size_t stride;        /* floats from one row to the next; 0: at.nx */
    uint32_t wait;        /* 1: wait while queries or updates run; 0: fail with CW_ERROR_BUSY */
    uint32_t zero;        /* 0 */
    uint64_t reserved[7]; /* 0 */
} cw_update;

/* Changes samples. Afterwards the field has the same bits as one made of the new samples. The time grows with the
 * rectangle, and hardly with the field. Does not allocate. Only run's pool is used: an update is not cancelled.
 * CW_ERROR_SAMPLE: a sample is refused, and the field does not change; if it borrows, put other samples there and call
 * this again before the next query. CW_ERROR_BUSY: a query or another update is running on the field, and wait is 0.
 * Functions without a status are not checked for that.
 *
 * With wait, the update begins when all queries that run have ended. Queries that begin meanwhile wait for it, instead
 * of failing with CW_ERROR_BUSY. Nobody starves: such updates take turns, and before the next one all queries begin
 * that waited. Two calls that wait for each other never end, so no watch or task of a query or update may call
 * functions on a field that is updated with wait, nor wait for a thread that does. In a child made by fork during an
 * update, wait fails with CW_ERROR_BUSY. Borrowed samples change before the call, so the caller still keeps queries
 * away from them. */
CW_API cw_status cw_field_update(cw_field *field, const cw_run *run, const cw_update *update);

/* Gives the field another map, as for a floating origin. Samples and answers in field space stay, and user space moves.
 * A query that runs in another thread has the old map or the new one for all its rays. map as in cw_field_desc, wait as
 * in cw_update. CW_ERROR_ARGUMENT: the map is not finite or cannot be inverted, and the field keeps its own.
 * CW_ERROR_BUSY as for updates. */
CW_API cw_status cw_field_move(cw_field *field, const double map[3][4], uint32_t wait);

typedef struct cw_field_info {
    size_t nx, ny;        /* samples in a row; rows */
    float low, high;      /* lowest and highest sample; low > high if all are holes */
    size_t holes;         /* samples that are holes */
    size_t bytes_samples; /* owned by the field: 0 if borrowed */
    size_t bytes_built;   /* of all structures */
    double map[3][4];     /* field space to user space */
} cw_field_info;

/* Fills in the first size bytes of a cw_field_info; size is sizeof *info. */
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
    float tmax; /* infinite: the ray has no end. 0: the ray is its origin alone, and nearly always misses */
} cw_ray;

enum { CW_TRIANGLE_A = 0, CW_TRIANGLE_B = 1 };

/* With p0, p1, p2 the triangle's vertices in the order given at the top, the hit is p0 + u (p1 - p0) + v (p2 - p0).
 * t counts from the ray's origin as given, and lies in [tmin, tmax]. It is the exact t rounded to the nearest float (if
 * it is within 2^-50 of itself of the middle between two floats, to either), and u and v are within 1.25 · 2^-24 of
 * theirs, with four exceptions: the ray passes within rounding of the triangle's edge; it is all but parallel to the
 * triangle; its range begins or ends within rounding of the surface, where t may be that end; or t is so small, as
 * below 1e-10 in a field of unit heights, that the rounding of the heights in double counts. papers/numerics.md has the
 * bounds of all. From afar a float t does not distinguish neighbouring cells: i, j, u and v do. A miss has
 * t = +infinity, i = j = -1, and 0 elsewhere. The 24 bytes are also the record of the tool's hits.npy. */
typedef struct cw_hit {
    float t;
    int32_t i, j;      /* the cell */
    uint32_t triangle; /* CW_TRIANGLE_A or CW_TRIANGLE_B */
    float u, v;
} cw_hit;

/* The closest hit of each of n rays (n may be 0). rays and hits must not overlap. The answer for a ray does not
 * depend on the others, its place in the array or the number of threads. One ray a call costs several times as much as
 * one of a larger call, most where rays are alike (`cellwalk-bench measure single`). Fails with
 * CW_ERROR_ARGUMENT, _BUSY during an update without wait, or _CANCELLED; with a watch also _MEMORY. */
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

/* Moves rays to field space in double and rounds last, so that a field far from the user's origin loses nothing: from
 * 5 · 10^6 m away, cells of 1 m get the same rays as at the origin. One rounding to float is lost: of an origin within
 * a field of 10 000 cells, as in UTM, up to 5 · 10^-4 cells; of one 10^5 cells away, a sensor 700 km above cells of
 * 10 m in geocentric coordinates, up to 4 · 10^-3; and 2^-24 of the direction's length. A map that skews by a factor s
 * loses up to s times as much. t is the same in both spaces. in and out must not overlap. Fails like cw_closest. */
CW_API cw_status cw_rays_to_field(const cw_field *field, const cw_run *run, const cw_user_ray *in, size_t n,
                                  cw_ray *out);

/* cw_closest and cw_occluded of rays in user space: the answers are those of cw_rays_to_field and a query after it. */
CW_API cw_status cw_closest_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                                 cw_hit *hits);
CW_API cw_status cw_occluded_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                                  uint8_t *occluded);

/* ---- places, points and normals ---------------------------------------------------------------------------------- */

/* The places on the surface at n pairs of field coordinates x, y, as hits with t = 0. A miss outside the field, in a
 * triangle with a hole at a vertex, and for NaN. A place on the border of two cells lies in the one of greater i or j,
 * and one on a diagonal in CW_TRIANGLE_A. Fails like cw_closest. */
CW_API cw_status cw_surface_at(const cw_field *field, const cw_run *run, const double *xy, size_t n, cw_hit *hits);
/* The same above or below n points x, y, z in user space, along the field's own up, which is the map's third column:
 * (x, y, any number) where that is (0, 0, 1), (x, any number, z) in a world whose y is up. */
CW_API cw_status cw_surface_at_user(const cw_field *field, const cw_run *run, const double *xyz, size_t n,
                                    cw_hit *hits);

/* For each of n hits on this field, three doubles in user space: NaN for a miss and for a triangle that the field does
 * not have. Fail like cw_closest. */

/* The point on the triangle, from i, j, triangle, u and v. It lies on the surface to rounding, unlike org + t · dir. */
CW_API cw_status cw_hit_points(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n, double *points);

/* The triangle's unit normal, on the side of growing z. It may be NaN on maps whose axes differ by 10^320 and more,
 * which doubles cannot hold. */
CW_API cw_status cw_hit_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                                double *normals);

/* Unit Phong normals (Phong 1975): each vertex takes the area-weighted sum of the normals of its up to six
 * triangles, and the hit interpolates them by its barycentric coordinates. Triangles with holes are left out. */
CW_API cw_status cw_hit_phong_normals(const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                                      double *normals);

#ifdef __cplusplus
}
#endif

#endif
